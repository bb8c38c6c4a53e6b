"""The function `design`: parameters that give a wanted law of motion, and how far its nearest change is."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.stated import ties_of_call
from vibropipe.physics.ties import Ties
from vibropipe.solve.checks import check_whole
from vibropipe.solve.design.dataset import design_dataset
from vibropipe.solve.design.goals import check_allow, check_placed, check_presence, goals_of
from vibropipe.solve.design.margin import law_margin
from vibropipe.solve.design.pareto import STEPS, front, undominated
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.ranges import at_lower_ends, check_vary
from vibropipe.solve.design.scatter import (
    LEAST_YIELD,
    assumed_scatter,
    judged,
    moved_inside,
    off_limits,
    ranked,
)
from vibropipe.solve.design.scattered_parts import check_tolerances
from vibropipe.solve.design.search import (
    REFINED,
    ROUNDS,
    distinct,
    find_candidates,
    miss_text,
    without_copies,
)
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rows.points import WorkSpentError
from vibropipe.solve.with_units import (
    are_with_units,
    plain_deviations,
    plain_goals,
    plain_mapping,
    plain_objectives,
    plain_values,
)
from vibropipe.words.designs import DESIGN_SAMPLES, DesignResult
from vibropipe.words.designs import DESIGNS as DESIGNS_LIMITS
from vibropipe.words.progress import Progress, WorkCount
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr

SAMPLES, DESIGNS = 512, 8
TOO_MUCH = (
    "must leave motions that are settled sooner: the search was ended, since those in these ranges take hundreds of "
    "times the usual steps. Keep stiffness and damping of supports, nu and 1/h within fewer decades of each other"
)
# Arguments by quantity of a steady state; the others are by parameter.
GOALS = ("target", "subject_to", "allow")


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
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Find parameters whose motion has wanted quantities, keeps to bounds, and has others as small as possible.

    Points of low discrepancy [1]_ in the ranges of `vary` are solved by one sweep. The best are refined along their
    laws of motion by derivatives: targets and bounds in least squares [2]_, a quantity to be least by successive linear
    programs [3]_, the front of two of them under limits of the second [4]_. Only stable orbits count that the motion
    from the start settles on: each design is marched from there again.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are not varied. Of one made by `from_physical`, ranges, goals and tolerances may have
        units, bare numbers beside them are in SI, and so is the dataset.
    vary : mapping of str to (float, float)
        Lower and upper end of each varied parameter, or name that `ties` use.
    target : mapping of str to float, optional
        Values of quantities, named as the columns of `table` are: displacement_mean, displacement_amplitude_3,
        impact_velocity_max_1 and, of soft supports, support_force_max_2. Those of the law of motion, as
        impacts_per_period_1, are met by choice of the law. The key displacement takes a curve: an array (n, 2) of
        phases, in forcing periods, and displacements. fold_nu_up and the like are places of bifurcations: the value of
        a parameter (nu, f, h, l, delta, R1, R2; of an exciter with units omega and so on) at the first fold, flip,
        pitchfork or grazing on the branch of the motion, followed up or down as by `branch` to its first fold, its end,
        or four times the parameter or a quarter of it (an offset by l). A design without one does not count.
    subject_to : mapping of str to str or (float, float), optional
        Bounds: "< 0.8", "> 0.1", "> 0.1, < 0.8", or a pair.
    minimise : str or sequence of str, optional
        A quantity to be least, or two for a Pareto front; with a minus sign before it, one to be largest. A parameter
        (f), a spread (displacement_mean_std) and a sensitivity (displacement_mean_sensitivity_R1) count as quantities;
        "-yield", alone, asks for designs of which most scattered parts keep all goals.
    x0, v0 : float, optional
        Start of every motion, as for `steady_state`.
    tolerance : mapping of str to float, optional
        Standard deviations of parameters, for the yield and the spread of each design (`tolerance`).
    allow : mapping of str to float, optional
        How far each target may be off: asks for the yield and for the tolerances that the parameters need.
    samples : int
        Samples of a round, from 8 to 1e6; there are up to three rounds, until a design is met.
    designs : int
        Largest number of designs returned, from 1 to 100; a front has up to 16.
    progress : callable, optional
        Called as progress(done, total), in steps of the search.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others or of names of one's own, as of `sweep`; derivatives follow them. They hold
        for designs: the parts of a yield scatter in each parameter by itself.

    Returns
    -------
    xarray.Dataset
        Over `design`, distinct ones, the best first: those that are met, by the quantity to be least if there is one,
        and by `law_margin`; a front in the order of the first quantity. If none is met, those that miss least.

        With `tolerance` or `allow` they are ranked by `yield`, then by `reliability_index`; with a quantity to be
        least, or a curve, by that among yields of the same whole per cent. Designs are sought first among those that
        keep their law within three standard deviations of parameters, and then moved inside their bounds
        by four standard deviations of the quantity, or by two or one if there is no more room; one that stays within a
        tenth of one is left out if there are others. A front is sought among points that keep as many deviations, and
        has only designs that half of the parts keep at least, if there are any.

        <parameter>
            Varied parameters, names of one's own, and what is tied to them; the others are scalars.
        design_result, design_miss
            Whether all that is wanted holds (targets within 1e-9 of their size) or what keeps it from holding: an end
            of a range, a change of law, a conflict; and the largest miss over its size.
        law_margin
            Distance, in shares of the ranges, to the nearest point found where the motion from the start has another
            law (regime, m, p1, p2).
        from_rest
            Whether the mass settles on this motion if it is started at rest: same, other, or unknown.
        yield, yield_low, yield_high
            With `tolerance` or `allow`: share of 4,096 scattered parts that keep the law, the bounds and the targets
            within `allow` (any value of a target without it), and its 95 % confidence interval [5]_ for as many random
            ones. Parameters are independent and normal, with the deviations of `tolerance`; without it, with 0.1 % of
            each parameter (of the larger end of its range; of an offset, of l). Places of bifurcations of parts are to
            first order, by their derivatives. <parameter>_std are these deviations,
            the attribute `scatter` says whether they are given or assumed. law_yield and <name>_yield are the shares
            that keep the law and each goal, <name>_quantile what they have (of those with the law).
        reliability_index
            Least distance to a limit of a goal, to first order, in the standard deviations of its quantity.
        <parameter>_tolerance
            How far each parameter may be off, up or down, all at once, so that the law, the bounds and the targets
            within `allow` hold, at the ends of each axis of this box and, of up to ten parameters, at all its corners.
            What the tightest goal leaves is shared in proportion to what each parameter contributes with its deviation;
            where that is less than the deviations need together, the smallest contributions are kept and the largest
            cut. Without a deviation in `tolerance` the 0.1 % above take its place.
        tolerance_result
            Whether there are tolerances or, where they are NaN, why not: a bound or a change of law within a tenth of a
            deviation, that tenth misses a goal, or the design itself does.
        displacement_misfit
            Root mean square distance from the wanted curve; designs are ranked by it.
        <name>_target, <name>_lower, <name>_upper
            What is wanted, NaN where nothing is; of a varied parameter the ends of its range.
        <name>_swept
            Of a front without targets: both quantities at the points of a grid of 4,096 over the ranges whose motion
            is a stable orbit within all bounds.

        foretold_by, <name>_sort_threshold, <name>_sort_area, <name>_sort_wrong, and its _low, _high
            With `tolerance` or `allow`: the sorting rules of `vibropipe.tolerance`, by the parts that the yield counts,
            and the name of the best of each design. NaN stands in a design without a rule beside one with a rule.

        with all that `steady_state` returns and, with `tolerance`, all that `vibropipe.tolerance` does.

    Raises
    ------
    ParameterError
        If a name is unknown, a range or a bound is wrong, goals contradict each other, no sample is a stable motion
        with the wanted quantities, or the motions take hundreds of times the usual steps.

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
    .. [3] R. E. Griffith, R. A. Stewart, A nonlinear programming technique for the optimization of continuous
       processing systems, Management Science 7 (1961) 379.
    .. [4] Y. Y. Haimes, L. S. Lasdon, D. A. Wismer, On a bicriterion formulation of the problems of integrated system
       identification and system optimization, IEEE Transactions on Systems, Man, and Cybernetics 1 (1971) 296.
    .. [5] E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of the American
       Statistical Association 22 (1927) 209.
    """
    wanted: dict[str, Any] = {
        "vary": vary, "target": target, "subject_to": subject_to, "minimise": minimise,
        "x0": x0, "v0": v0, "tolerance": tolerance, "allow": allow,
    }  # fmt: skip
    if with_units := are_with_units(exciter, vary, target, subject_to, tolerance, allow, x0, v0):
        wanted |= {name: plain_goals(exciter, name, wanted[name]) for name in GOALS}
        wanted |= {name: plain_values(exciter, name, wanted[name]) for name in ("x0", "v0")}
        wanted["vary"] = plain_mapping(exciter, vary)
        wanted["tolerance"] = tolerance and plain_deviations(exciter, tolerance, vary)
        wanted["minimise"] = plain_objectives(minimise)
    untied, tied = ties_of_call(exciter, ties, vary)
    check_whole("samples", samples, DESIGN_SAMPLES)
    check_whole("designs", designs, DESIGNS_LIMITS)
    problem = _problem(untied, tied, **wanted)
    try:
        found, missed = _designs(problem, samples, designs, progress)
    except WorkSpentError:
        raise ParameterError("vary", dict(vary), must=TOO_MUCH, got="") from None
    if missed and with_units:
        reason = DesignResult(int(found.design_result[0])).reason
        missed = f"No design that was found is met: {reason}."
    if missed:
        warnings.warn(missed, UnsolvedWarning, stacklevel=3)
    return to_physical(found, exciter) if with_units else found


