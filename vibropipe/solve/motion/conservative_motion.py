"""A conservative motion (h = f = 0, R1 = R2 = 1) in closed form, for any number of impacts."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.conservative import Arc, arc_state, speed_at, top_support
from vibropipe.solve.motion.contacts import Contacts

# Times, supports and velocities before contact of the contacts with one support.
Columns = tuple[np.ndarray, np.ndarray, np.ndarray]
NO_CONTACTS: Columns = np.empty(0), np.empty(0, np.int8), np.empty(0)


@jit
def _sample(a: Arc, tau: np.ndarray, x: np.ndarray, v: np.ndarray) -> None:
    """Fill x and v with the motion at the times tau (n,) after its start."""
    for i in range(tau.size):
        x[i], v[i] = arc_state(a, tau[i])


def positions(a: Arc, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return displacement and velocity, each (n,), at the times tau (n,) after the start of a free motion."""
    x, v = np.empty(tau.size), np.empty(tau.size)
    _sample(a, tau, x, v)
    return x, v


def _times(a: Arc, offset: float, span: float, moves_outwards: bool) -> np.ndarray:
    """Return the times in [0, span] at which the mass is at one end of the motion.

    `offset` is the time from the upper end to this end. A contact at the start counts if the mass moves outwards.
    """
    period = 2 * a.half
    first = offset - a.time_from_top
    if first < 0 or (first == 0 and not moves_outwards):
        first += period
    return first + period * np.arange(max(0, math.floor((span - first) / period) + 1))


def contacts(a: Arc, span: float, x: float, v: float, upper: float, lower: float) -> Contacts:
    """Compute the impacts and grazings of a free motion.

    Parameters
    ----------
    a : Arc
        The motion.
    span : float
        Length of the motion, in tau.
    x, v : float
        Its start.
    upper, lower : float
        Displacement of support 1 and of support 2.

    Returns
    -------
    Contacts
        The columns of `simulate` in order of time, with times from the start and no rests.
    """
    impacts: list[Columns] = []
    grazings: list[Columns] = []
    top = top_support(a)
    for support, offset, meets in ((top, 0.0, a.meets_top), (3 - top, a.half, a.meets_bottom)):
        if meets == 0:
            continue
        sign, support_x = (1, upper) if support == 1 else (-1, lower)
        times = _times(a, offset, span, sign * v > 0 or meets == 2)
        before = np.full(times.size, sign * speed_at(x, v, support_x))
        columns = times, np.full(times.size, support, np.int8), before
        (grazings if meets == 2 else impacts).append(columns)
    impact_tau, impact_support, before = _in_order(impacts)
    grazing_tau, grazing_support, _ = _in_order(grazings)
    return {
        "impact_tau": impact_tau,
        "impact_support": impact_support,
        "impact_velocity": before,
        "impact_velocity_after": -before,
        "rest_start": np.empty(0),
        "rest_end": np.empty(0),
        "rest_support": np.empty(0, np.int8),
        "grazing_tau": grazing_tau,
        "grazing_support": grazing_support,
    }


def _in_order(contacts: list[Columns]) -> list[np.ndarray]:
    """Merge the contacts with each support into columns in order of time."""
    # The motion reaches its ends alternately, so that interleaving replaces sorting.
    ordered = sorted((each for each in contacts if each[0].size > 0), key=lambda each: each[0][0])
    columns = []
    for parts in zip(*ordered or [NO_CONTACTS], strict=True):
        column = np.empty(sum(part.size for part in parts), parts[0].dtype)
        for i, part in enumerate(parts):
            column[i :: len(parts)] = part
        columns.append(column)
    return columns
