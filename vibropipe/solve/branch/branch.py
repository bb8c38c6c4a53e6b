"""The function `branch`: orbits followed along a parameter, stable or not, as a labelled dataset."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.branches.tree import follow_tree
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics import limits
from vibropipe.physics.effects import effect_names
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.start import start_text
from vibropipe.physics.stated import stated_names, ties_of_call
from vibropipe.physics.ties import Ties
from vibropipe.solve.branch.branch_dataset import branch_dataset
from vibropipe.solve.branch.point_yields import check_bounds, outputs_beside, with_yields
from vibropipe.solve.branch.problem import (
    MUST_REPEAT,
    check_alone,
    check_branch_outputs,
    check_place_tolerance,
    check_range,
    check_start,
    check_switch,
    exciter_at,
    problem_of,
    seed_of_steady_state,
    with_rests,
    with_ties,
)
from vibropipe.solve.branch.stretches import STARTS, VALUES, law_stretches
from vibropipe.solve.checks import check_law, check_whole
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rows.named import harmonics_of
from vibropipe.solve.rows.steady import steady_state
from vibropipe.solve.with_units import (
    are_with_units,
    plain_goals,
    plain_mapping,
    plain_name,
    plain_values,
)
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr


def branch(
    exciter: Exciter,
    along: str,
    to: float | Sequence[float],
    x0: float | None = None,
    v0: float | None = None,
    at: Sequence[float] = (),
    switch: Collection[str] = (),
    harmonics: int = 6,
    max_step: float = 0.02,
    outputs: Sequence[str] = OF_STEADY_STATE,
    law: Sequence[int] | None = None,
    tolerance: Mapping[str, float] | None = None,
    ties: Mapping[str, Any] | None = None,
    subject_to: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Follow the orbit that settles from (x0, v0) along a parameter, stable or not, round folds.

    An orbit of m forcing periods and n impacts is a zero of 2n equations in the times and velocities of its impacts:
    flights between them are closed forms. Pseudo-arclength continuation [1]_ follows it; nothing is marched but the
    start. Test functions find the bifurcations, each located to rounding: the component of the tangent along the
    parameter (fold), the derivative D of the return map with det(D + 1) = 0 (flip; for the map to the mirror image of
    a symmetric orbit pitchfork), and the least distance from a support at the turning points of all flights, and the
    least impact velocity (grazing [2]_). With rests, soft supports, friction or a housing that slides an orbit is a
    zero of equations over its law, the events of its period in turn, and is followed from law to law; where a chatter
    pushes a held housing off without end, it is not.

    Parameters
    ----------
    exciter : Exciter
        The start; its own value of `along` lies on the branch.
    along : str
        The parameter that varies: any of an exciter but contact_1, contact_2 and wear_exponent; `k1` and `k2` only
        above 0, for 0 is a rigid support. Of an exciter of `from_physical` also one with units, as omega or F: `to`,
        `at` and `tolerance` are then in SI, text or quantities of pint, and the dataset is in SI, as `to_physical`
        returns it. Or a name that `ties` use: it is followed from the first to the second of two numbers `to`.
    to : float or (float, float)
        Value to which the branch is followed, from the exciter's own; or the range that it is followed through, both
        ways. A branch is left where it leaves this range.
    x0, v0 : float, optional
        Start of the motion that settles on the orbit, as for `steady_state`.
    at : sequence of float
        Values of the parameter at which points are wanted exactly, each time the branch passes them.
    switch : collection of str
        Any of flip, pitchfork, grazing: at these bifurcations the branches that begin there are followed too, and so
        on: the orbits of twice the period, both asymmetric ones, and at a grazing the orbit that touches a support and
        those that strike it there: in each of its periods, of a symmetric orbit on both sides or on one, and once in
        two or three periods. At most 64 branches are followed, none of more than 128 impacts or 32 forcing periods.
    harmonics : int
        Number of harmonics, from 1 to 1,000.
    max_step : float
        Largest distance of neighbouring points, up to 0.1, where 1 is the range of the parameter, a forcing period, or
        the largest impact velocity of the start.
    outputs : sequence of str
        Any of harmonics, impacts, stability, energy, power, frame, subharmonics, sensitivity, as for `steady_state`.
    law : (int, int, int), optional
        Period multiple, up to 32, and impacts on each support, up to 64, without rests: all stretches of this law in
        the range `to` that are found, stable or not, each a branch of its own, and nothing else. Orbits are sought at
        64 values of the parameter, from 17 velocities and, of laws that have one, by the closed form, and what begins
        at their flips, pitchforks and grazings is followed through other laws. The exciter's own value of `along`, x0,
        v0 and `switch` are not used.
    tolerance : mapping of str to float, optional
        Standard deviations of parameters that scatter independently: bifurcations then have the derivative of their
        place by each of them, and its standard deviation to first order.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others or of names of one's own, as of `sweep`: {"R2": "R1"} along R1, an unbalance
        {"f": "0.02 * nu**2"} along nu, {"h": "2 * zeta"} along zeta. What is tied follows along the branch.
    subject_to : mapping of str to str or (float, float), optional
        Bounds of quantities that parts are to keep, as of `design`: {"impact_velocity_max_1": "< 0.8"}. Asks for the
        yield beside `tolerance`; {} for that of the law of motion alone.

    Returns
    -------
    xarray.Dataset
        Over `point`, in order along each branch, all quantities of `steady_state`, the parameter under its own name,
        and

        branch_id
            Number of the branch; 0 is the one through the start.
        stable, floquet_multiplier (multiplier)
            As for `steady_state`; multipliers are infinite and 0 where an impact has no velocity.
            With a housing there are three, and a pair of them on the unit circle is neimark_sacker.

        Impacts are a contiguous ragged array, `row_size` of them for each point. Over `bifurcation`:

        bifurcation_kind
            fold, flip, pitchfork, grazing, neimark_sacker, end or, if the branch begins with rests, soft supports,
            friction or a housing, change: contacts, turns, sticks, rests or slips of the orbit begin or end.
        bifurcation_<along>
            The parameter.
        bifurcation_point
            Index of its point.
        bifurcation_<along>_sensitivity, bifurcation_<along>_contribution (parameter), bifurcation_<along>_std
            With `tolerance`: how the place of a fold, flip, pitchfork or grazing moves with each parameter, the share
            of each in the variance of the place, and its standard deviation. NaN where it has no derivative, as that of
            a pitchfork by a parameter that ends the symmetry.
        yield, yield_low, yield_high (point)
            With `subject_to`: share of 1,024 scattered parts (the first samples of `tolerance`), each started from the
            orbit of the point, that keep its law of motion and all bounds, with its 95 % interval: at the stable points
            with a parameter of `at`, without `at` at up to 32 of the stable points, the first and last among them,
            and NaN elsewhere. What follows R1 by `ties` follows it in each part. A point takes some 0.1 s, with soft
            supports a second or two. law_yield, <name>_yield, <name>_sort_threshold and so on are those of
            `tolerance`, `foretold_by` names over `point` what foretells best which parts are good; empty elsewhere.
        end_reason
            Why the branch ends there: other_sequence (grazing or change), parent (its orbit is one of fewer periods
            or its own mirror image, from which doubled, asymmetric and others begin), chatter, rest, closed, rounding,
            continuum (orbits that are not isolated), lost or points; or goes_on. A branch that ends at the limit of the
            range has no entry for it. At a flip or pitchfork the branch itself goes on, but the orbits that begin
            there are not followed for impact_limit and period_limit (they have more than 128 impacts or 32 periods)
            and for rounding (the bifurcation is so steep that rounding hides them).

        The attribute `incomplete` says how many branches are left, if 64 do not suffice.

    Warns
    -----
    UnsolvedWarning
        If branches are left.

    Raises
    ------
    ParameterError
        If an argument is out of range, the motion from (x0, v0) settles on no orbit that repeats with the force, or no
        orbit of the law is found.

    References
    ----------
    .. [1] H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in: Applications of
       Bifurcation Theory, Academic Press 1977, 359-384.
    .. [2] A. B. Nordmark, Non-periodic motion caused by grazing incidence in an impact oscillator, Journal of Sound
       and Vibration 145 (1991) 279-297.
    """
    if are_with_units(exciter, {along: to}, tolerance, at, x0, v0, subject_to):
        dataset = branch(
            exciter,
            plain_name(along),
            plain_values(exciter, along, to),
            x0=plain_values(exciter, "x0", x0),
            v0=plain_values(exciter, "v0", v0),
            at=np.atleast_1d(plain_values(exciter, along, at)).tolist(),
            switch=switch,
            harmonics=harmonics,
            max_step=max_step,
            outputs=outputs,
            law=law,
            ties=ties,
            tolerance=None if tolerance is None else plain_mapping(exciter, tolerance),
            subject_to=plain_goals(exciter, "subject_to", subject_to),
        )
        return to_physical(dataset, exciter)
    begin = exciter.ties.get(along)
    exciter, tied = ties_of_call(exciter, ties, [along])
    check_whole("harmonics", harmonics, limits.HARMONICS)
    bounds = check_bounds(vars(exciter), (along, *tied.parameters), subject_to, tolerance)
    requested = outputs_beside(check_branch_outputs(outputs), bounds)
    harmonics = harmonics_of([bound.quantity for bound in bounds or ()], harmonics)
    if law is not None:
        check_alone(x0, v0, switch)
        dataset, problem = _branch_of_law(
            exciter, along, to, check_law(law), at, harmonics, max_step, requested, tolerance, tied
        )
        return with_yields(dataset, problem, tolerance, bounds, at)
    v = 0.0 if v0 is None else v0
    exciter, to, own = with_ties(exciter, along, to, tied, begin)
    exciter.check_start(x0, v)
    problem, signs = problem_of(exciter, along, to, at, max_step, tied, own)
    switches = check_switch(switch)
    sigma = check_place_tolerance(exciter, along, tolerance, outputs, tied)
    start = steady_state(exciter, x0, v, harmonics=1)
    values = {name: np.array([value]) for name, value in exciter.numbers()._asdict().items()}
    follow = along, "both" if len(signs) > 1 else "up" if signs[0] > 0 else "down"
    effects = problem.effects
    reached = {**values, **ends_of(problem)}
    attrs = origin_attrs(effect_names(effects, reached), start_text(values, x0, v), follow=follow)
    attrs |= tied.attrs | ({"switch": " ".join(switches)} if switches else {})
    check_start(exciter, start)
    problem = with_rests(problem, start)
    seed = seed_of_steady_state(exciter, problem, signs, start)
    if seed is None:
        got = "an orbit within rounding of chatter"
        if effects.housing is not None:
            got += ", whose chatter pushes a held housing off without end, or that is not isolated"
        raise ParameterError("exciter", exciter, must=MUST_REPEAT, got=got)
    tree = follow_tree(problem, seed, switches)
    if tree.n_left:
        told = (
            f"{len(tree.branches)} branches are followed, the most of one call; "
            f"{tree.n_left} more begin at their bifurcations"
        )
        attrs["incomplete"] = told
        remedy = f"Follow a shorter range of {along}, or switch at fewer kinds of bifurcation."
        warnings.warn(f"{told}. {remedy}", UnsolvedWarning, stacklevel=2)
    dataset = branch_dataset(problem, tree.branches, harmonics, attrs, requested, sigma)
    return with_yields(dataset, problem, sigma, bounds, at)


