"""The tables of what was timed: time to reach an accuracy, and what effects and outputs cost."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.effect_costs import describe_effects
from vibropipe.figures.options import Options
from vibropipe.figures.text import number
from vibropipe.lab.work_precision_summary import time_to_reach
from vibropipe.physics.effects import NAMES
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.vocabulary import Outcome

NOT_REACHED = "not reached"
MEDIAN_OF_ALL = "median of all"
VERDICTS = {0: "not passed", 1: "passed"}


def race_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each race."""
    return [race_table(data) for data in datasets.values() if "setting_value" in data]


def race_table(dataset: xr.Dataset) -> Table:
    """Return a row per motion and method that took part: ns per forcing period for each error; then, per
    method, the median over the motions that reach it, with their number where not all do."""
    times = time_to_reach(dataset)
    absent = (dataset["outcome"] == int(Outcome.NOT_INSTALLED)).any("setting").all("motion").values
    methods = [(i, str(m)) for i, m in enumerate(dataset["method"].values) if not absent[i]]
    rows = []
    for motion, by_method in zip(dataset["motion"].values, times.values, strict=True):
        for place, method in methods:
            rows.append([breakable(str(motion)), method, *map(reached_words, by_method[place])])
    for place, method in methods:
        cells = [median_words(column) for column in times.values[:, place].T]
        rows.append([MEDIAN_OF_ALL, method, *cells])
    accuracies = [number(float(a), 1) for a in times["accuracy"].values]
    return Table(["motion", "method", *accuracies], rows)


def reached_words(time: float) -> str:
    """Write a time in ns, or that the accuracy is not reached."""
    return digits(float(time)) if np.isfinite(time) else NOT_REACHED


def digits(value: float) -> str:
    """Write a number with three digits, whole ones in full up to six."""
    return f"{value:.0f}" if 100 <= value < 1e6 else number(value, 3)


def median_words(times: np.ndarray) -> str:
    """Write the median of the times there are, and of how many motions it is if not of all."""
    known = times[np.isfinite(times)]
    if not known.size:
        return NOT_REACHED
    told = digits(float(np.median(known)))
    return told if known.size == times.size else f"{told} ({known.size} of {times.size})"


def effect_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene of effects."""
    return [effect_table(data) for data in datasets.values() if "kernel_time" in data]


def effect_words(datasets: Datasets) -> str:
    """Say which targets are met and by how much the others are missed."""
    costs = [data for data in datasets.values() if "kernel_time" in data]
    return " ".join(describe_effects(data, Options()) for data in costs)


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
                number(float(full["time_ratio"]), 2),
                digits(float(own["bytes_per_row"])),
                number(float(full["bytes_ratio"]), 2),
                f"{number(float(one['target']), 3)} of {breakable(against)}" if asked else DASH,
                spread_words(one, "target_ratio") if asked or against != "all effects" else DASH,
                VERDICTS.get(int(one["target_met"]), DASH),
            ]
        )
    head = ["", "effects", "outputs", "ns", "over all effects", "over full", "bytes", "over full"]
    return Table([*head, "target", "measured", "passed"], rows)


def spread_words(one: xr.Dataset, name: str) -> str:
    """Write a median with its quartiles."""
    middle, low, high = (float(one[f"{name}{side}"]) for side in ("", "_low", "_high"))
    return f"{digits(middle)} ({digits(low)} to {digits(high)})"


def effects_words(names: str) -> str:
    """Write the effects of a motion; all of them in a word."""
    if not names:
        return DASH
    return "all" if set(names.split(", ")) == set(NAMES) else breakable(names)
