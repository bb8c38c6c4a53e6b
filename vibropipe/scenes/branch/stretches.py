"""Stretches of branches: stable orbits of one law, where several are stable, and where motions jump between them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import amount_text, number_word, words_of
from vibropipe.figures.text import format_number
from vibropipe.scenes.branch.lines import (
    KINDS,
    followed,
    is_symmetric,
    pieces_of,
    stable_points,
    values_beside,
)
from vibropipe.words.quantities import FLAGS

UNKNOWN, NOT_STABLE = "unknown", -2
# Values closer than this share of the range followed are the same; so are amplitudes of the same motion.
SAME = 1e-6
SAME_END = 1e-6  # distance of ends that are one, as a share of an interval
SAME_ORBIT = (
    0.02  # relative difference of amplitudes, means and velocities of one orbit, between points
)
MAX_WORDS = 4  # motions in words


@dataclass(frozen=True)
class Stretch:
    """Stable orbits of one law between two values of the parameter, and the bifurcation at either end, if any.

    points : indices of the points, with increasing parameter
    has_image : whether the exciter is its own mirror image, and the orbits have mirror images
    """

    values: np.ndarray
    amplitudes: np.ndarray
    speeds: np.ndarray
    law: str
    words: str
    over: float
    ends: tuple[str, str]
    from_rest: np.ndarray
    means: np.ndarray
    points: np.ndarray
    has_image: bool

    def reaches(self, value: float) -> bool:
        """Return whether a value of the parameter lies on the stretch or at its ends."""
        return bool(self.values[0] <= value <= self.values[-1])

    def amplitude(self, value: float) -> float:
        """Return the first harmonic at a value of the parameter."""
        return float(np.interp(value, self.values, self.amplitudes))

    def speed(self, value: float) -> float:
        """Return the largest impact velocity at a value of the parameter."""
        return float(np.interp(value, self.values, self.speeds))


def stretches_of(dataset: xr.Dataset) -> list[Stretch]:
    """Return the stable stretches of all branches, with increasing parameter; orbits that were followed twice once."""
    if "impact_velocity_max" not in dataset:
        return list(_followed_stretches(dataset))
    along = dataset[followed(dataset)].values
    gap = SAME * float(along.max() - along.min())
    struck = dataset["impact_velocity_max"].transpose("point", "support").values
    kept: list[Stretch] = []
    for one in _followed_stretches(dataset):
        if not any(is_same(one, other, struck, gap) for other in kept):
            kept.append(one)
    return kept


def is_same(one: Stretch, other: Stretch, struck: np.ndarray, gap: float) -> bool:
    """Return whether two stretches are of the same orbits: between the same ends, and alike in the middle.

    Mirror images meet at their ends, and differ between them in the sign of the mean or have velocities exchanged.

    struck : (point, support), the largest velocity on each
    gap : largest difference of ends that are one
    """
    ends = np.abs(one.values[[0, -1]] - other.values[[0, -1]])
    if (one.words, one.over) != (other.words, other.over) or ends.max() > gap:
        return False
    middle = (one.values[0] + one.values[-1]) / 2
    first, second = (
        [
            np.interp(middle, each.values, quantity)
            for quantity in (each.amplitudes, each.means, *np.nan_to_num(struck[each.points].T))
        ]
        for each in (one, other)
    )
    return bool(np.allclose(first, second, rtol=SAME_ORBIT, atol=SAME * max(first)))


def _followed_stretches(dataset: xr.Dataset) -> Iterator[Stretch]:
    """Yield the stable stretches of all branches, also those of an orbit that was followed twice."""
    along, over = dataset[followed(dataset)].values, values_beside(dataset)
    amplitude, speed = _sizes_of(dataset)
    mean = dataset["displacement_mean"].values if "displacement_mean" in dataset else 0.0 * along
    branches, stable = dataset["branch_id"].values, stable_points(dataset)
    moduli = np.abs(dataset["floquet_multiplier"].values).max(axis=-1)
    kinds = [KINDS[int(code)] for code in dataset["bifurcation_kind"].values]
    at, reach = dataset["bifurcation_point"].values, SAME * float(np.ptp(along))
    bifurcations = _Bifurcations(along, over, branches, at, kinds, reach)
    has_image = {v: is_symmetric(dataset.isel(point=over == v)) for v in np.unique(over).tolist()}
    for piece in pieces_of(dataset):
        first, last = piece.points.start, piece.points.stop - 1
        # Where a branch begins, at a flip or a pitchfork of another, its multiplier is 1 but for rounding.
        is_first_alone = (
            last == first + 1 and not stable[last] and branches[first - 1] < branches[first]
        )
        if not piece.is_stable or (is_first_alone and moduli[first] > 1.0 - SAME):
            continue
        ends = (bifurcations.end(first, max), bifurcations.end(last, min))
        points = np.arange(ends[0][0], ends[1][0] + 1)
        if points.size < 2:
            continue
        if along[points[-1]] <= along[points[0]]:
            points, ends = points[::-1], ends[::-1]
        yield Stretch(
            np.maximum.accumulate(along[points]), amplitude[points], speed[points], piece.law,
            words_of(dataset.isel(point=piece.points.start)), piece.value, (ends[0][1], ends[1][1]),
            from_rest_of(dataset, points), mean[points], points, has_image[piece.value],
        )  # fmt: skip


class _Bifurcations(NamedTuple):
    """Where bifurcations lie among the points of branches.

    along, over, branches : both parameters and the branch of each point
    points, kinds : the point of each bifurcation, and its kind
    reach : largest difference of places that are one
    """

    along: np.ndarray
    over: np.ndarray
    branches: np.ndarray
    points: np.ndarray
    kinds: list[str]
    reach: float

    def end(self, index: int, inmost: Callable[[Iterable[int]], int]) -> tuple[int, str]:
        """Return the point at which a stable piece ends that begins or ends at a point, and the bifurcation there.

        inmost : which of several points bounds the piece: `max` where it begins, `min` where it ends
        """
        own = self.branches[index]
        near = {
            point: kind
            for point, kind in zip(self.points.tolist(), self.kinds, strict=True)
            if abs(point - index) <= 1 and self.branches[point] == own
        }
        if near:
            # Stability ends at the bifurcation itself, maybe a point before or after the piece. Next to it, pieces may
            # change without consequence.
            return inmost(near), min(near.values(), key=lambda each: each == "change")
        before = index - 1
        if inmost is max and before >= 0 and self.branches[before] == own:
            is_begin = before == 0 or self.branches[before - 1] < own
            if is_begin and (kind := self._beside(before)):
                return before, kind
        return index, self._beside(index)

    def _beside(self, index: int) -> str:
        """Return the bifurcation of another branch at which one ends: a grazing is stored with one of them."""
        there = np.abs(self.along[self.points] - self.along[index]) <= self.reach
        there &= self.over[self.points] == self.over[index]
        return self.kinds[int(there.argmax())] if there.any() else ""


def _sizes_of(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitude of each point, without harmonics its displacement, and its largest impact velocity or 0."""
    if "displacement_amplitude" in dataset:
        amplitude = dataset["displacement_amplitude"].sel(harmonic=1).values
    else:
        amplitude = abs(dataset["displacement_strobe"].values)
    if "impact_velocity_max" not in dataset:
        return amplitude, 0.0 * amplitude
    return amplitude, np.nan_to_num(dataset["impact_velocity_max"].max("support").values)


