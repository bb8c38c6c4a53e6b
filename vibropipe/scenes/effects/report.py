"""What a report says of an effects scene: what effects and outputs cost."""

from __future__ import annotations

import xarray as xr

from vibropipe.figures.text import digits, format_number
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.effects.pictures import describe_effects
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.effects import EFFECT_NAMES

VERDICTS = {0: "not passed", 1: "passed"}
HOW = (
    "Each motion is solved by the kernel of its own effects (in closed form where it has one), and that time is set "
    "against two others taken beside it in the same rounds: “over all effects”, the kernel of all effects on the very "
    "same motion; “over full”, the kernel of all effects, with the same outputs, on the motion in which all effects "
    "happen. A row of a sweep is the steady state that settles from its start, settling included; rows are compared "
    "by row, motions by forcing period. Medians of the rounds, in brackets their quartiles."
)
CAPTION = (
    "Time of one core per forcing period (of a row: of the periods it takes to settle), bytes stored before "
    "compression for a forcing period of a motion or for a row, and ratios aimed at."
)
WIDTHS = ("auto", "1fr", "2.5cm", "2.9cm", "3cm", "auto", "auto", "auto", "2.3cm", "3cm", "1.2cm")


def sections(datasets: Datasets) -> list[Section]:
    """Return the section of the measured costs."""
    tables = effect_tables(datasets)
    if not tables:
        return []
    title = "What each effect and each output costs"
    return [Section(title, [HOW, effect_words(datasets)], tables, is_landscape=True)]


def effect_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene of effects."""
    return [effect_table(data) for data in datasets.values() if "kernel_time" in data]


def effect_words(datasets: Datasets) -> str:
    """Say which targets are met and by how much the others are missed."""
    costs = [data for data in datasets.values() if "kernel_time" in data]
    return " ".join(describe_effects(data) for data in costs)


def effect_table(dataset: xr.Dataset) -> Table:
    """Return a row per motion: what it calls for, time and bytes, their ratios, and its target."""
    rows = []
    for place, name in enumerate(dataset["motion"].values):
        one = dataset.isel(motion=place)
        own, all_effects, full = (one.sel(kernel=kernel) for kernel in ("own", "all", "full"))
        asked = int(one["target_met"]) != 2
        against = str(one["target_against"].item())
        rows.append(
            [
                breakable(str(name)),
                effects_words(str(one["effects_present"].item())),
                str(one["outputs_asked"].item()) or DASH,
                spread_words(own, "kernel_time"),
                spread_words(all_effects, "time_ratio"),
                format_number(float(full["time_ratio"]), 2),
                digits(float(own["bytes_per_row"])),
                format_number(float(full["bytes_ratio"]), 2),
                f"{format_number(float(one['target']), 3)} of {breakable(against)}"
                if asked
                else DASH,
                spread_words(one, "target_ratio") if asked or against != "all effects" else DASH,
                VERDICTS.get(int(one["target_met"]), DASH),
            ]
        )
    head = ["", "effects", "outputs", "ns", "over all effects", "over full", "bytes", "over full"]
    head += ["target", "measured", "passed"]
    return Table(head, rows, CAPTION, WIDTHS, left=3)


def spread_words(one: xr.Dataset, name: str) -> str:
    """Write a median with its quartiles."""
    middle, low, high = (float(one[f"{name}{side}"]) for side in ("", "_low", "_high"))
    return f"{digits(middle)} ({digits(low)} to {digits(high)})"


def effects_words(names: str) -> str:
    """Write the effects of a motion; all of them in a word."""
    if not names:
        return DASH
    return "all" if set(names.split(", ")) == set(EFFECT_NAMES) else breakable(names)


REPORT = ReportPart(sections)
