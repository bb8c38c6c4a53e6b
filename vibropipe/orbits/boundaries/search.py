"""All boundaries in a box that are reached from orbits that settle on a grid of points."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event, both_ways, joined
from vibropipe.orbits.boundaries.curve import KINDS, BoundaryFollower, Box, followed
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.level_curve import Level, LevelCurve, LevelFollower, level_curves
from vibropipe.orbits.boundaries.seeds import begin
from vibropipe.orbits.branches.curve import is_no_motion
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.symmetry import whole_orbit
from vibropipe.orbits.branches.tree import seed_of_orbit, with_children
from vibropipe.orbits.law.marching import Marcher

# Difference of the sum of impact speeds, relative, at which two orbits of the same parameters are one.
SAME_SPEEDS = 1e-6


class Settled(NamedTuple):
    """An orbit that settled: its parameters (7,), period multiple, impact sequence, times and velocities (2n,)."""

    values: np.ndarray
    m: int
    supports: np.ndarray
    u: np.ndarray


class Boundary(NamedTuple):
    """A boundary: its points in order, and what it meets."""

    curve: Any
    points: list[Point]
    meetings: list[Event]


def find_boundaries(
    box: Box, orbits: Iterable[Settled], of: Collection[str], levels: Sequence[Level] = ()
) -> list[Boundary]:
    """Follow all boundaries that pass through the branches of some orbits.

    orbits : within the box
    of : kinds: fold, flip, pitchfork, grazing
    levels : of level curves

    Returns each once, and one of mirror images.
    """
    boundaries: list[Boundary] = []
    # An orbit of impacts alone has no rests.
    marcher = Marcher(box.effects._replace(rest=None))
    for branch in _branches(box, orbits):
        for event in branch.events:
            if event.kind not in of:
                continue
            begun = begin(box, branch, event, KINDS[event.kind], marcher)
            if begun is None or is_known(boundaries, *begun) or is_no_motion(begun[1]):
                continue
            boundaries.append(follow_both_ways(*begun))
        for curve, point in level_curves(box, branch, levels, marcher):
            if not is_known(boundaries, curve, point):
                boundaries += new_levels(follow_both_ways(curve, point), boundaries)
    return boundaries


def _branches(box: Box, orbits: Iterable[Settled]) -> Iterator[Branch]:
    """Yield the branches of orbits along both parameters, none twice."""
    grouped: dict[tuple[int, float], list[Settled]] = {}
    for orbit in orbits:
        for index in (0, 1):
            held = float(orbit.values[box.along[1 - index]])
            grouped.setdefault((index, held), []).append(orbit)
    for (index, _held), group in grouped.items():
        along = int(box.along[index])
        at = tuple(sorted({float(orbit.values[along]) for orbit in group}))
        passed: list[tuple[float, int, int, float]] = []
        for orbit in group:
            key = (float(orbit.values[along]), orbit.m, *_size(orbit.u))
            if _contains(passed, key):
                continue
            problem = box.problem(orbit.values, index, at)
            u = np.append(orbit.u, orbit.values[along])
            seed = seed_of_orbit(problem, orbit.m, orbit.supports, u, (1.0, -1.0))
            passed.append(key)
            if seed is None:
                continue
            for branch in with_children(problem, seed):
                passed += _passed(branch, set(at))
                yield branch


def _size(u: np.ndarray) -> tuple[int, float]:
    """Return the number of impacts of an orbit and the sum of their speeds, from (2n,) or (2n + 1,) unknowns."""
    n = len(u) // 2
    return n, float(np.abs(u[n : 2 * n]).sum())


def _passed(branch: Branch, at: set[float]) -> list[tuple[float, int, int, float]]:
    """Return value, period multiple, number of impacts and sum of speeds of a branch at some values."""
    if branch.curve is None:
        return [(value, 1, 0, 0.0) for value in branch.values if value in at]
    keys = []
    for point in branch.points:
        if point.value in at:
            sequence, u = whole_orbit(branch.curve.sequence, point.u)
            keys.append((point.value, sequence.m, *_size(u)))
    return keys


def _contains(
    keys: Iterable[tuple[float, int, int, float]], key: tuple[float, int, int, float]
) -> bool:
    """Return whether an orbit is among some."""
    return any(
        key[:3] == each[:3] and abs(key[3] - each[3]) <= SAME_SPEEDS * max(key[3], 1e-300)
        for each in keys
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


def new_levels(found: Boundary, others: Iterable[Boundary]) -> list[Boundary]:
    """Return a level curve if it is none of some others: where it began at an end of one, that was not seen."""
    is_again = found.curve.is_again(found.points[len(found.points) // 2], others)
    return [] if is_again else [found]


def follow_both_ways(curve: Any, point: Point) -> Boundary:
    """Follow a boundary from a point to both ends."""
    follower = LevelFollower if isinstance(curve, LevelCurve) else BoundaryFollower
    paths = both_ways(lambda start: followed(follower(curve, start)), point)
    return Boundary(curve, *joined(*paths))
