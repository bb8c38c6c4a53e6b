"""Stable stretches of branches, where several have values in common, and the places of bifurcations and cascades."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import words_of
from vibropipe.figures.text import flag_texts
from vibropipe.scenes.branch.lines import followed, kinds_present, pieces_of, swept
from vibropipe.words.bifurcations import Bifurcation

# Distance, as a share of the range followed, within which bifurcations of one kind are one.
SAME_PLACE = 1e-9

PLURALS = {
    "fold": "folds",
    "flip": "flips",
    "pitchfork": "pitchforks",
    "grazing": "grazings",
    "change": "changes of contacts, turns or sticks",
}


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


KINDS = flag_texts("bifurcation_kind")
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
        )


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
