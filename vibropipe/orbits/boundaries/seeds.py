"""Where boundaries begin: the bifurcations of branches, written as points of a boundary."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.march.piece_log import HOME
from vibropipe.orbits.boundaries.curve import NO_TOUCH, BoundaryCurve, Box, Touch
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.system import FLIPS, GRAZINGS, KINDS, PITCHFORKS
from vibropipe.orbits.boundaries.touches import Grazing, grazing_at, in_least_periods, touching
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.linear import linear_state, linear_touch
from vibropipe.orbits.branches.sequence import Sequence
from vibropipe.orbits.branches.symmetry import SAME_PARTS, halved, halves_agree, repeats
from vibropipe.orbits.law.curve import NO_TOUCH as BY_LAW
from vibropipe.orbits.law.law import Law, without_events
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.law.steps import GAP_FLIGHT, GAP_SIDE, GAP_TIME
from vibropipe.orbits.row import row_parameters

# Orbits with more contacts are left out: towards chatter, and in cascades of flips, there are any number of them.
MAX_CONTACTS = 24
# Weighted speed below which an impact has none.
NO_SPEED = 1e-6
# Distance of a seed from the bifurcation that it begins at, weighted.
SEED_REACH = 1e-3


def begin(box: Box, branch: Branch, event: Event) -> tuple[BoundaryCurve, Point] | None:
    """Return the boundary that passes through a bifurcation of a branch, and its point there; None if there is none.

    branch : along one of the parameters of the box; its problem holds the other
    """
    if branch.curve is None:
        values = branch.problem.values_at(branch.values[event.point])
        return begin_linear(box, values[box.along], values)
    point, kind = branch.points[event.point], KINDS[event.kind]
    values = branch.problem.values_at(point.value)
    ends = values[box.along]
    law, u, speed = branch.curve.sequence, point.u, branch.curve.speed
    sequence: Any = Sequence(law.m, law.mirrored, law.codes[:, HOME].copy())
    touch, time = NO_TOUCH, math.nan
    if event.reason == "gap":
        touch, time = (
            Touch(int(point.tests[GAP_FLIGHT]), int(point.tests[GAP_SIDE])),
            point.tests[GAP_TIME],
        )
    elif event.reason == "speed":
        sequence, u, touch, time = _without_slow(sequence, u, speed)
        if len(sequence.supports) == 0:
            return begin_linear(box, ends, values)
    elif event.reason == "doubled":
        sequence, u = halved(sequence, u, event.kind)
    if kind == GRAZINGS:
        sequence, u, touch, time = _primitive(box, sequence, u, touch, time, speed)
    n = len(sequence.supports)
    timed = [time] if kind == GRAZINGS else []
    # Velocities of the orbit itself: a branch may have begun with others.
    speed = float(np.abs(u[n : 2 * n]).max())
    curve = BoundaryCurve(box, kind, sequence, touch, speed)
    return settled(curve, np.concatenate([u[: 2 * n], timed, ends]))


def begin_law(
    box: Box, branch: Branch, event: Event, kind: int, marcher: Marcher
) -> tuple[LawBoundary, Point] | None:
    """Return the boundary by its law that passes through a bifurcation of a branch, and its point there, or None.

    box, branch, event : as for `begin`
    kind : a `Bifurcation`
    """
    if branch.curve is None:
        values = branch.problem.values_at(branch.values[event.point])
        p = row_parameters(values.reshape(1, -1), 0)
        law, u, touch = linear_grazing(p)
        scales = Scales(p.l, p.l * p.nu)
        return begin_at(box, kind, law, u.ravel(), touch, values[box.along], scales, marcher)
    point = branch.points[event.point]
    curve = branch.curve if point.curve is None else point.curve
    law, u, touch = curve.sequence, point.u, BY_LAW
    ends = branch.problem.values_at(point.value)[box.along]
    if kind == GRAZINGS:
        grazing = grazing_at(point._replace(curve=curve))
        if grazing is None:
            return None
        law, u, touch = grazing.law, grazing.u.T.ravel(), grazing.touch
    elif event.reason == "doubled":
        law, u = halved(law, u, event.kind)
    u = u[: law.width * len(law.codes)]
    return begin_at(box, kind, law, u, touch, ends, curve.scales, marcher)


def linear_grazing(p: Any) -> Grazing:
    """Return the motion without impacts where it touches the support that it comes nearest to; p : its parameters."""
    return touching(without_events(1.0, 0), np.array([linear_state(p)]), *linear_touch(p))


def begin_at(
    box: Box,
    kind: int,
    law: Law,
    u: np.ndarray,
    touch: tuple[float, float, float],
    ends: np.ndarray,
    scales: Scales,
    marcher: Marcher,
) -> tuple[LawBoundary, Point] | None:
    """Return the boundary of a law near some events and both parameters, and its point there; None if there is none."""
    # A pitchfork is that of a law of half of the orbit.
    if (kind == PITCHFORKS) != bool(law.mirrored) and kind in (PITCHFORKS, FLIPS):
        return None
    curve = LawBoundary(box, kind, law, touch, scales, marcher)
    if sum(curve.contacts()) > MAX_CONTACTS:
        return None
    begun = settled(curve, np.concatenate([u, ends]))
    least = in_least_periods(*begun) if begun is not None and kind == GRAZINGS else None
    if begun is None or least is None:
        return begun
    again = LawBoundary(box, kind, least.law, least.touch, scales, marcher)
    return settled(again, np.concatenate([least.u.T.ravel(), begun[1].u[-2:]]))


def settled(curve: Any, u: np.ndarray, reach: float = SEED_REACH) -> tuple[Any, Point] | None:
    """Return a boundary and its point within reach of u, with one of both parameters held; None if there is none."""
    for fixed in (-1, -2):
        point = curve.settle(u, fixed)
        if point is not None and curve.weighted(point.u - u) < reach:
            return curve, point
    return None


def begin_linear(
    box: Box, ends: np.ndarray, values: np.ndarray
) -> tuple[BoundaryCurve, Point] | None:
    """Return the boundary of the motion without impacts near some parameters."""
    side, time = linear_touch(row_parameters(values.reshape(1, -1), 0))
    sequence = Sequence(1, 0, np.zeros(0, np.int8))
    curve = BoundaryCurve(box, GRAZINGS, sequence, Touch(0, side), 1.0)
    return settled(curve, np.array([time, *ends]))


def _without_slow(
    sequence: Sequence, u: np.ndarray, speed: float
) -> tuple[Sequence, np.ndarray, Touch, float]:
    """Return a sequence without the impacts that have no speed, the flight that touches instead, and when."""
    n = len(sequence.supports)
    slow = np.abs(u[n : 2 * n]) < NO_SPEED * speed
    at = int(np.abs(u[n : 2 * n]).argmin())
    slow[at] = True
    kept = np.flatnonzero(~slow)
    shorter = Sequence(sequence.m, sequence.mirrored, sequence.supports[kept].copy())
    without = np.concatenate([u[:n][kept], u[n : 2 * n][kept], u[-1:]])
    side, time = int(sequence.supports[at]), float(u[at])
    if kept.size == 0:
        return shorter, without, Touch(0, side), time
    flight = int(np.count_nonzero(kept < at)) - 1
    if flight < 0:
        # Before the first impact: in the last flight, which leads to that impact or to its mirror image.
        flight, time = kept.size - 1, time + sequence.span
        side = 3 - side if sequence.mirrored else side
    return shorter, without, Touch(flight, side), time


def _primitive(
    box: Box, sequence: Any, u: np.ndarray, touch: Touch, time: float, speed: float
) -> tuple[Sequence, np.ndarray, Touch, float]:
    """Return the orbit that repeats or mirrors itself in a sequence, if it does, and where its flight touches."""
    n = len(sequence.supports)
    weights = np.concatenate([np.ones(n), np.full(n, 1.0 / speed), [0.0]])
    parts = next(
        (q for q in range(n, 1, -1) if not sequence.mirrored and repeats(sequence, u, weights, q)),
        1,
    )
    size, m = n // parts, sequence.m // parts
    if parts > 1:
        laps, flight = divmod(touch.flight, size)
        u = np.concatenate([u[:size], u[n : n + size], u[-1:]])
        sequence = Sequence(m, sequence.mirrored, sequence.supports[:size].copy())
        touch, time = Touch(flight, touch.side), time - laps * m
    if box.symmetric and halves_agree(sequence, u, np.ones(u.size), SAME_PARTS) == "pitchfork":
        half, laps = size // 2, touch.flight // (size // 2)
        sequence, u = halved(sequence, u, "pitchfork")
        if laps:
            touch, time = Touch(touch.flight - half, 3 - touch.side), time - 0.5 * sequence.m
    return sequence, u, touch, time
