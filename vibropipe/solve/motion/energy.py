"""The energy balance of one motion: work of the force = loss by damping + losses at the supports + stored energy.

The residual measures the error of the motion. An exact motion is integrated from contact to contact, each flight
from the state after the contact before; a Newmark motion over its own steps.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.march.grid import exact_grid
from vibropipe.march.state import initial_state
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.housing import GROUND, LOADS
from vibropipe.orbits.quadrature import add_energy
from vibropipe.physics.effects import Effects, grid_effects, kernel_effects, shared_effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.load_harmonics import force_values
from vibropipe.solve.motion.contacts import Contacts, log_of, tail_speeds


def work_of_flights(
    exciter: Exciter,
    effects: Effects,
    start: tuple[float, float],
    turns: tuple[float, float],
    contacts: Contacts,
) -> np.ndarray:
    """Compute the energy terms (4,) of an exact motion: work of the force, loss by damping, at support 1, at support 2.

    start : displacement and velocity at the start
    turns : start and end, in forcing periods
    contacts : columns of `simulate`
    """
    e, p = kernel_effects(effects), exciter.parameters()
    log = log_of(exciter, contacts, turns[1])
    state = initial_state(
        shared_effects(e), p, exact_grid(grid_effects(e), p), turns[0], *start, None
    )
    terms = np.zeros(4)
    sums = Integrals(terms, np.zeros(0), np.zeros(0, complex), ONE_PERIOD)
    # The log contains a rest that lasts beyond the end, so the end state counts as flight.
    end = state._replace(mode=0)
    add_energy(e, p, *start, turns[0], turns[1], end, log, sums, np.empty(DEGREE + 1))
    return terms


def work_of_steps(
    exciter: Exciter, turns: np.ndarray, x: np.ndarray, v: np.ndarray, contacts: Contacts
) -> np.ndarray:
    """Compute the energy terms (4,) of a Newmark motion, as `work_of_flights`.

    A step of constant average acceleration balances exactly: the mean force acts over the displacement of the step.

    turns : (n,), start and ends of the steps, in forcing periods
    x, v : (n,), states at these times
    contacts : columns of `simulate`
    """
    period, support_x = exciter.period, np.array([math.nan, exciter.upper, exciter.lower])
    impacts, side = contacts["impact_tau"] / period, contacts["impact_support"]
    before, after = contacts["impact_velocity"], contacts["impact_velocity_after"]
    rests = np.concatenate([contacts["rest_start"], contacts["rest_end"]]) / period
    is_before_end = rests < turns[-1]
    rest_x = support_x[np.tile(contacts["rest_support"], 2)][is_before_end]
    at = np.concatenate([turns, impacts, impacts, rests[is_before_end]])
    permutation = np.argsort(at, kind="stable")
    xs = np.concatenate([x, support_x[side], support_x[side], rest_x])[permutation]
    vs = np.concatenate([v, before, after, np.zeros(rest_x.size)])[permutation]
    force = force_values(exciter.f, at[permutation], exciter.f2, exciter.phi2)
    dx = np.diff(xs)
    losses = np.append(0.5 * (before**2 - after**2), 0.5 * tail_speeds(contacts) ** 2)
    side = np.append(side, contacts["rest_support"])
    return np.array(
        [
            np.sum(0.5 * (force[1:] + force[:-1]) * dx),
            np.sum(0.5 * exciter.h * (vs[1:] + vs[:-1]) * dx),
            losses[side == 1].sum(),
            losses[side == 2].sum(),
        ]
    )


def support_energy(exciter: Exciter, x: float) -> float:
    """Return the energy stored in soft supports at the displacement x."""
    deep = max(0.0, x - exciter.upper), max(0.0, exciter.lower - x)
    return 0.5 * (exciter.k1 * deep[0] ** 2 + exciter.k2 * deep[1] ** 2)


def balance(
    work: np.ndarray,
    start: tuple[float, ...],
    end: tuple[float, ...],
    in_supports: float = 0.0,
    has_friction: bool = False,
) -> dict[str, object]:
    """Return the terms of the balance of a motion by name, each (dimensions, values).

    start, end : numbers half of whose squares' sum is the energy stored but in supports: x, x' and more of a housing.

    in_supports : change of the energy stored in soft supports; has_friction : whether there is a term of friction.
    """
    # The product form of a difference of squares cancels less.
    stored = 0.5 * sum((b - a) * (b + a) for a, b in zip(start, end, strict=True)) + in_supports
    residual = work[0] - (work[1] + work[2] + work[3] + stored)
    further: dict[str, object] = {}
    if has_friction:
        residual -= work[4]
        further = {"energy_friction": ((), work[4])}
    if work.size > GROUND:
        residual += work[LOADS] - work[GROUND]
        further |= {"energy_housing_friction": ((), work[GROUND])}
        further |= {"energy_housing_load": ((), work[LOADS])}
    return {
        "energy_input": ((), work[0]),
        "energy_damping": ((), work[1]),
        "energy_impact": (("support",), work[2:4]),
        "energy_change": ((), stored),
        "energy_residual": ((), residual),
        **further,
    }
