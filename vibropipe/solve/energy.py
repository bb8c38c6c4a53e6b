"""The energy balance of one motion: work of the force = lost by damping + lost at the supports + stored.

What is left over is an error measure that every motion carries itself. The exact motion is integrated from
contact to contact, each flight from where the contact before left it; Newmark's over its own steps.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.march.grid import exact_grid
from vibropipe.march.state import initial_state
from vibropipe.orbits.quadrature import add_energy
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.load import force_values
from vibropipe.solve.contacts import Contacts, log_of, tail_speeds

# Variables of a balance, in the order of their terms; the last is what the others leave.
TERMS = ("energy_input", "energy_damping", "energy_impact", "energy_change", "energy_residual")


def work_of_flights(
    exciter: Exciter,
    effects: Effects,
    start: tuple[float, float],
    turns: tuple[float, float],
    contacts: Contacts,
) -> np.ndarray:
    """Work of the force, loss by damping, losses at support 1 and 2, shape (4,), of an exact motion.

    start: (x, v); turns: its beginning and end in forcing periods; contacts: columns of `simulate`.
    """
    e, p = effects, exciter.parameters()
    log = log_of(exciter, contacts, turns[1])
    state = initial_state(e, p, exact_grid(e, p), turns[0], *start)
    found = np.zeros(4)
    # A rest at the end is in the log: the motion ends in no state of its own.
    end = state._replace(mode=0)
    add_energy(e, p, *start, turns[0], turns[1], end, log, found, np.empty(DEGREE + 1))
    return found


def work_of_steps(
    exciter: Exciter, turns: np.ndarray, x: np.ndarray, v: np.ndarray, contacts: Contacts
) -> np.ndarray:
    """The same (4,) of Newmark's motion from its states (n,) at the ends of steps, the first its start.

    A step of constant average acceleration closes its own balance: its mean force works over its way.
    """
    period, place = exciter.period, np.array([math.nan, exciter.upper, exciter.lower])
    struck, side = contacts["impact_tau"] / period, contacts["impact_support"]
    before, after = contacts["impact_velocity"], contacts["impact_velocity_after"]
    rests = np.concatenate([contacts["rest_start"], contacts["rest_end"]]) / period
    among = rests < turns[-1]
    lain = place[np.tile(contacts["rest_support"], 2)][among]
    at = np.concatenate([turns, struck, struck, rests[among]])
    order = np.argsort(at, kind="stable")
    xs = np.concatenate([x, place[side], place[side], lain])[order]
    vs = np.concatenate([v, before, after, np.zeros(lain.size)])[order]
    force, way = force_values(exciter.f, at[order]), np.diff(xs)
    lost = np.append(0.5 * (before**2 - after**2), 0.5 * tail_speeds(contacts) ** 2)
    side = np.append(side, contacts["rest_support"])
    return np.array(
        [
            np.sum(0.5 * (force[1:] + force[:-1]) * way),
            np.sum(0.5 * exciter.h * (vs[1:] + vs[:-1]) * way),
            lost[side == 1].sum(),
            lost[side == 2].sum(),
        ]
    )


def balance(work: np.ndarray, start: tuple[float, float], end: tuple[float, float]) -> list[object]:
    """The terms TERMS of a balance, each (dimensions, values)."""
    # Differences of squares written as products: they cancel less.
    stored = 0.5 * sum((b - a) * (b + a) for a, b in zip(start, end, strict=True))
    residual = work[0] - (work[1] + work[2] + work[3] + stored)
    values = (work[0], work[1], work[2:], stored, residual)
    return [(("support",) if np.ndim(value) else (), value) for value in values]
