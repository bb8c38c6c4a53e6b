"""Lines of branches: pieces of one stability and law, values along them, and bifurcations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import orbit_texts
from vibropipe.figures.text import (
    ORDINALS,
    flag_texts,
    format_number,
    in_brackets,
    parameter_names,
    symbol_of,
)
from vibropipe.report.findings import at_text, symbol_text
from vibropipe.report.parts import Table
from vibropipe.solve.branch import problem
from vibropipe.solve.rebuild import exciter_of, ties_of
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.vocabulary import held_name, quantity

SAME_VALUES = 1e-6  # relative difference of parameters of mirror images
SEEN = 1e-4  # of the heights of a panel: lines nearer than this are one


class Panel(NamedTuple):
    """A panel: its label, and the values of each line, (points, lines).

    `backbone` is the line of the free motion; `both` has the values of both supports, of which `values` has one where
    the lines of mirror images make both alike.
    """

    label: str
    values: np.ndarray
    backbone: np.ndarray | None = None
    both: np.ndarray | None = None


class Piece(NamedTuple):
    """Consecutive points of a branch of one stability and one law of motion."""

    points: slice
    law: str
    is_stable: bool
    value: float


def colour_of(colours: Mapping[Any, str], law: str, value: float) -> str:
    """Return the colour of a law, or that of a value of the further parameter."""
    return colours.get(law) or colours[value]


def followed(dataset: xr.Dataset) -> str:
    """Return the parameter along which the branches were followed."""
    return str(dataset.attrs["follow"]).split()[0]


def is_symmetric(dataset: xr.Dataset) -> bool:
    """Return whether the exciter is its own mirror image, half a forcing period later, all along the branches."""
    along = dataset[followed(dataset)].values
    ends = (int(along.argmin()), int(along.argmax()))
    return all(problem.is_symmetric(exciter_of(dataset.isel(point=n))) for n in ends)


def has_points(dataset: xr.Dataset) -> bool:
    """Return whether a dataset holds a branch, and not only what `vp.motor` returns of it."""
    return "point" in dataset.dims


def swept(dataset: xr.Dataset) -> str | None:
    """Return the further parameter with several values, or None."""
    ties = ties_of(dataset)
    known = {followed(dataset), *(held_name(dataset, name) for name in ties.parameters)}
    names = [name for name in (*parameter_names(dataset), *ties.own) if name not in known]
    return next((name for name in names if dataset[name].dims == ("point",)), None)


def values_beside(dataset: xr.Dataset) -> np.ndarray:
    """Return the further parameter at each point; zeros without one."""
    over = swept(dataset)
    return dataset[over].values if over else np.zeros(dataset.sizes["point"])


def with_values_beside(table: Table, dataset: xr.Dataset, values: Iterable[float]) -> Table:
    """Return a table with the value of the further parameter of each row as its first column; as it is without one."""
    if (over := swept(dataset)) is None:
        return table
    return replace(
        table,
        head=[in_brackets(symbol_text(dataset[over]), dataset[over]), *table.head],
        rows=[[format_number(value), *row] for value, row in zip(values, table.rows, strict=True)],
        widths=table.widths and ("auto", *table.widths),
        left=table.left + 1,
    )


def place_text(dataset: xr.Dataset, point: int) -> str:
    """Write where a point lies: ν = 1.723, f = 1."""
    names = filter(None, (followed(dataset), swept(dataset)))
    return at_text(dataset[name][point] for name in names)


def panels_of(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> list[Panel]:
    """Return the panels of the quantities to show, of harmonics the first, without supports that are not struck."""
    panels: list[Panel] = []
    for name in show:
        entry, array = quantity(name), dataset[name]
        if name == "impact_velocity":
            text = in_brackets("velocity of each impact", array)
            panels.append(Panel(text, velocities_of(dataset)))
        elif "harmonic" in entry.dims:
            free = free_values(backbone, name, harmonic=1)
            values = array.sel(harmonic=1).values[:, None]
            text = in_brackets(f"{ORDINALS[0]} harmonic {symbol_of(array, 1)}", array)
            panels.append(Panel(text, values, free))
        elif "support" in entry.dims:
            text = entry.short or entry.long_name
            supports = dataset["support"].values.tolist()
            are_alike = both_alike(dataset, array)
            for support in supports[:1] if are_alike else supports:
                values = array.sel(support=support).values[:, None]
                if np.isfinite(values).any():
                    free = free_values(backbone, name, support=support)
                    who = "each support" if are_alike else f"support {support}"
                    label = in_brackets(f"{text}, {who}", array)
                    both = array.transpose("point", "support").values if are_alike else None
                    panels.append(Panel(label, values, free, both))
        else:
            free = free_values(backbone, name)
            text = in_brackets(f"{entry.long_name} {symbol_of(array)}", array)
            panels.append(Panel(text, array.values[:, None], free))
    return panels


def both_alike(dataset: xr.Dataset, array: xr.DataArray) -> bool:
    """Return whether the lines of both supports are the same, those of mirror images taken together."""
    along, beside = dataset[followed(dataset)].values, values_beside(dataset)
    # points of mirror images differ by rounding
    along = np.round(along / np.ptp(along), 8)
    first, second = (array.sel(support=support).values for support in (1, 2))
    seen = SEEN * np.ptp(first[np.isfinite(first)]) if np.isfinite(first).any() else 0.0
    orders = [np.lexsort([values, along, beside]) for values in (first, second)]
    return bool(
        np.allclose(
            first[orders[0]], second[orders[1]], rtol=0.0, atol=seen + 1e-12, equal_nan=True
        )
        and np.allclose(along[orders[0]], along[orders[1]], rtol=SAME_VALUES, atol=0.0)
    )


def free_values(backbone: xr.Dataset | None, name: str, **index: int) -> np.ndarray | None:
    """Return a quantity of the free motion over its amplitude; None without a backbone that has it."""
    if backbone is None or name not in backbone:
        return None
    return np.asarray(backbone[name].sel(index).values)


def velocities_of(dataset: xr.Dataset) -> np.ndarray:
    """Return the velocity of each impact of each point, NaN beyond the last: (points, impacts).

    Whichever impact comes first in an orbit, a column follows one impact along a branch while their number is the same.
    """
    sizes, branches = dataset["row_size"].values, dataset["branch_id"].values
    velocities = np.full((sizes.size, max(int(sizes.max(initial=0)), 1)), np.nan)
    velocities[np.arange(velocities.shape[1]) < sizes[:, None]] = np.abs(dataset["impact_velocity"])
    follows = (np.diff(branches, prepend=-1) == 0) & (np.diff(sizes, prepend=-1) == 0)
    for point in np.flatnonzero(follows & (sizes > 0)):
        own, before = velocities[point, : sizes[point]], velocities[point - 1, : sizes[point]]
        expected = before
        if follows[point - 1]:  # tells two lines apart where they cross
            expected = 2.0 * before - velocities[point - 2, : sizes[point]]
        turned = np.stack([np.roll(own, shift) for shift in range(own.size)])
        own[:] = turned[np.abs(turned - expected).sum(axis=1).argmin()]
    return velocities


def stable_points(dataset: xr.Dataset) -> np.ndarray:
    """Return whether the orbit at each point is stable; right at a change, those beside it tell."""
    branches, stable = dataset["branch_id"].values, dataset["stable"].values == 1
    changes = dataset["bifurcation_kind"].values == Bifurcation.CHANGE
    inner = dataset["bifurcation_point"].values[changes].astype(int)
    inner = inner[(inner > 0) & (inner < stable.size - 1)]
    before, after = inner - 1, inner + 1
    stable[inner] |= stable[before] & stable[after] & (branches[before] == branches[after])
    return stable


def pieces_of(dataset: xr.Dataset) -> Iterator[Piece]:
    """Yield the pieces of all branches; each ends at the first point of the next one of its branch."""
    branches, stable = dataset["branch_id"].values, stable_points(dataset)
    laws, values = orbit_texts(dataset, "point"), values_beside(dataset)
    keys = list(zip(branches, stable, laws, strict=True))
    cuts = [0, *(n + 1 for n in range(len(keys) - 1) if keys[n] != keys[n + 1]), len(keys)]
    for start, stop in pairwise(cuts):
        joined = stop < len(keys) and branches[stop] == branches[start]
        yield Piece(
            slice(start, stop + joined), laws[start], bool(stable[start]), float(values[start])
        )


# Kinds of bifurcations whose names are those of people.
NAMED = {"neimark sacker": "Neimark-Sacker bifurcation"}
KINDS = {code: NAMED.get(name, name) for code, name in flag_texts("bifurcation_kind").items()}


def kinds_present(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the mask of each kind of bifurcation that occurs."""
    codes = dataset["bifurcation_kind"].values
    masks = {name: codes == code for code, name in KINDS.items()}
    return {name: mask for name, mask in masks.items() if mask.any()}


