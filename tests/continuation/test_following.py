"""Curves that are followed: a circle, a fold, a pitchfork and a cusp, whose points and events are known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from vibropipe.continuation.curve import CROSSING, FOLD, OWN_TESTS, Curve, Point, Zero
from vibropipe.continuation.follower import MIN_LENGTH, Follower
from vibropipe.continuation.path import Event, Mark, Path, Step, Wanted, both_ways, joined

Filled = tuple[NDArray, NDArray]
ONES = np.ones(2)


def circle(u: NDArray) -> Filled:
    """x^2 + p^2 = 1."""
    x, p = u
    return np.array([x * x + p * p - 1.0]), np.array([[2.0 * x, 2.0 * p]])


def fold(u: NDArray) -> Filled:
    """p = x^2."""
    x, p = u
    return np.array([p - x * x]), np.array([[-2.0 * x, 1.0]])


def pitchfork(u: NDArray) -> Filled:
    """x = 0 or p = x^2."""
    x, p = u
    return np.array([x * (p - x * x)]), np.array([[p - 3.0 * x * x, x]])


def cusp(u: NDArray) -> Filled:
    """Folds of x^3 + a x + b = 0: a = -3 x^2, b = 2 x^3."""
    x, a, b = u
    equations = np.array([x**3 + a * x + b, 3.0 * x**2 + a])
    return equations, np.array([[3.0 * x**2 + a, x, 1.0], [6.0 * x, 1.0, 0.0]])


NAMES = {FOLD: "fold", CROSSING: "crossing", OWN_TESTS: "own"}


class Named(Follower):
    """Names zeros of tests."""

    def name_of(self, test: int, step: Step, zero: Zero) -> tuple[str, str]:
        name = NAMES[test]
        return name, name if test in self.ends else ""


def started(curve: Curve, u: Sequence[float], fixed: int = -1) -> Point:
    point = curve.settle(np.array(u), fixed)
    assert point is not None
    return point


def named(path: Path) -> list[tuple[str, NDArray]]:
    return [(event.kind, path.points[event.point].u) for event in path.events]


class Circle(Named):
    turns = (FOLD,)


def test_a_circle_closes_after_both_folds() -> None:
    curve = Curve(ONES, 0.1, circle)
    start = started(curve, (0.8, 0.6))
    assert start.u[1] == 0.6
    path = Circle(curve, start).follow()
    assert path.end == "closed"
    for point in path.points:
        assert np.hypot(*point.u) == pytest.approx(1.0, abs=1e-15)
        assert point.u @ point.tangent == pytest.approx(0.0, abs=1e-12)
        assert point.tests[FOLD] == point.tangent[1]
    assert (path.points[-1].u == start.u).all()
    angles = np.unwrap([math.atan2(point.u[1], point.u[0]) for point in path.points])
    assert angles[-1] - angles[0] == pytest.approx(2.0 * math.pi, abs=1e-12)
    assert np.abs(np.diff(angles)).max() < 0.15
    (top, first), (bottom, second) = named(path)
    assert (top, bottom) == ("fold", "fold")
    assert first == pytest.approx([0.0, 1.0], abs=1e-12)
    assert second == pytest.approx([0.0, -1.0], abs=1e-12)


def test_weights_measure_lengths() -> None:
    curve = Curve(np.array([1.0, 0.5]), 0.1, circle)
    start = started(curve, (1.0, 0.0))
    new = curve.advance(start, 0.1)
    assert new is not None
    assert new.u[1] == pytest.approx(math.copysign(0.2, start.tangent[1]), abs=1e-15)
    assert curve.along_tangent(start, new.u) == pytest.approx(0.1)
    assert curve.distance(start, new) == pytest.approx(0.1)


def test_values_are_points_to_the_last_bit() -> None:
    curve = Curve(ONES, 0.1, circle)
    follower = Circle(curve, started(curve, (0.8, 0.6)))
    follower.wanted = [Wanted(1, 0.25), Wanted(0, -0.3), Wanted(1, 0.6)]
    points = np.array([point.u for point in follower.follow().points])
    assert sorted(points[points[:, 1] == 0.25, 0]) == pytest.approx(
        [-math.sqrt(0.9375), math.sqrt(0.9375)], abs=1e-15
    )
    assert sorted(points[points[:, 0] == -0.3, 1]) == pytest.approx(
        [-math.sqrt(0.91), math.sqrt(0.91)], abs=1e-15
    )
    # The start has a wanted value, and is not found twice where the curve closes.
    assert points[points[:, 1] == 0.6, 0] == pytest.approx([0.8, -0.8, 0.8], abs=1e-15)


def test_unknowns_may_return_a_whole_number_later() -> None:
    """The angle of a circle, in turns."""

    def turning(u: NDArray) -> Filled:
        t, p = u
        angle = 2.0 * math.pi * t
        return np.array([math.cos(angle) - p]), np.array([[-2.0 * math.pi * math.sin(angle), -1.0]])

    curve = Curve(ONES, 0.05, turning)
    curve.periodic = (0,)
    start = started(curve, (0.1, math.cos(0.2 * math.pi)), 0)
    path = Circle(curve, start).follow()
    assert path.end == "closed"
    assert path.points[-1].u - start.u == pytest.approx(
        [round(path.points[-1].u[0] - 0.1), 0.0], abs=1e-15
    )
    assert abs(round(path.points[-1].u[0] - 0.1)) == 1
    assert curve.distance(path.points[-1], start) < 1e-15
    assert [kind for kind, _u in named(path)] == ["fold", "fold"]


def test_a_curve_ends_at_limits_beyond_its_fold() -> None:
    curve = Curve(ONES, 0.1, fold)
    start = started(curve, (0.5, 0.25))

    def follow(side: Point) -> Path:
        follower = Circle(curve, side)
        follower.wanted = [Wanted(1, 1.0, "limit", 1.0)]
        return follower.follow()

    paths = both_ways(follow, start)
    assert [path.end for path in paths] == ["limit", "limit"]
    assert paths[1].points[0] is start
    back, ahead = both_ways(follow, start, (-1.0,))
    assert (len(back.points), ahead.points[-1].value) == (1, 1.0)
    assert ahead.points[-1].u[0] == paths[0].points[-1].u[0]
    points, events = joined(*paths)
    x = np.array([point.u[0] for point in points])
    assert x[[0, -1]] == pytest.approx(sorted(x[[0, -1]], key=lambda v: v * (x[-1] - x[0])))
    assert sorted(x[[0, -1]]) == pytest.approx([-1.0, 1.0], abs=1e-15)
    assert points[0].value == points[-1].value == 1.0
    assert (np.diff(x) * (x[-1] - x[0]) > 0.0).all()
    assert [event.kind for event in events] == ["fold"]
    assert points[events[0].point].u == pytest.approx([0.0, 0.0], abs=1e-12)
    assert all(curve.cosine(*pair) > 0.0 for pair in pairwise(points))


def test_a_curve_that_begins_on_its_limit_does_not_leave() -> None:
    curve = Curve(ONES, 0.1, fold)
    start = started(curve, (1.0, 1.0))
    outwards = start if start.tangent[1] > 0.0 else start.reversed()
    for side, n_folds in ((outwards, 0), (outwards.reversed(), 1)):
        follower = Circle(curve, side)
        follower.wanted = [Wanted(1, 1.0, "limit", 1.0)]
        path = follower.follow()
        assert (path.end, len(path.events)) == ("limit", n_folds)
        assert max(point.value for point in path.points) == 1.0


class Trivial(Named):
    turns = (CROSSING,)


def test_a_pitchfork_is_where_curves_cross() -> None:
    curve = Curve(ONES, 0.1, pitchfork)
    start = started(curve, (0.0, -0.73))
    follower = Trivial(curve, start)
    follower.wanted = [Wanted(1, 1.0, "limit", 1.0)]
    path = follower.follow()
    assert path.end == "limit"
    assert [point.u[0] for point in path.points] == [0.0] * len(path.points)
    ((kind, u),) = named(path)
    assert (kind, u) == ("crossing", pytest.approx([0.0, 0.0], abs=1e-12))
    assert start.reversed().tests[CROSSING] == -start.tests[CROSSING]


def test_the_other_curve_of_a_pitchfork_turns_there() -> None:
    curve = Curve(ONES, 0.1, pitchfork)
    start = started(curve, (0.73, 0.5329))
    follower = Circle(curve, start.reversed())
    follower.wanted = [Wanted(1, 1.0, "limit", 1.0)]
    path = follower.follow()
    assert path.end == "limit"
    assert path.points[-1].u == pytest.approx([-1.0, 1.0], abs=1e-14)
    ((kind, u),) = named(path)
    assert (kind, u) == ("fold", pytest.approx([0.0, 0.0], abs=1e-6))
    assert abs(u[1]) < 1e-12


class Cusps(Named):
    def marks_of_its_own(self, step: Step) -> list[Mark]:
        zero = self.curve.cusp_of(*step)
        return [] if zero is None else [Mark(*zero, "cusp", "")]


def test_two_parameters_turn_back_at_a_cusp() -> None:
    curve = Curve(np.array([1.0, 0.5, 0.5]), 0.1, cusp)
    start = started(curve, (0.7, -3 * 0.49, 2 * 0.343), 0)
    follower = Cusps(curve, start if start.tangent[0] < 0.0 else start.reversed())
    follower.wanted = [Wanted(-2, -2.0, "box", -1.0), Wanted(-1, -0.5, "box", -1.0)]
    path = follower.follow()
    assert path.end == "box"
    assert path.points[-1].u[2] == -0.5
    assert path.points[-1].u[0] == pytest.approx(-(0.25 ** (1 / 3)), abs=1e-14)
    (first, u), (last, _end) = named(path)
    assert (first, last) == ("cusp", "box")
    assert u == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


class Ending(Named):
    ends = (OWN_TESTS,)


def test_a_test_that_must_be_positive_ends_the_curve() -> None:
    curve = Curve(ONES, 0.1, circle, lambda u, _derivative: [0.9 - u[1]])
    start = started(curve, (0.8, 0.6))
    path = Ending(curve, start if start.tangent[1] > 0.0 else start.reversed()).follow()
    assert path.end == "own"
    assert path.events == [Event("own", "own", len(path.points) - 1)]
    assert path.points[-1].u == pytest.approx([math.sqrt(0.19), 0.9], abs=1e-12)
    assert all(point.u[1] < 0.9 for point in path.points[:-1])


def test_zeros_that_no_point_shows_are_found() -> None:
    """A test that is negative for a hundredth of a step."""
    half = 5e-4
    curve = Curve(ONES, 0.1, circle, lambda u, _derivative: [(u[0] + 0.3) ** 2 - half**2])

    class Own(Named):
        turns = (OWN_TESTS,)

    path = Own(curve, started(curve, (0.8, 0.6))).follow()
    zeros = sorted(u[0] for _kind, u in named(path))
    wanted = [-0.3 - half, -0.3 - half, -0.3 + half, -0.3 + half]
    assert zeros == pytest.approx(wanted, abs=1e-12)
    assert path.end == "closed"


def test_a_curve_is_lost_where_its_equations_end() -> None:
    def ends(u: NDArray) -> Filled | None:
        return circle(u) if u[1] <= 0.9 else None

    curve = Curve(ONES, 0.1, ends)
    start = started(curve, (0.8, 0.6))
    path = Circle(curve, start if start.tangent[1] > 0.0 else start.reversed()).follow()
    assert path.end == "lost"
    assert 0.0 <= 0.9 - path.points[-1].value < 10.0 * MIN_LENGTH


def test_a_curve_that_crawls_or_has_too_many_points_is_left() -> None:
    curve = Curve(ONES, 1e-3, circle)
    follower = Circle(curve, started(curve, (0.8, 0.6)))
    follower.max_points = 7
    assert (follower.follow().end, len(follower.path.points)) == ("points", 7)
    follower = Circle(curve, started(curve, (0.8, 0.6)))
    follower.crawl_length, follower.max_crawled = 0.1, 5
    assert (follower.follow().end, len(follower.path.points)) == ("lost", 7)


def test_what_cannot_be_located_is_none() -> None:
    curve = Curve(ONES, 0.1, circle)
    start = started(curve, (0.8, 0.6))
    assert curve.locate(start, (0.0, 0.1), lambda point: 1.0 + point.value) is None
    assert curve.locate(start, (0.0, 2.0), lambda point: point.value) is None
    assert curve.advance(start, 2.0) is None
    assert curve.settle(np.array([0.3, 1.5])) is None
    zero = curve.locate(start, (-0.3, 0.3), lambda point: math.atan(1e6 * (point.value - 0.5)))
    assert zero is not None
    assert zero[1].value == pytest.approx(0.5, abs=1e-13)


def test_a_step_towards_a_hint_takes_back_a_point_without_events() -> None:
    curve = Curve(ONES, 0.1, circle)
    start = started(curve, (0.8, 0.6))
    path = Path([start])
    path.append([Mark(0.25, start, "", ""), Mark(0.5, start, "", "")])
    assert path.length_towards(0.1) == 0.1
    assert path.length_towards(-0.1) == pytest.approx(0.15)
    assert path.lengths == [0.0, 0.25]
    path.append([Mark(0.5, start, "fold", "")])
    assert path.length_towards(-0.1) is None
    assert path.lengths == [0.0, 0.25, 0.5]


def test_a_path_takes_no_marks_beyond_its_end() -> None:
    start = started(Curve(ONES, 0.1, circle), (0.8, 0.6))
    path = Path([start])
    path.append(
        [Mark(0.1, start, "fold", ""), Mark(0.1, start, "end", "rest"), Mark(0.2, start, "", "")]
    )
    assert path.events == [Event("fold", "", 1), Event("end", "rest", 1)]
    assert (path.end, len(path.points)) == ("rest", 2)
