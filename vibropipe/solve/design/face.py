"""The function `design`: parameters that give a wanted law of motion."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import all_effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.solve import tolerance as spread
from vibropipe.solve.checks import check_soft, check_whole
from vibropipe.solve.design.goals import CURVE, Goals, check_allow, check_supports, goals_of
from vibropipe.solve.design.margin import law_margin
from vibropipe.solve.design.needed import needed_tolerances
from vibropipe.solve.design.pareto import STEPS, front
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.search import (
    REFINED,
    ROUNDS,
    Candidate,
    distinct,
    find_candidates,
)
from vibropipe.solve.named import harmonics_of
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.points import Points, clipped, points_dataset, solve_points
from vibropipe.solve.row_results import columns_of
from vibropipe.words.designs import DESIGN_SAMPLES, DesignResult
from vibropipe.words.designs import DESIGNS as DESIGNS_LIMITS
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.progress import Progress, WorkCount
from vibropipe.words.status import UnsolvedWarning
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr

SAMPLES, DESIGNS = 512, 8
# Harmonics of the stored designs, at least; samples of the spread of each.
HARMONICS, SPREAD_SAMPLES = 3, 1024


def design(
    exciter: Exciter,
    vary: Mapping[str, tuple[float, float]],
    target: Mapping[str, Any] | None = None,
    subject_to: Mapping[str, Any] | None = None,
    minimise: str | Sequence[str] | None = None,
    x0: float | None = None,
    v0: float = 0.0,
    tolerance: Mapping[str, float] | None = None,
    allow: Mapping[str, float] | None = None,
    samples: int = SAMPLES,
    designs: int = DESIGNS,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Find parameters whose motion has wanted quantities, keeps to bounds, and has others as small as possible.

    Points of low discrepancy [1]_ in the ranges of `vary` are solved by one sweep. The best are refined along their
    laws of motion by derivatives: targets and bounds in least squares [2]_, a quantity to be least by sequential
    quadratic programming [3]_, the front of two of them under limits of the second [4]_. Only stable orbits count that
    the motion from the start settles on: each design is marched from there again.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are not varied.
    vary : mapping of str to (float, float)
        Lower and upper end of each varied parameter.
    target : mapping of str to float, optional
        Values of quantities, named as the columns of `table` are: displacement_mean, displacement_amplitude_3,
        impact_velocity_max_1 and, of soft supports, support_force_max_2. Those of the law of motion, as
        impacts_per_period_1, are met by choice of the law. The key displacement takes a curve: an array (n, 2) of
        phases, in forcing periods, and displacements.
    subject_to : mapping of str to str or (float, float), optional
        Bounds: "< 0.8", "> 0.1", "> 0.1, < 0.8", or a pair.
    minimise : str or sequence of str, optional
        A quantity to be least, or two for a Pareto front; with a minus sign before it, one to be largest. A parameter
        (f), a spread (displacement_mean_std) and a sensitivity (displacement_mean_sensitivity_R1) count as quantities.
    x0, v0 : float, optional
        Start of every motion, as for `steady_state`.
    tolerance : mapping of str to float, optional
        Standard deviations of parameters, for the spread of each design (`tolerance`).
    allow : mapping of str to float, optional
        How far each target may be off: asks for the tolerances that the parameters need.
    samples : int
        Samples of a round, from 8 to 1e6; there are up to three rounds, until a design is met.
    designs : int
        Largest number of designs returned, from 1 to 100; a front has up to 16.
    progress : callable, optional
        Called as progress(done, total), in steps of the search.

    Returns
    -------
    xarray.Dataset
        Over `design`, distinct ones, the best first: those that are met, by the quantity to be least if there is one,
        and by `law_margin`; a front in the order of the first quantity. If none is met, those that miss least.

        <parameter>
            Varied parameters; the others are scalars.
        design_result, design_miss
            Whether all that is wanted holds (targets within 1e-9 of their size) or what keeps it from holding: an end
            of a range, a change of law, a conflict; and the largest miss over its size.
        law_margin
            Distance, in shares of the ranges, to the nearest point found where the motion from the start has another
            law (regime, m, p1, p2).
        <parameter>_tolerance
            With `allow`: how far each parameter may be off, up or down, all at once, so that the law, the bounds and
            the targets within `allow` hold, at all corners of this box; NaN where none does.
        displacement_misfit
            Root mean square distance from the wanted curve; designs are ranked by it.
        <name>_target, <name>_lower, <name>_upper
            What is wanted, NaN where nothing is.

        with all that `steady_state` returns and, with `tolerance`, all that `vibropipe.tolerance` does.

    Raises
    ------
    ParameterError
        If a name is unknown, a range or a bound is wrong, goals contradict each other, or no sample is a stable motion
        with the wanted quantities.

    Warns
    -----
    UnsolvedWarning
        If no design is met, with the reason of the nearest miss.

    References
    ----------
    .. [1] I. M. Sobol', On the distribution of points in a cube and the approximate evaluation of integrals, USSR
       Computational Mathematics and Mathematical Physics 7 (1967) 86.
    .. [2] M. A. Branch, T. F. Coleman, Y. Li, A subspace, interior, and conjugate gradient method for large-scale
       bound-constrained minimization problems, SIAM Journal on Scientific Computing 21 (1999) 1.
    .. [3] D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988).
    .. [4] Y. Y. Haimes, L. S. Lasdon, D. A. Wismer, On a bicriterion formulation of the problems of integrated system
       identification and system optimization, IEEE Transactions on Systems, Man, and Cybernetics 1 (1971) 296.
    """
    sigma = spread.check_tolerances(exciter, tolerance) if tolerance else {}
    goals = goals_of(target, subject_to, minimise, sigma)
    check_whole("samples", samples, DESIGN_SAMPLES)
    check_whole("designs", designs, DESIGNS_LIMITS)
    allowed = check_allow(goals, allow)
    problem = Problem(exciter, check_vary(exciter, vary), goals, x0, v0, sigma, allowed)
    check_supports({**vars(exciter), **{name: ends[0] for name, ends in vary.items()}}, goals)
    exciter.check_start(x0, v0)
    is_front = len(goals.objectives) == 2
    steps = WorkCount(ROUNDS * 2 * REFINED + designs * 2 + is_front * STEPS, progress)
    candidates, sampled = find_candidates(problem, samples, steps)
    if is_front:
        candidates = front(problem, sampled, candidates, steps)
    margins = [law_margin(problem, candidate.share) for candidate in candidates]
    if is_front and candidates[0].is_met:
        order = list(range(len(candidates)))
    else:
        order = distinct(problem, candidates, margins)[:designs]
    kept = [candidates[n] for n in order]
    dataset = design_dataset(problem, kept, [margins[n] for n in order], steps)
    steps.add(steps.total)
    if not kept[0].is_met:
        warnings.warn(miss_text(problem, kept[0]), UnsolvedWarning, stacklevel=2)
    return dataset


