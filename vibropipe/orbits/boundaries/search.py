"""All boundaries in a box that are reached from orbits that settle on a grid of points."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event, both_ways, joined
from vibropipe.orbits.boundaries.curve import GRAZINGS, KINDS, BoundaryFollower, Box, followed
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.level_curve import Level, LevelCurve, LevelFollower, level_curves
from vibropipe.orbits.boundaries.seeds import MAX_CONTACTS, begin, begin_at, settled
from vibropipe.orbits.boundaries.touches import touching
from vibropipe.orbits.branches.curve import is_no_motion
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.linear import linear_state
from vibropipe.orbits.branches.tree import seed_of_orbit, with_children
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.row import row_parameters

# Speed, as a share of the scale, below which a march only touches a support at a grazing.
TOUCHES_BELOW = 1e-3
# Relative difference of the states of two orbits of the same parameters that are one.
SAME_STATE = 1e-6
# Steps ahead of the end of a boundary at which it is sought with other events, weighted; they exceed the length within
# which the end is located.
AHEAD = (1e-6, 1e-5, 1e-4, 1e-3)
# Boundaries after which no more are sought, but between rigid supports alone.
MAX_BOUNDARIES = 64
BOTH_WAYS = (1.0, -1.0)


class Settled(NamedTuple):
    """An orbit that settled: its parameters, period multiple, state at the section, and scales of that.

    state : (2,) or, with a housing, (3,) float
        As `march_pieces`.
    struck : of impacts with rigid supports alone these, (n,) int8, and times and velocities (2n,)
    """

    values: np.ndarray
    m: int
    state: np.ndarray
    size: float
    speed: float
    struck: tuple[np.ndarray, np.ndarray] | None = None


class Boundary(NamedTuple):
    """A boundary: its points in order, and what it meets."""

    curve: Any
    points: list[Point]
    meetings: list[Event]


def find_boundaries(
    box: Box,
    orbits: Iterable[Settled],
    of: Collection[str],
    marcher: Marcher,
    levels: Sequence[Level] = (),
) -> tuple[list[Boundary], bool]:
    """Follow all boundaries that pass through the branches of some orbits.

    orbits : within the box
    of : kinds: fold, flip, pitchfork, grazing
    marcher : marches the motions
    levels : of level curves

    Returns each once, and one of mirror images; and whether all were followed: they are left at MAX_BOUNDARIES.
    """
    boundaries: list[Boundary] = []
    for branch in _branches(box, orbits, marcher):
        for seed in _seeds(box, branch, of, levels, marcher):
            waiting = [seed]
            while waiting:
                begun = waiting.pop()
                if is_spent(marcher):
                    return boundaries, False
                is_short = sum(begun[0].contacts()) <= MAX_CONTACTS
                if not is_short or is_no_motion(begun[1]) or is_known(boundaries, *begun):
                    continue
                if box.effects.has_pieces and len(boundaries) == MAX_BOUNDARIES:
                    return boundaries, False
                found = follow_both_ways(*begun)
                # A level curve may have begun at an end of one, where that was not seen.
                middle, is_level = len(found.points) // 2, isinstance(found.curve, LevelCurve)
                if is_level and is_known(boundaries, found.curve, found.points[middle]):
                    continue
                boundaries.append(found)
                # At its end an orbit of impacts alone touches once more, which no other law continues.
                if box.effects.has_pieces:
                    waiting += _beyond(box, found, marcher)
    return boundaries, True


def is_spent(marcher: Marcher) -> bool:
    """Return whether all work is done; orbits of impacts alone are not marched."""
    return marcher.effects.has_pieces and marcher.is_spent


def _seeds(
    box: Box, branch: Branch, of: Collection[str], levels: Sequence[Level], marcher: Marcher
) -> Iterator[tuple[LawBoundary, Point]]:
    """Yield the boundaries through a branch, and their points there."""
    for event in branch.events:
        kind = "grazing" if event.kind == "change" else event.kind
        if kind in of and kind in KINDS:
            begun = begin(box, branch, event, KINDS[kind], marcher)
            if begun is not None:
                yield begun
    yield from level_curves(box, branch, levels, marcher)


def _branches(box: Box, orbits: Iterable[Settled], marcher: Marcher) -> Iterator[Branch]:
    """Yield the branches of orbits along both parameters, none twice."""
    passed: dict[tuple[int, float], list[tuple[float, int, np.ndarray]]] = {}
    ordered = list(orbits)
    for index in (0, 1):
        along, other = int(box.along[index]), int(box.along[1 - index])
        for orbit in ordered:
            if is_spent(marcher):
                return
            value, held = float(orbit.values[along]), float(orbit.values[other])
            orbits_there = passed.setdefault((index, held), [])
            if _contains(orbits_there, value, orbit):
                continue
            at = {float(each.values[along]) for each in ordered if each.values[other] == held}
            problem = box.problem(orbit.values, index, tuple(sorted(at)))
            orbits_there.append((value, orbit.m, orbit.state))
            seed = _seed_of(orbit, problem, marcher)
            for branch in () if seed is None else with_children(problem, seed):
                orbits_there += _passed(branch, at)
                yield branch
                if is_spent(marcher):
                    return


def _seed_of(orbit: Settled, problem: Problem, marcher: Marcher) -> Seed | None:
    """Return the start of the branch through an orbit."""
    value = float(orbit.values[problem.along])
    if orbit.struck is not None:
        supports, u = orbit.struck
        return seed_of_orbit(problem, orbit.m, supports, np.append(u, value), BOTH_WAYS)
    p = row_parameters(orbit.values.reshape(1, -1), 0)
    read = marcher.law_of(p, orbit.state, orbit.m, problem.symmetric)
    if read is None:
        return None
    curve = LawCurve(problem, read.law, Scales(orbit.size, orbit.speed), marcher)
    point = curve.settle(np.concatenate([read.u.T.ravel(), [value]]))
    return None if point is None else Seed(curve, point, value, BOTH_WAYS)


def _passed(branch: Branch, at: set[float]) -> Iterator[tuple[float, int, np.ndarray]]:
    """Yield value, period multiple and state at the section of a branch at some values, and of mirror images."""
    problem = branch.problem
    for value in at.intersection(branch.values):
        yield value, 1, np.array(linear_state(problem.parameters_at(value)))
    for point in branch.points:
        if point.value in at:
            m = point.curve.sequence.m
            for visit in range(m):
                yield point.value, m, point.curve.state_at(point, visit)
                if problem.symmetric:
                    yield point.value, m, -point.curve.state_at(point, visit + 0.5)


def _contains(
    orbits: Iterable[tuple[float, int, np.ndarray]], value: float, orbit: Settled
) -> bool:
    """Return whether an orbit is among some."""
    scales = np.array([orbit.size, orbit.speed, orbit.speed])[: orbit.state.size]
    return any(
        value == there
        and orbit.m == m
        and float(np.abs((state - orbit.state) / scales).max()) < SAME_STATE
        for there, m, state in orbits
    )


def is_known(boundaries: Iterable[Boundary], curve: LawBoundary, point: Point) -> bool:
    """Return whether a point lies on a boundary that is known, or its mirror image does."""
    if isinstance(curve, LevelCurve):
        return curve.is_again(point, boundaries)
    law = curve.sequence
    keys = {law.key, law._replace(codes=law.image(law.codes)).key}
    return any(
        each.curve.kind == curve.kind
        and each.curve.sequence.key in keys
        and each.curve.passes(each.points, point)
        for each in boundaries
    )


def follow_both_ways(curve: Any, point: Point) -> Boundary:
    """Follow a boundary from a point to both ends."""
    follower = LevelFollower if isinstance(curve, LevelCurve) else BoundaryFollower
    paths = both_ways(lambda start: followed(follower(curve, start)), point)
    return Boundary(curve, *joined(*paths))


def _beyond(box: Box, boundary: Boundary, marcher: Marcher) -> Iterator[tuple[LawBoundary, Point]]:
    """Yield the boundaries that go on, by other events, where one ends, and their points there."""
    curve = boundary.curve
    assert isinstance(curve, LawBoundary)
    for meeting in boundary.meetings:
        if not meeting.reason or meeting.kind in ("box", "closed", "points", "rest"):
            continue
        point = boundary.points[meeting.point]
        way = 1.0 if meeting.point > 0 else -1.0
        for length in AHEAD:
            ahead = point.u + way * length * point.tangent
            p, state = curve.parameters_of(ahead), curve.state_at(point._replace(u=ahead))
            slow = TOUCHES_BELOW * curve.speed if curve.kind == GRAZINGS else 0.0
            read = marcher.law_of(p, state, curve.sequence.m, box.symmetric, slow)
            if read is None or read.law.mirrored != curve.sequence.mirrored:
                continue
            touch, events = curve.touched, read.u.T.ravel()
            if isinstance(curve, LevelCurve):
                there = curve.with_sequence(read.law)
                begun = settled(there, np.concatenate([events, ahead[-2:]]))
            else:
                if curve.kind == GRAZINGS:
                    touch = touching(read.law, read.u, int(touch[1]), touch[2]).touch
                here = curve.scales, curve.marcher
                begun = begin_at(box, curve.kind, read.law, events, touch, ahead[-2:], *here)
            if begun is not None and not is_no_motion(begun[1]):
                yield begun
                break
