"""Stretches of a branch along which the torque of a load less that of its motor only rises or falls; jumps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.branch.motor_load import INSIDE, MotorLoad

# Relative distance, of speeds and of torques, of ends of stretches that meet.
MEET = 1e-7
# Difference of multipliers of mirror images, which are followed apart.
IMAGE = 1e-5
# Relative width to which a speed is located.
LOCATED = 1e-15
# Relative distance of points of a branch between which the excess has no extreme: they lie at a bifurcation.
NARROW = 1e-6
# Stretches that a speed runs through after a jump.
MAX_STEPS = 1000


@dataclass(frozen=True, eq=False)
class Stretch:
    """Part of a branch between two speeds w[0] < w[1], where the excess s of the load's torque is monotone.

    start : it lies between this point of the branch and the next
    w, s : speeds and excesses at its lower and upper end
    at_event : whether there is a bifurcation at either end
    is_stable : whether its orbits are stable
    """

    start: int
    w: tuple[float, float]
    s: tuple[float, float]
    at_event: tuple[bool, bool]
    is_stable: bool

    @property
    def rises(self) -> bool:
        """Whether the load grows faster than the motor's torque with the speed."""
        return self.s[1] > self.s[0]


def zero(function: Callable[[float], float], low: float, high: float) -> float:
    """Return a zero between two arguments at which a function has opposite signs."""
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=LOCATED * high, rtol=8.9e-16))


def speed_at(load: MotorLoad, stretch: Stretch, level: float) -> float:
    """Return the speed of a stretch at which the excess has a value between those at its ends."""
    for end in (0, 1):
        if stretch.s[end] == level:
            return stretch.w[end]
    return zero(lambda w: load.excess(stretch.start, w) - level, *stretch.w)


def stretches_of(load: MotorLoad) -> list[Stretch]:
    """Return all stretches in the order of the branch."""
    ids = load.branch["branch_id"].values
    found: list[Stretch] = []
    for one in range(len(ids) - 1):
        if ids[one] != ids[one + 1] or load.speeds[one] == load.speeds[one + 1]:
            continue
        try:
            found += _between(load, one)
        except ParameterError:
            # An unstable orbit beside a grazing: no motor keeps its speed.
            if (load.branch["stable"].values[[one, one + 1]] == 1).any():
                raise
    return found


def _between(load: MotorLoad, one: int) -> Iterator[Stretch]:
    """Yield the stretches between a point and the next, cut where the torque bends and the excess turns."""
    low, high = sorted(load.speeds[[one, one + 1]].tolist())
    stable = load.branch["stable"].values
    # Where a branch begins at a bifurcation of another, as at the bifurcation itself, the multipliers do not tell.
    inner = [
        point for point in (one, one + 1) if point not in load.events and load.decay[point] != 0.0
    ]
    is_stable = bool(inner) and all(stable[point] == 1 for point in inner)
    if not inner and high - low > NARROW * high:
        is_stable = int(load.row(one, 0.5 * (low + high))["stable"]) == 1
    cuts = [low, *load.torque.corners(low, high), high]
    for a, b in pairwise(cuts):
        if not np.isfinite(load.torque.at(a) + load.torque.at(b)):
            continue
        turns = [a, *_turn(load, one, a, b), b]
        for c, d in pairwise(turns):
            s = load.excess(one, c), load.excess(one, d)
            at_event = load.is_event(one, c), load.is_event(one, d)
            yield Stretch(one, (c, d), s, at_event, is_stable)


def _turn(load: MotorLoad, one: int, a: float, b: float) -> list[float]:
    """Return the speed between two at which the excess has an extreme, if there is one."""
    if b - a <= NARROW * b:
        return []
    bend = (load.torque.at(b) - load.torque.at(a)) / (b - a)
    rates = load.slope(one, a, towards=b) - bend, load.slope(one, b, towards=a) - bend
    if not rates[0] * rates[1] < 0.0:
        return []
    ends = [
        w + INSIDE * (other - w) if load.is_event(one, w) else w for w, other in ((a, b), (b, a))
    ]
    try:
        return [zero(lambda w: load.slope(one, w) - bend, *ends)]
    except ValueError:  # a derivative is not known inside, as beside a grazing
        return [_extreme(load, one, (min(ends), max(ends)), math.copysign(1.0, rates[0]))]


