"""Following a branch of orbits by linear pieces, over the places where other events begin its pieces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibropipe.continuation.curve import CROSSING, FOLD, Point
from vibropipe.continuation.follower import (
    FIRST_LENGTH,
    GROWTH,
    GROWTH_COSINE,
    MIN_COSINE,
    MIN_LENGTH,
)
from vibropipe.continuation.path import Event, Mark, Path, Step
from vibropipe.orbits.branches.following import BranchFollower
from vibropipe.orbits.branches.pieces.curve import PIECES, SECTION, PieceCurve
from vibropipe.orbits.branches.pieces.return_map import LAW
from vibropipe.orbits.branches.symmetry import EQUAL_HALVES

# Length of a step within which a change of the pieces is located, and the largest weighted distance over it: beyond,
# what is found there is another orbit.
CHANGE_LENGTH, SAME_ORBIT = 1e-10, 1e-6
# Weighted distance of a point from the start at which a branch is closed.
CLOSED = 1e-7
# Length from a point to a change beyond which another point is needed to pass it.
CLOSE_LENGTH = 1e-8
# Largest number of such points, and the length of the step from the first; from the n-th, its n-th power.
MAX_RETRIES, RETRY_LENGTH = 3, 1e-3
# Length of a step up to which the tangent may turn more: beside a grazing it turns as the root of the length. After so
# many such steps in a row a branch ends.
SHARP_LENGTH, SHARP_COSINE, MAX_CRAWLED = 1e-6, 0.5, 100
# Events after which a branch is left: where contacts chatter, pieces change ever again.
MAX_EVENTS = 200
# Length ahead of a point from which no step succeeds at which its pieces are looked at.
AHEAD = 1e-8
# Lengths along the branch of the pieces ahead at which its first orbit is sought, and how many of the last points it
# must not lie on.
TURN_LENGTHS, RECENT = (1e-9, 1e-8, 1e-7, 1e-6), 4
# Largest length over a change without points.
LARGEST_GAP = 1e-4
# Largest change of the orbit over that of the parameter beyond it.
STEEPEST = 100.0
# Length of a step within which two branches cross: shorter ones need not succeed there.
CROSSING_LENGTH = 1e-7
# Weighted difference of the halves of an orbit next to which steps fail at which the branch of its halves is reached.
NEAR_HALVES = 1e-3
# That of an orbit which is its own mirror image: rounding.
SYMMETRIC = 1e-8


class Change(NamedTuple):
    """A change of the pieces within a step: the last point before it, the first found after it, and their lengths."""

    before: Point
    after: Point
    length: float
    length_after: float


def follow_pieces(
    curve: PieceCurve, start: Point, closes: bool = True, first_length: float = FIRST_LENGTH
) -> Path:
    """Follow a branch from a point along its tangent; arguments and result are those of `following.follow`.

    A change of the pieces is an event of kind "change"; the path ends there ("gap") where no orbit continues it.
    """
    follower = PieceFollower(curve, start, closes, first_length)
    path, length = Path([curve.recut(start)]), first_length
    retries, crawled, lengths = 0, 0, path.lengths
    while not path.end:
        point, reached = path.points[-1], length
        new, change = curve.advance(point, length), None
        if new is not None and new.tests[PIECES] != point.tests[PIECES]:
            change = _locate_change(curve, point, new, length)
            new, reached = change.before, change.length
        marks: list[Mark] | None = None
        least = SHARP_COSINE if length < SHARP_LENGTH else MIN_COSINE
        if (
            new is not None
            and curve.cosine(point, new) > least
            and not _is_halved(curve, (point,), new)
        ):
            marks = _marks(follower, Step(point, new, reached)) if reached > 0.0 else []
        if marks is None or new is None:
            length *= 0.5
            if length < MIN_LENGTH:
                _end_at_last(curve, path, lengths)
                length = FIRST_LENGTH
            continue
        path.append(marks)
        crawled = crawled + 1 if length < SHARP_LENGTH else 0
        if crawled > MAX_CRAWLED and not path.end:
            _end_at_last(curve, path, lengths)
            crawled = 0
            continue
        if change is not None and not path.end:
            is_passed = _pass_change(curve, path, change, lengths, retries < MAX_RETRIES)
            retries = 0 if is_passed else retries + 1
        if not path.end:
            path.points[-1] = curve.recut(path.points[-1])
        if len(path.points) >= follower.max_points or len(path.events) >= MAX_EVENTS:
            path.end = path.end or "points"
        if change is not None:
            length = FIRST_LENGTH if retries == 0 else max(RETRY_LENGTH**retries, MIN_LENGTH)
        elif curve.cosine(point, new) > GROWTH_COSINE:
            length = min(GROWTH * length, curve.problem.max_length)
    return path


class PieceFollower(BranchFollower):
    """What is looked for on a branch of orbits by linear pieces."""

    curve: PieceCurve

    def closing(self, step: Step) -> list[Mark]:
        """Return the start as a point of a step, where the parameter has its value again: sections may differ."""
        value, length = self.start.value, step.length
        passes = (step.point.value - value) * (step.new.value - value) < 0.0
        if not (self.closes and passes):
            return []
        zero = self.curve.value_of(step.point, (0.0, length), -1, value)
        is_start = zero is not None and self.curve.distance(zero[1], self.start) < CLOSED
        return [Mark(*zero, "", "closed")] if zero is not None and is_start else []


def _end_at_last(curve: PieceCurve, path: Path, lengths: list[float]) -> None:
    """End a path at its last point, from which no step succeeds, or go on beyond a change of the pieces there."""
    point, middle = path.points[-1], path.points[len(path.points) // 2]
    beyond = _beyond(curve, point)
    if beyond is not None and not _is_halved(curve, (middle, point), beyond):
        path.events.append(Event("change", "", len(path.points) - 1))
        path.points.append(beyond)
        lengths.append(LARGEST_GAP)
        if beyond.value in (curve.problem.low, curve.problem.high):
            path.end = "limit"
        return
    turned = _turned(curve, path)
    if turned is not None and not _is_halved(curve, (middle, point), turned):
        path.events.append(Event("change", "", len(path.points) - 1))
        path.points.append(turned)
        lengths.append(LARGEST_GAP)
    elif _reaches_parent(curve, (middle,), point, NEAR_HALVES):
        path.end = "doubled"
        path.events.append(Event(curve.halves, "doubled", len(path.points) - 1))
    elif _changes_ahead(curve, point):
        path.end = "gap"
        path.events.append(Event("change", "gap", len(path.points) - 1))
    else:
        path.end = "lost"


def _changes_ahead(curve: PieceCurve, point: Point) -> bool:
    """Return whether the motion just ahead of a point has other pieces, or grazes a rigid support."""
    curve.section = float(point.tests[SECTION])
    ahead = curve.differentiate(point.u + AHEAD * point.tangent)
    return ahead is None or ahead[LAW] != point.tests[PIECES]


def _beyond(curve: PieceCurve, point: Point) -> Point | None:
    """Return the next orbit along the parameter that has other pieces, and is as close; None if there is none.

    Where two events change at once, as in symmetric orbits, Newton's method along the branch alternates between them.
    """
    way, gap = np.sign(point.tests[FOLD]), CHANGE_LENGTH
    curve.section = float(point.tests[SECTION])
    while gap < LARGEST_GAP:
        u = point.u.copy()
        u[-1] = _nearest_in_range(curve, u[-1] + way * gap / curve.weights[-1])
        other = curve.settle(u)
        is_other = other is not None and other.tests[PIECES] != point.tests[PIECES]
        if other is None or not is_other:
            gap *= 10.0
            continue
        if curve.distance(point, other) < SAME_ORBIT + STEEPEST * gap:
            return other if other.tests[FOLD] * way > 0.0 else other.reversed()
        gap *= 10.0
    return None


def _turned(curve: PieceCurve, path: Path) -> Point | None:
    """Return the first orbit with the pieces just ahead of the last point, whichever way it leads; None if none.

    Its branch may lead back along the parameter, or at an angle at which steps along the old one miss it: it is sought
    along its own tangent, that of the equations ahead.
    """
    point = path.points[-1]
    curve.section = float(point.tests[SECTION])
    tangent = curve.tangent_at(point.u + AHEAD * point.tangent)
    if tangent is None or curve.result[LAW] == point.tests[PIECES]:
        return None
    start = Point(point.u, tangent, point.tests)
    for length in TURN_LENGTHS:
        for side in (start, start.reversed()):
            other = curve.advance(side, length)
            if other is None or other.tests[PIECES] == point.tests[PIECES]:
                continue
            is_near = curve.distance(point, other) < SAME_ORBIT + 2.0 * length
            is_in_range = _nearest_in_range(curve, other.value) == other.value
            if is_near and is_in_range and not _is_behind(curve, path, other):
                return other
    return None


def _is_behind(curve: PieceCurve, path: Path, other: Point) -> bool:
    """Return whether an orbit lies next to one of the last points but one, from which the path has come."""
    return any(
        before.tests[PIECES] == other.tests[PIECES] and curve.distance(before, other) < LARGEST_GAP
        for before in path.points[-RECENT:-1]
    )


def _nearest_in_range(curve: PieceCurve, value: float) -> float:
    """Return the value of the parameter in its range that is closest to one."""
    return min(max(value, curve.problem.low), curve.problem.high)


def _locate_change(curve: PieceCurve, point: Point, new: Point, length: float) -> Change:
    """Return where within a step to `new`, which has other pieces, they change."""
    low, high, before, after, reached = 0.0, length, point, new, length
    while high - low > CHANGE_LENGTH:
        middle = 0.5 * (low + high)
        trial = curve.advance(point, middle)
        if trial is not None and trial.tests[PIECES] == point.tests[PIECES]:
            low, before = middle, trial
            continue
        high = middle
        # Close to the change Newton's method may alternate between its sides.
        if trial is not None:
            after, reached = trial, middle
    return Change(before, after, low, reached)


def _pass_change(
    curve: PieceCurve, path: Path, change: Change, lengths: list[float], may_retry: bool
) -> bool:
    """Note a change of the pieces at the last point, and go on beyond it; return False if a shorter step should."""
    before, after = change.before, change.after
    limit = _nearest_in_range(curve, after.value)
    if limit != after.value:
        # The change may lie at the limit, within the length to which it is located.
        exact = before.u.copy()
        exact[-1] = limit
        last = curve.settle(exact)
        if last is not None and curve.distance(before, last) < SAME_ORBIT:
            path.points.append(last)
            lengths.append(CHANGE_LENGTH)
            path.end = "limit"
            return True
    gap = change.length_after - change.length
    is_near = gap < LARGEST_GAP and curve.distance(before, after) < SAME_ORBIT + 2.0 * gap
    goes_on = is_near and limit == after.value
    if not goes_on and may_retry and change.length > CLOSE_LENGTH:
        # The branch may turn sharply: from the last point, more of it can be seen.
        return False
    if not goes_on:
        turned = _turned(curve, path)
        if turned is not None:
            after, gap, goes_on = turned, max(TURN_LENGTHS), True
    middle = path.points[len(path.points) // 2]
    goes_on = goes_on and not _is_halved(curve, (middle, before), after)
    path.events.append(Event("change", "" if goes_on else "gap", len(path.points) - 1))
    if goes_on:
        path.points.append(after)
        lengths.append(gap)
    else:
        path.end = "gap"
    return True


def _marks(follower: PieceFollower, step: Step) -> list[Mark] | None:
    """Return the points of a step in order, as `marks_within`, with places where branches cross."""
    curve, (point, new, length) = follower.curve, step
    marks = follower.marks_within(step)
    if marks is None:
        return None
    for i, mark in enumerate(marks):
        # Doubled orbits turn at the branch of their halves.
        if mark.kind == "fold" and _reaches_parent(curve, (point, new), mark.point, EQUAL_HALVES):
            return [*marks[:i], mark._replace(kind=curve.halves, reason="doubled")]
    crosses = point.tests[CROSSING] * new.tests[CROSSING] < 0.0
    # A symmetric orbit loses its symmetry where its branch is crossed.
    if crosses and curve.halves == "pitchfork" and curve.halves_difference(new) < SYMMETRIC:
        crossing = curve.locate(point, (0.0, length), lambda each: float(each.tests[CROSSING]))
        if crossing is None and length > CROSSING_LENGTH:
            return None
        # The equations are singular there, and a step may fail.
        marks.append(Mark(*((length, new) if crossing is None else crossing), "pitchfork", ""))
    return sorted(marks, key=lambda mark: mark.length)


def _is_halved(curve: PieceCurve, beside: Sequence[Point], point: Point) -> bool:
    """Return whether a point after others of a branch is an orbit of half as many periods, which solves its equations.

    Orbits of even multiples end where they meet those of their halves, at a flip or with a change of the pieces.
    """
    return curve.halves == "flip" and _reaches_parent(curve, beside, point, SYMMETRIC)


def _reaches_parent(
    curve: PieceCurve, beside: Sequence[Point], point: Point, tolerance: float
) -> bool:
    """Return whether the halves of an orbit agree at a point, but not at one of others of its branch."""
    if not curve.halves:
        return False
    here = curve.halves_difference(point)
    there = max(map(curve.halves_difference, beside))
    return here < tolerance and there > max(SYMMETRIC, 2.0 * here)
