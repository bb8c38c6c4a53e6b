"""Following a branch: steps of adapted length, its bifurcations located, and the reason why it ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from vibropipe.orbits.branches.curve import Curve, Point, Problem
from vibropipe.orbits.branches.events import Event, Mark, is_no_motion, marks_within
from vibropipe.orbits.branches.parents import parent_ahead, reached_parent
from vibropipe.orbits.branches.steps import DOUBLING, FOLD, GAP, SPEED

# First and least length of a step, and factors of its growth.
FIRST_LENGTH, MIN_LENGTH, GROWTH = 1e-3, 1e-10, 1.5
# Cosine of the largest angle between the tangents of neighbouring points, and of that below which steps grow.
MIN_COSINE, GROWTH_COSINE = math.cos(0.15), math.cos(0.07)
# Step towards the parent at which what lies before it is found.
PARENT_LENGTH = 1e-6
# Component of the tangent along the parameter at both ends of a longer step where orbits are a continuum: rounding.
FLAT, FLAT_LENGTH = 1e-10, 1e-5
# A branch with more points is left.
MAX_POINTS = 20_000
# The least impact speed may fall to this share in a step, unless it is below a bound: tests vary with its inverse.
SPEED_SHARE, SLOW = 0.4, 1e-5
# Evaluations in the search for a zero of a test function that three points only hint at.
MAX_SEARCH = 30


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


@dataclass
class Path:
    """Points of a branch in one direction, its events, and why it ended."""

    points: list[Point]
    events: list[Event] = field(default_factory=list)
    end: str = ""


def follow(
    curve: Curve, start: Point, closes: bool = True, first_length: float = FIRST_LENGTH
) -> Path:
    """Follow a branch from a point along its tangent until it ends or leaves the range of the parameter.

    Parameters
    ----------
    curve : Curve
    start : Point
    closes : bool
        Whether the branch is left where it returns to its start.
    first_length : float
        Weighted length of the first step.

    Returns
    -------
    Path
        Its end is `limit` (of the parameter), `closed`, `lost` (no further point), `points` (too many), or that of its
        last event.
    """
    path, length = Path([start]), first_length
    lengths, searches = [0.0], 0
    while not path.end:
        point = path.points[-1]
        kind = parent_ahead(curve, point, length)
        if kind:
            parent = reached_parent(curve, point, kind)
            if parent is not None and _is_clear(curve, point, parent):
                path.points.append(parent)
                path.events.append(Event(kind, "doubled", len(path.points) - 1))
                path.end = "doubled"
                break
            # Past a parent that is not found yet, a step may hide the last flip before it, and end at a wrong place.
            if length > PARENT_LENGTH:
                length *= 0.5
                continue
        new = curve.advance(point, length)
        if new is not None and length > FLAT_LENGTH and _is_flat(point, new):
            path.points.append(new)
            path.end = "continuum"
            break
        is_first = len(path.points) == 1
        if new is None or _is_too_far(curve, point, new) or (is_first and is_no_motion(new)):
            length *= 0.5
            if length < MIN_LENGTH:
                path.end = "lost"
            continue
        if not is_first and searches < 3:
            hint = _missed(curve, path.points[-2], point, new, lengths[-1], length)
            if hint is not None:
                searches += 1
                towards = length_towards(hint, path.points, lengths, path.events)
                if towards is not None:
                    length = towards
                    continue
        marks = marks_within(curve, point, new, length, start if closes else None)
        if marks is None:
            length *= 0.5
            if length < MIN_LENGTH:
                path.end = "lost"
            continue
        append_marks(path, marks, lengths)
        searches = 0
        if len(path.points) >= MAX_POINTS:
            path.end = path.end or "points"
        if curve.cosine(point, new) > GROWTH_COSINE:
            length = min(GROWTH * length, curve.problem.max_length)
    return path


def length_towards(
    hint: float, points: list[Point], lengths: list[float], events: Sequence[Any]
) -> float | None:
    """Return the length of the next step, to a hint; None if it lies before a last point that has an event.

    A last point behind the hint is removed otherwise, and the step begins at the one before.

    Parameters
    ----------
    hint : float
        Weighted length from the last point; negative before it.
    points, lengths : list
        Points so far, and the length of the step to each.
    events : sequence
        Records with the index of their `point`, in order.
    """
    if hint > 0.0:
        return hint
    if events and events[-1].point >= len(points) - 1:
        return None
    points.pop()
    return lengths.pop() + hint


def _is_clear(curve: Curve, point: Point, parent: Point) -> bool:
    """Return whether no flip, and no wanted value or limit of the parameter, lies between a point and its parent."""
    # Next to the parent a doubled orbit has a multiplier close to 1.
    if point.tests[DOUBLING] < 0.0:
        return False
    values = (*curve.problem.at, curve.problem.low, curve.problem.high)
    return not any((point.value - value) * (parent.value - value) < 0.0 for value in values)


def _is_flat(point: Point, new: Point) -> bool:
    """Return whether the parameter does not change over a step, as for undamped orbits at a natural period."""
    return abs(point.tests[FOLD]) < FLAT and abs(new.tests[FOLD]) < FLAT


def _is_too_far(curve: Curve, point: Point, new: Point) -> bool:
    """Return whether a step is too long to see what lies within it."""
    speed = point.tests[SPEED]
    return bool(
        curve.cosine(point, new) < MIN_COSINE
        or (speed > SLOW and new.tests[SPEED] < SPEED_SHARE * speed)
    )


def append_marks(path: Path, marks: list[Mark], lengths: list[float]) -> None:
    """Append the points of a step, up to the first that ends the branch."""
    before = 0.0
    for mark in marks:
        if mark.length > before or not mark.kind:
            path.points.append(mark.point)
            lengths.append(mark.length - before)
            before = mark.length
        if mark.kind not in ("", "limit"):
            path.events.append(Event(mark.kind, mark.reason, len(path.points) - 1))
        if mark.reason:
            path.end = mark.reason
            break


def _missed(
    curve: Curve, before: Point, point: Point, new: Point, back: float, ahead: float
) -> float | None:
    """Return where, from `point`, a test function changes sign that none of three points in a row shows; or None."""
    for test in (FOLD, DOUBLING, SPEED, GAP):
        a, b, c = (float(each.tests[test]) for each in (before, point, new))
        if not (a * b > 0.0 and b * c > 0.0 and abs(b) < abs(a) and abs(b) <= abs(c)):
            continue
        slope_back, slope_ahead = (b - a) / back, (c - b) / ahead
        curvature = (slope_ahead - slope_back) / (0.5 * (back + ahead))
        slope = (slope_back * ahead + slope_ahead * back) / (back + ahead)
        if curvature != 0.0 and (b - 0.5 * slope**2 / curvature) * b > 0.5 * b * b:
            continue
        length = _search(curve, point, -back, ahead, test, math.copysign(1.0, b))
        if length is not None:
            return length
    return None


def _search(
    curve: Curve, point: Point, low: float, high: float, test: int, sign: float
) -> float | None:
    """Return a length at which a test function has the other sign, sought at its minimum by golden sections."""
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    first, second = high - ratio * (high - low), low + ratio * (high - low)
    values: dict[float, float] = {}
    for _ in range(MAX_SEARCH):
        for length in (first, second):
            if length not in values:
                trial = curve.advance(point, length)
                values[length] = math.inf if trial is None else sign * float(trial.tests[test])
                if values[length] < 0.0:
                    return length
        if values[first] < values[second]:
            high, second = second, first
            first = high - ratio * (high - low)
        else:
            low, first = first, second
            second = low + ratio * (high - low)
    return None
