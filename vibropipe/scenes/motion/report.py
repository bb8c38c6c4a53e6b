"""Part of the report on motions: steady states in one table, and how they differ."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.stability import stability_text
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    REGIME_TEXT,
    departure,
    format_number,
    in_brackets,
    regime_name,
    scalar_parameters,
    with_units,
)
from vibropipe.report.findings import value_text
from vibropipe.report.parts import answers_of, lines_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.motion.findings import findings
from vibropipe.scenes.motion.orbit_cells import DIGITS, multipliers_text, struck, struck_text
from vibropipe.words.vocabulary import PLAIN_SYMBOLS
from vibropipe.words.wording import series

STEADY_CAPTION = (
    "Steady states: regime, period multiple m, velocities before the impacts on the two supports (before a rest the "
    "largest), constant part and harmonics of displacement, Floquet multipliers."
)
CONTACT_CAPTION = " Beside them the largest force of each soft support, and its longest contact."
STEADY_TITLE, ASYMMETRY_TITLE = "Steady states of the motions", "Effect of each asymmetry"
ASYMMETRIES = {"delta", "R1", "R2", "load", "f2", "phi2", "F2"}
HARMONICS = 2  # rows of the table


def steady_scenes(datasets: Datasets) -> dict[str, xr.Dataset]:
    """Return the motions with a steady state and its multipliers, in study order."""
    return {
        name: dataset
        for name, dataset in datasets.items()
        if "floquet_multiplier" in dataset and "regime" in dataset and not dataset["regime"].ndim
    }


def steady_tables(datasets: Datasets) -> list[Table]:
    """Return tables of steady states, one column per scene, as many as fit on a page."""
    return [steady_table(block) for block in blocks(datasets)]


def steady_table(datasets: Datasets) -> Table:
    """Return a table of one row per quantity, after the parameters in which the scenes differ."""
    scenes = list(datasets.values())
    rows = [
        [
            with_unit(name, next(data for data in scenes if name in data.variables)),
            *(format_number(value, DIGITS) for value in values),
        ]
        for name, values in differing(datasets).items()
    ]
    rows.append(["regime", *(REGIME_TEXT[regime_name(int(d["regime"]))] for d in scenes)])
    rows.append(["multiple", *(str(int(d["period_multiple"]) or DASH) for d in scenes)])
    for support in (1, 2):
        cells = [struck_text(d, support) for d in scenes]
        rows.append([with_unit(f"impacts_{support}", scenes[0], "orbit_impact_velocity"), *cells])
    contacts = contact_rows(scenes)
    rows += contacts
    if any(rests(d) for d in scenes):
        rows.append(["rests", *(format_number(rests(d)) for d in scenes)])
    label = with_unit("mean", scenes[0], "displacement_mean")
    rows.append([label, *(format_number(mean(d), DIGITS) for d in scenes)])
    for k in range(HARMONICS):
        label = with_unit(f"harmonic {k + 1}", scenes[0], "displacement_amplitude")
        rows.append([label, *(format_number(harmonic(d, k), DIGITS) for d in scenes)])
    rows.append(["multipliers", *(multipliers_text(d) for d in scenes)])
    rows.append(["stability", *(stability_text(d) or DASH for d in scenes)])
    return Table(
        ["", *map(breakable, datasets)],
        rows,
        STEADY_CAPTION + (CONTACT_CAPTION if contacts else ""),
    )


def contact_rows(scenes: Sequence[xr.Dataset]) -> list[list[str]]:
    """Return the rows of the largest force and the longest contact of each soft support that is struck."""
    rows = []
    for text, name in (("force", "support_force_max"), ("contact", "contact_duration_max")):
        with_contacts = [dataset for dataset in scenes if name in dataset]
        for support in (1, 2):
            values = [
                float(dataset[name].sel(support=support)) if name in dataset else math.nan
                for dataset in scenes
            ]
            if np.isfinite(values).any():
                cells = [DASH if math.isnan(v) else format_number(v, DIGITS) for v in values]
                rows.append(
                    [with_unit(f"{text}, support {support}", with_contacts[0], name), *cells]
                )
    return rows


def with_unit(text: str, dataset: xr.Dataset, name: str = "") -> str:
    """Return the name of a row with the unit of a variable in brackets (default: of the variable of that name)."""
    name = name or text
    return in_brackets(text, dataset[name]) if name in dataset.variables else text


def differing(datasets: Datasets) -> dict[str, list[float]]:
    """Return the parameters that differ between scenes, with their values."""
    by_scene = [scalar_parameters(dataset) for dataset in datasets.values()]
    # Parameters of further effects are stored where the effect is present, and 0 elsewhere.
    names = dict.fromkeys(name for values in by_scene for name in values)
    found = {name: [values.get(name, 0.0) for values in by_scene] for name in names}
    return {name: values for name, values in found.items() if len({*values}) > 1}


def hardest(dataset: xr.Dataset, support: int) -> float:
    """Return the largest speed before an impact of the orbit on a support, 0 if there is none."""
    return max((abs(v) for v in struck(dataset, support)), default=0.0)


def rests(dataset: xr.Dataset) -> float:
    """Return the number of rests of the orbit on both supports."""
    return float(dataset["rests_per_orbit"].sum()) if "rests_per_orbit" in dataset else 0.0


def harmonic(dataset: xr.Dataset, k: int) -> float:
    """Return the displacement amplitude at index `k` (0: first harmonic), nan if not stored."""
    if "displacement_amplitude" not in dataset or k >= dataset.sizes["harmonic"]:
        return float("nan")
    return without_rounding(dataset, float(dataset["displacement_amplitude"].values[k]))


def mean(dataset: xr.Dataset) -> float:
    """Return the constant part of displacement, nan if not stored."""
    if "displacement_mean" not in dataset:
        return float("nan")
    return without_rounding(dataset, float(dataset["displacement_mean"]))


def without_rounding(dataset: xr.Dataset, value: float) -> float:
    """Return a value, or 0 if it is a rounding error relative to the first harmonic."""
    first = abs(float(dataset["displacement_amplitude"].values[0]))
    return 0.0 if abs(value) <= ROUNDING * first else value


def largest_multiplier(dataset: xr.Dataset) -> float:
    """Return the largest modulus of a Floquet multiplier."""
    return float(np.abs(dataset["floquet_multiplier"].values).max())


def comparison(datasets: Datasets) -> dict[str, Any]:
    """Compare each scene with one of them: different parameters, and changes of the steady state.

    Scenes without an orbit are left out. Scenes that differ only in asymmetries are compared with the symmetric one,
    others with the first.

    Returns `title`, `opening`, `items` (name and text of each scene) and `closing` of a `Section`.
    """
    datasets = {n: d for n, d in datasets.items() if int(d["period_multiple"]) > 0}
    if len(datasets) < 2:
        return {"title": STEADY_TITLE}
    symmetric = [name for name, data in datasets.items() if is_symmetric(data)]
    is_asymmetry = bool(symmetric) and set(differing(datasets)) <= ASYMMETRIES
    base = symmetric[0] if is_asymmetry else next(iter(datasets))
    kind = "symmetric" if is_asymmetry else "first"
    return {
        "title": ASYMMETRY_TITLE if is_asymmetry else STEADY_TITLE,
        "opening": f"Compared with the {kind} scene, {breakable(base)}:",
        "items": [
            {"name": breakable(name), "text": compare(datasets[base], data)}
            for name, data in datasets.items()
            if name != base
        ],
        "closing": strongest(datasets),
    }


def is_symmetric(dataset: xr.Dataset) -> bool:
    """Return whether the exciter is symmetric: equal supports about the equilibrium, and no second harmonic."""
    values = scalar_parameters(dataset)
    is_centred = values.get("delta") == 0.0 and not any(values.get(n) for n in ("load", "f2", "F2"))
    pairs = (("R1", "R2"), ("k1", "k2"), ("C1", "C2"), ("h1", "h2"), ("H1", "H2"))
    return is_centred and all(values.get(one) == values.get(other) for one, other in pairs)


def compare(base: xr.Dataset, other: xr.Dataset) -> str:
    """Write in one sentence how the steady state of another scene differs."""
    values, base_values = scalar_parameters(other), scalar_parameters(base)
    changed = series(
        f"{PLAIN_SYMBOLS[key]} = {value_text(array, value)} instead of {value_text(array, before)}"
        for key in dict.fromkeys((*values, *base_values))
        for value, before in [(values.get(key, 0.0), base_values.get(key, 0.0))]
        for array in [other[key] if key in values else base[key]]
        if value != before
    )
    changes = []
    if int(base["regime"]) != int(other["regime"]):
        regimes = [REGIME_TEXT[regime_name(int(d["regime"]))] for d in (base, other)]
        changes.append(f"the regime changes from {regimes[0]} to {regimes[1]}")
    moved = step(mean(base), mean(other), unit_of(other, "displacement_mean"))
    changes.append(f"the constant part of displacement changes {moved}")
    for support in (1, 2):
        before, after = hardest(base, support), hardest(other, support)
        changes.append(
            f"the impact velocity on support {support} "
            f"{step(before, after, unit_of(other, 'orbit_impact_velocity'), share=True)}"
        )
    second = step(harmonic(base, 1), harmonic(other, 1), unit_of(other, "displacement_amplitude"))
    changes.append(f"the second harmonic {second}")
    largest = step(largest_multiplier(base), largest_multiplier(other))
    changes.append(f"the larger multiplier {largest}")
    return f"{changed or 'the same parameters'}: {series(changes)}."


def unit_of(dataset: xr.Dataset, name: str) -> str:
    """Return the unit of a variable as text, empty if it has none or is not stored."""
    return with_units(dataset[name], "") if name in dataset.variables else ""


def step(before: float, after: float, unit: str = "", share: bool = False) -> str:
    """Write a change from one value to another, with the relative change if `share`."""
    text = f"from {format_number(before)} to {f'{format_number(after)} {unit}'.strip()}"
    if share and before:
        return f"{text} ({signed_percent(after / before - 1.0)})"
    return text


def signed_percent(share: float) -> str:
    """Write a share as a signed percentage: +5.7 %."""
    size = abs(100.0 * share)
    # two digits, but no power of ten of a hundred
    text = f"{size:.0f}" if 99.5 <= size < 1e6 else format_number(size, 2)
    return f"{'+' if share >= 0 else '−'}{text} %"


def strongest(datasets: Datasets) -> str:
    """Write the scenes with the largest constant part and the most unequal impact velocities."""
    displaced = max(datasets, key=lambda name: abs(np.nan_to_num(mean(datasets[name]))))
    unequal = {
        name: abs(hardest(data, 1) - hardest(data, 2))
        / (max(hardest(data, 1), hardest(data, 2)) or 1)
        for name, data in datasets.items()
    }
    uneven = max(unequal, key=lambda name: unequal[name])
    first, second = (harmonic(datasets[uneven], k) for k in (0, 1))
    ratio = ""
    if first > 0.0 and not np.isnan(second):  # a mass at rest has no harmonics to compare
        ratio = f"; there the second harmonic is {format_number(100 * second / first, 2)} % of the first"
    top = value_text(datasets[displaced]["displacement_mean"], mean(datasets[displaced]))
    return (
        f"The constant part is largest in {breakable(displaced)}, {top}. The impact velocities on the two "
        f"supports differ most in {breakable(uneven)}, by "
        f"{format_number(100 * unequal[uneven], 2)} % of the larger one{ratio}."
    )


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on steady states and their differences, if motions have any."""
    steady = steady_scenes(datasets)
    if not steady:
        return []
    return [Section(tables=steady_tables(steady), **comparison(steady))]


def accuracy_notes(datasets: Datasets) -> list[str]:
    """Write the largest deviation of a stepping method from the exact motion."""
    departures = {n: departure(d) for n, d in datasets.items() if "displacement_exact" in d}
    if not departures:
        return []
    worst = max(departures, key=lambda name: departures[name])
    return [
        f"Displacements computed in steps differ from the exact motion of the same start by at most "
        f"{value_text(datasets[worst]['displacement'], departures[worst], 2)}, in {breakable(worst)}."
    ]


def question(datasets: Datasets) -> str:
    """Return the question of motions."""
    if len(datasets) == 1:
        return "How does the mass move, and how hard does it strike?"
    return "How do these motions differ?"


REPORT = ReportPart(
    "Motions",
    question,
    answers_of(findings),
    tables_of(sections),
    lines_of("Compared with", accuracy_notes),
)
