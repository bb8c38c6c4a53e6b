"""Part of the report on effects scenes: cost of effects and outputs."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import digits, format_number
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.effects.pictures import describe_effects
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.effects import COMMON_EFFECTS
from vibropipe.words.measurements import Passed

VERDICTS = {Passed.NOT_PASSED: "missed", Passed.PASSED: "met"}
HOW = (
    "Each motion is solved by the kernel specialised to its effects (in closed form where there is one), and timed in "
    "the same rounds as two references. “Over all effects”: the all-effects kernel on the same motion. “Over full”: "
    "the all-effects kernel, same outputs, on the motion that contains all effects. A sweep row is one steady state, "
    "transient included, in closed form by every kernel where there is one. Times are compared per row, or per forcing "
    "period of a motion: medians of the rounds, with quartiles in brackets."
)
CAPTION = (
    "Time per forcing period on one core (of a row: per period of its transient), bytes stored per forcing period or "
    "row before compression, and targets for the ratios."
)
WIDTHS = ("auto", "1fr", "2.5cm", "2.9cm", "3cm", "auto", "auto", "auto", "2.3cm", "3cm", "1.2cm")


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on measured costs."""
    tables = effect_tables(datasets)
    if not tables:
        return []
    title = "Cost of each effect and each output"
    return [Section(title, [HOW], tables, is_landscape=True)]


def range_text(dataset: xr.Dataset) -> str:
    """Write the smallest and the largest ratio of the specialised to the all-effects kernel on the same motion."""
    ratio = dataset["time_ratio"].sel(kernel="all")
    if not np.isfinite(ratio).any():
        return ""
    names = [str(name).replace("_", " ") for name in dataset["motion"].values]
    low, high = int(np.nanargmin(ratio.values)), int(np.nanargmax(ratio.values))
    return (
        "The kernel specialised to the effects of a motion takes "
        f"{format_number(float(ratio[low]), 2)} ({names[low]}) to {format_number(float(ratio[high]), 2)} "
        f"({names[high]}) of the time of the all-effects kernel on the same motion"
    )


def effect_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene."""
    return [effect_table(data) for data in datasets.values() if "kernel_time" in data]


def findings(datasets: Datasets) -> list[Finding]:
    """Return which targets each scene meets."""
    return [
        Finding((describe_effects(data), range_text(data)), name)
        for name, data in datasets.items()
        if "kernel_time" in data
    ]


def effect_table(dataset: xr.Dataset) -> Table:
    """Return a table of one row per motion: effects, outputs, time, bytes, their ratios, and the target."""
    rows = []
    for index, name in enumerate(dataset["motion"].values):
        one = dataset.isel(motion=index)
        own, all_effects, full = (one.sel(kernel=kernel) for kernel in ("own", "all", "full"))
        has_target = int(one["target_met"]) != Passed.NOT_ASKED
        against = str(one["target_against"].item())
        rows.append(
            [
                breakable(str(name)),
                effects_text(str(one["effects_present"].item())),
                str(one["outputs_asked"].item()) or DASH,
                quartiles_text(own, "kernel_time"),
                quartiles_text(all_effects, "time_ratio"),
                format_number(float(full["time_ratio"]), 2),
                digits(float(own["bytes_per_row"])),
                format_number(float(full["bytes_ratio"]), 2),
                f"{format_number(float(one['target']), 3)} of {breakable(against)}"
                if has_target
                else DASH,
                quartiles_text(one, "target_ratio")
                if has_target or against != "all effects"
                else DASH,
                VERDICTS.get(Passed(int(one["target_met"])), DASH),
            ]
        )
    head = ["", "effects", "outputs", "ns", "over all effects", "over full", "bytes", "over full"]
    head += ["target", "measured", "target met"]
    return Table(head, rows, CAPTION, WIDTHS, left=3)


def quartiles_text(one: xr.Dataset, name: str) -> str:
    """Write a median with quartiles."""
    middle, low, high = (float(one[f"{name}{side}"]) for side in ("", "_low", "_high"))
    return f"{digits(middle)} ({digits(low)} to {digits(high)})"


def effects_text(names: str) -> str:
    """Write the effects of a motion, 'all' for all of them."""
    if not names:
        return DASH
    return "all" if set(names.split(", ")) == set(COMMON_EFFECTS) else breakable(names)


REPORT = ReportPart(
    "Cost of effects and outputs",
    "What does each effect and each output cost?",
    answers_of(findings),
    tables_of(sections),
)
