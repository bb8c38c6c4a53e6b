"""Captions of the pictures of designs, written from their data."""

from __future__ import annotations

import re

import xarray as xr

from vibropipe.figures.text import (
    format_number,
    orbit_texts,
    plain_symbol,
    plain_symbol_of,
    sentences,
    with_units,
)
from vibropipe.figures.units import unit_text
from vibropipe.scenes.design.data import (
    Part,
    has_spread,
    objectives,
    part_of,
    spread_parts,
    varied,
    wanted_parts,
)
from vibropipe.scenes.design.spread_pictures import NO_SPREAD
from vibropipe.solve.shown_units import shown_unit
from vibropipe.words.designs import DesignResult
from vibropipe.words.wording import count, series

# A number of a goal, `displacement_mean = -0.05 m; ...`, not of a name, with its unit if any.
_NUMBER = re.compile(r"(?<![\w.])([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)(?: ([A-Za-z][^,;]*))?")


def wanted_text(dataset: xr.Dataset) -> str:
    """Write what is wanted, one goal after the other."""
    least = [
        f"{'largest' if text.startswith('-') else 'least'} {text.removeprefix('-')}"
        for text in objectives(dataset)
    ]
    return "; ".join([*goal_texts(dataset), *least])


def goal_texts(dataset: xr.Dataset) -> list[str]:
    """Write targets and bounds, with their numbers in the units that the dataset shows."""
    goals = [str(dataset.attrs[key]) for key in ("target", "subject_to") if key in dataset.attrs]
    return [_NUMBER.sub(lambda match: _shown_number(dataset, *match.groups()), g) for g in goals]


def _shown_number(dataset: xr.Dataset, number: str, units: str | None) -> str:
    """Write a number of a goal, given in stored units, in the units shown."""
    unit, factor = shown_unit(dataset, units or "1")
    return f"{format_number(factor * float(number), 6)} {unit_text(unit)}".strip()


def value_of(dataset: xr.Dataset, part: Part, row: int) -> str:
    """Write a quantity of a design with its unit."""
    values = part.of(dataset)
    return with_units(values, format_number(float(values.values[row])))


def place_text(dataset: xr.Dataset, row: int) -> str:
    """Write the varied parameters of a design."""
    return ", ".join(
        f"{plain_symbol_of(array)} = {with_units(array, format_number(float(array.values[row])))}"
        for array in (dataset[name] for name in varied(dataset))
    )


def reached_text(dataset: xr.Dataset) -> str:
    """Write how many designs are met, or why the nearest is not."""
    results = [DesignResult(int(code)) for code in dataset["design_result"].values]
    if DesignResult.MET in results:
        return f"All that is wanted holds of {count(len(results), 'design')}"
    miss = format_number(float(dataset["design_miss"].values[0]), 2)
    return f"No design is met; the nearest misses by {miss} of what is wanted: {results[0].reason}"


def describe_designs(dataset: xr.Dataset) -> str:
    """Return the caption of the designs beside each other."""
    best = ", ".join(
        f"{part.name} = {value_of(dataset, part, 0)}" for part in wanted_parts(dataset)
    )
    return sentences(
        f"Designs with {wanted_text(dataset)}: varied parameters, wanted quantities, and below the distance to the "
        "nearest change of the law of motion, in shares of the ranges",
        reached_text(dataset),
        f"Design 1, of law {orbit_texts(dataset, 'design')[0]}, has {place_text(dataset, 0)} and {best}",
    )


def describe_front(dataset: xr.Dataset) -> str:
    """Return the caption of the Pareto front."""
    rows = (0, dataset.sizes["design"] - 1)
    parts = [part_of(dataset, text.removeprefix("-")) for text in objectives(dataset)]
    ends = [
        f"design {row + 1} with "
        + series(f"{part.name} = {value_of(dataset, part, row)}" for part in parts if part)
        for row in rows
    ]
    given = goal_texts(dataset)
    return sentences(
        f"Designs of which none improves one quantity without harm to the other: {wanted_text(dataset)}",
        "Markers: laws of motion; numbers: designs of the table",
        f"The front goes from {' to '.join(ends)}"
        + (f", under {'; '.join(given)}" if given else ""),
    )


def describe_tornado(dataset: xr.Dataset) -> str:
    """Return the caption of the bars of each parameter."""
    if not has_spread(dataset):
        return sentences(NO_SPREAD)
    return sentences(
        "Deviation of the wanted quantities of design 1 if one parameter alone is off by three standard deviations, "
        "marched anew; ticks: first order",
        f"Most of the spread of {series(leading(dataset))}",
    )


def leading(dataset: xr.Dataset, in_words: bool = False) -> list[str]:
    """Write, for each wanted quantity by its name or in words, which parameter matters most for its spread."""
    best = dataset.isel(design=0)
    texts = []
    for part in spread_parts(dataset):
        share = part.of(best, "_contribution")
        most = int(share.fillna(-1).argmax("parameter"))
        name = plain_symbol(str(best["parameter"].values[most]))
        if float(share[most]) > 0:
            quantity = f"the {part.plain_words(dataset)}" if in_words else part.name
            texts.append(f"{quantity} comes from {name} ({100 * float(share[most]):.0f} %)")
    return texts


def describe_sensitivities(dataset: xr.Dataset) -> str:
    """Return the caption of the map of shares."""
    if not has_spread(dataset):
        return sentences(NO_SPREAD)
    return sentences(
        "Share of each parameter in the variance of each quantity of design 1, to first order; minus: the quantity "
        "falls where the parameter rises",
        f"Most of the spread of {series(leading(dataset))}",
    )
