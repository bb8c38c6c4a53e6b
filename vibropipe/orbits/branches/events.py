"""Bifurcations, ends and wanted values of the parameter within one step of a branch, located to rounding."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from vibropipe.orbits.branches.curve import Curve, Point
from vibropipe.orbits.branches.steps import DOUBLING, FOLD, GAP, SPEED
from vibropipe.orbits.branches.symmetry import halves_agree

# Largest value of a test function where it is located: larger ones are jumps. Those of long orbits are so steep that
# they differ from zero where their argument is known to rounding.
MAX_TEST_LEFT = {FOLD: 1e-3, DOUBLING: 1e-3, SPEED: 1e-6, GAP: 1e-6}
# A bifurcation is steep where DOUBLING changes by more than `STEEP` within a length on both sides. With its slope k,
# doubled orbits bifurcate again at a distance of 1 / k. Their equations are those of the parent but for its square, so
# that rounding blurs orbits by 1e-16 k and tests by 1e-16 k^2: what begins there cannot be followed from k = 1e6 on
# (`HIDDEN_LENGTH`). From k = 1e8 on (`UNRESOLVED_LENGTH`) a branch ends, before the rounding of a length reaches the
# distance of a fold from its flip, again 1 / k.
HIDDEN_LENGTH, UNRESOLVED_LENGTH, STEEP = 1e-7, 1e-9, 0.2
# Distance of two orbits that are one, in weighted unknowns.
SAME_ORBIT = 1e-7


class Event(NamedTuple):
    """A bifurcation of a branch: its kind, why the branch ends there ("" if it goes on), and its point's number."""

    kind: str
    reason: str
    point: int


class Mark(NamedTuple):
    """A point within a step: its length from the start of the step, kind ("" for none) and reason to end there."""

    length: float
    point: Point
    kind: str
    reason: str


def length_of(mark: Mark) -> float:
    """Return the length of a mark from the start of its step, by which marks are ordered."""
    return mark.length


def is_no_motion(point: Point) -> bool:
    """Return whether a point is no motion: a flight beyond a support, or an impact away from it."""
    return not (point.tests[GAP] > 0.0 and point.tests[SPEED] > 0.0)


def marks_within(
    curve: Curve, point: Point, new: Point, length: float, start: Point | None
) -> list[Mark] | None:
    """Return the points of a step in order, the last one included; None if one cannot be located."""
    marks = _ends_within(curve, point, new, length)
    if marks is None:
        return None
    last = new
    if marks:
        # At a grazing impact the return map's derivative is infinite: its tests are compared just before.
        before_end = curve.advance(point, (1.0 - 1e-6) * min(map(length_of, marks)))
        if before_end is None:
            return None
        last = before_end
    for test in (FOLD, DOUBLING):
        if point.tests[test] * last.tests[test] < 0.0:
            zero = _locate_test(curve, point, length, test)
            if zero is None:
                return None
            marks.append(Mark(*zero, *_kind_of(curve, test, zero[1])))
            if is_steep(curve, point, zero[0], UNRESOLVED_LENGTH):
                marks[-1] = Mark(*zero, "end", "rounding")
    marks.sort(key=length_of)
    ends = [Mark(0.0, point, "", ""), *marks, Mark(length, new, "", "")]
    for before, after in pairwise(ends):
        at_values = _values_within(curve, point, before, after, start)
        if at_values is None:
            return None
        marks += at_values
    return sorted([*marks, ends[-1]], key=length_of)


def _locate_test(
    curve: Curve, point: Point, length: float, test: int
) -> tuple[float, Point] | None:
    """Return where in a step a test function is zero; None if it cannot be located."""
    zero = curve.locate(point, (0.0, length), lambda each: float(each.tests[test]))
    if zero is None or abs(zero[1].tests[test]) > MAX_TEST_LEFT[test]:
        unresolved = zero is not None and is_steep(curve, point, zero[0], UNRESOLVED_LENGTH)
        return zero if unresolved else None
    return zero


def is_steep(curve: Curve, point: Point, at: float, within: float) -> bool:
    """Return whether DOUBLING changes by more than `STEEP` within a length of a place of a step."""
    before, after = curve.advance(point, at - within), curve.advance(point, at + within)
    return (
        before is not None
        and after is not None
        and abs(after.tests[DOUBLING] - before.tests[DOUBLING]) > STEEP
    )


def _ends_within(curve: Curve, point: Point, new: Point, length: float) -> list[Mark] | None:
    """Return where in a step the orbit ceases to be a motion, if it does; None if that cannot be located."""
    marks: list[Mark] = []
    for test in (SPEED, GAP):
        if point.tests[test] * new.tests[test] < 0.0:
            zero = _locate_test(curve, point, length, test)
            # Where an impact loses its speed, the flight towards it turns at its end: one event.
            if zero is None or (marks and zero[0] > marks[0].length - 1e-6 * length):
                if marks:
                    continue
                return None
            marks.append(Mark(*zero, *_kind_of(curve, test, zero[1])))
    return None if is_no_motion(new) and not marks else marks


def _kind_of(curve: Curve, test: int, point: Point) -> tuple[str, str]:
    """Return the kind of an event and the reason to end the branch there, "" if it goes on."""
    if test == DOUBLING:
        return ("pitchfork" if curve.sequence.mirrored else "flip"), ""
    if test == FOLD:
        kind = halves_agree(curve.sequence, point.u, curve.weights)
        return (kind, "doubled") if kind else ("fold", "")
    return curve.end_of(test, point)


def _values_within(
    curve: Curve, point: Point, before: Mark, after: Mark, start: Point | None
) -> list[Mark] | None:
    """Return the points between two of a step at wanted values and limits of the parameter, and at the start."""
    problem, marks = curve.problem, list[Mark]()
    values = dict.fromkeys(problem.at, "") | {problem.low: "limit", problem.high: "limit"}
    if start is not None:
        values.setdefault(start.value, "start")
    for value, meaning in values.items():
        if not (before.point.value - value) * (after.point.value - value) < 0.0:
            continue
        zero = _point_at(curve, point, (before.length, after.length), value)
        if zero is None:
            return None
        length, settled = zero
        is_start = start is not None and value == start.value
        if start is not None and is_start and curve.distance(settled, start) < SAME_ORBIT:
            marks.append(Mark(length, settled, "", "closed"))
        elif meaning != "start":
            marks.append(Mark(length, settled, meaning, meaning))
    return marks


def _point_at(
    curve: Curve, point: Point, ends: tuple[float, float], value: float
) -> tuple[float, Point] | None:
    """Return where between two lengths of a step the parameter has a value, which the point has exactly."""
    zero = curve.locate(point, ends, lambda each: each.value - value)
    if zero is None:
        return None
    length, crossing = zero
    exact = crossing.u.copy()
    exact[-1] = value
    settled = curve.settle(exact)
    if settled is None:
        return None
    return length, settled.reversed() if curve.cosine(crossing, settled) < 0.0 else settled
