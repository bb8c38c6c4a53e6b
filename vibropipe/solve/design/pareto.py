"""The Pareto front of two quantities: designs of which none can lower one without raising the other."""

from __future__ import annotations

import numpy as np

from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.refine import Search
from vibropipe.solve.design.search import Candidate, Samples, checked
from vibropipe.words.designs import DesignResult
from vibropipe.words.progress import WorkCount

# Designs along the front, and samples from which its ends are sought.
FRONT, ENDS = 16, 4


def front(
    problem: Problem, samples: Samples, candidates: list[Candidate], steps: WorkCount
) -> list[Candidate]:
    """Return the designs of the front in the order of the first objective.

    The first objective is made least under a limit of the second one (epsilon constraint), for limits between the
    ends of the front, from the best designs already known.
    """
    designs = [candidate for candidate in candidates if candidate.is_met]
    if not designs:
        return candidates
    missed = np.abs(problem.misses(samples.values)).sum(axis=1)
    feasible = Samples(*(part[missed == 0] for part in vars(samples).values()))
    designs += [_candidate(feasible, n) for n in range(len(feasible.share))]
    for which in (0, 1):
        for candidate in _best(problem, designs, which, ENDS):
            designs += _moved(problem, candidate, which, {})
            steps.add()
    low, high = _ends(problem, designs)
    for limit in np.linspace(high, low, FRONT):
        within = [each for each in designs if problem.costs(each.values)[1] <= limit + 1e-12]
        for candidate in _best(problem, within, 0, 2):
            designs += _moved(problem, candidate, 0, {1: float(limit)})
        steps.add()
    return thinned(problem, undominated(problem, designs))


def _candidate(samples: Samples, n: int) -> Candidate:
    share, values, state, law = (
        part[n] for part in (samples.share, samples.values, samples.state, samples.law)
    )
    return Candidate(share, values, state, law, DesignResult.MET)


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
    problem: Problem, candidate: Candidate, which: int, limits: dict[int, float]
) -> list[Candidate]:
    """Return the design of least cost along the law of another one, if the start leads to it."""
    search = Search(problem, candidate.share, candidate.state, candidate.law)
    if not search.last.valid:
        return []
    trial = search.improve(which, limits)
    design = checked(problem, search, search.meet() if problem.goals.bounds else trial)
    return [design] if design is not None and design.is_met else []


def _ends(problem: Problem, designs: list[Candidate]) -> tuple[float, float]:
    """Return the least second cost, and that of the design of the least first cost."""
    costs = np.array([problem.costs(each.values) for each in designs])
    return float(costs[:, 1].min()), float(costs[np.lexsort(costs.T[::-1])[0], 1])


def undominated(problem: Problem, designs: list[Candidate]) -> list[Candidate]:
    """Return the designs that no other one beats in both costs, in the order of the first."""
    costs = np.array([problem.costs(each.values) for each in designs])
    kept, least = [], np.inf
    for n in np.lexsort((costs[:, 1], costs[:, 0])):
        if costs[n, 1] < least:
            kept.append(designs[n])
            least = costs[n, 1]
    return kept


def thinned(problem: Problem, designs: list[Candidate]) -> list[Candidate]:
    """Return at most FRONT designs, evenly spread along the front, with both ends."""
    costs = np.array([problem.costs(each.values) for each in designs])
    spread = np.ptp(costs, axis=0)
    steps = np.abs(np.diff(costs / np.where(spread > 0, spread, 1.0), axis=0)).sum(axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, length[-1], FRONT)
    chosen = np.unique([int(np.abs(length - each).argmin()) for each in wanted])
    return [designs[n] for n in chosen]
