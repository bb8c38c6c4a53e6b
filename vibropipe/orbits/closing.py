"""Closing an orbit at a near return of the section, and deciding whether the motion settles on it."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.log import IMPACTS, RESTS, TAILS
from vibropipe.march.loop import OK
from vibropipe.orbits.housing_jacobian import has_coupling, no_coupling, solve_with_coupling
from vibropipe.orbits.recurrence import nearly_repeats
from vibropipe.orbits.return_map import gap_difference, momentum_change, multipliers_of
from vibropipe.orbits.shooting import CLOSURE_TOLERANCE, Orbit, Shooting, shoot
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import force_times

# Largest residual, relative to the norm of the motion, with which an orbit of multiple m repeats after a divisor of m.
DIVISOR_TOLERANCE = 1e-9
# Largest distance to an accepted orbit, in units of the last change per return divided by 1 - |multiplier|. The factor
# allows for non-normal derivatives, with which changes exceed the estimate from the multipliers.
NEWTON_REACH = 20.0
# Largest modulus of a multiplier with which Newton's method starts. Near a stable orbit no multiplier exceeds it;
# a chaotic motion passes unstable orbits, whose multipliers do, all the time.
MAX_TRIAL_MULTIPLIER = 2.0
# Distance of the modulus of a multiplier from 1 that is its rounding: nothing settles on an orbit that is neutral.
NEUTRAL = 2.0**-40
# Newton's correction of a closed orbit that is more than rounding, relative to the norm of the motion, and its largest
# size, in units of the overshoot of the slowest impact: one as large as this takes the impact away.
ROUNDED_CORRECTION, MAX_CORRECTION = 1e-12, 0.1


@jit
def least_overshoot(e, p, log):
    """Return the least v^2/2|a| of the logged impacts: how far the mass would go on, were there no support.

    v and a are velocity and acceleration before the impact. Impacts before a rest are slow by nature: inf with rests,
    and without impacts.
    """
    least = math.inf
    if log.counts[RESTS] + log.counts[TAILS] == 0:
        for i in range(min(log.counts[IMPACTS], log.position.size)):
            v = log.velocity[i]
            a = -support_position(p, log.support[i]) - p.h * v
            if e.forcing is not None:
                a += force_times(p, 1.0, log.position[i], e.second_harmonic)
            least = min(least, 0.5 * v * v / abs(a) if a != 0.0 else math.inf)
    return least


@jit
def is_located(e, p, orbit, log) -> bool:
    """Return whether a closed orbit, whose contacts the log holds, is known well enough for its impacts to be shown.

    An undamped motion may lose less and less in ever slower impacts, and never settle: it repeats the better the slower
    it is, and Newton's method finds nothing but the motion that touches no more. What tells it is the next correction
    |(I - J)^-1 r|, which would take the slowest impact away.
    """
    j11, j12, j21, j22 = orbit.derivative
    dy, dw = gap_difference(e, p, orbit.end, orbit.state)
    if has_coupling(orbit.coupling):
        dp = momentum_change(e, p, orbit.end, orbit.state)
        dy, dw, dp, determinant = solve_with_coupling(orbit.derivative, orbit.coupling, dy, dw, dp)
        correction = abs(dy) + abs(dw) + abs(dp)
        return determinant == 0.0 or correction <= max(
            ROUNDED_CORRECTION * orbit.norm, MAX_CORRECTION * least_overshoot(e, p, log)
        )
    a11, a22 = 1.0 - j11, 1.0 - j22
    determinant = a11 * a22 - j12 * j21
    if determinant == 0.0:
        return True
    correction = abs(a22 * dy + j12 * dw) + abs(j21 * dy + a11 * dw)
    correction /= abs(determinant)
    if correction <= ROUNDED_CORRECTION * orbit.norm:
        return True
    return correction <= MAX_CORRECTION * least_overshoot(e, p, log)


@jit
def settles_on(orbit) -> bool:
    """Return whether the motion that shooting started from settles on the orbit.

    The orbit must be stable and no further away than `NEWTON_REACH` times the last change divided by
    1 - |multiplier|: a fixed point beyond that is another orbit. The motion must also approach it: the last change is
    the one that the derivative at the orbit predicts, to within its own size, or leads nearer to the orbit. Where a
    motion passes a stable orbit slowly, next to an unstable one, it does neither. A motion that already repeats lies
    on its own orbit, stable or not.

    orbit : result of `shoot`
    """
    if not orbit.is_closed:
        return False
    if orbit.iterations == 0:
        return True
    radius = abs(multipliers_of(orbit.derivative, orbit.coupling)[0])
    reach = NEWTON_REACH * orbit.first_change / (1.0 - radius) if radius < 1.0 else 0.0
    if radius > 1.0 - NEUTRAL:
        return False
    rounding = CLOSURE_TOLERANCE * orbit.norm
    approaches = (
        orbit.mismatch <= orbit.first_change + rounding or orbit.image_distance < orbit.distance
    )
    return radius < 1.0 and approaches and orbit.distance <= reach + rounding


@jit
def reach_orbit(e, p, grid, state, m, within, closed, log, c):
    """Close the orbit of m periods next to a state and decide whether the motion settles on it.

    e, p, grid, log, c : as for `shoot`
    state : state at the section
    within, closed : bounds of `Shooting`: largest residual to start from, and residual of a closed orbit

    Returns whether the motion settles on the orbit, and the orbit, closed or not.
    """
    orbit = shoot(e, p, grid, state, m, Shooting(within, MAX_TRIAL_MULTIPLIER, closed), log, c)
    return settles_on(orbit) and is_located(e, p, orbit, log), orbit


@jit
def reduce_multiple(e, p, grid, orbit, log, c):
    """Close an orbit over its least period multiple.

    A motion that spirals in can nearly repeat after m periods before it does after a divisor of m. The log is left
    with the contacts of the returned orbit.

    e, p, grid, log, c : as for `shoot`
    orbit : a closed orbit that the motion settles on

    Returns whether the motion settles on the returned orbit, and that orbit, over its least multiple.
    """
    for m in range(1, orbit.m // 2 + 1):
        if orbit.m % m == 0:
            is_reached, least = reach_orbit(
                e, p, grid, orbit.state, m, DIVISOR_TOLERANCE, CLOSURE_TOLERANCE, log, c
            )
            if is_reached:
                return True, least
    if orbit.m == 1:
        return True, orbit
    is_reached, reclosed = reach_orbit(
        e, p, grid, orbit.state, orbit.m, DIVISOR_TOLERANCE, CLOSURE_TOLERANCE, log, c
    )
    if is_reached:
        return True, reclosed
    # The orbit was closed as far as rounding allows, not to CLOSURE_TOLERANCE, and Newton's method may lose it again
    # within that rounding. Keep the orbit as it was; another march with the same bits restores its log.
    return reach_orbit(e, p, grid, orbit.state, orbit.m, DIVISOR_TOLERANCE, orbit.residual, log, c)


@jit
def close_first_candidate(e, p, grid, state, sections, k, norm, largest, log, c):
    """Close the orbit of the least multiple that the section nearly repeats with and that the motion settles on.

    e, p, grid, log, c : as for `shoot`
    state : state at period k
    sections : tuple of (HISTORY_OFFSET + n,), sections (x, x', X') at the periods 0 to k, from HISTORY_OFFSET on
    k : forcing periods marched
    largest : largest multiple tried

    Returns the sum of the multiples that were tried, whether the motion settles on the orbit, and the orbit, which is
    not closed if no multiple was tried.
    """
    orbit = Orbit(
        False,
        OK,
        0,
        state,
        state,
        math.inf,
        (0.0, 0.0, 0.0, 0.0),
        0,
        math.inf,
        math.inf,
        math.inf,
        math.inf,
        0.0,
        no_coupling(),
    )
    trial_periods = 0
    for m in range(1, min(k, largest) + 1):
        if not nearly_repeats(sections, k, m, norm):
            continue
        trial_periods += m
        is_reached, orbit = reach_orbit(e, p, grid, state, m, math.inf, CLOSURE_TOLERANCE, log, c)
        if is_reached:
            is_reached, orbit = reduce_multiple(e, p, grid, orbit, log, c)
            if is_reached:
                return trial_periods, True, orbit
    return trial_periods, False, orbit
