"""Orbits as fixed points of the return map, by Newton's method: solved for, not judged.

An unstable orbit is a result like any other. Whoever shoots decides what an orbit means: `orbits.settling` asks
whether a motion settles on it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS
from vibropipe.march.loop import OK
from vibropipe.march.state import REST, State
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    clear_log,
    floquet_multipliers,
    gap_difference,
    march_periods,
    newton_step,
    return_map_jacobian,
    state_xv,
)

MAX_NEWTON = 12
# Residual, as a share of the motion's size, that rounding lets a march reach.
CLOSURE_TOLERANCE = 1e-13
# A numpy integer: numba compiles a plain constant to code of its own, march and all.
EVENTS_PER_PERIOD = np.int64(100_000)


class Shooting(NamedTuple):
    """When Newton's method begins and ends.

    Attributes
    ----------
    within : float
        Largest residual of the start from which it begins.
    max_multiplier : float
        Largest modulus of a multiplier of the return map at the start from which it begins.
    closed : float
        Residual at which an orbit is closed. It also is where the residual, small already, shrinks no more.

    Residuals are shares of the motion's size.
    """

    within: float = math.inf
    max_multiplier: float = math.inf
    closed: float = CLOSURE_TOLERANCE


class Orbit(NamedTuple):
    """A fixed point of the return map, or the last guess at one.

    Attributes
    ----------
    is_closed : bool
        Whether the return map brings `state` back to itself as nearly as was asked.
    status : int
        `Status` of the last march. LOG_FULL: the log has only the last contacts, and `return_map_jacobian` is of these.
    m : int
        Period multiple.
    state, end : State
        At forcing period 0 of the orbit, and m periods later.
    residual : float
        Distance from `state` to `end`, as a share of `size`.
    derivative : tuple of 4 floats
        Derivative (j11, j12, j21, j22) of the return map by (x, x') at `state`; zero after a rest.
    iterations : int
        Newton steps made; 0 where the start is on the orbit.
    first_change : float
        Distance from the start to its image.
    distance : float
        Distance from the start to `state`.
    size : float
        Size of the motion (`motion_norm`).

    Distances are |dx| + |dx'|. The log is left with the contacts from `state` to `end`.
    """

    is_closed: bool
    status: int
    m: int
    state: State
    end: State
    residual: float
    derivative: tuple[float, float, float, float]
    iterations: int
    first_change: float
    distance: float
    size: float


@jit_inline
def motion_norm(p, state, log):
    """Size of a marched motion: largest of |x| + |x'| at its section and |x'| at its impacts."""
    x, v = state_xv(p, state)
    size = abs(x) + abs(v)
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        size = max(size, abs(log.velocity[i]))
    return size


@jit
def shoot(e, p, grid, start, m, shooting, log, c):
    """Find an orbit of m forcing periods near a state at the section.

    Parameters
    ----------
    start : State
        Where Newton's method begins; its step and theta are 0.
    m : int
        Period multiple.
    shooting : Shooting
    log, c :
        Work space, as for `march`.

    Returns
    -------
    Orbit
        `is_closed` is False where Newton's method was not begun, left the gap, or gained no more digits.

    References
    ----------
    T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989, chapter 5
    (shooting). P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos,
    Solitons & Fractals 5 (1995) 1671 (saltation matrices, of which the derivative is made).
    """
    start = at_period_zero(start)
    state, end, status = start, start, OK
    j11, j12, j21, j22 = 0.0, 0.0, 0.0, 0.0
    first_change, residual, best, size = math.inf, math.inf, math.inf, 0.0
    is_closed, iterations = False, 0
    for iteration in range(MAX_NEWTON):
        if iteration > 0:
            best = min(best, residual)
            state, is_inside = newton_step(e, p, state, end, j11, j12, j21, j22)
            if not is_inside:
                break
            iterations = iteration
        clear_log(log)
        end, status = march_periods(e, p, grid, state, m, log, c, EVENTS_PER_PERIOD * m)
        if status != OK and status != LOG_FULL:
            break
        dy, dw = gap_difference(e, p, end, state)
        change = abs(dy) + abs(dw)
        size = motion_norm(p, state, log)
        residual = change / size if size > 0.0 else 0.0
        if iteration == 0:
            first_change = change
            if residual > shooting.within:
                break
        j11, j12, j21, j22 = return_map_jacobian(e, p, log, state, end, m)
        stalls = residual >= best and residual <= 1e3 * CLOSURE_TOLERANCE
        if (residual <= shooting.closed or stalls) and (state.mode == REST) == (end.mode == REST):
            is_closed = True
            break
        if (
            iteration == 0
            and abs(floquet_multipliers(j11, j12, j21, j22)[0]) > shooting.max_multiplier
        ):
            break
        if iteration > 2 and residual > 0.5 * best:
            # Newton's method near an orbit gains digits at every step; a chance return does not.
            break
    dy, dw = gap_difference(e, p, state, start)
    return Orbit(
        is_closed,
        status,
        m,
        state,
        end,
        residual,
        (j11, j12, j21, j22),
        iterations,
        first_change,
        abs(dy) + abs(dw),
        size,
    )
