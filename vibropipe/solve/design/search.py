"""The search for designs: samples of low discrepancy, refined along their laws of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.design.goals import MET
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.refine import Search, Trial
from vibropipe.solve.rows.points import within_ranges
from vibropipe.words.designs import DesignResult
from vibropipe.words.progress import WorkCount

# Rounds of samples, as long as no design is met; samples refined in each; the least distance between them, and between
# designs, in shares of the ranges.
ROUNDS, REFINED = 3, 12
MIN_SAMPLE_DISTANCE, MIN_DESIGN_DISTANCE = 0.08, 0.02
# Standard deviations around a design within which it is to keep its law, if that can be had.
LAW_REACH = 3.0
# A design reached from the start has the quantities of the search within this share of their scales.
SAME = 1e-7
# Searches that end this near to each other, in shares of the ranges, have found one design.
COPY_DISTANCE = 1e-6
# A share this near to an end of a range lies on it.
AT_END = 1e-5


@dataclass(frozen=True, eq=False)
class Candidate:
    """A design: its point, quantities as `Problem.read` returns them, law of motion, and how it ended.

    `reach` is that of the problem with which it was sought.
    """

    share: np.ndarray
    values: np.ndarray
    state: np.ndarray
    law: np.ndarray
    result: DesignResult
    reach: float = 0.0

    @property
    def is_met(self) -> bool:
        """Whether all that is wanted holds."""
        return self.result == DesignResult.MET


class Samples(NamedTuple):
    """Stable motions among sampled points; `reliability` as of `Problem`, if it was asked for, else without end."""

    share: np.ndarray
    values: np.ndarray
    state: np.ndarray
    law: np.ndarray
    reliability: np.ndarray

    def chosen(self, rows: Sequence[int] | np.ndarray) -> Samples:
        """Return some of the samples."""
        return Samples(*(part[list(rows)] for part in self))

    def joined(self, other: Samples) -> Samples:
        """Return both sets, one after the other."""
        return Samples(*(np.concatenate(both) for both in zip(self, other, strict=True)))


def find_candidates(problem: Problem, n_samples: int, steps: WorkCount) -> list[Candidate]:
    """Return the designs found, not yet ranked.

    Raises ParameterError if no sample is a stable motion that has the quantities.
    """
    samples: Samples | None = None
    candidates: list[Candidate] = []
    for turn in range(ROUNDS):
        fresh = sample(problem, n_samples, turn)
        samples = fresh if samples is None else samples.joined(fresh)
        steps.add(REFINED)
        for begin in begins(problem, fresh):
            candidate = refined(problem, begin)
            candidates += [candidate] if candidate is not None else []
            steps.add()
        if any(candidate.is_met for candidate in candidates):
            break
    assert samples is not None
    if not len(samples.share):
        must = (
            "must have an exciter whose motion from the start is a stable orbit with "
            f"{', '.join(name.name for name in problem.names)}; none of {ROUNDS * n_samples} samples has"
        )
        raise ParameterError("vary", dict(problem.vary), must=must, got="")
    if not candidates:
        candidates = [unreached(problem, samples, index) for index in seeds(problem, samples, 1)]
    return candidates


def sample(problem: Problem, n: int, turn: int, among_parts: bool = False) -> Samples:
    """Return the stable motions at the n points of a turn of Sobol's sequence."""
    from scipy.stats import qmc

    k = len(problem.vary)
    sequence = qmc.Sobol(k, scramble=False)
    # The first point of the sequence is a corner.
    sequence.fast_forward(1 + turn * n)
    return solved(problem, sequence.random(n), among_parts)


def solved(problem: Problem, share: np.ndarray, among_parts: bool = False) -> Samples:
    """Return the stable motions that have all quantities at points (n, k) in shares of the ranges.

    With `among_parts` they have their reliability, if parts scatter.
    """
    among_parts &= bool(problem.scatter)
    share = share[within_ranges(problem.parameters(share))]
    points = problem.from_start(problem.parameters(share), sensitivity=among_parts)
    values = problem.read(points)
    valid = problem.is_valid(points, values)
    reliability = problem.reliability(points) if among_parts else np.full(len(share), np.inf)
    return Samples(
        share[valid], values[valid], points.states[valid], points.laws[valid], reliability[valid]
    )


