"""Where a flight turns back: the stationary points of a motion without supports."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.physics.flow import DEGREE, motion_with_curvature, steps_for_exact, taylor
from vibropipe.physics.load import force_at, forcing_period

# Bisections of a step: the last interval is below the rounding of theta.
BISECTIONS = 54


@jit
def _zero(c, derivative, low, high):
    """Return a zero on [low, high] of the first or second derivative of a polynomial, which changes sign there."""
    slope, curvature = motion_with_curvature(c, low)[1:]
    positive = (slope if derivative == 1 else curvature) > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        slope, curvature = motion_with_curvature(c, middle)[1:]
        if ((slope if derivative == 1 else curvature) > 0.0) == positive:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@jit_allocating
def flight_extremes(p, turn, x, v, n):
    """Return the least minimum and the largest maximum of x within a flight that passes through supports.

    Parameters
    ----------
    p : Parameters
    turn : float
        Phase at its start, in turns.
    x, v : float
        State at its start.
    n : int
        Its length in half forcing periods.

    Returns
    -------
    least, most : float
        Over the points strictly within the flight where x' changes sign; inf and -inf without such a point.

    Notes
    -----
    A step is at most half of the shortest time scale, so that x'' changes sign at most once in it: x' has a zero on
    either side of that point, or none.
    """
    steps = math.ceil(0.5 * n * steps_for_exact(p.nu, p.h))
    dt = 0.5 * n * forcing_period(p) / steps
    c, least, most = np.empty(DEGREE + 1), math.inf, -math.inf
    for step in range(steps):
        at = turn + 0.5 * n * step / steps
        taylor(c, x, v, force_at(p, 1.0, at - math.floor(at)), 0.0, p.h, p.nu, dt)
        _x, slope, curvature = motion_with_curvature(c, 0.0)
        end, end_slope, end_curvature = motion_with_curvature(c, 1.0)
        bend = _zero(c, 2, 0.0, 1.0) if curvature * end_curvature < 0.0 else 1.0
        bend_slope = motion_with_curvature(c, bend)[1]
        for low, high, before, after in (
            (0.0, bend, slope, bend_slope),
            (bend, 1.0, bend_slope, end_slope),
        ):
            if before * after < 0.0 or (before != 0.0 and after == 0.0 and low < high):
                extreme = motion_with_curvature(c, _zero(c, 1, low, high))[0]
                if before < 0.0:
                    least = min(least, extreme)
                else:
                    most = max(most, extreme)
        x, v = end, end_slope / dt
    return least, most
