"""What is followed along a parameter, how, and from which orbit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.branches.following import Seed
from vibropipe.orbits.branches.tree import IMPACTS, Rules, seed_of_orbit
from vibropipe.orbits.law.following import LAWS
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.effects import Effects, all_effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import as_float
from vibropipe.solve.branch.branch_of_pieces import seed_of_pieces
from vibropipe.solve.checks import check_soft
from vibropipe.words.parameters import (
    FOLLOWED,
    PARAMETERS,
    RIGID_AT_ZERO,
    SOFT_ALONG,
    TWINS,
    stated_value,
)

if TYPE_CHECKING:
    import xarray as xr

# Parameters whose change keeps a symmetric exciter symmetric.
KEEP_SYMMETRY = ("nu", "f", "h", "l", "friction", "friction_ratio", "mass_ratio", "shaker")
OF_GROUND = ("housing_friction_1", "housing_friction_2")
# Without friction of the ground both bodies keep any velocity: an orbit is one of a continuum.
NO_FRICTION = (
    "must be above 0, or housing_friction_2 must: a housing without friction keeps any velocity"
)


def is_symmetric(exciter: Exciter) -> bool:
    """Return whether the exciter is its own mirror image half a forcing period later."""
    is_even = all(getattr(exciter, one) == getattr(exciter, two) for one, two in TWINS)
    is_pulled = exciter.mass_ratio > 0.0 and exciter.load + exciter.housing_load != 0.0
    return exciter.delta == exciter.load and exciter.f2 == 0.0 and is_even and not is_pulled


def problem_of(
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


def check_range(exciter: Exciter, along: str, to: Any) -> tuple[float, float]:
    """Return a range that a parameter is followed through, wherever the exciter's own value lies."""
    if along not in FOLLOWED:
        raise ParameterError("along", along, f"one of {', '.join(FOLLOWED)}")
    ends = [_check_value(exciter, along, "to", value) for value in np.atleast_1d(to).tolist()]
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


def _check_value(exciter: Exciter, along: str, name: str, value: Any) -> float:
    """Return a value of the parameter as a float; ParameterError if the exciter cannot have it."""
    number = as_float(name, value, PARAMETERS[along].range.text)
    if not PARAMETERS[along].range.contains(number):
        raise ParameterError(name, value, PARAMETERS[along].range.text)
    all_effects(vars(Exciter(**{**vars(exciter), along: number})), pieces=True, housing=True)
    return number


def rules_of(effects: Effects) -> Rules:
    """Return how branches of exciters with some effects are followed."""
    return LAWS if effects.has_pieces else IMPACTS


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
