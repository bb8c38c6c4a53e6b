"""Steady states side by side, and what each small asymmetry does to them, said from the data."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    REGIME_WORDS,
    departure,
    format_number,
    regime_name,
    scalar_parameters,
)
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.vocabulary import PLAIN_SYMBOLS
from vibropipe.words.wording import series

STEADY_CAPTION = (
    "Steady states side by side: regime, forcing periods m per orbit, velocities before the impacts on the two "
    "supports, constant part and harmonics of displacement, Floquet multipliers."
)
HARMONICS = 3
DIGITS = 4


def steady_scenes(datasets: Datasets) -> dict[str, xr.Dataset]:
    """Return the motions that carry their steady state with its multipliers, in study order."""
    return {
        name: dataset
        for name, dataset in datasets.items()
        if "floquet_multiplier" in dataset and "regime" in dataset and not dataset["regime"].ndim
    }


def steady_tables(datasets: Datasets) -> list[Table]:
    """Return the table of steady states, one column per scene, cut where the page is too narrow."""
    return [steady_table(block) for block in blocks(datasets)]


def steady_table(datasets: Datasets) -> Table:
    """Return one table: a row per quantity, the parameters in which the scenes differ on top."""
    scenes = list(datasets.values())
    rows = [
        [name, *(format_number(value, DIGITS) for value in values)]
        for name, values in differing(datasets).items()
    ]
    rows.append(["regime", *(REGIME_WORDS[regime_name(int(d["regime"]))] for d in scenes)])
    rows.append(["multiple", *(str(int(d["period_multiple"])) for d in scenes)])
    for support in (1, 2):
        cells = [
            ", ".join(format_number(v, DIGITS) for v in struck(d, support)) or DASH for d in scenes
        ]
        rows.append([f"impacts_{support}", *cells])
    if any(rests(d) for d in scenes):
        rows.append(["rests", *(format_number(rests(d)) for d in scenes)])
    rows.append(["mean", *(format_number(mean(d), DIGITS) for d in scenes)])
    for k in range(HARMONICS):
        rows.append([f"harmonic {k + 1}", *(format_number(harmonic(d, k), DIGITS) for d in scenes)])
    rows.append(["multipliers", *(multipliers_words(d) for d in scenes)])
    rows.append(["stable", *("yes" if largest_multiplier(d) < 1.0 else "no" for d in scenes)])
    return Table(["", *map(breakable, datasets)], rows, STEADY_CAPTION)


def differing(datasets: Datasets) -> dict[str, list[float]]:
    """Return the parameters that are not the same in all scenes, with their values."""
    given = [scalar_parameters(dataset) for dataset in datasets.values()]
    return {
        name: [values[name] for values in given]
        for name in (given[0] if given else {})
        if len({values[name] for values in given}) > 1
    }


def struck(dataset: xr.Dataset, support: int) -> list[float]:
    """Return the velocities before the orbit's impacts on ``support``, in order."""
    if "orbit_impact_velocity" not in dataset:
        return []
    at = dataset["orbit_impact_support"].values == support
    return [float(v) for v in dataset["orbit_impact_velocity"].values[at]]


def hardest(dataset: xr.Dataset, support: int) -> float:
    """Return the largest speed before an impact of the orbit on ``support``, 0 if there is none."""
    return max((abs(v) for v in struck(dataset, support)), default=0.0)


def rests(dataset: xr.Dataset) -> float:
    """Return the rests of the orbit on both supports together."""
    return float(dataset["rests_per_orbit"].sum()) if "rests_per_orbit" in dataset else 0.0


def harmonic(dataset: xr.Dataset, k: int) -> float:
    """Return the amplitude of displacement at position ``k`` (0 is the first); nan if not kept."""
    if "displacement_amplitude" not in dataset or k >= dataset.sizes["harmonic"]:
        return float("nan")
    return without_rounding(dataset, float(dataset["displacement_amplitude"].values[k]))


def mean(dataset: xr.Dataset) -> float:
    """Return the constant part of displacement; nan if not kept."""
    if "displacement_mean" not in dataset:
        return float("nan")
    return without_rounding(dataset, float(dataset["displacement_mean"]))


def without_rounding(dataset: xr.Dataset, value: float) -> float:
    """Return 0 for what is rounding beside the first harmonic."""
    first = abs(float(dataset["displacement_amplitude"].values[0]))
    return 0.0 if abs(value) <= ROUNDING * first else value


def largest_multiplier(dataset: xr.Dataset) -> float:
    """Return the largest magnitude of a Floquet multiplier."""
    return float(np.abs(dataset["floquet_multiplier"].values).max())


