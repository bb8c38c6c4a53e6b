"""The function `branch`: orbits followed along a parameter, stable or not, as a labelled dataset."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.branches.tree import Tree, follow_tree, seed_of_orbit
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics import limits
from vibropipe.physics.effects import Effects, all_effects, effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import as_float
from vibropipe.physics.start import start_text
from vibropipe.solve.branch.branch_dataset import branch_dataset, rest_dataset
from vibropipe.solve.branch.branch_of_pieces import follow_branches_of_pieces, solver_of_pieces
from vibropipe.solve.branch.rest_branch import follow_rest
from vibropipe.solve.checks import (
    check_outputs,
    check_soft,
    check_whole,
)
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.outputs import OF_BRANCH, OF_STEADY_STATE
from vibropipe.words.parameters import (
    FOLLOWED,
    PARAMETERS,
    RIGID_AT_ZERO,
    SOFT_ALONG,
    TWINS,
    stated_value,
)
from vibropipe.words.regimes import Regime
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr

# Kinds of bifurcation at which branches begin.
SWITCHES = ("flip", "pitchfork", "grazing")
MUST_REPEAT = "must lead from (x0, v0) to an orbit that repeats with the force"
# Parameters whose change keeps a symmetric exciter symmetric.
KEEP_SYMMETRY = ("nu", "f", "h", "l", "mass_ratio", "shaker")
OF_GROUND = ("housing_friction_1", "housing_friction_2")
# Without friction of the ground both bodies keep any velocity: an orbit is one of a continuum.
NO_FRICTION = (
    "must be above 0, or housing_friction_2 must: a housing without friction keeps any velocity"
)


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
) -> xr.Dataset:
    """Follow the orbit that settles from (x0, v0) along a parameter, stable or not, round folds.

    An orbit of m forcing periods and n impacts is a zero of 2n equations in the times and velocities of its impacts:
    flights between them are closed forms. Pseudo-arclength continuation [1]_ follows it; nothing is marched but the
    start. Test functions find the bifurcations, each located to rounding: the component of the tangent along the
    parameter (fold), the derivative D of the return map with det(D + 1) = 0 (flip; for the map to the mirror image of
    a symmetric orbit pitchfork), and the least distance from a support at the turning points of all flights, and the
    least impact velocity (grazing [2]_). An orbit with rests has the multipliers 0 and is followed as far as what
    settles has the same rests. With soft supports, friction or a housing that slides an orbit is a zero of equations
    over its law, the events of its period in turn, and is followed from law to law; with a housing it has no rests.

    Parameters
    ----------
    exciter : Exciter
        The start; its own value of `along` lies on the branch.
    along : str
        The parameter that varies: any of an exciter; `k1` and `k2` only above 0, for 0 is a rigid support.
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
            fold, flip, pitchfork, grazing, neimark_sacker, end or, with soft supports, friction or a housing, change:
            contacts, turns, sticks, rests or slips of the orbit begin or end.
        bifurcation_<along>
            The parameter.
        bifurcation_point
            Index of its point.
        end_reason
            Why the branch ends there: other_sequence (grazing or change), parent (of doubled or asymmetric orbits),
            chatter, rest, closed, rounding, continuum (orbits that are not isolated), lost or points; or goes_on.
            A branch that ends at the limit of the range has no
            entry for it. At a flip or pitchfork the branch itself goes on, but the orbits that begin there are not
            followed for impact_limit and period_limit (they have more than 128 impacts or 32 periods) and for rounding
            (the bifurcation is so steep that rounding hides them).

        The attribute `incomplete` says how many branches are left, if 64 do not suffice.

    Warns
    -----
    UnsolvedWarning
        If branches are left.

    Raises
    ------
    ParameterError
        If an argument is out of range, or the motion from (x0, v0) settles on no orbit that repeats with the force.

    References
    ----------
    .. [1] H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, in: Applications of
       Bifurcation Theory, Academic Press 1977, 359-384.
    .. [2] A. B. Nordmark, Non-periodic motion caused by grazing incidence in an impact oscillator, Journal of Sound
       and Vibration 145 (1991) 279-297.
    """
    v = 0.0 if v0 is None else v0
    exciter.check_start(x0, v)
    problem, signs = _problem(exciter, along, to, at, max_step)
    check_whole("harmonics", harmonics, limits.HARMONICS)
    switches, requested = _check_switch(switch), _check_outputs(outputs)
    ends = [problem.low, problem.high]
    start = steady_state(exciter, x0, v, harmonics=1)
    values = {name: np.array([value]) for name, value in exciter.numbers()._asdict().items()}
    follow = along, _direction(signs)
    reached = {**values, along: np.array(ends)}
    effects = problem.effects
    attrs = origin_attrs(effect_names(effects, reached), start_text(values, x0, v), follow=follow)
    if int(start.regime) == Regime.WITH_REST and not effects.has_pieces:
        return rest_dataset(
            problem,
            follow_rest(exciter, problem, signs, start, harmonics, requested),
            harmonics,
            attrs,
        )
    _check_start(exciter, start)
    solve = None
    if effects.has_pieces:
        tree = follow_branches_of_pieces(exciter, problem, signs, start, switches, effects)
        solve = solver_of_pieces(effects)
    else:
        tree = _follow(problem, signs, start, switches)
    if tree is None:
        got = "an orbit within rounding of chatter"
        if effects.housing is not None:
            got += ", with rests beside a housing that slides, or that is not isolated"
        raise ParameterError("exciter", exciter, must=MUST_REPEAT, got=got)
    if tree.n_left:
        attrs["incomplete"] = (
            f"{len(tree.branches)} branches are followed, the most of one call; "
            f"{tree.n_left} more begin at their bifurcations"
        )
        remedy = f"Follow a shorter range of {along}, or switch at fewer kinds of bifurcation."
        warnings.warn(f"{attrs['incomplete']}. {remedy}", UnsolvedWarning, stacklevel=3)
    return branch_dataset(problem, tree.branches, harmonics, attrs, requested, solve)


def _check_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    """Return the outputs of points, or raise a ParameterError."""
    requested = check_outputs(outputs)
    if not set(requested) <= set(OF_BRANCH):
        raise ParameterError("outputs", outputs, f"a list of {', '.join(OF_BRANCH)}")
    return requested


def is_symmetric(exciter: Exciter) -> bool:
    """Return whether the exciter is its own mirror image half a forcing period later."""
    is_even = all(getattr(exciter, one) == getattr(exciter, two) for one, two in TWINS)
    is_pulled = exciter.mass_ratio > 0.0 and exciter.load + exciter.housing_load != 0.0
    return exciter.delta == exciter.load and exciter.f2 == 0.0 and is_even and not is_pulled


def _direction(signs: tuple[float, ...]) -> str:
    """Return the directions in which a parameter is followed as a word."""
    return "both" if len(signs) > 1 else "up" if signs[0] > 0 else "down"


def _problem(
    exciter: Exciter, along: str, to: Any, at: Sequence[float], max_step: float
) -> tuple[Problem, tuple[float, ...]]:
    """Return what is followed and in which directions; ParameterError for values that are not allowed."""
    if along not in FOLLOWED:
        raise ParameterError("along", along, f"one of {', '.join(FOLLOWED)}")
    own = stated_value(getattr(exciter, along))
    ends = [_check_value(exciter, along, "to", value) for value in np.atleast_1d(to).tolist()]
    if len(ends) == 1:
        if ends[0] == own:
            raise ParameterError("to", to, must=f"must differ from the exciter's own {along}")
        low, high = sorted((own, ends[0]))
        signs: tuple[float, ...] = (1.0 if ends[0] > own else -1.0,)
    else:
        if len(ends) != 2 or not ends[0] < own < ends[1]:
            allowed = f"a number, or two that enclose the exciter's own {along}, {own!r}"
            raise ParameterError("to", to, allowed)
        low, high = ends
        signs = (1.0, -1.0)
    if along in RIGID_AT_ZERO and low == 0.0:
        raise ParameterError("along", along, must=SOFT_ALONG, got="0 at an end of the range")
    exciter.check_frequency((along,))
    check_soft("along", exciter, (along,), {along: low} if along in RIGID_AT_ZERO else {})
    wanted = [_check_value(exciter, along, "at", value) for value in at]
    for value in wanted:
        if not low <= value <= high:
            raise ParameterError("at", value, f"numbers from {low!r} to {high!r}")
    length = as_float("max_step", max_step, "a number above 0 up to 0.1")
    if not 0.0 < length <= 0.1:
        raise ParameterError("max_step", max_step, "a number above 0 up to 0.1")
    symmetric = is_symmetric(exciter) and along in KEEP_SYMMETRY
    values = np.array(exciter.numbers())
    index = Parameters._fields.index(along)
    reached = {name: np.array([value]) for name, value in exciter.numbers()._asdict().items()}
    effects = all_effects({**reached, along: np.array([low, high])}, pieces=True, housing=True)
    check_ground(exciter, effects, {along: low})
    wanted_values = tuple(sorted(set(wanted)))
    problem = Problem(values, index, low, high, wanted_values, symmetric, length, effects)
    return problem, signs


def check_ground(exciter: Exciter, effects: Effects, lows: Mapping[str, float]) -> None:
    """Raise a ParameterError unless the ground resists a housing that slides; lows : of what varies."""
    least = (lows.get(name, getattr(exciter, name)) for name in OF_GROUND)
    if effects.housing is not None and not any(least):
        raise ParameterError("housing_friction_1", 0.0, must=NO_FRICTION)


def _check_value(exciter: Exciter, along: str, name: str, value: Any) -> float:
    """Return a value of the parameter as a float; ParameterError if the exciter cannot have it."""
    number = as_float(name, value, PARAMETERS[along].range.text)
    if not PARAMETERS[along].range.contains(number):
        raise ParameterError(name, value, PARAMETERS[along].range.text)
    all_effects(vars(Exciter(**{**vars(exciter), along: number})), pieces=True, housing=True)
    return number


def _check_switch(switch: Collection[str]) -> tuple[str, ...]:
    """Return the kinds of bifurcation to switch at, or raise a ParameterError."""
    if isinstance(switch, str) or not set(switch) <= set(SWITCHES):
        raise ParameterError("switch", switch, f"a list of {', '.join(SWITCHES)}")
    return tuple(switch)


def _check_start(exciter: Exciter, start: xr.Dataset) -> None:
    """Raise a ParameterError unless a steady state is an orbit that repeats with the force."""
    regime = Regime(int(start.regime))
    is_free = exciter.f == exciter.f2 == 0.0 and exciter.h == 0.0
    if int(start.period_multiple) == 0 or is_free:
        got = f"a motion with the regime {regime.name.lower()}"
        raise ParameterError("exciter", exciter, must=MUST_REPEAT, got=got)


def _follow(
    problem: Problem, signs: tuple[float, ...], start: xr.Dataset, switches: tuple[str, ...]
) -> Tree | None:
    """Return the branches through the orbit of a steady state; None if its equations have no solution there."""
    times = start.impact_phase.values + start.impact_period.values
    own = problem.values[problem.along]
    u = np.concatenate([times, start.impact_velocity.values, [own]])
    supports = start.impact_support.values.astype(np.int8)
    seed = seed_of_orbit(problem, int(start.period_multiple), supports, u, signs)
    if seed is None or not math.isfinite(seed.value):
        return None
    return follow_tree(problem, seed, switches)
