"""Boundaries of orbits with soft supports, friction or a housing, from the bifurcations of their branches."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.orbits.boundaries.curve import GRAZINGS, KINDS, Box
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.level_curve import Level, LevelCurve, level_curves
from vibropipe.orbits.boundaries.search import (
    Boundary,
    follow_both_ways,
    is_known,
    new_levels,
)
from vibropipe.orbits.boundaries.seeds import MAX_CONTACTS, begin, begin_at, settled
from vibropipe.orbits.boundaries.touches import touching
from vibropipe.orbits.branches.curve import is_no_motion
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.tree import with_children
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.row import row_parameters

# Speed, as a share of the scale, below which a march only touches a support at a grazing.
TOUCHES_BELOW = 1e-3
# Relative difference of the states of two orbits of the same parameters that are one.
SAME_STATE = 1e-6
# Steps ahead of the end of a boundary at which it is sought with other events, weighted; they exceed the length within
# which the end is located.
AHEAD = (1e-6, 1e-5, 1e-4, 1e-3)
# Boundaries after which no more are sought.
MAX_BOUNDARIES = 64


class SettledPieces(NamedTuple):
    """An orbit that settled: its parameters, period multiple, state at the section, and scales of that.

    state : (2,) or, with a housing, (3,) float
        As `march_pieces`.
    """

    values: np.ndarray
    m: int
    state: np.ndarray
    size: float
    speed: float


def find_boundaries_of_pieces(
    box: Box,
    orbits: Iterable[SettledPieces],
    of: Collection[str],
    marcher: Marcher,
    levels: Sequence[Level] = (),
) -> tuple[list[Boundary], bool]:
    """Follow all boundaries that pass through the branches of some orbits.

    Arguments are those of `vibropipe.orbits.boundaries.search.find_boundaries`; marcher : marches the motions.
    Returns the boundaries, and whether all were followed: they are left at MAX_BOUNDARIES.
    """
    boundaries: list[Boundary] = []
    for branch in _branches(box, orbits, marcher):
        for seed in _seeds(box, branch, of, levels, marcher):
            waiting = [seed]
            while waiting:
                begun = waiting.pop()
                if marcher.is_spent:
                    return boundaries, False
                is_short = sum(begun[0].contacts()) <= MAX_CONTACTS
                if not is_short or is_no_motion(begun[1]) or is_known(boundaries, *begun):
                    continue
                if len(boundaries) == MAX_BOUNDARIES:
                    return boundaries, False
                found = follow_both_ways(*begun)
                if isinstance(found.curve, LevelCurve) and not new_levels(found, boundaries):
                    continue
                boundaries.append(found)
                waiting += _beyond(box, boundaries[-1], marcher)
    return boundaries, True


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


def _branches(box: Box, orbits: Iterable[SettledPieces], marcher: Marcher) -> Iterator[Branch]:
    """Yield the branches of orbits along both parameters, none twice."""
    passed: dict[tuple[int, float], list[tuple[float, int, np.ndarray]]] = {}
    ordered = list(orbits)
    for index in (0, 1):
        along = int(box.along[index])
        for orbit in ordered:
            if marcher.is_spent:
                return
            value, held = float(orbit.values[along]), float(orbit.values[box.along[1 - index]])
            orbits_there = passed.setdefault((index, held), [])
            state = orbit.state
            if _contains(orbits_there, value, orbit):
                continue
            at = tuple(
                sorted(
                    {
                        float(o.values[along])
                        for o in ordered
                        if o.values[box.along[1 - index]] == held
                    }
                )
            )
            problem = box.problem(orbit.values, index, at)
            orbits_there.append((value, orbit.m, state))
            p = row_parameters(orbit.values.reshape(1, -1), 0)
            read = marcher.law_of(p, state, orbit.m, box.symmetric)
            if read is None:
                continue
            curve = LawCurve(problem, read.law, Scales(orbit.size, orbit.speed), marcher)
            point = curve.settle(np.concatenate([read.u.T.ravel(), [value]]))
            if point is None:
                continue
            seed = Seed(curve, point, value, (1.0, -1.0))
            for branch in with_children(problem, seed):
                orbits_there += _passed(branch, set(at))
                yield branch
                if marcher.is_spent:
                    return


def _passed(branch: Branch, at: set[float]) -> list[tuple[float, int, np.ndarray]]:
    """Return value, period multiple and state at the section of a branch at some values."""
    return [
        (each.value, each.curve.sequence.m, each.curve.state_at(each, visit))
        for each in branch.points
        if each.value in at
        for visit in range(each.curve.sequence.m)
    ]


def _contains(
    orbits: Iterable[tuple[float, int, np.ndarray]], value: float, orbit: SettledPieces
) -> bool:
    """Return whether an orbit is among some."""
    scales = np.array([orbit.size, orbit.speed, orbit.speed])[: orbit.state.size]
    return any(
        value == there
        and orbit.m == m
        and float(np.abs((state - orbit.state) / scales).max()) < SAME_STATE
        for there, m, state in orbits
    )


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
