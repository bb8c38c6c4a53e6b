"""Following a boundary to both of its ends: admissible points, and what meets it on the way."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vibropipe.orbits.boundaries.curve import SAME_POINT, BoundaryCurve
from vibropipe.orbits.boundaries.system import GRAZINGS
from vibropipe.orbits.branches.curve import Point
from vibropipe.orbits.branches.events import is_no_motion
from vibropipe.orbits.branches.following import (
    FIRST_LENGTH,
    GROWTH,
    GROWTH_COSINE,
    MIN_COSINE,
    MIN_LENGTH,
    length_towards,
)
from vibropipe.orbits.branches.steps import DOUBLING, FOLD, GAP, SPEED

# A boundary with more points is left.
MAX_POINTS = 5_000
# Two impacts may begin at once: the equations are singular there. A boundary whose steps are as short as this, and that
# is `near_end`, has reached such a point.
SHORT_LENGTH = 1e-6
# One whose steps are as short as this so many times in a row is left.
CRAWL_LENGTH, MAX_CRAWLED = 1e-5, 50
# Share of a step along the parameters, weighted, below which they do not change: a cusp.
NO_CHANGE = 1e-5
# Evaluations in the search for a zero between three points.
MAX_SEARCH = 24


class Meeting(NamedTuple):
    """What a boundary meets: its name, the index of the point, and whether the boundary ends there."""

    name: str
    point: int
    ends: bool


class Mark(NamedTuple):
    """A point within a step: its length from the start of the step, the name of a meeting or "", and if it ends."""

    length: float
    point: Point
    name: str = ""
    ends: bool = False


@dataclass
class Path:
    """Points of a boundary in one direction, what it meets, and whether it came back to its start."""

    points: list[Point]
    meetings: list[Meeting] = field(default_factory=list)
    closed: bool = False


def follow(curve: BoundaryCurve, start: Point) -> Path:
    """Follow a boundary from a point along its tangent until it leaves the box or the orbit ceases to be a motion.

    Parameters
    ----------
    curve : BoundaryCurve
    start : Point
    """
    path, length, lengths, searches, crawled = Path([start]), FIRST_LENGTH, [0.0], 0, 0
    end = ""
    while not end:
        point = path.points[-1]
        new = curve.advance(point, length)
        if (
            new is None
            or curve.cosine(point, new) < MIN_COSINE
            or (len(path.points) == 1 and is_no_motion(new))
        ):
            length *= 0.5
            end = _singular_end(curve, point, length)
            continue
        if lengths[-1] > 0.0 and searches < 2:
            missed = _missed(curve, path.points[-2], point, new, lengths[-1], length)
            if missed is not None:
                searches += 1
                towards = length_towards(missed, path.points, lengths, path.meetings)
                if towards is not None:
                    length = towards
                    continue
        marks = marks_within(curve, point, new, length)
        if marks is None:
            length *= 0.5
            end = _singular_end(curve, point, length)
            continue
        if len(path.points) > 3 and _returns(curve, start, point, new, length):
            path.closed, end = True, "closed"
            path.points.append(Point(curve.shifted(start.u, point.u), start.tangent, start.tests))
            continue
        searches, before = 0, 0.0
        for mark in marks:
            path.points.append(mark.point)
            lengths.append(mark.length - before)
            before = mark.length
            if mark.name:
                path.meetings.append(Meeting(mark.name, len(path.points) - 1, mark.ends))
            if mark.ends:
                end = mark.name
                break
        if not end and len(path.points) >= MAX_POINTS:
            end = "points"
        crawled = crawled + 1 if length < CRAWL_LENGTH else 0
        if not end and crawled > MAX_CRAWLED:
            end = curve.near_end(point) or "lost"
        if curve.cosine(point, new) > GROWTH_COSINE:
            length = min(GROWTH * length, curve.box.max_length)
    if not path.closed and not (path.meetings and path.meetings[-1].ends):
        path.meetings.append(Meeting(end, len(path.points) - 1, True))
    return path


def _singular_end(curve: BoundaryCurve, point: Point, length: float) -> str:
    """Return what a boundary meets where its equations become singular, if its steps have become that short; or ""."""
    name = curve.near_end(point) if length < SHORT_LENGTH else ""
    return name or ("lost" if length < MIN_LENGTH else "")


def marks_within(
    curve: BoundaryCurve, point: Point, new: Point, length: float
) -> list[Mark] | None:
    """Return the points of a step in order, up to the first end; None if one cannot be located."""
    marks: list[Mark] = []
    for test in (SPEED, GAP):
        if point.tests[test] > 0.0 >= new.tests[test]:
            zero = curve.zero_of(point, length, test)
            if zero is None:
                return None
            # Where an impact loses its speed, the flight towards it turns at its end: one meeting.
            if not marks or zero[0] < marks[0].length - 1e-6 * length:
                marks.append(Mark(*zero, curve.meeting_of(test, zero[1], new), True))
    if is_no_motion(new) and not marks:
        return None
    if curve.kind == GRAZINGS:
        for test, name in ((FOLD, "grazing_fold"), (DOUBLING, "grazing_flip")):
            if point.tests[test] * new.tests[test] < 0.0:
                zero = curve.zero_of(point, length, test)
                if zero is None:
                    return None
                if test == DOUBLING and curve.sequence.mirrored:
                    name = "grazing_pitchfork"
                marks.append(Mark(*zero, name))
    else:
        cusp = _cusp_within(curve, point, new, length)
        marks += [cusp] if cusp is not None else []
    limits = _limits_within(curve, point, new, length)
    if limits is None:
        return None
    marks = sorted([*marks, *limits, Mark(length, new)], key=lambda mark: mark.length)
    first_end = next((n for n, mark in enumerate(marks) if mark.ends), len(marks))
    return marks[: first_end + 1]


def _crossing(
    curve: BoundaryCurve, point: Point, length: float, column: int, limit: float
) -> tuple[float, Point] | None:
    """Return where in a step an unknown has a value."""
    return curve.locate(point, (0.0, length), lambda each: float(each.u[column] - limit))


def _direction(curve: BoundaryCurve, point: Point) -> np.ndarray:
    """Return the weighted change of both parameters along the boundary."""
    return np.asarray(point.tangent[-2:] * curve.weights[-2:])


def _cusp_within(curve: BoundaryCurve, point: Point, new: Point, length: float) -> Mark | None:
    """Return where both parameters turn back at once, if they do within a step."""
    first = _direction(curve, point)
    if np.dot(first, _direction(curve, new)) >= 0.0:
        return None
    zero = curve.locate(
        point, (0.0, length), lambda each: float(np.dot(first, _direction(curve, each)))
    )
    if zero is None or np.abs(_direction(curve, zero[1])).max() > NO_CHANGE:
        return None
    # At a degenerate bifurcation doubled orbits shrink to their parent, and go back with their halves exchanged.
    half = curve.halves_at(zero[1])
    return Mark(*zero, f"degenerate_{half}" if half else "cusp", bool(half))


def _limits_within(
    curve: BoundaryCurve, point: Point, new: Point, length: float
) -> list[Mark] | None:
    """Return the points of a step on the sides of the box."""
    marks = []
    for index in (0, 1):
        for limit, sign in ((curve.box.low[index], -1.0), (curve.box.high[index], 1.0)):
            column = index - 2
            if sign * (new.u[column] - limit) <= 0.0:
                continue
            crossing = _crossing(curve, point, length, column, float(limit))
            if crossing is None:
                return None
            exact = crossing[1].u.copy()
            exact[column] = limit
            settled = curve.settle(exact, column)
            if settled is None:
                return None
            if curve.cosine(crossing[1], settled) < 0.0:
                settled = Point(settled.u, -settled.tangent, settled.tests)
            marks.append(Mark(crossing[0], settled, "box", True))
    return marks


def _returns(curve: BoundaryCurve, start: Point, point: Point, new: Point, length: float) -> bool:
    """Return whether a boundary comes back to its start within a step."""
    there = curve.shifted(start.u, point.u)
    at = curve.along_tangent(point, there)
    if not 0.0 < at <= length or curve.weighted(there - point.u) > 2.0 * length:
        return False
    reached = curve.advance(point, at)
    return reached is not None and curve.weighted(reached.u - there) < SAME_POINT


def _missed(
    curve: BoundaryCurve, before: Point, point: Point, new: Point, back: float, ahead: float
) -> float | None:
    """Return where, from `point`, a gap or speed changes sign that none of three points shows; or None."""
    for test in (GAP, SPEED):
        a, b, c = (float(each.tests[test]) for each in (before, point, new))
        if not (min(a, b, c) > 0.0 and b < a and b <= c):
            continue
        slope_back, slope_ahead = (b - a) / back, (c - b) / ahead
        curvature = (slope_ahead - slope_back) / (0.5 * (back + ahead))
        slope = (slope_back * ahead + slope_ahead * back) / (back + ahead)
        if curvature <= 0.0 or b - 0.5 * slope**2 / curvature > 0.5 * b:
            continue
        for share in np.linspace(-0.96, 0.96, MAX_SEARCH):
            length = float(share * (ahead if share > 0.0 else back))
            trial = curve.advance(point, length)
            if trial is not None and trial.tests[test] < 0.0:
                return length
    return None
