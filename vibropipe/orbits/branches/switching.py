"""Branches that begin at the bifurcations of another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibropipe.orbits.branches.curve import Curve, Point, Problem
from vibropipe.orbits.branches.events import HIDDEN_LENGTH, Event, is_steep
from vibropipe.orbits.branches.following import FIRST_LENGTH
from vibropipe.orbits.branches.linear import (
    begin_struck,
    linear_gap,
    struck_from_linear,
)
from vibropipe.orbits.branches.parents import child_point, parent_point
from vibropipe.orbits.branches.sequence import Sequence
from vibropipe.orbits.branches.steps import (
    DOUBLING,
    FOLD,
    GAP,
    GAP_FLIGHT,
    GAP_SIDE,
    GAP_TIME,
    SLOWEST,
    SPEED,
    TRACE,
)
from vibropipe.orbits.recurrence import MAX_MULTIPLE

# Largest number of impacts of a sequence.
MAX_SEQUENCE = 128
# First step away from a parent: both branches solve the equations of the doubled sequence, which are singular there.
DOUBLED_LENGTH = 1e-2
# First step away from a grazing, whose tests show on which side of it each bifurcation lies.
STRUCK_LENGTH = 1e-6
# Least weighted impact speed of orbits at which others begin. A slower mass rises by its square only: 1e-16, the
# rounding of a displacement, is then more than 1e-4 of that hop.
MIN_CHATTER_SPEED = 1e-6
# Trace of the return map's derivative beyond which a doubled orbit and its parent graze at the same parameter.
MAX_TRACE = 1e12
# Weighted distance from a bifurcation at which a test function is compared with zero.
PROBE = 1e-5


class Seed(NamedTuple):
    """The start of a branch: a point with its tangent, or the parameter of a motion without impacts; and where to go.

    Attributes
    ----------
    curve : Curve or None
        None without impacts.
    point : Point or None
    value : float
        The parameter.
    signs : tuple of float
        1 along the tangent (without impacts: upwards), -1 against it.
    first_length : float
        Of the first step.
    """

    curve: Curve | None
    point: Point | None
    value: float
    signs: tuple[float, ...]
    first_length: float = FIRST_LENGTH


@dataclass
class Branch:
    """A branch: its points or, without impacts, its values of the parameter, in order; its events; why it ended."""

    problem: Problem
    curve: Curve | None
    points: list[Point]
    values: list[float]
    events: list[Event]


def _with_tests(point: Point, **changed: float) -> Point:
    """Return a point with some test functions replaced."""
    index = {"fold": FOLD, "doubling": DOUBLING, "gap": GAP, "speed": SPEED}
    tests = point.tests.copy()
    for name, value in changed.items():
        tests[index[name]] = value
    return Point(point.u, point.tangent, tests)


def _doubled_seeds(curve: Curve, point: Point, kind: str) -> list[Seed]:
    """Return the branches of doubled (or asymmetric) orbits that begin at a flip (or pitchfork)."""
    n = len(curve.sequence.supports)
    child, start = child_point(curve, point, curve.doubling_vector(point))
    # The other side of a flip is the same orbit a period later; that of a pitchfork is its mirror image. The one that
    # strikes support 1 harder comes first, wherever the sequence begins.
    sides = [start]
    if kind == "pitchfork":
        on_first = child.sequence.supports == 1
        harder = start.tangent[2 * n : 4 * n][on_first].sum() >= 0.0
        sides = [start, start.reversed()] if harder else [start.reversed(), start]
    return [Seed(child, side, point.value, (1.0,), DOUBLED_LENGTH) for side in sides]


def _struck_seed(curve: Curve, point: Point) -> list[Seed]:
    """Return the branch that begins with an impact without speed, if it is a motion next to it."""
    ahead = curve.advance(point, STRUCK_LENGTH)
    if ahead is None or not (ahead.tests[GAP] > 0.0 and ahead.tests[SPEED] > 0.0):
        return []
    return [Seed(curve, Point(point.u, point.tangent, ahead.tests), point.value, (1.0,))]


def _inserted(curve: Curve, point: Point) -> list[Seed]:
    """Return the branch with an impact more where a flight touches a support."""
    sequence, n = curve.sequence, len(curve.sequence.supports)
    at, side = int(point.tests[GAP_FLIGHT]) + 1, int(point.tests[GAP_SIDE])
    u = np.insert(np.insert(point.u, n + at, 0.0), at, point.tests[GAP_TIME])
    supports = np.insert(sequence.supports, at, side).astype(np.int8)
    child = Curve(curve.problem, Sequence(sequence.m, sequence.mirrored, supports), curve.speed)
    begun = begin_struck(child, u.tolist(), at)
    if begun is None:
        return []
    return _struck_seed(*begun)


def _is_at_rounding(point: Point) -> bool:
    """Return whether a second impact loses its speed at the same parameter, on a doubled orbit next to its parent."""
    return bool(abs(point.tests[TRACE]) > MAX_TRACE and point.tests[SPEED] < MIN_CHATTER_SPEED)


def _removed(curve: Curve, point: Point) -> list[Seed]:
    """Return the branch without the impact that has lost its speed, in the directions in which it is a motion."""
    sequence, n, at = curve.sequence, len(curve.sequence.supports), int(point.tests[SLOWEST])
    problem, value = curve.problem, point.value
    if n == 1:
        probe = 1e-3 * PROBE * (problem.high - problem.low)
        signs = tuple(s for s in (1.0, -1.0) if linear_gap(problem, value + s * probe) > 0.0)
        return [Seed(None, None, value, signs)] if signs else []
    u = np.delete(point.u, [at, n + at])
    supports = np.delete(sequence.supports, at)
    child = Curve(problem, Sequence(sequence.m, sequence.mirrored, supports), curve.speed)
    settled = child.settle(u)
    if settled is None or _is_at_rounding(settled):
        return []
    start = _with_tests(settled, gap=0.0)
    seeds = []
    for side in (start, start.reversed()):
        ahead = child.advance(side, PROBE)
        if ahead is not None and ahead.tests[GAP] > 0.0 and ahead.tests[SPEED] > 0.0:
            seeds.append(Seed(child, side, value, (1.0,)))
    return seeds


def limit_at(branch: Branch, event: Event) -> str:
    """Return why the orbits that begin at a bifurcation of a branch are not followed, "" if they are.

    Returns
    -------
    str
        "multiple" or "impacts" if they have too many periods or impacts, "rounding" if that hides them.
    """
    if branch.curve is None or event.reason in ("speed", "doubled"):
        return ""
    sequence = branch.curve.sequence
    n, is_doubled = len(sequence.supports), event.kind != "grazing"
    # A mirrored sequence is half of its orbit, and loses its symmetry within the same periods.
    if is_doubled and not sequence.mirrored and 2 * sequence.m > MAX_MULTIPLE:
        return "multiple"
    if (2 * n if is_doubled else n + 1) > MAX_SEQUENCE:
        return "impacts"
    point = branch.points[event.point]
    if point.tests[SPEED] < MIN_CHATTER_SPEED:
        return "rounding"
    return "rounding" if is_doubled and is_steep(branch.curve, point, 0.0, HIDDEN_LENGTH) else ""


def seeds_at(branch: Branch, event: Event) -> list[Seed]:
    """Return the branches that begin at a bifurcation of a branch."""
    if branch.curve is None:
        problem, value = branch.problem, branch.values[event.point]
        begun = struck_from_linear(problem, value)
        if begun is None:
            return []
        return _struck_seed(*begun)
    point = branch.points[event.point]
    if event.kind == "grazing":
        return (_removed if event.reason == "speed" else _inserted)(branch.curve, point)
    if event.reason == "doubled":
        at_parent = parent_point(branch.curve, point, event.kind)
        if at_parent is None:
            return []
        return [
            Seed(at_parent[0], _with_tests(at_parent[1], doubling=0.0), point.value, (1.0, -1.0))
        ]
    return _doubled_seeds(branch.curve, point, event.kind)
