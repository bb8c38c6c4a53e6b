"""The Pareto front of two quantities: designs of which none can lower one without raising the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.refine import Search
from vibropipe.solve.design.scatter import INSIDE, deviations, is_inside, moved_inside
from vibropipe.solve.design.search import Candidate, Samples, checked, sample, solved
from vibropipe.words.designs import DesignResult
from vibropipe.words.progress import WorkCount

# Designs along the front, and designs from which each of its ends is sought.
FRONT, ENDS = 16, 2
# Points of the grid that the front is sought on, ends of the ranges included, and of the sequence that follows it:
# where laws of motion are narrow, the front has corners between the points of the grid.
GRID, DENSE = 4096, 32768
# Reaches of the sweeps around the front, in shares of the ranges, and points around each of its designs; the last
# sweeps check the designs that were refined along their laws.
REACHES, CHECKS = tuple(0.1 * 0.6**n for n in range(12)), 3
AROUND = 64
# Costs within this share of their spread are the same.
EQUAL = 1e-6
# Steps of the search of a front beside those of the search for candidates.
STEPS = 2 * ENDS + FRONT + len(REACHES) + CHECKS


def front(
    problem: Problem, candidates: list[Candidate], steps: WorkCount
) -> tuple[list[Candidate], Samples | None]:
    """Return the designs of the front in the order of the first objective, and the grid that it was sought on.

    The front is sought by sweeps, over the ranges and then around its own points within less and less, since laws of
    motion divide the ranges: derivatives see one law only. From its points the first objective is then made least along
    each law under a limit of the second one (epsilon constraint). Sweeps around the result check it. No point of a
    sweep meets a target exactly: with targets there are limits alone, from the best designs already known, and no grid.
    If parts scatter, all these points keep as many of INSIDE deviations off the bounds as any has.
    """
    known = [candidate for candidate in candidates if candidate.is_met]
    if not known:
        return candidates, None
    if any(problem.goals.bounds[n].is_target for n in problem.smooth):
        known = _along_limits(problem, _with_ends(problem, known, 0.0, steps), steps)
        return thinned(problem, undominated(problem, known), FRONT), None
    swept = solved(problem, grid(problem), among_parts=True)
    over = swept.joined(sample(problem, DENSE, 0, among_parts=True))
    most = over.reliability[problem.is_met(over.values)].max(initial=0.0)
    inside = next((reach for reach in INSIDE if most >= reach), 0.0) if problem.scatter else 0.0
    if inside:
        moved = [moved_inside(problem, each, (inside,)) for each in known]
        known = [each for each in moved if is_inside(problem, each, inside)]
    known = _with_ends(problem, known + _kept(problem, over, inside), inside, steps)
    known = _by_sweeps(problem, known, inside, steps)
    return thinned(problem, undominated(problem, known), FRONT), swept


def _with_ends(
    problem: Problem, known: list[Candidate], inside: float, steps: WorkCount
) -> list[Candidate]:
    """Return designs with those of least first and of least second cost along the laws of the best ones."""
    for which in (0, 1):
        for candidate in _best(problem, known, which, ENDS):
            known = known + _moved(problem, candidate, which, {}, inside)
            steps.add()
    return known


def _by_sweeps(
    problem: Problem, known: list[Candidate], inside: float, steps: WorkCount
) -> list[Candidate]:
    """Return designs with the front that sweeps around them lead to, refined along its laws and swept again."""
    for reach in REACHES:
        known = _swept(problem, known, reach, inside)
        steps.add()
    for each in thinned(problem, known, FRONT):
        known += _moved(problem, each, 0, {1: float(problem.costs(each.values)[1])}, inside)
        steps.add()
    for reach in REACHES[-CHECKS:]:
        known = _swept(problem, known, reach, inside)
        steps.add()
    return known


def _along_limits(problem: Problem, known: list[Candidate], steps: WorkCount) -> list[Candidate]:
    """Return designs with those of least first cost under limits of the second one."""
    costs = problem.costs(np.array([each.values for each in known]))
    low, high = costs[:, 1].min(), costs[np.lexsort(costs.T[::-1])[0], 1]
    for limit in np.linspace(high, low, FRONT).tolist():
        within = [each for each in known if problem.costs(each.values)[1] <= limit + 1e-12]
        for candidate in _best(problem, within, 0, 2):
            known += _moved(problem, candidate, 0, {1: limit}, 0.0)
        steps.add()
    return known


def grid(problem: Problem) -> np.ndarray:
    """Return the points (n, k) of a grid over the ranges and their ends, in shares of the ranges."""
    k = len(problem.vary)
    along = np.linspace(0.0, 1.0, max(2, int(GRID ** (1 / k) + 1e-9)))
    return np.stack(np.meshgrid(*[along] * k, indexing="ij"), axis=-1).reshape(-1, k)


def _kept(problem: Problem, samples: Samples, inside: float) -> list[Candidate]:
    """Return the samples that no other one beats among those that keep to all bounds, with so many deviations left."""
    chosen = np.flatnonzero(problem.is_met(samples.values) & (samples.reliability >= inside))
    order = _front_of(problem.costs(samples.values[chosen]))
    share, values, state, law = samples.share, samples.values, samples.state, samples.law
    return [
        Candidate(share[n], values[n], state[n], law[n], DesignResult.MET) for n in chosen[order]
    ]


def _swept(
    problem: Problem, designs: list[Candidate], reach: float, inside: float
) -> list[Candidate]:
    """Return the front of designs and of points around them, within a reach in shares of the ranges."""
    from scipy.stats import qmc

    parents = thinned(problem, undominated(problem, designs), 2 * FRONT)
    k = len(problem.vary)
    # Points beyond the ranges are moved onto their ends, where a front often lies.
    moves = reach * (2 * qmc.Halton(k, scramble=False).random(AROUND + 1)[1:] - 1)
    share = np.clip(np.stack([each.share for each in parents])[:, None] + moves, 0.0, 1.0)
    fresh = _kept(problem, solved(problem, share.reshape(-1, k), among_parts=True), inside)
    return undominated(problem, designs + fresh)


def _best(problem: Problem, designs: list[Candidate], which: int, most: int) -> list[Candidate]:
    """Return the designs of least cost, apart from each other in law or parameters."""
    costs = np.array([problem.costs(each.values)[which] for each in designs])
    kept: list[Candidate] = []
    for n in np.argsort(costs, kind="stable"):
        near = [np.abs(designs[n].share - other.share).max() < 0.1 for other in kept]
        if not any(near):
            kept.append(designs[n])
        if len(kept) == most:
            break
    return kept


def _moved(
    problem: Problem, candidate: Candidate, which: int, limits: dict[int, float], inside: float
) -> list[Candidate]:
    """Return the design of least cost along the law of another one, if the start leads to it.

    It keeps so many standard deviations off its bounds.
    """
    aimed = problem
    if inside:
        aimed = replace(problem, margins=1.01 * inside * deviations(problem, candidate))
    search = Search(aimed, candidate.share, candidate.state, candidate.law)
    if not search.last.valid:
        return []
    trial = search.improve(which, limits)
    design = checked(problem, search, search.meet() if problem.goals.bounds else trial)
    if design is None or not design.is_met or (inside and not is_inside(problem, design, inside)):
        return []
    return [design]


def _front_of(costs: np.ndarray) -> list[int]:
    """Return the rows of costs (n, 2) that no other row beats in both, in the order of the first.

    Costs closer than EQUAL of their spread are the same: else a design is kept for a gain by rounding in one of them.
    """
    spread = np.ptp(costs, axis=0) if len(costs) else np.ones(2)
    first, second = np.round(costs / np.where(spread > 0, EQUAL * spread, 1.0)).T
    order = np.lexsort((second, first))
    least = np.minimum.accumulate(np.concatenate([[np.inf], second[order]]))[:-1]
    return [int(n) for n in order[second[order] < least]]


def undominated(problem: Problem, designs: list[Candidate]) -> list[Candidate]:
    """Return the designs that no other one beats in both costs, in the order of the first."""
    costs = problem.costs(np.array([each.values for each in designs]))
    return [designs[n] for n in _front_of(costs)]


def thinned(problem: Problem, designs: list[Candidate], most: int) -> list[Candidate]:
    """Return at most so many designs, evenly spread along the front, with both ends."""
    costs = problem.costs(np.array([each.values for each in designs]))
    spread = np.ptp(costs, axis=0)
    steps = np.abs(np.diff(costs / np.where(spread > 0, spread, 1.0), axis=0)).sum(axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, length[-1], most)
    chosen = np.unique([int(np.abs(length - each).argmin()) for each in wanted])
    return [designs[n] for n in chosen]