def ends_of(problem: Problem) -> dict[str, np.ndarray]:
    """Return what varies at the ends of the range."""
    ends = [exciter_at(problem, value)._asdict() for value in (problem.low, problem.high)]
    names = [name for name in problem.varied if name in PARAMETERS]
    return {name: np.array([end[name] for end in ends]) for name in names}


def _branch_of_law(
    exciter: Exciter,
    along: str,
    to: float | Sequence[float],
    law: tuple[int, int, int],
    at: Sequence[float],
    harmonics: int,
    max_step: float,
    outputs: tuple[str, ...],
    tolerance: Mapping[str, float] | None,
    ties: Ties,
) -> tuple[xr.Dataset, Problem]:
    """Return all stretches of a law as the dataset of `branch`, and what was followed."""
    ties.check(stated_names(exciter), [along], "along")
    ends = check_range(exciter, along, to, ties)
    first = ties.applied(exciter, {along: ends[0]})
    sigma = check_place_tolerance(first, along, tolerance, outputs, ties)
    found = law_stretches(exciter, along, ends, law, at, max_step, ties)
    name, effects = f"({law[0]}; {law[1]}, {law[2]})", found.problem.effects
    searched = f"orbits at {VALUES} values of the parameter, from {STARTS} velocities each"
    if not found.branches:
        got = f"{name}, of which none is found ({searched})"
        must = f"must have orbits in the range of {along}"
        raise ParameterError("law", law, must=must, got=got)
    values = {key: np.array([value]) for key, value in first.numbers()._asdict().items()}
    reached = {**values, **ends_of(found.problem)}
    attrs = origin_attrs(effect_names(effects, reached), searched, follow=(along, "both"))
    attrs |= ties.attrs | {"law": name}
    if found.n_left:
        attrs["incomplete"] = f"{found.n_left} more branches that may lead to the law are left"
        warnings.warn(
            f"{attrs['incomplete']}. Follow a shorter range of {along}.",
            UnsolvedWarning, stacklevel=3,
        )  # fmt: skip
    dataset = branch_dataset(found.problem, found.branches, harmonics, attrs, outputs, sigma)
    return dataset, found.problem
