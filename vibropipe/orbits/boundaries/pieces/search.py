"""Boundaries of orbits with soft supports or friction, from the bifurcations of their branches."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.orbits.boundaries.curve import NO_TOUCH, BoundaryCurve, Box, Touch
from vibropipe.orbits.boundaries.pieces.curve import TOUCHES_BELOW, PieceBoundary
from vibropipe.orbits.boundaries.pieces.flights import nearest_touch
from vibropipe.orbits.boundaries.pieces.law import Law, law_of
from vibropipe.orbits.boundaries.search import SWITCHED, Boundary, follow_both_ways
from vibropipe.orbits.boundaries.seeds import KINDS, begin_linear, settled
from vibropipe.orbits.boundaries.system import FLIPS, GRAZINGS, PITCHFORKS
from vibropipe.orbits.branches.curve import Problem, is_no_motion
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.tree import follow_tree
from vibropipe.orbits.law.curve import LawCurve, Scales
from vibropipe.orbits.law.following import LAWS, limit_of_laws, seeds_of_laws
from vibropipe.orbits.law.marching import Marcher, march_pieces
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.effects import Effects

# Least gap of a flight, as a share of the size of the orbit, next to which a grazing is sought.
NEAR_TOUCH = 1e-2
# Relative difference of the states of two orbits of the same parameters that are one.
SAME_STATE = 1e-6
# Steps ahead of the end of a boundary at which it is sought with other events, weighted; they exceed the length within
# which the end is located.
AHEAD = (1e-6, 1e-5, 1e-4, 1e-3)
# Boundaries after which no more are sought.
MAX_BOUNDARIES = 256
# Orbits with more contacts are left out: towards chatter, and in cascades of flips, there are any number of them.
MAX_CONTACTS = 24


class SettledPieces(NamedTuple):
    """An orbit that settled: its parameters, period multiple, (x, x') at the section, and scales of both."""

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
) -> tuple[list[Boundary], bool]:
    """Follow all boundaries that pass through bifurcations of the branches of some orbits.

    Arguments are those of `vibropipe.orbits.boundaries.search.find_boundaries`; marcher : marches the motions.
    Returns the boundaries, and whether all were followed: they are left at MAX_BOUNDARIES.
    """
    boundaries: list[Boundary] = []
    room = marcher.effects, marcher.room
    for branch in _branches(box, orbits, marcher):
        for event in branch.events:
            kind = "grazing" if event.kind == "change" else event.kind
            if kind not in of or kind not in KINDS:
                continue
            waiting = [*_begin(box, branch, event, KINDS[kind], *room)]
            while waiting:
                begun = waiting.pop()
                if is_no_motion(begun[1]) or _is_known(boundaries, *begun):
                    continue
                if len(boundaries) == MAX_BOUNDARIES:
                    return boundaries, False
                boundaries.append(follow_both_ways(*begun))
                waiting += _beyond(box, boundaries[-1], *room)
    return boundaries, True


def _branches(box: Box, orbits: Iterable[SettledPieces], marcher: Marcher) -> Iterator[Branch]:
    """Yield the branches of orbits along both parameters, none twice."""
    passed: dict[tuple[int, float], list[tuple[float, int, np.ndarray]]] = {}
    ordered = list(orbits)
    for index in (0, 1):
        along = int(box.along[index])
        for orbit in ordered:
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
            problem = Problem(
                orbit.values, along, box.low[index], box.high[index], at, box.symmetric,
                box.max_length,
            )  # fmt: skip
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
            for branch in _with_children(problem, seed):
                orbits_there += _passed(branch, set(at))
                yield branch


def _with_children(problem: Problem, seed: Seed) -> Iterator[Branch]:
    """Yield the branch of a seed, and those that begin at its bifurcations."""
    (parent,) = follow_tree(problem, seed, (), LAWS).branches
    yield parent
    for event in parent.events:
        if event.kind in SWITCHED and not limit_of_laws(parent, event):
            for child in seeds_of_laws(parent, event):
                yield from follow_tree(problem, child, (), LAWS).branches


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
    scales = np.array([orbit.size, orbit.speed])
    return any(
        value == there
        and orbit.m == m
        and float(np.abs((state - orbit.state) / scales).max()) < SAME_STATE
        for there, m, state in orbits
    )