def _problem(
    exciter: Exciter,
    ties: Ties,
    *,
    vary: Mapping[str, tuple[float, float]],
    target: Mapping[str, Any] | None,
    subject_to: Mapping[str, Any] | None,
    minimise: str | Sequence[str] | None,
    x0: float | None,
    v0: float,
    tolerance: Mapping[str, float] | None,
    allow: Mapping[str, float] | None,
) -> Problem:
    """Return the checked problem of a call without units."""
    sigma = check_tolerances(exciter, tolerance) if tolerance else {}
    goals = goals_of(target, subject_to, minimise, sigma)
    allowed = check_allow(goals, allow)
    ranges = check_vary(exciter, vary, ties)
    exciter = at_lower_ends(exciter, ranges, ties)
    exciter.check_frequency(sigma.keys() - {"nu"})
    problem = Problem(exciter, ranges, goals, x0, v0, sigma, allowed, {}, ties=ties)
    for name in goals.names:
        if name.derived and name.parameter in (*ties.free, *ties.parameters):
            must = f"must leave out {name.parameter}, since {name.name} is wanted, by it alone"
            raise ParameterError("ties", ties.texts, must=must, got="")
    check_placed(goals, ties)
    if sigma or allowed:
        problem = replace(problem, scatter=sigma or assumed_scatter(exciter, problem.ranges))
    lows = {name: ends[0] for name, ends in problem.ranges.items()}
    check_presence({**vars(exciter), **lows}, goals)
    exciter.check_start(x0, v0)
    return problem