def _extreme(load: MotorLoad, one: int, ends: tuple[float, float], sign: float) -> float:
    """Return the speed between two at which the excess is largest, or with sign -1 least, without derivatives."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda w: -sign * load.excess(one, w), bounds=ends, method="bounded",
        options={"xatol": NARROW * ends[1]},
    )  # fmt: skip
    return float(found.x)


def without_images(
    load: MotorLoad, at: Sequence[tuple[float, Stretch]]
) -> list[tuple[float, Stretch]]:
    """Return crossings, sorted by the speed, without those of the mirror image of an earlier orbit."""
    kept: list[tuple[float, Stretch]] = []
    ids = load.branch["branch_id"].values
    for w, each in at:
        near = [
            (v, other) for v, other in kept
            if w - v <= MEET * w and ids[other.start] != ids[each.start]
        ]  # fmt: skip
        images = [n for n, other in enumerate(near) if _are_images(load, (w, each), other)]
        if not images:
            kept.append((w, each))
        elif near[images[0]][1].start > each.start:
            kept[kept.index(near[images[0]])] = w, each
    return kept


def _are_images(load: MotorLoad, one: tuple[float, Stretch], two: tuple[float, Stretch]) -> bool:
    """Return whether orbits at one speed are mirror images, by their multipliers and the supports that they strike."""
    row, other = (load.row(each.start, w) for w, each in (one, two))
    struck, mirrored = (each["impacts_per_period"].values for each in (row, other))
    a, b = (each["floquet_multiplier"].values for each in (row, other))
    return bool((struck == mirrored[::-1]).all() and np.allclose(a, b, IMAGE, IMAGE))


def jumps_of(
    load: MotorLoad, stretches: Sequence[Stretch]
) -> list[tuple[float, float, float, float]]:
    """Return (torque added, 1 raised or 0 lowered, speed lost, speed reached), sorted by the torque."""
    stable = [each for each in stretches if each.is_stable]
    found: list[tuple[float, float, float, float]] = []
    for stretch in stable:
        if not stretch.rises:
            continue
        for end in (0, 1):
            onward = _onward(stable, stretch, end)
            is_kept = any(each.rises for each in onward)
            if is_kept or not (onward or stretch.at_event[end]):
                continue
            w, level = stretch.w[end], stretch.s[end]
            reached = _reached(load, stable, stretch, end, level)
            # What returns to where it is lost keeps no speed: it hunts.
            jump = level, float(end), w, np.nan if abs(reached - w) <= MEET * w else reached
            # Mirror images jump alike: what is known of one holds of the other.
            alike = [other for other in found if np.allclose(jump[:3], other[:3], MEET, 0.0)]
            if not alike:
                found.append(jump)
            elif np.isnan(alike[0][3]):
                found[found.index(alike[0])] = jump
    return sorted(found)


def _onward(stable: Sequence[Stretch], stretch: Stretch, end: int) -> list[Stretch]:
    """Return the stable stretches that go on where one ends."""
    w, s = stretch.w[end], stretch.s[end]
    size = max(abs(value) for value in (*stretch.s, s))
    return [
        each
        for each in stable
        if each is not stretch
        and abs(each.w[1 - end] - w) <= MEET * abs(w)
        and abs(each.s[1 - end] - s) <= MEET * size
    ]


def _reached(
    load: MotorLoad, stable: Sequence[Stretch], stretch: Stretch, end: int, level: float
) -> float:
    """Return the stable speed to which the motor goes from the end of a stretch; NaN if it is not known."""
    here: Stretch | None = None
    for _ in range(MAX_STEPS):
        onward = _onward(stable, stretch, end)
        w = stretch.w[end]
        if onward:
            here = onward[0]
        elif stretch.at_event[end]:
            if not load.has_all_beside(stretch.start, w):
                return np.nan
            others = _others_at(load, stable, stretch, w)
            if len(others) != 1:
                return np.nan
            here, s = others[0]
            end = 1 if level > s else 0
            # From within the stretch: its part ahead.
            parts = (w, s), (here.w[1], here.s[1])
            if not end:
                parts = (here.w[0], here.s[0]), (w, s)
            ends, excesses = zip(*parts, strict=True)
            here = Stretch(here.start, ends, excesses, here.at_event, True)
        else:
            return np.nan
        if (here.s[end] - level) * (1 if end else -1) >= 0.0:
            return speed_at(load, here, level)
        stretch = here
    return np.nan


def _others_at(
    load: MotorLoad, stable: Sequence[Stretch], stretch: Stretch, w: float
) -> list[tuple[Stretch, float]]:
    """Return the other stable orbits at the speed where one ends, each once, with their excess."""
    found: list[tuple[Stretch, float]] = []
    size = max(abs(value) for each in stable for value in each.s)
    for each in stable:
        if each is stretch or not each.w[0] <= w < each.w[1]:
            continue
        s = each.s[0] if w == each.w[0] else load.excess(each.start, w)
        if not any(abs(s - other) <= MEET * size for _stretch, other in found):
            found.append((each, s))
    return found
