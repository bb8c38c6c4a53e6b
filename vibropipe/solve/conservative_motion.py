"""A conservative motion (h = f = 0, R1 = R2 = 1) in closed form, for any number of impacts."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.conservative import Arc, arc_state, speed_at, top_support
from vibropipe.solve.contacts import Contacts

# Times, supports and velocities before impact of the contacts at one support.
Met = tuple[np.ndarray, np.ndarray, np.ndarray]
NONE: Met = np.empty(0), np.empty(0, np.int8), np.empty(0)


@jit
def _sample(a: Arc, tau: np.ndarray, x: np.ndarray, v: np.ndarray) -> None:
    for i in range(tau.size):
        x[i], v[i] = arc_state(a, tau[i])


def positions(a: Arc, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(x, v), each (n,), of a free motion at times tau (n,) after its start."""
    x, v = np.empty(tau.size), np.empty(tau.size)
    _sample(a, tau, x, v)
    return x, v


def _times(a: Arc, at: float, span: float, moving_in: bool) -> np.ndarray:
    """Times in [0, span] at which the motion passes the end that lies `at` after its upper end; one at the
    very start counts when the mass moves in."""
    period = 2 * a.half
    first = at - a.time_from_top
    if first < 0 or (first == 0 and not moving_in):
        first += period
    return first + period * np.arange(max(0, math.floor((span - first) / period) + 1))


def contacts(a: Arc, span: float, x: float, v: float, upper: float, lower: float) -> Contacts:
    """Impacts and grazings of a free motion from (x, v), up to `span` after its start, in order of time:
    the columns of `simulate` with times counted from the start, and no rests."""
    impacts: list[Met] = []
    grazings: list[Met] = []
    top = top_support(a)
    for support, at, meets in ((top, 0.0, a.meets_top), (3 - top, a.half, a.meets_bottom)):
        if meets == 0:
            continue
        sign, place = (1, upper) if support == 1 else (-1, lower)
        times = _times(a, at, span, sign * v > 0 or meets == 2)
        before = np.full(times.size, sign * speed_at(x, v, place))
        met = times, np.full(times.size, support, np.int8), before
        (grazings if meets == 2 else impacts).append(met)
    struck, side, before = _in_order(impacts)
    grazed, grazed_side, _ = _in_order(grazings)
    return {
        "impact_tau": struck,
        "impact_support": side,
        "impact_velocity": before,
        "impact_velocity_after": -before,
        "rest_start": np.empty(0),
        "rest_end": np.empty(0),
        "rest_support": np.empty(0, np.int8),
        "grazing_tau": grazed,
        "grazing_support": grazed_side,
    }


def _in_order(met: list[Met]) -> list[np.ndarray]:
    """Times, supports and velocities of contacts in order of time, from those at each support."""
    # Both ends are passed by turns, so that nothing must be sorted.
    by_turns = sorted((one for one in met if one[0].size > 0), key=lambda one: float(one[0][0]))
    columns = []
    for parts in zip(*by_turns or [NONE], strict=True):
        column = np.empty(sum(part.size for part in parts), parts[0].dtype)
        for i, part in enumerate(parts):
            column[i :: len(parts)] = part
        columns.append(column)
    return columns
