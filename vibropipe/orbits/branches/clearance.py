"""Whether the flights of an orbit stay between the supports: all turning points of each flight, certified."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.orbits.branches.sequence import next_impact
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.flow import DEGREE, REACH, fastest_rate, motion, taylor
from vibropipe.physics.load import fastest_of_row, force_at, forcing_period, has_second

# Share of a step of the polynomial below which it is not halved any more: velocity and acceleration are then zero
# together, and the point itself is taken as a turning point.
MIN_STEP_SHARE = 1e-9
MAX_BISECTIONS = 60


@jit
def _tail(c, first, factor_offset):
    """Return the sum of |c[n]| n (or n (n - 1) if factor_offset is 1) from n = first."""
    total = 0.0
    for n in range(DEGREE, first - 1, -1):
        total += abs(c[n]) * n * ((n - 1) if factor_offset == 1 else 1)
    return total


@jit
def _turning_theta(c, dt, w0):
    """Return the zero of the velocity in [0, 1], where it is monotone and changes sign, by bisection and secants."""
    low, high = 0.0, 1.0
    w_low, w_high = w0, motion(c, 1.0, dt)[1]
    theta = 0.5
    for iteration in range(MAX_BISECTIONS):
        theta = (low * w_high - high * w_low) / (w_high - w_low)
        if iteration % 3 == 2 or not low < theta < high:
            theta = 0.5 * (low + high)
        w = motion(c, theta, dt)[1]
        if w == 0.0:
            break
        if (w > 0.0) == (w_low > 0.0):
            low, w_low = theta, w
        else:
            high, w_high = theta, w
        if high - low < 1e-15:
            break
    return theta


@jit
def flight_clearance(p, start, end, support, v, c):
    """Return the least distance from a support at the turning points within a flight.

    Displacement is monotone between turning points, so a flight whose turning points are clear is clear. A step of the
    polynomial has no turning point if the first term of its velocity exceeds the sum of all others, and at most one if
    the same holds of the acceleration; it is halved until one of them holds.

    start, end : times in forcing periods
    support : the support that the flight leaves
    v : velocity of departure
    c : (DEGREE + 1,), work array

    Returns (gap, time, side):
    gap : negative beyond a support; the distance 2l of the supports if the flight does not turn towards one
    time : of that turning point
    side : its support; 0 if there is none, or if the mass is pressed on the support that it leaves at zero speed
    """
    sigma = -1.0 if support == 1 else 1.0
    period, load = forcing_period(p), -sigma * support_position(p, support)
    rate = REACH / fastest_rate(fastest_of_row(p), p.h) / period
    longest = (end - start) / max(1.0, math.ceil((end - start) / rate))
    y, w, time, step = 0.0, sigma * v, start, longest
    least, at, side = 2.0 * p.l, start, 0
    departs = True
    while time < end:
        step = min(step, end - time)
        if end - time - step < MIN_STEP_SHARE * longest:
            step = end - time
        dt = step * period
        if has_second(p):
            taylor(c, y, w, force_at(p, sigma, time, 1), load, p.h, p.nu, dt, 1)
        else:
            taylor(c, y, w, force_at(p, sigma, time), load, p.h, p.nu, dt)
        if departs and w <= 0.0:
            if c[2] <= 0.0:
                return c[2], time, 0
            # Without speed the mass leaves by its acceleration: the zero of the velocity at the start is no turn.
            w = 1e-300
        y1, w1 = motion(c, 1.0, dt)
        has_turn = abs(c[1]) <= _tail(c, 2, 0)
        is_short = step <= MIN_STEP_SHARE * longest
        if has_turn and not is_short and abs(c[2]) * 2.0 <= _tail(c, 3, 1):
            step *= 0.5
            continue
        if has_turn and ((w > 0.0) != (w1 > 0.0) or is_short) and not (departs and is_short):
            theta = _turning_theta(c, dt, w) if (w > 0.0) != (w1 > 0.0) else 0.0
            turn = time + theta * step
            height = motion(c, theta, dt)[0]
            # A maximum turns towards the far support, a minimum towards the near one.
            gap = 2.0 * p.l - height if w > 0.0 else height
            if is_short:
                gap = min(height, 2.0 * p.l - height)
            if gap < least and turn < end:
                least, at = gap, turn
                is_near = gap == height
                side = support if is_near else 3 - support
        y, w, departs = y1, w1, False
        time = end if end - time <= step else time + step
        step = min(longest, 2.0 * step)
    return least, at, side


@jit
def clearance(p, span, mirrored, supports, u, c):
    """Return the least distance from a support at the turning points of all flights.

    span, mirrored, supports, u : as for `fill_equations`
    c : (DEGREE + 1,), work array

    Returns gap, time and side as `flight_clearance` does, and the index of the flight; -1 if none turns towards a
    support.
    """
    n = supports.size
    gap, time, side, flight = 2.0 * p.l, 0.0, 0, -1
    for i in range(n):
        _j, end, _velocity, _support, _sign = next_impact(span, mirrored, supports, u, i)
        v = -restitution_at(p, supports[i]) * u[n + i]
        here, at, support = flight_clearance(p, u[i], end, np.int64(supports[i]), v, c)
        if here < gap:
            gap, time, side, flight = here, at, support, i
    return gap, time, side, flight
