"""The tolerances that a design needs: how far its parameters may be off so that all that is wanted still holds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.scatter import ON_LIMIT, kept_goals
from vibropipe.solve.design.search import Candidate
from vibropipe.solve.design.tolerance import box
from vibropipe.solve.rows.points import clipped
from vibropipe.words.designs import ToleranceResult

# Largest tolerance, as a share of a parameter (of l, of a length near 0); a box that fails shrinks by a factor.
LARGEST, SHRINK, MAX_TRIES = 0.2, 0.8, 40
# A design is on a bound nearer to it than this share of the bound, however small its quantity's deviation is.
ON_BOUND = 1e-6


def needed_tolerances(
    problem: Problem, candidate: Candidate, deviations: Mapping[str, float]
) -> tuple[np.ndarray, ToleranceResult]:
    """Return how far each parameter (p,) may be off, up or down, all at once; NaN of absent effects, or of all.

    What the tightest goal leaves is shared by what each parameter contributes with its deviation, to first order. If
    that is less than they take together, small contributions are left as they are and the large ones cut. At all
    corners and at the ends of the axes of this box the motion from the start is then marched: where a goal is missed or
    the law changes, the box shrinks. A target may be off by what `allow` gives.

    Parameters
    ----------
    problem : Problem
    candidate : Candidate
        The design.
    deviations : mapping of str to float
        Standard deviations of the parameters, given or assumed.
    """
    nothing = np.full(len(Parameters._fields), np.nan)
    base = problem.parameters(candidate.share[None])[0]
    columns = [Parameters._fields.index(name) for name in deviations]
    sigma = np.array(list(deviations.values()))
    _, values, slopes = problem.linearised(base, candidate.state, columns)
    half = base[Parameters._fields.index("l")]
    widths = LARGEST * np.where(base[columns] != 0, np.abs(base[columns]), half)
    for bound in (problem.goals.bounds[n] for n in problem.smooth):
        room = problem.distance(bound, values)
        effects = np.abs(slopes[problem.names.index(bound.quantity)]) * sigma
        if room < 0:
            return nothing, ToleranceResult.NOT_MET
        least = max(
            ON_LIMIT * float(np.linalg.norm(effects)), ON_BOUND * bound.scale(problem.exciter.l)
        )
        if room < least:
            is_target = bound.is_target
            return nothing, ToleranceResult.GOAL_MISSED if is_target else ToleranceResult.ON_BOUND
        widths = np.minimum(widths, sigma * shared(effects, room))
    corners = box(len(columns), 1.0)
    for _ in range(MAX_TRIES):
        rows = np.tile(base, (len(corners) + 1, 1))
        rows[1:, columns] += corners * widths
        points = problem.from_start(clipped(rows))
        kept = kept_goals(problem, points, candidate.law)
        if not kept[:, 0].all():
            return nothing, ToleranceResult.NOT_MET
        if kept.all():
            tolerances = nothing.copy()
            tolerances[columns] = widths
            return tolerances, ToleranceResult.FOUND
        widths = widths * SHRINK
        if (widths < ON_LIMIT * sigma).all():
            break
    return nothing, ToleranceResult.GOAL_MISSED if kept[0].all() else ToleranceResult.LAW_CHANGES


def shared(effects: np.ndarray, room: float) -> np.ndarray:
    """Return the factors of deviations, above 1 or below, with which the sum of their effects fits a room.

    All grow alike where there is room. Where there is not, effects above a common level are cut to it, so that as few
    parameters as possible need more than their deviation.
    """
    total = float(effects.sum())
    if total == 0:
        return np.full(effects.shape, np.inf)
    if total <= room:
        return np.full(effects.shape, room / total)
    ordered = np.sort(effects)
    below = np.concatenate([[0.0], np.cumsum(ordered)])[:-1]
    # The level that fits if the n smallest effects are kept whole.
    levels = (room - below) / np.arange(len(ordered), 0, -1)
    level = levels[np.flatnonzero(levels <= ordered)[0]]
    with np.errstate(divide="ignore"):
        return np.minimum(1.0, level / effects)
