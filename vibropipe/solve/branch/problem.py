"""What is followed along a parameter, how, from which orbit, and which arguments `branch` takes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.branches.following import Seed
from vibropipe.orbits.branches.switching import SWITCHES
from vibropipe.orbits.branches.tree import seed_of_orbit
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.tied import Tied
from vibropipe.physics.effects import Effects, all_effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import as_float
from vibropipe.physics.stated import stated_names
from vibropipe.physics.ties import SAMPLES, TIED, Ties
from vibropipe.solve.branch.branch_of_pieces import seed_of_pieces
from vibropipe.solve.checks import check_outputs, check_varied
from vibropipe.solve.design.scattered_parts import check_tolerances
from vibropipe.words.bifurcations import BESIDE_LAW, without_slope
from vibropipe.words.outputs import OF_BRANCH
from vibropipe.words.parameters import (
    FOLLOWED,
    PARAMETERS,
    RIGID_AT_ZERO,
    SOFT_ALONG,
    TWINS,
    stated_value,
)
from vibropipe.words.records import FINITE
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import physical_name

if TYPE_CHECKING:
    import xarray as xr

# Parameters whose change keeps a symmetric exciter symmetric.
KEEP_SYMMETRY = ("nu", "f", "h", "l", "friction", "friction_ratio", "mass_ratio", "shaker")
OF_GROUND = ("housing_friction_1", "housing_friction_2")
# Without friction of the ground both bodies keep any velocity: an orbit is one of a continuum.
NO_FRICTION = (
    "must be above 0, or housing_friction_2 must: a housing without friction keeps any velocity"
)
NO_TIES = Ties()
MUST_REPEAT = "must lead from (x0, v0) to an orbit that repeats with the force"


def is_symmetric(exciter: Exciter | Parameters) -> bool:
    """Return whether the exciter is its own mirror image half a forcing period later."""
    is_even = all(getattr(exciter, one) == getattr(exciter, two) for one, two in TWINS)
    is_pulled = exciter.mass_ratio > 0.0 and exciter.load + exciter.housing_load != 0.0
    return exciter.delta == exciter.load and exciter.f2 == 0.0 and is_even and not is_pulled


def with_ties(
    exciter: Exciter, along: str, to: Any, ties: Ties, own: str | None = None
) -> tuple[Exciter, Any, float | None]:
    """Return the exciter that a branch begins at with what is tied, how far it is followed, and where a name begins.

    A name of one's own is followed from the first to the second of two numbers, or from its `own` number to one.
    """
    ties.check(stated_names(exciter), [along], "along")
    if along not in ties.own:
        return (ties.applied(exciter, {}) if ties else exciter), to, None
    ends = [as_float("to", value, FINITE.text) for value in np.atleast_1d(to).tolist()]
    if own is not None and len(ends) == 1:
        ends = [float(own), *ends]
    if len(ends) != 2 or ends[0] == ends[1]:
        raise ParameterError("to", to, f"two numbers: {along} from the first to the second")
    return ties.applied(exciter, {along: ends[0]}), ends[1], ends[0]


def problem_of(
    exciter: Exciter,
    along: str,
    to: Any,
    at: Sequence[float],
    max_step: float,
    ties: Ties = NO_TIES,
    own: float | None = None,
) -> tuple[Problem, tuple[float, ...]]:
    """Return what is followed and in which directions; ParameterError for values that are not allowed.

    exciter : with what is tied
    own : where a name of one's own begins
    """
    check_along(along, ties)
    own = stated_value(getattr(exciter, along)) if own is None else own
    if along in RIGID_AT_ZERO and 0.0 in (own, *np.atleast_1d(to).tolist()):
        raise ParameterError("along", along, must=SOFT_ALONG, got="0 at an end of the range")
    ends = [_check_value(exciter, along, "to", value, ties) for value in np.atleast_1d(to).tolist()]
    if own in ends and len(ends) <= 2:
        ends = [value for value in ends if value != own]
        if not ends:
            raise ParameterError("to", to, must=f"must differ from the exciter's own {along}")
    if len(ends) == 1:
        low, high = sorted((own, ends[0]))
        signs: tuple[float, ...] = (1.0 if ends[0] > own else -1.0,)
    else:
        if len(ends) != 2 or not min(ends) < own < max(ends):
            allowed = f"a number, or two that enclose the exciter's own {along}, {own!r}"
            name = physical_name(along)
            if name in exciter.written:
                allowed += f" ({name} = {exciter.written[name]})"
            raise ParameterError("to", to, allowed)
        low, high = sorted(ends)
        signs = (1.0, -1.0)
    reached = {along: np.array([low, high])}
    if ties:
        reached = {along: np.linspace(low, high, SAMPLES)}
        reached |= ties.followed({**exciter.numbers()._asdict(), **reached}, [along])
    lows = {name: float(values.min()) for name, values in reached.items()}
    exciter.check_frequency(reached)
    check_varied(
        "along", exciter, reached, {name: lows[name] for name in RIGID_AT_ZERO if name in lows}
    )
    wanted = [_check_value(exciter, along, "at", value, ties) for value in at]
    for value in wanted:
        if not low <= value <= high:
            of = f" ({along})" if exciter.written else ""
            raise ParameterError("at", value, f"numbers from {low!r} to {high!r}{of}")
    length = as_float("max_step", max_step, "a number above 0 up to 0.1")
    if not 0.0 < length <= 0.1:
        raise ParameterError("max_step", max_step, "a number above 0 up to 0.1")
    tied = Tied(ties, (along,)) if ties else None
    values = np.array([*exciter.numbers(), *([] if along in PARAMETERS else [own])])
    index = (Parameters._fields if tied is None else tied.names).index(along)
    held = {name: np.array([value]) for name, value in exciter.numbers()._asdict().items()}
    effects = all_effects({**held, **reached}, pieces=True, housing=True)
    check_ground(exciter, effects, lows)
    wanted_values = tuple(sorted(set(wanted)))
    problem = Problem(values, index, low, high, wanted_values, False, length, effects, tied=tied)
    # What is tied may keep an exciter symmetric along a parameter that alone would not.
    symmetric = all(is_symmetric(exciter_at(problem, value)) for value in reached[along].tolist())
    return problem._replace(symmetric=symmetric), signs


def exciter_at(problem: Problem, value: float) -> Parameters:
    """Return the parameters, as they are stated, at a value of the one that varies."""
    return Parameters(*problem.values_at(value)[: len(Parameters._fields)].tolist())


def check_along(along: str, ties: Ties) -> None:
    """Raise a ParameterError for a name along which no orbit can be followed."""
    known = (*FOLLOWED, *ties.own)
    if along not in known:
        raise ParameterError("along", along, f"one of {', '.join(known)}")


def check_range(exciter: Exciter, along: str, to: Any, ties: Ties = NO_TIES) -> tuple[float, float]:
    """Return a range that a parameter is followed through, wherever the exciter's own value lies."""
    check_along(along, ties)
    ends = [_check_value(exciter, along, "to", value, ties) for value in np.atleast_1d(to).tolist()]
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise ParameterError(
            "to", to, "two increasing numbers, the range in which the law is sought"
        )
    return ends[0], ends[1]


