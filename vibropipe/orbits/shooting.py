"""Shooting: periodic orbits as fixed points of the return map, found by Newton's method.

Stable and unstable orbits are found alike. `orbits.settling` decides whether a motion settles on an orbit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS, RESTS, TAILS, clear_log, is_spent, log_grazing
from vibropipe.march.loop import OK
from vibropipe.march.state import REST, State
from vibropipe.orbits.housing_jacobian import Coupling, coupling_of, no_coupling
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    gap_difference,
    march_periods,
    momentum_change,
    multipliers_of,
    newton_step,
    return_map_jacobian,
    state_xv,
)

# Largest number of Newton iterations; with quadratic convergence a few suffice.
MAX_NEWTON = 12
# Residual of a closed orbit, relative to the norm of the motion: about the rounding of a march.
CLOSURE_TOLERANCE = 1e-13
# Velocity below which an impact is a grazing, as a share of the norm of the motion.
SLOWEST_IMPACT = 1e-9
# Norm of a motion that is at its equilibrium, as a share of the distance from the support that its displacement is
# computed from: a few roundings of it; and a norm of which nearly all digits are lost.
STILL, TINY = 2.0**-50, 1e-300
# Largest number of events in a forcing period, which bounds the time of a march. It is a numpy integer because numba
# compiles another copy of the march for a literal constant.
EVENTS_PER_PERIOD = np.int64(100_000)


class Shooting(NamedTuple):
    """Bounds of Newton's method. Residuals are relative to the norm of the motion.

    within : largest residual of the start; beyond it no iteration is made
    max_multiplier : largest modulus of a multiplier at the start; beyond it no iteration is made
    closed : residual of a closed orbit. An orbit is also closed if its residual is small but decreases no more
    """

    within: float = math.inf
    max_multiplier: float = math.inf
    closed: float = CLOSURE_TOLERANCE


class Orbit(NamedTuple):
    """A fixed point of the return map, or the last iterate of Newton's method. Distances are |dx| + |dx'|.

    The log is left with the contacts from `state` to `end`.

    is_closed : whether the return map brings `state` back to itself within the tolerance
    status : `Status` of the last march. LOG_FULL: the log, and `derivative`, contain only the last contacts
    state, end : state at forcing period 0 of the orbit, and m periods later
    residual : distance from `state` to `end`, relative to `norm`
    derivative : Jacobian (j11, j12, j21, j22) of the return map by (x, x') at `state`; zero after a rest
    iterations : Newton steps made; 0 if the start lies on the orbit
    first_change : distance from the start to its image
    distance, image_distance : distance from the start to `state`, and from its image
    mismatch : distance of that image from the one that `derivative` predicts
    norm : norm of the motion (`motion_norm`)
    coupling : the rest of `derivative`, for the momentum of both bodies, where a housing may slide; distances then have
        its difference, too
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
    image_distance: float
    mismatch: float
    norm: float
    coupling: Coupling


@jit_inline
def motion_norm(p, state, log):
    """Return the norm of a marched motion: the largest of |x| + |x'| at its section and |x'| at its impacts.

    state : state at the section
    log : contacts of the motion
    """
    x, v = state_xv(p, state)
    norm = abs(x) + abs(v)
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        norm = max(norm, abs(log.velocity[i]))
    return norm


@jit
def count_as_grazings(log, norm) -> None:
    """Turn logged impacts that are slower than SLOWEST_IMPACT times the norm of the motion into grazings.

    Where an orbit grazes a support, rounding decides whether it strikes it, with a velocity that is rounding as well;
    the saltation matrix divides by it. Impacts before a rest are slow by nature, and are kept. Soft supports have no
    such matrix.
    """
    n = log.counts[IMPACTS]
    if log.pieces is not None or n > log.position.size:
        return
    if log.counts[RESTS] + log.counts[TAILS] > 0:
        return
    kept = 0
    for i in range(n):
        if abs(log.velocity[i]) < SLOWEST_IMPACT * norm:
            log_grazing(log, log.position[i], abs(log.support[i]))
            continue
        if kept < i:
            log.position[kept], log.velocity[kept] = log.position[i], log.velocity[i]
            log.impulse[kept], log.support[kept] = log.impulse[i], log.support[i]
        kept += 1
    log.counts[IMPACTS] = kept


@jit
def shoot(e, p, grid, start, m, shooting, log, c):
    """Find an orbit of m forcing periods near a state at the section.

    start : start of Newton's method, on a step of the grid (theta = 0)
    shooting : bounds of the iteration
    log, c : work space, as for `march`

    Returns an `Orbit`; it is not closed if Newton's method did not start, left the gap, stopped converging or is
    allowed no work.

    .. [1] T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989, chapter 5
       (shooting).
    .. [2] P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos, Solitons
       & Fractals 5 (1995) 1671 (saltation matrices).
    """
    start = at_period_zero(start)
    state, end, status = start, start, OK
    derivative, coupling, first_dp = (0.0, 0.0, 0.0, 0.0), no_coupling(), 0.0
    first_dy, first_dw, residual, best, norm = math.inf, math.inf, math.inf, math.inf, 0.0
    is_closed, iterations = False, 0
    for iteration in range(MAX_NEWTON):
        if is_spent(log):
            break
        if iteration > 0:
            best = min(best, residual)
            state, is_inside = newton_step(log.pieces, e, p, grid, state, end, derivative, coupling)
            if not is_inside:
                break
            iterations = iteration
        clear_log(log)
        end, status = march_periods(e, p, grid, state, m, log, c, EVENTS_PER_PERIOD * m)
        if status != OK and status != LOG_FULL:
            break
        dy, dw = gap_difference(e, p, end, state)
        dp = momentum_change(e, p, end, state)
        change = abs(dy) + abs(dw) + abs(dp)
        norm = motion_norm(p, state, log)
        count_as_grazings(log, norm)
        residual = change / norm if norm > STILL * abs(state.y) + TINY else 0.0
        if iteration == 0:
            first_dy, first_dw, first_dp = dy, dw, dp
            if residual > shooting.within:
                break
        derivative = return_map_jacobian(e, p, log, state, end, m)
        coupling = coupling_of(log.pieces)
        stalls = residual >= best and residual <= 1e3 * CLOSURE_TOLERANCE
        if (residual <= shooting.closed or stalls) and (state.mode == REST) == (end.mode == REST):
            is_closed = True
            break
        if iteration == 0:
            if abs(multipliers_of(derivative, coupling)[0]) > shooting.max_multiplier:
                break
        elif iteration > 2 and residual > 0.5 * best:
            # Near an orbit every Newton step gains digits; near a chance return it does not.
            break
    dy, dw = gap_difference(e, p, state, start)
    # The start and its image, as seen from the orbit, are (-dy, -dw) and (image_y, image_w).
    image_y, image_w = first_dy - dy, first_dw - dw
    dp = momentum_change(e, p, state, start)
    image_p, k, (j11, j12, j21, j22) = first_dp - dp, coupling, derivative
    mismatch = (
        abs(image_y + j11 * dy + j12 * dw + k.j13 * dp)
        + abs(image_w + j21 * dy + j22 * dw + k.j23 * dp)
        + abs(image_p + k.j31 * dy + k.j32 * dw + k.j33 * dp)
    )
    first_change = abs(first_dy) + abs(first_dw) + abs(first_dp)
    distance = abs(dy) + abs(dw) + abs(dp)
    image_distance = abs(image_y) + abs(image_w) + abs(image_p)
    return Orbit(
        is_closed, status, m, state, end, residual, derivative, iterations, first_change, distance,
        image_distance, mismatch, norm, coupling,
    )  # fmt: skip
