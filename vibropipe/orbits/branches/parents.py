"""Where a branch of doubled (or asymmetric) orbits reaches the branch of orbits that repeat (or mirror) their half."""

from __future__ import annotations

import numpy as np

from vibropipe.continuation.curve import FOLD, Point
from vibropipe.orbits.branches.symmetry import doubled, halved, halves_difference
from vibropipe.orbits.law.curve import LawCurve, LawZeros
from vibropipe.orbits.law.steps import DETERMINANT, DOUBLING, MINORS, TRACE

# Weighted distances from an orbit within which the flip or pitchfork of its parent is sought, one after the other.
PROBES = (1e-5, 1e-3, 0.05)
# Weighted difference of the halves of an orbit from which its parent is sought, and below which it is the parent.
NEAR_PARENT, AT_PARENT = 0.2, 1e-9


def parent_point(curve: LawCurve, point: Point, kind: str) -> tuple[LawCurve, Point] | None:
    """Return the parent of a doubled orbit, at its flip or pitchfork next to the orbit; None if there is none.

    curve, point : the doubled orbit
    kind : "flip" or "pitchfork"
    """
    sequence, u = halved(curve.sequence, point.u, kind)
    parent = curve.with_sequence(sequence)
    start = parent.settle(u)
    if start is None:
        return None
    for probe in PROBES:
        zero = parent.locate(start, (-probe, probe), lambda each: float(each.tests[DOUBLING]))
        if zero is not None and abs(zero[1].tests[DOUBLING]) < AT_PARENT:
            return parent, zero[1]
    return None


def child_point(parent: LawCurve, point: Point, by: np.ndarray) -> tuple[LawCurve, Point]:
    """Return a flip or pitchfork of a branch as the point of its doubled orbits, with its tangent along them.

    parent, point : the bifurcation
    by : (w n + 1,), `LawZeros.doubling_vector` there
    """
    sequence, u, change = doubled(parent.sequence, point.u, by)
    child = parent.with_sequence(sequence)
    tests = point.tests.copy()
    trace, determinant = tests[TRACE], tests[DETERMINANT]
    minors = tests[MINORS] if parent.width > 2 else determinant
    tests[TRACE], tests[DETERMINANT] = trace**2 - 2.0 * minors, determinant**2
    tests[MINORS] = minors**2 - 2.0 * trace * determinant
    tests[FOLD], tests[DOUBLING] = 0.0, 1.0
    length = np.sqrt(np.sum(change * change * child.squares))
    return child, child.point(u, change / length, tests)


def parent_ahead(curve: LawZeros, symmetric: bool, point: Point, length: float) -> str:
    """Return of which kind the parent of doubled orbits is, if a step along the tangent leads past it.

    symmetric : whether the exciter is its own mirror image on the whole curve
    length : weighted length of the step

    Returns "flip" or "pitchfork"; "" if the step leads past none.
    """
    sequence, weights = curve.sequence, curve.weights
    kind = "pitchfork" if sequence.m % 2 else "flip"
    if kind == "pitchfork" and not symmetric:
        return ""
    now = halves_difference(sequence, point.u, weights, kind)
    if now is None or not AT_PARENT < np.abs(now).max() < NEAR_PARENT:
        return ""
    ahead = halves_difference(sequence, point.u + length * point.tangent, weights, kind)
    return "" if ahead is None or np.dot(now, ahead) > 0.0 else kind


def reached_parent(curve: LawCurve, point: Point, kind: str) -> Point | None:
    """Return the parent of doubled orbits as a point of their branch, if the branch reaches it next to a point.

    The equations of the doubled sequence are singular there, and steps fail: the parent's are not.

    kind : that of `parent_ahead`
    """
    now = halves_difference(curve.sequence, point.u, curve.weights, kind)
    at_parent = parent_point(curve, point, kind)
    if now is None or at_parent is None:
        return None
    parent, at = at_parent
    _child, reached = child_point(parent, at, parent.doubling_vector(at))
    return None if curve.distance(reached, point) > 2.0 * np.abs(now).max() else reached
