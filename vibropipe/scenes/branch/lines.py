"""Lines of branches: pieces of one stability and law, values along them, bifurcations, and where motions coexist."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import orbit_texts, words_of
from vibropipe.figures.text import ORDINALS, flag_texts, in_brackets, parameter_names, symbol_of
from vibropipe.solve.rebuild import ties_of
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import held_name, quantity

UNKNOWN, NOT_STABLE = "unknown", -2
SAME_VALUES = 1e-6  # relative difference of what mirrored supports have alike


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


def followed(dataset: xr.Dataset) -> str:
    """Return the parameter along which the branches were followed."""
    return str(dataset.attrs["follow"]).split()[0]


def swept(dataset: xr.Dataset) -> str | None:
    """Return the further parameter with several values, or None."""
    ties = ties_of(dataset)
    known = {followed(dataset), *(held_name(dataset, name) for name in ties.parameters)}
    names = [name for name in (*parameter_names(dataset), *ties.own) if name not in known]
    return next((name for name in names if dataset[name].dims == ("point",)), None)


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
    along, over = dataset[followed(dataset)].values, swept(dataset)
    beside = dataset[over].values if over else np.zeros(along.size)
    # points of mirror images differ by rounding
    along = np.round(along / np.ptp(along), 8)
    first, second = (array.sel(support=support).values for support in (1, 2))
    orders = [np.lexsort([values, along, beside]) for values in (first, second)]
    return bool(
        np.allclose(
            first[orders[0]], second[orders[1]], rtol=SAME_VALUES, atol=1e-12, equal_nan=True
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


def pieces_of(dataset: xr.Dataset) -> Iterator[Piece]:
    """Yield the pieces of all branches; each ends at the first point of the next one of its branch."""
    branches, stable = dataset["branch_id"].values, dataset["stable"].values
    laws, over = orbit_texts(dataset, "point"), swept(dataset)
    values = dataset[over].values if over else np.zeros(branches.size)
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
    along, over = followed(dataset), swept(dataset)
    at = dataset[f"bifurcation_{along}"].values
    beside = dataset[over].values[dataset["bifurcation_point"].values] if over else 0.0 * at
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


# Values closer than this share of the range followed are the same; so are amplitudes of the same motion.
SAME = 1e-6


@dataclass(frozen=True)
class Stretch:
    """Stable orbits of one law between two values of the parameter, and the bifurcation at either end, if any."""

    values: np.ndarray
    amplitudes: np.ndarray
    speeds: np.ndarray
    law: str
    words: str
    over: float
    ends: tuple[str, str]
    from_rest: np.ndarray
    means: np.ndarray

    def reaches(self, value: float) -> bool:
        """Return whether a value of the parameter lies on the stretch or at its ends."""
        return bool(self.values[0] <= value <= self.values[-1])

    def amplitude(self, value: float) -> float:
        """Return the first harmonic at a value of the parameter."""
        return float(np.interp(value, self.values, self.amplitudes))

    def speed(self, value: float) -> float:
        """Return the largest impact velocity at a value of the parameter."""
        return float(np.interp(value, self.values, self.speeds))


def stretches_of(dataset: xr.Dataset) -> Iterator[Stretch]:
    """Yield the stable stretches of all branches, with increasing parameter."""
    along = dataset[followed(dataset)].values
    amplitude = dataset["displacement_amplitude"].sel(harmonic=1).values
    speed = np.nan_to_num(dataset["impact_velocity_max"].max("support").values)
    mean = dataset["displacement_mean"].values if "displacement_mean" in dataset else 0.0 * along
    points = dataset["bifurcation_point"].values
    kinds = [KINDS[int(code)] for code in dataset["bifurcation_kind"].values]
    branches, stable = dataset["branch_id"].values, dataset["stable"].values
    moduli = np.abs(dataset["floquet_multiplier"].values).max(axis=-1)
    over = dataset[swept(dataset)].values if swept(dataset) else np.zeros(along.size)
    gap = SAME * float(along.max() - along.min())

    def beside(index: int) -> str:
        """Return the bifurcation of another branch at which this one ends: a grazing is stored with one of them."""
        is_there = (np.abs(along[points] - along[index]) <= gap) & (over[points] == over[index])
        return kinds[int(is_there.argmax())] if is_there.any() else ""

    for piece in pieces_of(dataset):
        first, last = piece.points.start, piece.points.stop - 1
        # Where a branch begins, at a flip or a pitchfork of another, its multiplier is 1 but for rounding.
        is_first_alone = (
            last == first + 1 and not stable[last] and branches[first - 1] < branches[first]
        )
        if not piece.is_stable or (is_first_alone and moduli[first] > 1.0 - SAME):
            continue
        ends = []
        for index, is_first in ((first, True), (last, False)):
            near = {
                point: kind
                for point, kind in zip(points.tolist(), kinds, strict=True)
                if abs(point - index) <= 1 and branches[point] == branches[first]
            }
            # Next to a bifurcation that ends stability, pieces may change without consequence.
            kind = min(near.values(), key=lambda each: each == "change", default="")
            before = index - 1
            if is_first and not near and before >= 0 and branches[before] == branches[index]:
                kind = (
                    beside(before) if before == 0 or branches[before - 1] < branches[before] else ""
                )
                first -= bool(kind)
            ends.append(kind or beside(index))
            # stability ends at the bifurcation itself, which is a point, maybe the one before or after the piece
            if near and is_first:
                first = max(near)
            elif near:
                last = min(near)
        if last <= first:
            continue
        order = slice(None) if along[last] > along[first] else slice(None, None, -1)
        yield Stretch(
            np.maximum.accumulate(along[first : last + 1][order]),
            amplitude[first : last + 1][order],
            speed[first : last + 1][order],
            piece.law,
            words_of(dataset.isel(point=piece.points.start)),
            piece.value,
            (ends[0], ends[1]) if order.step is None else (ends[1], ends[0]),
            from_rest_of(dataset, slice(first, last + 1))[order],
            mean[first : last + 1][order],
        )


def from_rest_of(dataset: xr.Dataset, points: slice) -> np.ndarray:
    """Return the codes of `from_rest` of some points, of which those at the ends may not be stable."""
    n = points.stop - points.start
    if "from_rest" not in dataset:
        return np.full(n, FLAGS["settled_same"]["unknown"])
    stable = dataset["stable"].values[points] == 1
    return np.where(stable, dataset["from_rest"].values[points], NOT_STABLE)


def rest_text(alike: Sequence[Stretch]) -> str:
    """Write whether the mass settles on a stretch, or one of its mirror images, from rest."""
    first, known = alike[0], FLAGS["settled_same"]
    codes = first.from_rest
    for other in alike[1:]:
        nearest = np.abs(first.values[:, None] - other.values).argmin(axis=1)
        codes = np.maximum(codes, other.from_rest[nearest])
    codes = codes[codes != NOT_STABLE]
    told = np.flatnonzero(codes != known["unknown"])
    # What is not known of the ends alone, which are borders, leaves all between them.
    codes = codes[told[0] : told[-1] + 1] if told.size else codes
    if not (codes == known["same"]).any():
        return "no" if codes.size and (codes == known["other"]).all() else UNKNOWN
    return "yes" if (codes == known["same"]).all() else "in part"


def common_intervals(stretches: list[Stretch]) -> list[tuple[float, float]]:
    """Return the intervals that at least two stretches have in common."""
    ends = sorted({float(v) for s in stretches for v in (s.values[0], s.values[-1])})
    least = SAME * (ends[-1] - ends[0]) if ends else 0.0
    intervals: list[tuple[float, float]] = []
    for low, high in pairwise(ends):
        middle = (low + high) / 2
        if high - low <= least or sum(s.reaches(middle) for s in stretches) < 2:
            continue
        if intervals and low - intervals[-1][1] <= least:
            low = intervals.pop()[0]
        intervals.append((low, high))
    return intervals
