"""Branches that meet at a grazing: of the orbit that touches a support, and of those that strike it there.

Where a flight of an orbit touches a support begin the orbits that strike it there with no velocity: in every period,
of a symmetric orbit with the mirror image of the impact or without it, or once in some periods. Which of them are
motions next to the grazing, and on which side of it, a short step along each tells.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.orbits.branches.curve import ImpactCurve
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.linear import (
    begin_struck,
    linear_gap,
    linear_touch,
    speed_of_struck,
    touches_both,
)
from vibropipe.orbits.branches.symmetry import primitive, whole_orbit
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.law import Law, law_of_impacts
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.steps import GAP, GAP_FLIGHT, GAP_SIDE, GAP_TIME, SLOW_EVENT, SPEED, TRACE
from vibropipe.orbits.recurrence import MAX_MULTIPLE

# Largest number of impacts of a sequence.
MAX_SEQUENCE = 128
# Orbits that strike once in more periods of the one that touches are not sought.
MAX_REPEATS = 3
# First step away from a grazing, whose tests show on which side of it each bifurcation lies.
STRUCK_LENGTH = 1e-6
# Least weighted impact speed of orbits at which others begin. A slower mass rises by its square only: 1e-16, the
# rounding of a displacement, is then more than 1e-4 of that hop.
MIN_CHATTER_SPEED = 1e-6
# Weighted speed below which an impact has none.
NO_SPEED = 1e-6
# Trace of the return map's derivative beyond which a doubled orbit and its parent graze at the same parameter.
MAX_TRACE = 1e12
# Weighted distance from a grazing at which a test function is compared with zero.
PROBE = 1e-5


class Touching(NamedTuple):
    """An orbit that touches a support.

    speed : scale of impact velocities
    sequence : without impacts, mirrored if both supports are touched
    u : (2n + 1,)
    flight, support : the flight that touches, and what
    time : when, in forcing periods
    """

    problem: Problem
    speed: float
    sequence: Law
    u: np.ndarray
    flight: int
    support: int
    time: float


def seeds_at_grazing(branch: Branch, event: Event) -> list[Seed]:
    """Return the branch with an impact more, or less, that begins where a branch ends."""
    if branch.curve is not None and event.reason == "speed":
        return _without(branch.curve, branch.points[event.point])
    touching = touching_at(branch, event)
    return [] if touching is None else _struck(touching, 1, 0)


def siblings_at_grazing(branch: Branch, event: Event) -> Iterator[Seed]:
    """Yield all branches that begin at a grazing: of the orbit that touches, if it is linear, and of those that strike.

    Those of `seeds_at_grazing` and the branch itself are among them.
    """
    touching = touching_at(branch, event)
    if touching is None:
        return
    if len(touching.sequence.supports) == 0:
        yield from _linear_seeds(touching.problem, float(touching.u[-1]))
    turns = 2 * MAX_REPEATS if touching.sequence.mirrored else MAX_REPEATS
    for turn in range(1, turns + 1):
        # An even number of turns of a mirrored orbit is not mirrored: its mirror image strikes in another turn.
        sides = (0, 1) if touching.sequence.mirrored and turn % 2 == 0 else (0,)
        for side in sides:
            yield from _struck(touching, turn, side)


def touching_at(branch: Branch, event: Event) -> Touching | None:
    """Return the orbit that touches a support at a grazing of a branch; None if its equations have no solution."""
    problem = branch.problem
    if branch.curve is None:
        return _touching_linear(problem, branch.values[event.point])
    curve, point = branch.curve, branch.points[event.point]
    if event.reason == "speed":
        n = len(curve.sequence.supports)
        if np.abs(point.u[n : 2 * n]).max() < NO_SPEED * curve.speed:
            return _touching_linear(problem, point.value)
        found = _settled_without(curve, point)
        if found is None:
            return None
        curve, point = found
    flight, support = int(point.tests[GAP_FLIGHT]), int(point.tests[GAP_SIDE])
    time = float(point.tests[GAP_TIME])
    if support == 0 or flight < 0:
        return None
    return Touching(problem, curve.speed, curve.sequence, point.u, flight, support, time)


def _touching_linear(problem: Problem, value: float) -> Touching:
    """Return the motion without impacts at a value of the parameter where it touches a support."""
    p = problem.parameters_at(value)
    support, time = linear_touch(p)
    sequence = law_of_impacts(1, int(touches_both(p)), np.zeros(0, np.int8))
    speed = speed_of_struck(p)
    return Touching(problem, speed, sequence, np.array([value]), -1, support, time % 1.0)


def _struck(touching: Touching, turns: int, side: int) -> list[Seed]:
    """Return the branch of orbits that strike where one touches, if they are motions next to it.

    turns : they strike once in so many turns of it, of half its period if it is mirrored
    side : in which turn
    """
    problem, sequence, n = touching.problem, touching.sequence, len(touching.sequence.supports)
    turn = np.arange(turns)
    is_flipped = (turn % 2 == 1) & (sequence.mirrored == 1)
    signs = np.where(is_flipped, -1.0, 1.0)[:, None]
    shifts = (turn * sequence.span)[:, None]
    times, velocities = touching.u[:n] + shifts, touching.u[n : 2 * n] * signs
    images = [sequence.image(sequence.codes) if each else sequence.codes for each in is_flipped]
    at = side * n + touching.flight + 1
    support = 3 - touching.support if is_flipped[side] else touching.support
    times = np.insert(times.ravel(), at, touching.time + side * sequence.span)
    velocities = np.insert(velocities.ravel(), at, 0.0)
    codes = np.insert(np.concatenate(images), at, law_of_impacts(1, 0, [support]).codes, axis=0)
    m = sequence.m * turns if not sequence.mirrored or turns % 2 else sequence.m * turns // 2
    struck = sequence.like(m, sequence.mirrored * (turns % 2), codes)
    u = np.concatenate([times, velocities, touching.u[-1:]])
    if struck.mirrored and not problem.symmetric:
        # The motion without impacts does not know that the supports differ.
        struck, u = whole_orbit(struck, u)
    if len(struck.supports) > MAX_SEQUENCE or m > MAX_MULTIPLE:
        return []
    begun = begin_struck(ImpactCurve(problem, struck, touching.speed), u.tolist(), at)
    if begun is None:
        return []
    curve, point = begun
    ahead = curve.advance(point, STRUCK_LENGTH)
    if ahead is None or not (ahead.tests[GAP] > 0.0 and ahead.tests[SPEED] > 0.0):
        return []
    return [Seed(curve, curve.point(point.u, point.tangent, ahead.tests), point.value, (1.0,))]


def _linear_seeds(problem: Problem, value: float) -> list[Seed]:
    """Return the motion without impacts in the directions from a value in which it touches no support."""
    probe = 1e-3 * PROBE * (problem.high - problem.low)
    signs = tuple(s for s in (1.0, -1.0) if linear_gap(problem, value + s * probe) > 0.0)
    return [Seed(None, None, value, signs)] if signs else []


def _settled_without(curve: LawCurve, point: Point) -> tuple[LawCurve, Point] | None:
    """Return the orbit without the impact that has lost its speed, in its least number of periods."""
    sequence, n, at = curve.sequence, len(curve.sequence.supports), int(point.tests[SLOW_EVENT])
    u = np.delete(point.u, [at, n + at])
    shorter = sequence._replace(codes=np.delete(sequence.codes, at, axis=0))
    child = curve.with_sequence(shorter)
    settled = child.settle(u)
    if settled is None:
        return None
    least, u = primitive(shorter, settled.u, child.weights, curve.problem.symmetric)
    if len(least.supports) == len(shorter.supports):
        return child, settled
    child = curve.with_sequence(least)
    settled = child.settle(u)
    return None if settled is None else (child, settled)


def _without(curve: LawCurve, point: Point) -> list[Seed]:
    """Return the branch without the impact that has lost its speed, in the directions in which it is a motion."""
    n, value = len(curve.sequence.supports), point.value
    is_still = np.abs(point.u[n : 2 * n]).max() < NO_SPEED * curve.speed
    if n == 1:
        return _linear_seeds(curve.problem, value)
    settled = _settled_without(curve, point)
    seeds = []
    if settled is not None and not _is_at_rounding(settled[1]):
        child, touching = settled
        tests = touching.tests.copy()
        tests[GAP] = 0.0
        start = child.point(touching.u, touching.tangent, tests)
        for side in (start, start.reversed()):
            ahead = child.advance(side, PROBE)
            if ahead is not None and ahead.tests[GAP] > 0.0 and ahead.tests[SPEED] > 0.0:
                seeds.append(Seed(child, side, value, (1.0,)))
    return _linear_seeds(curve.problem, value) if is_still and not seeds else seeds


def _is_at_rounding(point: Point) -> bool:
    """Return whether a second impact loses its speed at the same parameter, on a doubled orbit next to its parent."""
    return bool(abs(point.tests[TRACE]) > MAX_TRACE and point.tests[SPEED] < MIN_CHATTER_SPEED)
