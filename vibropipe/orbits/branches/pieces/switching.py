"""Branches that begin at flips and pitchforks of orbits by linear pieces, and those that such branches return to."""

from __future__ import annotations

import numpy as np

from vibropipe.continuation.curve import CROSSING, FOLD, Point
from vibropipe.continuation.path import Event
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.pieces.curve import BETTER, PIECES, SECTION, PieceCurve
from vibropipe.orbits.branches.pieces.return_map import (
    BY_PARAMETER,
    BY_SECTION,
    LAW,
    fixed_point_jacobian,
)
from vibropipe.orbits.branches.steps import DOUBLING
from vibropipe.orbits.branches.switching import DOUBLED_LENGTH
from vibropipe.orbits.recurrence import MAX_MULTIPLE

# Lengths of the first step of doubled orbits that are tried, and the least difference of their halves over it: the
# parent solves the same equations.
FIRST_LENGTHS, MIN_SHARE = (DOUBLED_LENGTH, 1e-3, 1e-4, 1e-5), 0.1


def limit_of_pieces(branch: Branch, event: Event) -> str:
    """Return "multiple" if the orbits that begin at a flip have too many periods to be followed, "" if not."""
    assert branch.curve is not None
    is_long = 2 * branch.curve.sequence.m > MAX_MULTIPLE
    return "multiple" if is_long and event.kind == "flip" and not event.reason else ""


def seeds_of_pieces(branch: Branch, event: Event) -> list[Seed]:
    """Return the branches that begin at a bifurcation of a branch: none but at flips and pitchforks."""
    curve, point = branch.curve, branch.points[event.point]
    assert isinstance(curve, PieceCurve)
    if event.kind not in ("flip", "pitchfork"):
        return []
    is_flip, m = event.kind == "flip", curve.sequence.m
    if event.reason == "doubled":
        parent = curve.of_multiple(m // 2 if is_flip else m)
        start = _along_parent(parent, point)
        return [] if start is None else [Seed(parent, start, point.value, (1.0, -1.0))]
    child = curve.of_multiple(2 * m if is_flip else m)
    across = _across(curve, child, point, -1.0 if is_flip else 1.0)
    # The other side of a flip is the same orbit a period later.
    sides = [across] if is_flip else [across, across.reversed()]
    lengths = [_first_length(child, side) for side in sides]
    return [
        Seed(child, side, point.value, (1.0,), length)
        for side, length in zip(sides, lengths, strict=True)
        if length > 0.0
    ]


def _first_length(child: PieceCurve, start: Point) -> float:
    """Return the length of a first step that leads away from the parent; 0 if there is none."""
    for length in FIRST_LENGTHS:
        ahead = child.advance(start, length)
        if ahead is not None and child.halves_difference(ahead) > MIN_SHARE * length:
            return length
    return 0.0


def _across(curve: PieceCurve, child: PieceCurve, point: Point, multiplier: float) -> Point:
    """Return a bifurcation as a point of the branch that begins there, its tangent along a Floquet vector."""
    curve.section = float(point.tests[SECTION])
    result = curve.differentiate(point.u)
    assert result is not None
    multipliers, vectors = np.linalg.eig(result[BY_SECTION].reshape(2, 2))
    vector = np.real(vectors[:, np.abs(multipliers - multiplier).argmin()])
    tangent = np.append(vector, 0.0)
    doubled = child.sequence.m // curve.sequence.m
    return _start(child, point, tangent, doubled * point.tests[PIECES])


def _along_parent(parent: PieceCurve, point: Point) -> Point | None:
    """Return the point where a branch turns at its parent as a point of the parent."""
    parent.section = float(point.tests[SECTION])
    result = parent.differentiate(point.u)
    if result is None:
        return None
    equations = fixed_point_jacobian(result)
    # At a pitchfork the equations are singular: of all solutions, the least one.
    section = np.linalg.lstsq(equations, -result[BY_PARAMETER], rcond=1e-6)[0]
    return _start(parent, point, np.append(section, 1.0), float(result[LAW]))


def _start(curve: PieceCurve, point: Point, tangent: np.ndarray, law: float) -> Point:
    """Return the first point of a branch, at a bifurcation: no test function changes its sign there."""
    tests = point.tests.copy()
    tests[FOLD] = tests[DOUBLING] = tests[CROSSING] = 0.0
    tests[PIECES] = law
    curve.section = float(tests[SECTION])
    is_known = curve.differentiate(point.u) is not None
    tests[BETTER] = curve.better_section() if is_known else curve.section
    return Point(point.u, tangent / np.linalg.norm(tangent * curve.weights), tests)