def from_rest_of(dataset: xr.Dataset, points: np.ndarray) -> np.ndarray:
    """Return the codes of `from_rest` of some points, of which those at the ends may not be stable."""
    if "from_rest" not in dataset:
        return np.full(points.size, FLAGS["settled_same"]["unknown"])
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


def image_groups(stretches: Sequence[Stretch]) -> list[list[Stretch]]:
    """Return stretches with their mirror images."""
    groups: list[list[Stretch]] = []
    for each in stretches:
        own = (group for group in groups if len(group) == 1 and are_images(group[0], each))
        if (group := next(own, None)) is None:
            groups.append([each])
        else:
            group.append(each)
    return groups


def are_images(*both: Stretch) -> bool:
    """Return whether two stretches are mirror images: of one law and the same ends, with the opposite mean."""
    ends, laws = [], []
    for each in both:
        (m, *contacts) = re.findall(r"\w+", each.law)
        laws.append((each.over, m, sorted(contacts)))
        ends.append([format_number(float(value), 8) for value in each.values[[0, -1]]])
    if not all(each.has_image for each in both) or laws[0] != laws[1] or ends[0] != ends[1]:
        return False
    middle = both[0].values.mean()
    size, other = (each.amplitude(middle) for each in both)
    mean, opposite = (float(np.interp(middle, each.values, each.means)) for each in both)
    near = [abs(size - other), abs(mean + opposite)]
    return max(near) <= SAME_ORBIT * max(size, abs(mean))


def group_words(alike: Sequence[Stretch]) -> str:
    """Write the motion of a stretch and its mirror image, if it has one, in words."""
    return alike[0].words + (" (mirror images)" if len(alike) > 1 else "")


def stable_words(stretches: Sequence[Stretch], low: float, high: float) -> str:
    """Write the motions that are stable in all of an interval, and how many are in parts of it."""
    near = SAME_END * (high - low)
    inside = [s for s in stretches if s.values[0] < high and s.values[-1] > low]
    whole = [s for s in inside if s.values[0] <= low + near and s.values[-1] >= high - near]
    words = [group_words(alike) for alike in image_groups(whole)]
    amounts = {text: words.count(text) for text in words}
    texts = [text + f" ({number_word(n)} motions)" * (n > 1) for text, n in amounts.items()]
    left_out = len(texts[MAX_WORDS:])
    texts = texts[:MAX_WORDS] + ([f"{number_word(left_out)} more"] if left_out else [])
    parts = len(inside) - len(whole)
    if not texts:
        return f"{amount_text(parts, 'motion')}, each in a part of it"
    return "; ".join(texts + ([f"{number_word(parts)} more in parts of it"] if parts else []))


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


def coexistence(stretches: list[Stretch]) -> dict[float, list[tuple[float, float]]]:
    """Return the intervals in which at least two motions are stable, by the values of the further parameter."""
    values = dict.fromkeys(stretch.over for stretch in stretches)
    found = {
        value: common_intervals([each for each in stretches if each.over == value])
        for value in values
    }
    return {value: intervals for value, intervals in found.items() if intervals}


def united(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the union of intervals, as intervals in order."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if joined and low <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(high, joined[-1][1])
        else:
            joined.append((low, high))
    return joined