def check_vary(
    exciter: Exciter, vary: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Return the ranges of varied parameters in the order of the parameters, or raise a ParameterError."""
    if not vary:
        raise ParameterError("vary", vary, must="must have at least one parameter with its range")
    for name, ends in vary.items():
        if name not in PARAMETERS:
            must = f"must have keys among {', '.join(PARAMETERS)}"
            raise ParameterError("vary", vary, must=must, got=repr(name))
        try:
            low, high = map(float, ends)
        except (TypeError, ValueError):
            low, high = np.nan, np.nan
        if not low < high:
            raise ParameterError(f"vary.{name}", ends, "a pair of increasing numbers")
        limits = PARAMETERS[name].range
        if not (limits.contains(low) and limits.contains(high)):
            raise ParameterError(f"vary.{name}", ends, f"within its range, {limits.text}")
    check_soft("vary", exciter, vary, {name: float(ends[0]) for name, ends in vary.items()})
    return {
        name: (float(vary[name][0]), float(vary[name][1])) for name in PARAMETERS if name in vary
    }


def design_dataset(
    problem: Problem, designs: Sequence[Candidate], margins: Sequence[float], steps: WorkCount
) -> xr.Dataset:
    """Return designs as a labelled dataset."""
    harmonics = harmonics_of(problem.names, HARMONICS)
    parameters = problem.parameters(np.array([candidate.share for candidate in designs]))
    start = problem.x0, problem.v0
    points = solve_points(parameters, start, spread.OUTPUTS, harmonics)
    start_words = f"x0 = {problem.x0 or 0.0:g}, v0 = {problem.v0:g}"
    attrs = {
        **origin_attrs(all_effect_names(columns_of(parameters), pieces=True), start_words),
        **problem.goals.texts,
    }
    attrs["vary"] = " ".join(problem.vary)
    dataset = points_dataset(points, "design", harmonics, attrs, list(problem.vary))
    misses = problem.misses(np.array([candidate.values for candidate in designs]))
    variables: dict[str, Any] = {
        "design_result": ("design", np.array([each.result for each in designs], np.int8)),
        "design_miss": ("design", np.abs(misses).max(axis=1, initial=0.0)),
        "law_margin": ("design", np.array(margins)),
        **curve_misfit(problem, designs),
        **bound_variables(problem.goals, harmonics),
    }
    if problem.allow:
        widths = np.array(
            [
                needed_tolerances(problem, row, state)
                for row, state in zip(parameters, points.states, strict=True)
            ]
        )
        variables |= {
            f"{name}_tolerance": ("design", column)
            for name, column in zip(Parameters._fields, widths.T, strict=True)
            if np.isfinite(column).any()
        }
    dataset = dataset.assign(variables)
    if not problem.tolerance:
        return describe(dataset)

    def from_start(rows: np.ndarray) -> Points:
        return solve_points(clipped(rows), start, spread.OUTPUTS, harmonics)

    spreads = []
    for row in range(len(designs)):
        spreads.append(
            spread.spread_variables(
                parameters[row], points.take(slice(row, row + 1)), problem.tolerance,
                SPREAD_SAMPLES, spread.WORST, harmonics, from_start,
            )
        )  # fmt: skip
        steps.add()
    return spread.with_spread(dataset, spreads, problem.tolerance, ("design",))


def curve_misfit(problem: Problem, designs: Sequence[Candidate]) -> dict[str, Any]:
    """Return the root mean square distance of designs from the wanted curve, if there is one."""
    if problem.goals.curve is None:
        return {}
    misfits = np.array([candidate.values[len(problem.names) :] for candidate in designs])
    return {f"{CURVE}_misfit": ("design", np.sqrt((misfits**2).mean(axis=1)))}


def bound_variables(goals: Goals, harmonics: int) -> dict[str, Any]:
    """Return targets and bounds over the dimension of their quantity, NaN where there is none."""
    sizes = {"support": 2, "harmonic": harmonics, "multiplier": 2}
    variables: dict[str, Any] = {}
    for bound in goals.bounds:
        name = bound.quantity
        if name.is_parameter or name.derived or name.part:
            continue  # the attributes have them
        dims = quantity(name.variable).dims
        ends = (
            {"target": bound.low} if bound.is_target else {"lower": bound.low, "upper": bound.high}
        )
        for suffix, end in ends.items():
            if not np.isfinite(end) or any(dim not in sizes for dim in dims):
                continue
            empty = np.full([sizes[dim] for dim in dims], np.nan)
            _, values = variables.setdefault(f"{name.variable}_{suffix}", (dims, empty))
            values[... if name.number is None else name.number - 1] = end
    return variables


def miss_text(problem: Problem, nearest: Candidate) -> str:
    """Return why no design is met, with the values of the nearest one."""
    missed = problem.misses(nearest.values)
    misses = [
        f"{bound.text} is missed with {nearest.values[problem.names.index(bound.quantity)]:.6g}"
        for bound, miss in zip(problem.goals.bounds, missed, strict=True)
        if abs(miss) > 0
    ]
    at = problem.parameters(nearest.share[None])[0]
    place = ", ".join(f"{name} = {at[Parameters._fields.index(name)]:.6g}" for name in problem.vary)
    reason = DesignResult(nearest.result).reason
    return f"No design is met. The nearest has {place}: {'; '.join(misses)}; {reason}."
