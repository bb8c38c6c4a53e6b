"""Findings of branches: where they bifurcate, where several motions are stable, and where and why motions jump."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr

from vibropipe.figures.claims import inwards
from vibropipe.figures.text import flag_texts, format_number, with_units
from vibropipe.report.findings import Finding, symbol_text, value_text
from vibropipe.report.table import Datasets
from vibropipe.scenes.branch.curves import followed, pieces_of, swept
from vibropipe.scenes.branch.places import PLURALS, places_of
from vibropipe.words.wording import count, series

# Bifurcations of a kind, intervals and jumps that a sentence lists; of more, the widest and the largest.
MAX_LISTED, MAX_INTERVALS, MAX_JUMPS = 6, 4, 4
# What happens to a motion where it jumps.
CAUSES = {
    "fold": "meets an unstable motion (fold)",
    "grazing": "touches a support (grazing)",
    "change": "gains or loses a contact, turn or stick (change)",
}
UNKNOWN = "a motion that is not followed here"
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


@dataclass(frozen=True)
class Jump:
    """Where a followed motion has no stable neighbour, the laws beyond, and the change of impact velocity."""

    stretch: Stretch
    is_up: bool
    targets: tuple[str, ...]
    size: float

    @property
    def value(self) -> float:
        """Where it jumps."""
        return float(self.stretch.values[-1 if self.is_up else 0])


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each scene of branches."""
    return [Finding(branch_texts(data), name) for name, data in datasets.items()]


