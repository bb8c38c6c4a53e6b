"""All stretches of one law of motion along a parameter that a search of the range leads to, stable or not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.switching import SWITCHES
from vibropipe.orbits.branches.tree import follow_tree, seed_of_orbit
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import START_WORK
from vibropipe.physics.ties import Ties
from vibropipe.solve.basins.attractors import reachable_velocity
from vibropipe.solve.boundary.closed_orbits import one_sided_orbit, symmetric_orbit
from vibropipe.solve.branch.places import values_of
from vibropipe.solve.branch.problem import NO_TIES, problem_of, seed_of_steady_state
from vibropipe.solve.branch.same_orbits import (
    Struck,
    begins_or_ends,
    counts_of,
    is_covered,
    is_same,
    parts_of,
    with_ends,
)
from vibropipe.solve.rows.steady import steady_state
from vibropipe.solve.sweep.blocks import LIMITS, solve_shard
from vibropipe.solve.sweep.sweep import grid_of

if TYPE_CHECKING:
    import xarray as xr

# Values of the parameter at which orbits are sought, and velocities that they are sought from.
VALUES, STARTS = 64, 17
# Work of each, in steps: several times what motions take that settle.
WORK = LIMITS._replace(row_work=4 * START_WORK)
# Orbits of more periods or impacts than these multiples of the law's, and so many impacts more, are not followed on.
MOST, FURTHER = 2, 2
# Trees of branches that are followed.
MAX_TREES = 64


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
    ties: Ties = NO_TIES,
) -> Stretches:
    """Return the stretches of a law.

    Orbits are sought at VALUES values of the parameter: what settles from STARTS velocities, and closed forms. Each
    that no branch has passed is followed through the range, and so is what begins at its bifurcations.

    within : range of the parameter `along`
    law : period multiple, and impacts on each support
    at : values at which points are wanted
    max_step : as for `branch`
    ties : of the exciter, which does not state what is tied
    """
    low, high = within
    own = 0.5 * (low + high)
    middle = ties.applied(exciter, {along: own})
    problem, signs = problem_of(middle, along, (low, high), [*at], max_step, ties, own)
    values = low + (np.arange(VALUES) + 0.5) * ((high - low) / VALUES)
    problem = problem._replace(at=tuple(sorted({*problem.at, *values.tolist()})))
    found: list[Branch] = []
    is_near = near(law, found)
    trees = left = 0
    for own, orbit, seed_of in candidates(exciter, along, values, law, ties):
        if is_covered(found, own, orbit):
            continue
        if trees == MAX_TREES:
            left += 1
            continue
        seed = seed_of(problem._replace(values=problem.values_at(own)), signs)
        if seed is None:
            continue
        tree = follow_tree(problem, seed, SWITCHES, is_near)
        trees, left = trees + 1, left + tree.n_left
        found += tree.branches
    kept: list[Branch] = []
    parts = [part for branch in found for part in parts_of(branch, law)]
    for part in sorted(parts, key=lambda each: -np.ptp(values_of(each))):
        if not any(is_same(part, other) for other in kept):
            kept.append(with_ends(part, found))
    kept.sort(key=lambda each: min(values_of(each)))
    return Stretches(problem, kept, left)


def near(law: tuple[int, int, int], found: Iterable[Branch]) -> Callable[[Seed], bool]:
    """Return what says of a start whether its orbit has not far more periods or impacts than a law, and is new."""

    def is_near(seed: Seed) -> bool:
        if any(begins_or_ends(branch, seed) for branch in found):
            return False
        if seed.curve is None:
            return True
        m, first, second = counts_of(seed.curve.sequence)
        most = MOST * (law[1] + law[2]) + FURTHER
        return m <= MOST * law[0] and first + second <= most

    return is_near


def candidates(
    exciter: Exciter, along: str, values: np.ndarray, law: tuple[int, int, int], ties: Ties
) -> Iterator[tuple[float, Struck, Any]]:
    """Yield a value, the orbit found there, and what returns the start of its branch; those of the law first."""
    yield from closed_candidates(exciter, along, values, law, ties)
    ends = [ties.applied(exciter, {along: float(value)}) for value in values[[0, -1]]]
    reach = max(reachable_velocity(each) for each in ends)
    over = {along: values, "v0": np.linspace(-reach, reach, STARTS)}
    grid = grid_of(exciter, over, None, ties.texts)
    rows = solve_shard(grid, 0, grid.rows, outputs=("impacts",), limits=WORK)
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
                ties.applied(exciter, {along: own}), problem, signs, row
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
    exciter: Exciter, along: str, values: np.ndarray, law: tuple[int, int, int], ties: Ties
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
            orbits = solve(ties.applied(exciter, {along: own}))
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