# Distance, as a share of the range followed, within which bifurcations of one kind are one.
SAME_PLACE = 1e-9


def places_of(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Return for each kind that occurs the parameter at its places, in order.

    Mirror images have the same bifurcation, and at a grazing all branches end that meet there. Places at several values
    of a further parameter are several.
    """
    along = followed(dataset)
    at = dataset[f"bifurcation_{along}"].values
    beside = values_beside(dataset)[dataset["bifurcation_point"].values]
    reach = SAME_PLACE * float(np.ptp(dataset[along].values))
    places = {}
    for kind, mask in kinds_present(dataset).items():
        found = []
        for value in np.unique(beside[mask]):
            own = np.sort(at[mask & (beside == value)])
            found.append(own[np.diff(own, prepend=-np.inf) > reach])
        places[kind] = np.sort(np.concatenate(found))
    return places


MIN_FLIPS = 3  # of a cascade: two steps, whose ratio is known


def cascade_of(dataset: xr.Dataset) -> list[float]:
    """Return the places of flips of an orbit, of that of twice the period, and so on, each step smaller than the last.

    The list is empty with fewer than MIN_FLIPS, with a further parameter, or where an orbit of one of these periods
    flips at several places.
    """
    if swept(dataset) is not None:
        return []
    is_flip = dataset["bifurcation_kind"].values == Bifurcation.FLIP
    points = dataset["bifurcation_point"].values[is_flip]
    at = dataset[f"bifurcation_{followed(dataset)}"].values[is_flip]
    multiples = dataset["period_multiple"].values[points]
    reach = SAME_PLACE * float(np.ptp(dataset[followed(dataset)].values))
    multiple, places = int(multiples.min(initial=1 << 30)), []
    while (own := at[multiples == multiple]).size and np.ptp(own) <= reach:
        places.append(float(own[0]))
        multiple *= 2
    steps = np.diff(places)
    shrinks = (
        steps.size and np.all(steps[1:] * steps[:-1] > 0) and np.all(np.diff(np.abs(steps)) < 0)
    )
    return places if len(places) >= MIN_FLIPS and shrinks else []
