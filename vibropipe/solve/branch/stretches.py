"""All stretches of one law of motion along a parameter that a search of the range leads to, stable or not."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.march.piece_log import CAUSE, ENTER, HOME, IMPACT, REST_BEGINS
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.tree import Rules, follow_tree, seed_of_orbit
from vibropipe.orbits.law.law import Law
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.basins.attractors import reachable_velocity
from vibropipe.solve.boundary.closed_orbits import one_sided_orbit, symmetric_orbit
from vibropipe.solve.branch.problem import problem_of, rules_of, seed_of_steady_state
from vibropipe.solve.rows.steady import steady_state
from vibropipe.solve.sweep.sweep import sweep
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr

# Values of the parameter at which orbits are sought, and velocities that they are sought from.
VALUES, STARTS = 64, 17
# Orbits of more periods or impacts than these multiples of the law's, and so many impacts more, are not followed on.
MOST, FURTHER = 2, 2
# Trees of branches that are followed.
MAX_TREES = 64
# Relative difference of impact velocities of one orbit, and of the ends of stretches, that are the same.
SAME = 1e-6
# Difference of the sums of unit vectors at the phases of impacts of one orbit.
SAME_PHASES = 1e-4
# Bifurcations at which branches that may have the law begin.
SWITCHED = ("flip", "pitchfork", "grazing")


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


class Stretches(NamedTuple):
    """What was found: the problem, the stretches of the law as branches, and how many trees are left."""

    problem: Problem
    branches: list[Branch]
    n_left: int


def law_stretches(
    exciter: Exciter,
    along: str,
    within: tuple[float, float],
    law: tuple[int, int, int],
    at: Iterable[float],
    max_step: float,
) -> Stretches:
    """Return the stretches of a law.

    Orbits are sought at VALUES values of the parameter: what settles from STARTS velocities, and closed forms. Each
    that no branch has passed is followed through the range, and so is what begins at its bifurcations.

    Parameters
    ----------
    exciter : Exciter
    along : str
        The parameter.
    within : (float, float)
        Its range.
    law : (int, int, int)
        Period multiple, and impacts on each support.
    at : iterable of float
        Values at which points are wanted.
    max_step : float
        As for `branch`.
    """
    low, high = within
    middle = replaced(exciter, along, 0.5 * (low + high))
    problem, signs = problem_of(middle, along, (low, high), [*at], max_step)
    values = low + (np.arange(VALUES) + 0.5) * ((high - low) / VALUES)
    problem = problem._replace(at=tuple(sorted({*problem.at, *values.tolist()})))
    found: list[Branch] = []
    rules = near_rules(rules_of(problem.effects), law, found)
    trees = left = 0
    for own, orbit, seed_of in candidates(exciter, along, values, law):
        if is_covered(found, own, orbit):
            continue
        if trees == MAX_TREES:
            left += 1
            continue
        here = problem.values.copy()
        here[problem.along] = own
        seed = seed_of(problem._replace(values=here), signs)
        if seed is None:
            continue
        tree = follow_tree(problem, seed, SWITCHED, rules)
        trees, left = trees + 1, left + tree.n_left
        found += [with_curves(branch) for branch in tree.branches]
    kept: list[Branch] = []
    parts = [part for branch in found for part in parts_of(branch, law)]
    for part in sorted(parts, key=lambda each: -np.ptp(values_of(each))):
        if not any(is_same(part, other) for other in kept):
            kept.append(with_ends(part, found))
    kept.sort(key=lambda each: min(values_of(each)))
    return Stretches(problem, kept, left)


def replaced(exciter: Exciter, along: str, value: float) -> Exciter:
    """Return an exciter at another value of a parameter."""
    return replace(exciter, **{**exciter.numbers()._asdict(), along: value})


def near_rules(rules: Rules, law: tuple[int, int, int], found: Iterable[Branch]) -> Rules:
    """Return rules that follow no orbit of far more periods or impacts than a law has, and none found again."""

    def is_near(seed: Seed) -> bool:
        if any(begins_or_ends(branch, seed) for branch in found):
            return False
        if seed.curve is None:
            return True
        m, first, second = counts_of(seed.curve.sequence)
        most = MOST * (law[1] + law[2]) + FURTHER
        return m <= MOST * law[0] and first + second <= most

    return rules._replace(
        seeds_at=lambda branch, event: [s for s in rules.seeds_at(branch, event) if is_near(s)],
        siblings_at=lambda branch, event: (
            s for s in rules.siblings_at(branch, event) if is_near(s)
        ),
    )


def begins_or_ends(branch: Branch, seed: Seed) -> bool:
    """Return whether a branch begins or ends where a seed of its law begins."""
    reach = SAME * (branch.problem.high - branch.problem.low)
    values = values_of(branch)
    if not any(abs(values[end] - seed.value) <= reach for end in (0, -1)):
        return False
    if branch.curve is None or seed.curve is None or seed.point is None:
        return branch.curve is seed.curve
    point = seed.point._replace(curve=seed.curve)
    ends = (branch.points[end] for end in (0, -1))
    return any(
        end.curve.sequence.key == seed.curve.sequence.key
        and abs(end.value - seed.value) <= reach
        and phases_agree(end, point)
        for end in ends
    )


def candidates(
    exciter: Exciter, along: str, values: np.ndarray, law: tuple[int, int, int]
) -> Iterator[tuple[float, Struck, Any]]:
    """Yield a value, the orbit found there, and what returns the start of its branch; those of the law first."""
    yield from closed_candidates(exciter, along, values, law)
    ends = [replaced(exciter, along, float(value)) for value in values[[0, -1]]]
    reach = max(reachable_velocity(each) for each in ends)
    over = {along: values, "v0": np.linspace(-reach, reach, STARTS)}
    with warnings.catch_warnings():
        # Rows without an orbit begin no branch.
        warnings.simplefilter("ignore", UnsolvedWarning)
        rows = sweep(ends[0], over, outputs=("impacts",)).stack(row=(along, "v0"))
    listed = []
    for n in np.flatnonzero(rows.period_multiple.values > 0):
        row = rows.isel(row=n)
        first, second = (int(count) for count in np.nan_to_num(row.impacts_per_orbit.values))
        speeds = np.nan_to_num(row.impact_velocity_max.values)
        orbit = Struck(
            int(row.period_multiple), first, second, (float(speeds[0]), float(speeds[1]))
        )
        if orbit.m <= MOST * law[0] and first + second <= MOST * (law[1] + law[2]) + FURTHER:
            listed.append((float(row[along]), orbit, row))
    for own, orbit, row in sorted(listed, key=lambda each: each[1].law != law):
        yield (
            own,
            orbit,
            lambda problem, signs, own=own, row=row: seed_of_row(
                replaced(exciter, along, own), problem, signs, row
            ),
        )


def seed_of_row(
    exciter: Exciter, problem: Problem, signs: tuple[float, ...], row: xr.Dataset
) -> Seed | None:
    """Return the start of the branch through the orbit of a row of a sweep."""
    start = steady_state(exciter, v0=float(row.v0), harmonics=1)
    if int(start.period_multiple) != int(row.period_multiple):
        return None
    return seed_of_steady_state(exciter, problem, signs, start)


def closed_candidates(
    exciter: Exciter, along: str, values: np.ndarray, law: tuple[int, int, int]
) -> Iterator[tuple[float, Struck, Any]]:
    """Yield, as `candidates`, the orbits of the law in closed form, if it has one: stable or not."""
    m, first, second = law
    if first + second == 1:
        support = 1 if first else 2

        def solve(at: Exciter) -> xr.Dataset:
            return one_sided_orbit(at, support, m)

    elif (first, second) == (1, 1) and m % 2:

        def solve(at: Exciter) -> xr.Dataset:
            return symmetric_orbit(at, m)

    else:
        return
    for own in values.tolist():
        try:
            orbits = solve(replaced(exciter, along, own))
        except ParameterError:
            return  # the exciter has no closed form
        for n in np.flatnonzero(orbits.admissible.values == 1):
            orbit = orbits.isel(solution=n)
            supports, velocities = orbit.impact_support.values, orbit.impact_velocity.values
            speeds = [float(np.abs(velocities[supports == s]).max(initial=0.0)) for s in (1, 2)]
            u = np.concatenate(
                [(orbit.impact_phase + orbit.impact_period).values, velocities, [own]]
            )
            yield (
                own,
                Struck(m, first, second, (speeds[0], speeds[1])),
                lambda problem, signs, u=u, supports=supports: seed_of_orbit(
                    problem, m, supports.astype(np.int8), u, signs
                ),
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


def with_curves(branch: Branch) -> Branch:
    """Return a branch whose points all know the curve that they lie on; of one law that of the branch."""
    points = [
        point if point.curve is not None else point._replace(curve=branch.curve)
        for point in branch.points
    ]
    return replace(branch, points=points)


def values_of(branch: Branch) -> list[float]:
    """Return the parameter at the points of a branch."""
    return branch.values or [point.value for point in branch.points]


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
    floor, shared = (
        floor_of(one),
        {p.value for p in one.points[1:-1]} & {p.value for p in two.points[1:-1]},
    )
    if shared:
        value = min(shared)
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