def multipliers_words(dataset: xr.Dataset) -> str:
    """Write the multipliers: two real ones, or a conjugate pair once with a double sign."""
    values = np.atleast_1d(dataset["floquet_multiplier"].values)
    complex_pair = values.size == 2 and abs(values[0].imag) > 1e-12
    if complex_pair:
        return f"{format_number(values[0].real, DIGITS)} ± {format_number(abs(values[0].imag), DIGITS)} i"
    return ", ".join(format_number(float(value.real), DIGITS) for value in values)


def asymmetry(datasets: Datasets) -> dict[str, Any]:
    """Compare each scene with the symmetric one: which parameters differ, and what that changes.

    Returns an ``opening``, one of ``items`` per scene (name, text), and a ``closing`` sentence.
    """
    if len(datasets) < 2:
        return {"opening": "", "items": [], "closing": ""}
    base = next(
        (name for name, data in datasets.items() if is_symmetric(data)), next(iter(datasets))
    )
    kind = "symmetric" if is_symmetric(datasets[base]) else "first"
    return {
        "opening": f"Compared with the {kind} scene, {breakable(base)}:",
        "items": [
            {"name": breakable(name), "text": compare(datasets[base], data)}
            for name, data in datasets.items()
            if name != base
        ],
        "closing": strongest(datasets),
    }


def is_symmetric(dataset: xr.Dataset) -> bool:
    """Return whether the supports lie and throw back alike."""
    given = scalar_parameters(dataset)
    return given.get("delta") == 0.0 and given.get("R1") == given.get("R2")


def compare(base: xr.Dataset, other: xr.Dataset) -> str:
    """Say in one sentence what the other parameters change."""
    given, was = scalar_parameters(other), scalar_parameters(base)
    changed = series(
        f"{PLAIN_SYMBOLS[key]} = {format_number(value)} instead of {format_number(was[key])}"
        for key, value in given.items()
        if value != was.get(key)
    )
    effects = []
    if int(base["regime"]) != int(other["regime"]):
        regimes = [REGIME_WORDS[regime_name(int(d["regime"]))] for d in (base, other)]
        effects.append(f"the motion turns from {regimes[0]} to {regimes[1]}")
    effects.append(f"the constant part of displacement goes {step(mean(base), mean(other))}")
    for support in (1, 2):
        before, after = hardest(base, support), hardest(other, support)
        effects.append(f"the impact on support {support} {step(before, after, share=True)}")
    effects.append(f"the second harmonic {step(harmonic(base, 1), harmonic(other, 1))}")
    largest = step(largest_multiplier(base), largest_multiplier(other))
    effects.append(f"the larger multiplier {largest}")
    return f"{changed or 'the same parameters'}: {series(effects)}."


def step(before: float, after: float, share: bool = False) -> str:
    """Write a change from one value to another, with its share of the first where asked."""
    text = f"from {format_number(before)} to {format_number(after)}"
    if share and before:
        return f"{text} ({signed_percent(after / before - 1.0)})"
    return text


def signed_percent(share: float) -> str:
    """Write a share as a signed percentage: +5.7 %."""
    return f"{'+' if share >= 0 else ''}{format_number(100.0 * share, 2)} %"


def strongest(datasets: Datasets) -> str:
    """Name the scenes with the largest constant part and the most unequal impacts."""
    displaced = max(datasets, key=lambda name: abs(np.nan_to_num(mean(datasets[name]))))
    unequal = {
        name: abs(hardest(data, 1) - hardest(data, 2))
        / (max(hardest(data, 1), hardest(data, 2)) or 1)
        for name, data in datasets.items()
    }
    uneven = max(unequal, key=lambda name: unequal[name])
    first, second = (harmonic(datasets[uneven], k) for k in (0, 1))
    beside = ""
    if first > 0.0 and not np.isnan(second):  # a mass that never moves has no harmonics to compare
        beside = f"; the second harmonic has {format_number(100 * second / first, 2)} % of the first there"
    return (
        f"The constant part is largest in {breakable(displaced)}, "
        f"{format_number(mean(datasets[displaced]))}. The impacts on the two supports differ most in "
        f"{breakable(uneven)}, by {format_number(100 * unequal[uneven], 2)} % of the harder one{beside}."
    )


def sections(datasets: Datasets) -> list[Section]:
    """Return the steady states side by side and compared, where motions carry theirs."""
    steady = steady_scenes(datasets)
    if not steady:
        return []
    title = "What each small asymmetry does"
    return [Section(title, tables=steady_tables(steady), **asymmetry(steady))]


def accuracy_notes(datasets: Datasets) -> list[str]:
    """Say how far a stepping method departs from the exact motion."""
    departures = {n: departure(d) for n, d in datasets.items() if "displacement_exact" in d}
    if not departures:
        return []
    worst = max(departures, key=lambda name: departures[name])
    return [
        f"Motions computed in steps depart from the exact motion of the same start by at most "
        f"{format_number(departures[worst], 2)} in displacement, in {breakable(worst)}."
    ]


REPORT = ReportPart(sections, accuracy_notes)