def branch_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the findings of one scene, a sentence each."""
    stretches = list(stretches_of(dataset))
    return (
        jumps_text(dataset, stretches),
        together_text(dataset, stretches),
        kinds_text(dataset),
        velocity_text(dataset),
    )


def stretches_of(dataset: xr.Dataset) -> Iterator[Stretch]:
    """Yield the stable stretches of all branches, with increasing parameter."""
    along = dataset[followed(dataset)].values
    amplitude = dataset["displacement_amplitude"].sel(harmonic=1).values
    speed = np.nan_to_num(dataset["impact_velocity_max"].max("support").values)
    points = dataset["bifurcation_point"].values
    kinds = [KINDS[int(code)] for code in dataset["bifurcation_kind"].values]
    branches = dataset["branch_id"].values
    over = dataset[swept(dataset)].values if swept(dataset) else np.zeros(along.size)
    gap = SAME * float(along.max() - along.min())

    def beside(index: int) -> str:
        """Return the bifurcation of another branch at which this one ends: a grazing is stored with one of them."""
        is_there = (np.abs(along[points] - along[index]) <= gap) & (over[points] == over[index])
        return kinds[int(is_there.argmax())] if is_there.any() else ""

    for piece in pieces_of(dataset):
        first, last = piece.points.start, piece.points.stop - 1
        if not piece.is_stable:
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
            # Where a branch begins, at a flip or a pitchfork of another, its multiplier is 1 but for rounding.
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
            piece.value,
            (ends[0], ends[1]) if order.step is None else (ends[1], ends[0]),
        )


def jumps_of(dataset: xr.Dataset, stretches: list[Stretch]) -> list[Jump]:
    """Return where motions jump that are followed upwards or downwards, the largest jumps first."""
    along = dataset[followed(dataset)].values
    gap = SAME * float(along.max() - along.min())
    found: dict[tuple[float, bool, str, float], Jump] = {}
    for stretch in stretches:
        for is_up, kind in ((False, stretch.ends[0]), (True, stretch.ends[1])):
            if kind not in CAUSES:
                continue
            value = float(stretch.values[-1 if is_up else 0])
            before = stretch.amplitude(value)
            beyond = value + (gap if is_up else -gap)
            others = [s for s in stretches if s.over == stretch.over and s.reaches(beyond)]
            steps = [abs(s.amplitude(beyond) - before) for s in others]
            # The amplitude changes as a square root beside a grazing: by the root of the gap.
            if steps and min(steps) <= np.sqrt(SAME) * 10 * max(before, gap):
                continue
            if not steps and kind != "fold":
                continue  # it may go on with another impact sequence
            laws = tuple(dict.fromkeys(s.law for s in others)) or (UNKNOWN,)
            speed = stretch.speed(value)
            size = min((abs(s.speed(beyond) - speed) for s in others), default=speed)
            jump = Jump(stretch, is_up, laws, size)
            found.setdefault((stretch.over, is_up, stretch.law, round(value / gap)), jump)
    return sorted(found.values(), key=lambda jump: -jump.size)


def jumps_text(dataset: xr.Dataset, stretches: list[Stretch]) -> str:
    """Write where motions jump, why, and to which law."""
    jumps = jumps_of(dataset, stretches)
    axis = dataset[followed(dataset)]
    texts = []
    for jump in jumps[:MAX_JUMPS]:
        why = CAUSES[jump.stretch.ends[1 if jump.is_up else 0]]
        way = "upwards" if jump.is_up else "downwards"
        place = f"{symbol_text(axis)} = {value_text(axis, jump.value)}"
        texts.append(
            f"{way} at {place}{over_text(dataset, jump.stretch.over, ', ')}, where {jump.stretch.law} {why}, to "
            f"{' or '.join(jump.targets)}"
        )
    if not texts:
        return ""
    if len(jumps) > MAX_JUMPS:
        texts.append(f"at {len(jumps) - MAX_JUMPS} further places by less")
    return (
        "With m forcing periods and p₁ and p₂ impacts on the supports as (m; p₁, p₂), a motion that is followed "
        f"jumps {'; '.join(texts)}"
    )


def over_text(dataset: xr.Dataset, value: float, before: str = "") -> str:
    """Write the value of the further parameter after some text; empty without such a parameter."""
    over = swept(dataset)
    if over is None:
        return ""
    return f"{before}{symbol_text(dataset[over])} = {value_text(dataset[over], value)}"


def together_text(dataset: xr.Dataset, stretches: list[Stretch]) -> str:
    """Write between which values of the parameter several motions are stable."""
    axis = dataset[followed(dataset)]
    texts = []
    for over in dict.fromkeys(stretch.over for stretch in stretches):
        own = [stretch for stretch in stretches if stretch.over == over]
        common = common_intervals(own)
        widest = sorted(common, key=lambda ends: ends[0] - ends[1])[:MAX_INTERVALS]
        spans = [interval_text(axis, *ends) for ends in sorted(widest)]
        if len(common) > MAX_INTERVALS:
            spans.append(count(len(common) - MAX_INTERVALS, "narrower interval"))
        if spans:
            texts.append(f"{series(spans)}{over_text(dataset, over, ' for ')}")
    if not texts:
        return ""
    return (
        f"Among the motions followed here, at least two are stable at {'; '.join(texts)}: there the start decides "
        "which of them settles"
    )


def interval_text(axis: xr.DataArray, low: float, high: float) -> str:
    """Write an interval within which something holds, its ends rounded inwards."""
    first, last = inwards(low, high)
    return f"{symbol_text(axis)} = {first} … {with_units(axis, last)}"


def distinct_texts(values: np.ndarray) -> list[str]:
    """Write different numbers with as many digits as tell them apart, at least 4."""
    texts = [format_number(float(value)) for value in values]
    for digits in range(5, 13):
        if len({*texts}) == values.size:
            break
        texts = [format_number(float(value), digits) for value in values]
    return texts


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


def kinds_text(dataset: xr.Dataset) -> str:
    """Write the number of places of the bifurcations of each kind, and where they are."""
    axis = dataset[followed(dataset)]
    texts = []
    for kind, places in places_of(dataset).items():
        if kind not in PLURALS:
            continue
        values = np.unique(places)
        if values.size > MAX_LISTED:
            first, last = format_number(float(values[0])), value_text(axis, values[-1])
            where = f"from {symbol_text(axis)} = {first} to {last}"
        else:
            listed = with_units(axis, series(distinct_texts(values)))
            where = f"at {symbol_text(axis)} = {listed}"
        texts.append(f"{count(places.size, kind, PLURALS[kind])} {where}")
    return f"The branches have {'; '.join(texts)}" if texts else ""


def velocity_text(dataset: xr.Dataset) -> str:
    """Write the largest impact velocity of the stable points and its place."""
    velocity = dataset["impact_velocity_max"].where(dataset["stable"] == 1)
    if not bool((velocity > 0).any()):
        return ""
    top = velocity.isel({str(k): int(v) for k, v in velocity.argmax(...).items()})
    axis, over = dataset[followed(dataset)], swept(dataset)
    point = int(velocity.max("support").argmax("point"))
    where = f"{symbol_text(axis)} = {value_text(axis, axis.values[point])}"
    beside = f", {over_text(dataset, float(dataset[over][point]))}" if over else ""
    return (
        f"The largest impact velocity at a stable point of the branches is {value_text(top, float(top))}, on support "
        f"{int(top['support'])} at {where}{beside}"
    )
