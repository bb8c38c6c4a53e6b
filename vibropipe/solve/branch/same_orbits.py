"""Which orbits of branches are one, by their laws, impact velocities and phases, and the parts that have a law."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.march.piece_log import CAUSE, ENTER, HOME, IMPACT, REST_BEGINS
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.law.law import Law
from vibropipe.solve.branch.places import values_of

# Relative difference of impact velocities of one orbit, and of the ends of stretches, that are the same.
SAME = 1e-6
# Difference of the sums of unit vectors at the phases of impacts of one orbit.
SAME_PHASES = 1e-4


class Struck(NamedTuple):
    """What tells orbits at one parameter apart: law (m; first, second) and largest impact velocities."""

    m: int
    first: int
    second: int
    speeds: tuple[float, float]

    @property
    def law(self) -> tuple[int, int, int]:
        """The law of motion."""
        return self.m, self.first, self.second

    def is_near(self, other: Struck, floor: float) -> bool:
        """Return whether two orbits are one."""
        apart = np.abs(np.subtract(self.speeds, other.speeds))
        return self.law == other.law and bool((apart <= SAME * max(*self.speeds, floor)).all())


def begins_or_ends(branch: Branch, seed: Seed) -> bool:
    """Return whether a branch begins or ends where a seed of its law begins."""
    reach = SAME * (branch.problem.high - branch.problem.low)
    values = values_of(branch)
    if not any(abs(values[end] - seed.value) <= reach for end in (0, -1)):
        return False
    if branch.curve is None or seed.curve is None or seed.point is None:
        return branch.curve is seed.curve
    ends = (branch.points[end] for end in (0, -1))
    return any(
        end.curve.sequence.key == seed.curve.sequence.key
        and abs(end.value - seed.value) <= reach
        and phases_agree(end, seed.point)
        for end in ends
    )


def counts_of(law: Law) -> tuple[int, int, int]:
    """Return (m, first, second) of the events of an orbit; one that rests has the period multiple 0."""
    begins = np.isin(law.codes[:, CAUSE], (ENTER, IMPACT))
    first, second = (int((begins & (law.codes[:, HOME] == home)).sum()) for home in (1, 2))
    if law.mirrored:
        first = second = first + second
    rests = bool((law.codes[:, CAUSE] == REST_BEGINS).any())
    return 0 if rests else law.m, first, second


def struck_by(point: Point) -> Struck:
    """Return the law and the largest impact velocities of an orbit."""
    law, events = point.curve.sequence, point.curve.events_of(point.u)
    begins = np.isin(law.codes[:, CAUSE], (ENTER, IMPACT))
    speeds = [
        float(np.abs(events[begins & (law.codes[:, HOME] == home), 1]).max(initial=0.0))
        for home in (1, 2)
    ]
    if law.mirrored:
        speeds = [max(speeds)] * 2
    return Struck(*counts_of(law), (speeds[0], speeds[1]))


def floor_of(branch: Branch) -> float:
    """Return the velocity below which impacts of a branch are equally slow."""
    return 1e-3 * (branch.curve.speed if branch.curve is not None else 1.0)


def is_covered(branches: Iterable[Branch], value: float, orbit: Struck) -> bool:
    """Return whether a branch has passed an orbit at one of the values where all have points."""
    for branch in branches:
        if branch.curve is None:
            if orbit.law == (1, 0, 0) and min(branch.values) <= value <= max(branch.values):
                return True
            continue
        for point in branch.points:
            if point.value == value and struck_by(point).is_near(orbit, floor_of(branch)):
                return True
    return False


def parts_of(branch: Branch, law: tuple[int, int, int]) -> Iterator[Branch]:
    """Yield the parts of a branch whose orbits have a law."""
    if branch.curve is None:
        if law == (1, 0, 0):
            yield branch
        return
    laws = [struck_by(point).law == law for point in branch.points]
    begin = 0
    for is_wanted, run in groupby(laws):
        end = begin + len([*run])
        if is_wanted and end - begin > 1:
            events = [
                event._replace(point=event.point - begin)
                for event in branch.events
                if begin <= event.point < end
            ]
            points = branch.points[begin:end]
            yield replace(branch, curve=points[0].curve, points=points, events=events)
        begin = end


def with_ends(part: Branch, found: Iterable[Branch]) -> Branch:
    """Return a part with the bifurcations at its ends, which may be events of the branches that it begins from."""
    values, events = values_of(part), [*part.events]
    reach = SAME * (part.problem.high - part.problem.low)
    for point in {0, len(values) - 1} - {event.point for event in events}:
        there = (
            event
            for branch in found
            for event in branch.events
            if abs(values_of(branch)[event.point] - values[point]) <= reach
        )
        event = next(there, None)
        if event is not None:
            is_parent = event.kind in ("flip", "pitchfork")
            events.append(Event(event.kind, "doubled" if is_parent else event.reason, point))
    return replace(part, events=sorted(events, key=lambda event: event.point))


def is_same(one: Branch, two: Branch) -> bool:
    """Return whether two parts are of one stretch: they share an orbit where both have a point, or both ends."""
    if one.curve is None or two.curve is None:
        return one.curve is two.curve and set(one.values) & set(two.values) != set()
    shared = {p.value for p in one.points[1:-1]} & {p.value for p in two.points[1:-1]}
    if shared:
        value, floor = min(shared), floor_of(one)
        return any(
            struck_by(a).is_near(struck_by(b), floor) and phases_agree(a, b)
            for a in one.points
            for b in two.points
            if a.value == b.value == value
        )
    reach = SAME * (one.problem.high - one.problem.low)
    for ends in ((0, -1), (-1, 0)):
        pairs = [(one.points[a], two.points[b]) for a, b in zip((0, -1), ends, strict=True)]
        if all(abs(a.value - b.value) <= reach for a, b in pairs) and all(
            phases_agree(a, b) for a, b in pairs
        ):
            return True
    return False


def phases_agree(one: Point, two: Point) -> bool:
    """Return whether two orbits of a law strike at the same phases, and so are not mirror images."""
    means = []
    for point in (one, two):
        law, events = point.curve.sequence, point.curve.events_of(point.u)
        begins = np.isin(law.codes[:, CAUSE], (ENTER, IMPACT))
        turns, homes = np.exp(2j * np.pi * events[begins, 0]), law.codes[begins, HOME]
        if law.mirrored:
            later = turns * np.exp(2j * np.pi * law.span)
            turns, homes = np.append(turns, later), np.append(homes, 3 - homes)
        means.append([turns[homes == home].sum() for home in (1, 2)])
    return bool(np.abs(np.array(means[0]) - np.array(means[1])).max() < SAME_PHASES)