def begins(problem: Problem, samples: Samples) -> list[Samples]:
    """Return the samples that are refined, one by one.

    If parts scatter, those that keep their law within LAW_REACH deviations come first.
    """
    found: list[Samples] = []
    if problem.scatter and not problem.goals.of_yield:
        aimed = replace(problem, reach=LAW_REACH)
        kept = aimed.keeps_law_around(problem.parameters(samples.share), samples.law)
        safe, samples = (samples.chosen(np.flatnonzero(each)) for each in (kept, ~kept))
        found = [safe.chosen([n]) for n in seeds(problem, safe, REFINED)]
    return found + [samples.chosen([n]) for n in seeds(problem, samples, REFINED - len(found))]


def seeds(problem: Problem, samples: Samples, most: int) -> list[int]:
    """Return the best samples, those of one law apart from each other; only such as have the wanted law, if any has."""
    if not len(samples.share):
        return []
    missed = np.linalg.norm(problem.residuals(samples.values), axis=1)
    of_law = [n for n in range(len(problem.goals.bounds)) if n not in problem.smooth]
    wrong = np.abs(problem.misses(samples.values)[:, of_law]).sum(axis=1)
    keys = [missed, wrong]
    if problem.goals.objectives:
        costs = problem.costs(samples.values)
        spread = np.ptp(costs, axis=0)
        keys[0] = missed + (costs / np.where(spread > 0, spread, 1.0)).sum(axis=1)
    order = np.lexsort(keys)
    if not wrong[order[0]] > 0:
        order = order[wrong[order] == 0]
    return distinct_points(
        samples.share[order], samples.law[order], MIN_SAMPLE_DISTANCE, most, order
    )


