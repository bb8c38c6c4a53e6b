"""Following a curve: steps of adapted length, what lies on them located to rounding, and why the curve ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from vibropipe.continuation.curve import Curve, Point, Zero
from vibropipe.continuation.path import Mark, Path, Step, Wanted

# First and least length of a step, and factors of its growth.
FIRST_LENGTH, MIN_LENGTH, GROWTH = 1e-3, 1e-10, 1.5
# Cosine of the largest angle between the tangents of neighbouring points, and of that below which steps grow.
MIN_COSINE, GROWTH_COSINE = math.cos(0.15), math.cos(0.07)
# Steps that are sought for a zero that three points only hint at, in a row, and evaluations of each search.
MAX_SEARCHES, MAX_SEARCH = 3, 30
# Weighted distance from its start at which a curve is closed.
SAME_POINT = 1e-6
# Two places of a step within this share of it are one.
SAME_PLACE = 1e-6


class Follower:
    """Follows a curve from a point along its tangent until it ends.

    A kind of curve says in a class of its own what is looked for on it.

    closes : whether the curve is left where it returns to its start
    first_length : weighted length of the first step
    """

    # Test functions that are positive on the curve, which ends where one is zero, and those whose zeros are noted.
    ends: tuple[int, ...] = ()
    turns: tuple[int, ...] = ()
    # Whether test functions may jump, or be infinite, at an end: others are then compared just before it, and one that
    # cannot be located beside it is none.
    jumps = False
    # Those of which two zeros between points are sought; all without a choice.
    hinted: tuple[int, ...] | None = None
    # Values at which points are wanted, or at which the curve ends.
    wanted: Sequence[Wanted] = ()
    max_points = 20_000
    # A curve whose steps are no longer than this so many times in a row is left.
    crawl_length, max_crawled = 0.0, 50

    def __init__(
        self, curve: Curve, start: Point, closes: bool = True, first_length: float = FIRST_LENGTH
    ) -> None:
        self.curve, self.start, self.closes = curve, start, closes
        self.path, self.length = Path([start]), first_length

    def name_of(self, test: int, step: Step, zero: Zero) -> tuple[str, str]:
        """Return the kind of a zero of a test function, and the reason to end the curve there ("" if it goes on)."""
        return f"test {test}", "end" if test in self.ends else ""

    def looks_ahead(self) -> bool:
        """Return whether the next step may be tried; if not, the path has ended or the step is shorter now."""
        return True

    def ends_at(self, new: Point) -> str:
        """Return why the curve ends at a point just reached, whatever lies before it; "" if it goes on."""
        return ""

    def is_too_far(self, point: Point, new: Point) -> bool:
        """Return whether a step is too long to see what lies within it."""
        return self.curve.cosine(point, new) < MIN_COSINE

    def marks_of_its_own(self, step: Step) -> list[Mark]:
        """Return points of a step that no test function shows."""
        return []

    def why_stuck(self, point: Point, length: float) -> str:
        """Return why the curve ends at a point, where steps of this length fail; "" if shorter ones are to be tried."""
        return "lost" if length < MIN_LENGTH else ""

    def why_crawling(self, point: Point) -> str:
        """Return why the curve ends at a point to which steps have become short."""
        return "lost"

    def is_inside(self, point: Point) -> bool:
        """Return whether all test functions that end the curve are positive."""
        return all(point.tests[test] > 0.0 for test in self.ends)

    def follow(self) -> Path:
        """Follow the curve.

        The end of the path is the name of a limit, `closed`, `lost` (no further point), `points` (too many), or the
        reason of its last event.
        """
        path, curve = self.path, self.curve
        searches, crawled = 0, 0
        while not path.end:
            point, length = path.points[-1], self.length
            if not self.looks_ahead():
                continue
            new = curve.advance(point, length)
            is_first = len(path.points) == 1
            if new is not None:
                path.end = self.ends_at(new)
                if path.end:
                    path.points.append(new)
                    break
            if new is None or self.is_too_far(point, new) or (is_first and not self.is_inside(new)):
                self._shorten(point)
                continue
            if not is_first and searches < MAX_SEARCHES:
                hint = self._missed(new)
                towards = None if hint is None else path.length_towards(hint)
                searches += hint is not None
                if towards is not None:
                    self.length = towards
                    continue
            marks = self.marks_within(Step(point, new, length))
            if marks is None:
                self._shorten(point)
                continue
            path.append(marks)
            searches = 0
            crawled = crawled + 1 if length < self.crawl_length else 0
            if len(path.points) >= self.max_points:
                path.end = path.end or "points"
            if crawled > self.max_crawled:
                path.end = path.end or self.why_crawling(point)
            if curve.cosine(point, new) > GROWTH_COSINE:
                self.length = min(GROWTH * length, curve.max_length)
        return path

    def _shorten(self, point: Point) -> None:
        """Halve the next step, or end the path."""
        self.length *= 0.5
        self.path.end = self.why_stuck(point, self.length)

    def marks_within(self, step: Step) -> list[Mark] | None:
        """Return the points of a step in order, the last one included; None if one cannot be located."""
        point, new, length = step
        marks = self._ends_within(step)
        if marks is None:
            return None
        last: Point | None = new
        if marks and self.jumps:
            last = self.curve.advance(point, (1.0 - 1e-6) * min(mark.length for mark in marks))
            if last is None:
                return None
        for test in self.turns:
            assert last is not None
            if point.tests[test] * last.tests[test] < 0.0:
                zero = self.curve.zero_of(point, length, test)
                if zero is None:
                    return None
                marks.append(Mark(*zero, *self.name_of(test, step, zero)))
        marks += self.marks_of_its_own(step)
        marks.sort(key=lambda mark: mark.length)
        places = [Mark(0.0, point, "", ""), *marks, Mark(length, new, "", "")]
        for before, after in pairwise(places):
            at_values = self._values_within(step, before, after)
            if at_values is None:
                return None
            marks += at_values
        for closing in self.closing(step):
            until = closing.length - SAME_PLACE * length
            marks = [*(mark for mark in marks if mark.kind or mark.length < until), closing]
        return sorted([*marks, places[-1]], key=lambda mark: mark.length)

    def _ends_within(self, step: Step) -> list[Mark] | None:
        """Return where in a step a test function ends the curve, if one does; None if that cannot be located."""
        point, new, length = step
        marks: list[Mark] = []
        for test in self.ends:
            if not point.tests[test] > 0.0 >= new.tests[test]:
                continue
            zero = self.curve.zero_of(point, length, test)
            if zero is None and not (marks and self.jumps):
                return None
            # Several that vanish at once are one end, named by the first.
            if zero is None or (marks and zero[0] > marks[0].length - SAME_PLACE * length):
                continue
            marks.append(Mark(*zero, *self.name_of(test, step, zero)))
        return marks if marks or self.is_inside(new) else None

    def _values_within(self, step: Step, before: Mark, after: Mark) -> list[Mark] | None:
        """Return the points between two of a step at which an unknown has a wanted value."""
        marks: list[Mark] = []
        for column, value, name, side in self.wanted:
            first, last = before.point.u.item(column) - value, after.point.u.item(column) - value
            if not (first * last < 0.0 or (first == 0.0 and side * last > 0.0)):
                continue
            # A step beyond a limit passes it once, whatever else lies in it.
            is_left = side * (step.new.u[column] - value) > 0.0
            ends = (0.0, step.length) if is_left else (before.length, after.length)
            zero = self.curve.value_of(step.point, ends, column, value)
            if zero is None:
                return None
            marks.append(Mark(*zero, name, name))
        return marks

    def closing(self, step: Step) -> list[Mark]:
        """Return the start of the curve as a point of a step in which the curve comes back to it."""
        curve, (point, _new, length) = self.curve, step
        change = (self.start.value - point.value) * curve.weights[-1]
        if not self.closes or abs(change) > 2.0 * length or len(self.path.points) <= 3:
            return []
        there = curve.shifted(self.start.u, point.u)
        at = curve.along_tangent(point, there)
        if not 0.0 < at <= length or curve.weighted(there - point.u) > 2.0 * length:
            return []
        reached = curve.advance(point, at)
        if reached is None or not curve.weighted(reached.u - there) < SAME_POINT:
            return []
        return [Mark(at, self.start._replace(u=there), "", "closed")]

    def _missed(self, new: Point) -> float | None:
        """Return where, from the last point, a test function changes sign that none of three points shows; or None."""
        before, point = self.path.points[-2:]
        back, ahead = self.path.lengths[-1], self.length
        for test in (*self.turns, *self.ends) if self.hinted is None else self.hinted:
            a, b, c = before.tests.item(test), point.tests.item(test), new.tests.item(test)
            if not (a * b > 0.0 and b * c > 0.0 and abs(b) < abs(a) and abs(b) <= abs(c)):
                continue
            slope_back, slope_ahead = (b - a) / back, (c - b) / ahead
            curvature = (slope_ahead - slope_back) / (0.5 * (back + ahead))
            slope = (slope_back * ahead + slope_ahead * back) / (back + ahead)
            if curvature != 0.0 and (b - 0.5 * slope**2 / curvature) * b > 0.5 * b * b:
                continue
            length = self._search(-back, ahead, test, math.copysign(1.0, b))
            if length is not None:
                return length
        return None

    def _search(self, low: float, high: float, test: int, sign: float) -> float | None:
        """Return a length at which a test function has the other sign, sought at its minimum by golden sections."""
        ratio = 0.5 * (math.sqrt(5.0) - 1.0)
        first, second = high - ratio * (high - low), low + ratio * (high - low)
        values: dict[float, float] = {}
        for _ in range(MAX_SEARCH):
            for length in (first, second):
                if length not in values:
                    trial = self.curve.advance(self.path.points[-1], length)
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