def _designs(
    problem: Problem, samples: int, designs: int, progress: Progress | None
) -> tuple[xr.Dataset, str]:
    """Return designs without units, and why none is met; empty if one is."""
    is_front = len(problem.goals.objectives) == 2
    steps = WorkCount(ROUNDS * 2 * REFINED + designs * 2 + is_front * STEPS, progress)
    candidates = find_candidates(problem, samples, steps)
    swept = None
    if is_front:
        candidates, swept = front(problem, candidates, steps)
    candidates = [moved_inside(problem, candidate) for candidate in candidates]
    is_front &= candidates[0].is_met
    candidates = (
        undominated(problem, candidates) if is_front else without_copies(problem, candidates)
    )
    # What is not met is left out where anything is, before margins are sought, which take longest.
    candidates = [candidate for candidate in candidates if candidate.is_met] or candidates
    margins = [law_margin(problem, candidate.share) for candidate in candidates]
    order = list(range(len(candidates))) if is_front else distinct(problem, candidates, margins)
    parts = {n: judged(problem, candidates[n]) for n in order if problem.scatter}
    if problem.scatter:
        order = (
            off_limits(order, parts, LEAST_YIELD)
            if is_front
            else ranked(problem, candidates, order, margins, parts)
        )
    order = order if is_front else order[:designs]
    kept = [candidates[n] for n in order]
    dataset = design_dataset(
        problem, kept, [margins[n] for n in order], [parts[n] for n in order if parts], steps, swept
    )
    steps.add(steps.total)
    return dataset, "" if kept[0].is_met else miss_text(problem, kept[0])