def without_copies(problem: Problem, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates without those that searches from several samples led to again, those that are met first.

    Of those beside each other the one of least cost is kept; without a quantity to be least, `distinct` has the choice.
    """
    values = np.array([candidate.values for candidate in candidates])
    has_cost = len(problem.goals.objectives) == 1
    costs = problem.costs(values)[:, 0] if has_cost else np.zeros(len(candidates))
    ranks = zip(candidates, costs.tolist(), strict=True)
    ordered = [each for each, _ in sorted(ranks, key=lambda rank: (not rank[0].is_met, rank[1]))]
    share, law = (np.array([getattr(each, name) for each in ordered]) for name in ("share", "law"))
    distance = MIN_DESIGN_DISTANCE if has_cost else COPY_DISTANCE
    kept = distinct_points(share, law, distance, len(ordered), range(len(ordered)))
    return [ordered[n] for n in kept]


def distinct_points(
    share: np.ndarray,
    law: np.ndarray,
    distance: float,
    most: int,
    numbers: Sequence[int] | np.ndarray,
) -> list[int]:
    """Return the numbers of points, in their order, without those near an earlier one of the same law."""
    kept: list[int] = []
    for n in range(len(share)):
        if len(kept) == most:
            break
        near = (np.abs(share[kept] - share[n]).max(axis=1, initial=0.0) < distance) & (
            law[kept] == law[n]
        ).all(axis=1)
        if not near.any():
            kept.append(n)
    return [int(numbers[n]) for n in kept]


def refined(problem: Problem, sample: Samples) -> Candidate | None:
    """Return the design that one sample leads to; None if the motion from the start is another one.

    If parts scatter, it is sought among those that keep their law within LAW_REACH deviations, and among all where that
    leads to none.
    """
    if problem.scatter and not problem.reach and not problem.goals.of_yield:
        safe = refined(replace(problem, reach=LAW_REACH), sample)
        if safe is not None and safe.is_met:
            return safe
    search = Search(problem, sample.share[0], sample.state[0], sample.law[0])
    if not search.last.valid:
        return None
    trial = search.meet()
    if len(problem.goals.objectives) == 1 and problem.is_met(trial.values):
        search.improve()
        path = search.path
        best = checked(problem, search, search.meet())
        return best if best is not None and best.is_met else last_reached(problem, search, path)
    return checked(problem, search, trial)


def last_reached(problem: Problem, search: Search, path: Sequence[Trial]) -> Candidate | None:
    """Return the last of some trials that is met and that the motion from the start settles on; None without.

    Next to the end of a law, where a quantity may be least, the start may lead to another motion.
    """
    for trial in reversed(path):
        if problem.is_met(trial.values):
            candidate = checked(problem, search, trial)
            if candidate is not None and candidate.is_met:
                return candidate
    return None


def checked(problem: Problem, search: Search, trial: Trial) -> Candidate | None:
    """Return a trial as a design if the motion from the start settles on it."""
    points = problem.from_start(problem.parameters(trial.share[None]))
    values = problem.read(points)
    if not problem.is_valid(points, values)[0] or (points.laws[0] != search.law).any():
        return None
    scales = np.maximum(np.abs(trial.values), problem.exciter.l)
    if (np.abs(problem.difference(values[0], trial.values)) > SAME * scales).any():
        return None
    result = result_of(problem, search, trial.share, values[0])
    share, state = trial.share, points.states[0]
    return Candidate(share, values[0], state, search.law, result, problem.reach)


def result_of(
    problem: Problem, search: Search, share: np.ndarray, values: np.ndarray
) -> DesignResult:
    """Return whether a design is met or, if not, what keeps it from being met."""
    if problem.is_met(values):
        return DesignResult.MET
    if (np.minimum(share, 1 - share) < AT_END).any():
        return DesignResult.AT_RANGE
    return DesignResult.LAW_CHANGES if search.refused else DesignResult.CONFLICTING


def unreached(problem: Problem, samples: Samples, index: int) -> Candidate:
    """Return a sample as the nearest miss, where no refined design is reached from the start."""
    values = samples.values[index]
    met = problem.is_met(values)
    result = DesignResult.MET if met else DesignResult.NOT_REACHED
    return Candidate(samples.share[index], values, samples.state[index], samples.law[index], result)


def distinct(
    problem: Problem, candidates: Sequence[Candidate], margins: Sequence[float]
) -> list[int]:
    """Return the numbers of distinct designs, the best first.

    Those that are met, by the objective if there is one, and by their margin; if none is met, those that miss least.
    """
    met = np.array([candidate.is_met for candidate in candidates])
    values = np.array([candidate.values for candidate in candidates])
    missed = np.linalg.norm(problem.residuals(values), axis=1)
    keys = [-np.array(margins)]
    if problem.goals.objectives:
        # Rounding must not decide the order of equal designs.
        costs = problem.costs(values)[:, 0]
        keys.append(np.round(costs / max(np.abs(costs).max(), 1e-300), 7))
    if not met.any() or problem.goals.curve is not None:
        keys.append(np.round(missed, 9))
    order = [int(n) for n in np.lexsort(keys) if met[n] or not met.any()]
    share = np.array([candidates[n].share for n in order])
    law = np.array([candidates[n].law for n in order])
    return distinct_points(share, law, MIN_DESIGN_DISTANCE, len(order), order)


def miss_text(problem: Problem, nearest: Candidate) -> str:
    """Return why no design is met, with the values of the nearest one."""
    missed = problem.misses(nearest.values)
    misses = [
        f"{bound.text} is missed with {nearest.values[problem.names.index(bound.quantity)]:.6g}, by "
        f"{abs(miss) * bound.scale(problem.exciter.l):.2g}"
        for bound, miss in zip(problem.goals.bounds, missed, strict=True)
        if abs(miss) > MET
    ]
    at = (problem.low + nearest.share * problem.width).tolist()
    place = ", ".join(f"{name} = {value:.6g}" for name, value in zip(problem.vary, at, strict=True))
    reason = DesignResult(nearest.result).reason
    return (
        f"No design that was found is met. The nearest has {place}: {'; '.join(misses)}; {reason}."
    )