def _begin(
    box: Box,
    branch: Branch,
    event: Event,
    kind: int,
    effects: Effects,
    march_room: tuple[Any, ...],
) -> Iterator[tuple[Any, Point]]:
    """Yield the boundary through a bifurcation of a branch, if there is one, and its point there."""
    points = branch.points[event.point : event.point + (2 if event.kind == "change" else 1)]
    for point in points:
        values = branch.problem.values.copy()
        values[branch.problem.along] = point.value
        curve = point.curve
        m = curve.sequence.m
        if event.reason == "doubled" and kind == FLIPS:
            m //= 2
        slow = TOUCHES_BELOW * curve.speed if kind == GRAZINGS else 0.0
        ends = values[box.along]
        p = row_parameters(values.reshape(1, -1), 0)
        x, v = curve.state_at(point).tolist()
        if not march_pieces(effects, p, 0.0, x, v, 2.0 * m, march_room):
            continue
        law = law_of(march_room[0].pieces, m, box.symmetric, slow, p.friction > 0.0)
        if law is None:
            if kind == GRAZINGS and p.friction == 0.0:
                begun = begin_linear(box, ends, values)
                if begun is not None:
                    yield begun
                    return
            continue
        of_half = kind == PITCHFORKS
        if law.n_contacts > MAX_CONTACTS or (kind != GRAZINGS and of_half != bool(law.mirrored)):
            continue
        begun = begin_at(box, kind, law, ends, (curve.size, curve.speed), effects, march_room)
        if begun is not None:
            yield begun
            return


def _beyond(
    box: Box, boundary: Boundary, effects: Effects, march_room: tuple[Any, ...]
) -> Iterator[tuple[Any, Point]]:
    """Yield the boundaries that go on, by other events, where one ends, and their points there."""
    curve = boundary.curve
    if not isinstance(curve, PieceBoundary):
        return
    for meeting in boundary.meetings:
        if not meeting.reason or meeting.kind in ("box", "closed", "points", "rest"):
            continue
        point = boundary.points[meeting.point]
        way = 1.0 if meeting.point > 0 else -1.0
        for length in AHEAD:
            ahead = point.u + way * length * point.tangent
            # The orbit of the end is, next to it, close to that of other events.
            if not curve.replayed(point):
                break
            turns, x, v = curve.state_inside(point.u)
            p = curve.parameters(ahead)
            if not march_pieces(effects, p, turns, x, v, 2.0 * curve.law.m, march_room):
                continue
            slow = TOUCHES_BELOW * curve.speed if curve.kind == GRAZINGS else 0.0
            law = law_of(march_room[0].pieces, curve.law.m, box.symmetric, slow, p.friction > 0.0)
            if law is None or law.mirrored != curve.law.mirrored or law.n_contacts > MAX_CONTACTS:
                continue
            scales = (curve.size, curve.speed)
            begun = begin_at(box, curve.kind, law, ahead[-2:], scales, effects, march_room)
            if begun is not None and not is_no_motion(begun[1]):
                yield begun
                break


def begin_at(
    box: Box,
    kind: int,
    law: Law,
    ends: np.ndarray,
    scales: tuple[float, float],
    effects: Effects,
    march_room: tuple[Any, ...],
) -> tuple[BoundaryCurve, Point] | None:
    """Return the boundary of a law near both parameters `ends`, and its point there; None if there is none."""
    touch, timed = NO_TOUCH, []
    room = effects, march_room
    if kind == GRAZINGS:
        flown = PieceBoundary(box, FLIPS, law, NO_TOUCH, *scales, *room)
        flown.sought.guess[:] = law.spans
        u = np.array([law.at, law.start, *ends])
        nearest = np.empty(4)
        if not flown.flies(u):
            return None
        nearest_touch(effects, flown.parameters(u), flown.sought.pieces, nearest)
        if not abs(nearest[0]) < NEAR_TOUCH * scales[0]:
            return None
        touch, timed = Touch(int(nearest[1]), int(nearest[2])), [nearest[3]]
    curve = PieceBoundary(box, kind, law, touch, *scales, *room)
    return settled(curve, np.array([law.at, law.start, *timed, *ends]))


def _is_known(boundaries: Iterable[Boundary], curve: Any, point: Point) -> bool:
    """Return whether a point lies on a boundary that is known."""
    for each in boundaries:
        if type(each.curve) is not type(curve) or each.curve.kind != curve.kind:
            continue
        if not isinstance(curve, PieceBoundary):
            if each.curve.touch.side == curve.touch.side and each.curve.passes(
                each.points, point.u
            ):
                return True
        elif (
            isinstance(each.curve, PieceBoundary)
            and each.curve.law.m == curve.law.m
            and sorted(each.curve.contacts()) == sorted(curve.contacts())
            and each.curve.passes(each.points, point)
        ):
            return True
    return False