def check_ground(exciter: Exciter, effects: Effects, lows: Mapping[str, float]) -> None:
    """Raise a ParameterError unless the ground resists a housing that slides; lows : of what varies."""
    least = (lows.get(name, getattr(exciter, name)) for name in OF_GROUND)
    if effects.housing is not None and not any(least):
        raise ParameterError("housing_friction_1", 0.0, must=NO_FRICTION)


def _check_value(exciter: Exciter, along: str, name: str, value: Any, ties: Ties) -> float:
    """Return a value of the parameter as a float; ParameterError if the exciter cannot have it."""
    limits = PARAMETERS[along].range if along in PARAMETERS else FINITE
    number = as_float(name, value, limits.text)
    if not limits.contains(number):
        raise ParameterError(name, value, limits.text)
    all_effects(vars(ties.applied(exciter, {along: number})), pieces=True, housing=True)
    return number


def with_rests(problem: Problem, start: xr.Dataset) -> Problem:
    """Return the problem of an orbit: one with rests on rigid supports is known by its pieces, which may rest."""
    if problem.effects.has_pieces or int(start["regime"]) != Regime.WITH_REST:
        return problem
    return problem._replace(effects=problem.effects._replace(soft=1, friction=1))


def seed_of_steady_state(
    exciter: Exciter, problem: Problem, signs: tuple[float, ...], start: xr.Dataset
) -> Seed | None:
    """Return the start of the branch through the orbit of a steady state; None where its equations have no solution."""
    if problem.effects.has_pieces:
        return seed_of_pieces(exciter, problem, signs, start)
    times = start.impact_phase.values + start.impact_period.values
    own = problem.values[problem.along]
    u = np.concatenate([times, start.impact_velocity.values, [own]])
    supports = start.impact_support.values.astype(np.int8)
    seed = seed_of_orbit(problem, int(start.period_multiple), supports, u, signs)
    return None if seed is None or not math.isfinite(seed.value) else seed


def check_branch_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    """Return the outputs of points, or raise a ParameterError."""
    requested = check_outputs(outputs)
    if not set(requested) <= set(OF_BRANCH):
        raise ParameterError("outputs", outputs, f"a list of {', '.join(OF_BRANCH)}")
    return requested


def check_place_tolerance(
    exciter: Exciter,
    along: str,
    tolerance: Mapping[str, float] | None,
    outputs: Sequence[str],
    ties: Ties,
) -> dict[str, float] | None:
    """Return the standard deviations of parameters, or raise a ParameterError."""
    if tolerance is None:
        return None
    sigma = check_tolerances(exciter, tolerance)
    missing = without_slope(exciter.numbers()._asdict(), along)
    missing |= dict.fromkeys(ties.parameters, TIED)
    for name in sigma:
        if name in missing:
            raise ParameterError(f"tolerance.{name}", sigma[name], must=missing[name])
    if "sensitivity" in outputs:
        must = "must leave out sensitivity beside tolerance: both have a dimension parameter of their own"
        raise ParameterError("outputs", outputs, must=must)
    return sigma


def check_switch(switch: Collection[str]) -> tuple[str, ...]:
    """Return the kinds of bifurcation to switch at, or raise a ParameterError."""
    if isinstance(switch, str) or not set(switch) <= set(SWITCHES):
        raise ParameterError("switch", switch, f"a list of {', '.join(SWITCHES)}")
    return tuple(switch)


def check_start(exciter: Exciter, start: xr.Dataset) -> None:
    """Raise a ParameterError unless a steady state is an orbit that repeats with the force."""
    regime = Regime(int(start.regime))
    is_free = exciter.f == exciter.f2 == 0.0 and exciter.h == 0.0
    if int(start.period_multiple) == 0 or is_free:
        got = f"a motion with the regime {regime.name.lower()}"
        raise ParameterError("exciter", exciter, must=MUST_REPEAT, got=got)


def check_alone(x0: float | None, v0: float | None, switch: Collection[str]) -> None:
    """Raise a ParameterError where a start or bifurcations stand beside a law."""
    for name, value in (("x0", x0), ("v0", v0), ("switch", switch or None)):
        if value is not None:
            raise ParameterError(name, value, must=BESIDE_LAW)
