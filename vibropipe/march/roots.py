"""First contact of a polynomial gap: certified event location, no earlier contact exists.

A gap is g(theta) = offset + sign * sum(c[n] * theta**(n - power), n >= power) on [0, span]. Dividing by theta**power
removes the known zero of a departure from the support, so no nudge off it is needed. The search marches from the
left. Each stride ends where a parabola below g reaches zero, so it cannot skip a root; near a root the strides
converge like Newton's method.

A polynomial c has shape (DEGREE + 1,), of the exact method, or (3,), of Newmark's; theta and span are in steps of the
grid.

References
----------
L. F. Shampine, S. Thompson, "Event location for ordinary differential equations", Computers & Mathematics with
Applications 39 (2000) 43-54: why a first event needs more than a change of sign.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import evaluate
from vibropipe.march.log import EVALUATIONS
from vibropipe.physics.contact import GRAZING_TOLERANCE

NONE, CROSSING, GRAZING, STRIDE_LIMIT = 0, 1, 2, 3
# Iterations of the search, of Newton's method on a root, and of the growth of one stride (by factors of 4, enough for
# all exponents of a float). The searches of motions end far below them.
MAX_STRIDES = 400
MAX_POLISH = 12
MAX_GROWTHS = 600
# Rounding of a gap's value, as a share of the lengths that it is computed from.
VALUE_ROUNDING = 2.0**-51
# Largest penetration that counts as grazing, as a share of the same lengths: the rounding of a flight of some steps.
# Without damping and force a mass that lost its speed at a support grazes it again and again. A deeper contact is an
# impact: its velocity goes as the root of the depth and is far above rounding.
MAX_GRAZING_DEPTH = 2.0**-48


@jit
def gap(c, power, sign, offset, theta):
    """Return value, slope, curvature and third derivative of the gap at theta."""
    degree = c.size - 1
    value, slope, half, sixth = c[degree], 0.0, 0.0, 0.0
    for n in range(degree - 1, power - 1, -1):
        sixth = sixth * theta + half
        half = half * theta + slope
        slope = slope * theta + value
        value = value * theta + c[n]
    return offset + sign * value, sign * slope, 2.0 * sign * half, 6.0 * sign * sixth


@jit
def stays_open(c, power, sign, offset, span) -> bool:
    """Return whether the gap is positive on [0, span] even without the terms that open it."""
    span_power, lower_bound = 1.0, offset + sign * c[power]
    for n in range(power + 1, c.size):
        span_power *= span
        lower_bound += min(0.0, sign * c[n] * span_power)
    return lower_bound > 0.0


@jit
def _fourth_derivative_bound(c, power, span):
    """Return an upper bound of |g''''| on [0, span]."""
    bound = 0.0
    for n in range(c.size - 1, power + 3, -1):
        k = n - power
        bound = bound * span + k * (k - 1) * (k - 2) * (k - 3) * abs(c[n])
    return bound


@jit
def _first_zero(a, b, curvature):
    """Return the smallest positive zero of a + b s + curvature s^2/2, a > 0; inf if there is none."""
    discriminant = b * b - 2.0 * a * curvature
    if discriminant < 0.0 or (b >= 0.0 and curvature >= 0.0):
        return math.inf
    root = math.sqrt(discriminant)
    if b >= 0.0:
        return (b + root) / -curvature
    return 2.0 * a / (root - b)


@jit
def _stride(value, slope, curvature, third, fourth, remaining):
    """Return a distance over which the gap stays positive.

    It is the zero of a parabola below the gap, whose curvature is valid over a trial stride; the trial stride grows
    while the zero lies beyond it. While the gap opens with a positive curvature, a cubic below it is positive up to 3
    curvature / (largest fall of the curvature per length).

    third : value at the start, fourth : bound. Near a tangent release all derivatives up to the third vanish together;
    a bound of the third alone would make the strides as short as its square.
    """
    fall = max(0.0, -third)
    max_fall = fall + fourth * remaining
    if slope >= 0.0 and curvature * 3.0 >= max_fall * remaining:
        return remaining
    stride = _first_zero(value, slope, curvature - max_fall * remaining)
    if stride >= remaining:
        return remaining
    if slope >= 0.0 and curvature > 0.0:
        stride = max(stride, 3.0 * curvature / max_fall)
    trial_stride = 2.0 * stride
    for _ in range(MAX_GROWTHS):
        trial_stride = min(trial_stride, remaining)
        zero = _first_zero(
            value, slope, curvature - (fall + 0.5 * fourth * trial_stride) * trial_stride
        )
        if zero < trial_stride:
            return max(stride, zero)
        if trial_stride == remaining:
            return remaining
        stride = trial_stride
        trial_stride *= 4.0
    return stride


@jit
def _polish(c, power, sign, offset, theta, span):
    """Return a simple zero of the gap by Newton's method, from a theta just before it."""
    for _ in range(MAX_POLISH):
        value, slope, _curvature, _third = gap(c, power, sign, offset, theta)
        if slope >= 0.0:
            break
        change = -value / slope
        theta += change
        if abs(change) <= 2.0**-53 * theta:
            break
    return min(max(theta, 0.0), 2.0 * span)


@jit
def _max_curvature(c, sign, span) -> float:
    """Return an upper bound of the curvature of a gap on [0, span]."""
    curvature, power = sign * 2.0 * c[2], 1.0
    for n in range(3, c.size):
        power *= span
        curvature += max(0.0, sign * n * (n - 1) * c[n] * power)
    return curvature


@jit_inline
def unique_root(grid, c, sign, offset, first, last, span, distance) -> float:
    """Return the root of a gap that certainly has one root on [0, span]; -1 if this is not certain.

    Nearly all impacts are located here. The gap falls throughout, or it is concave and stays below `distance`, the
    distance between the supports. Newton's method starts from the root of the quadratic through both ends with the
    initial slope of the gap.

    first, last : values of the gap at 0 (> 0) and span; sign, offset : as in `first_root`.
    """
    slope = sign * c[1]
    if last > 0.0:
        return -1.0
    rise = slope
    for n in range(2, c.size):
        rise += max(0.0, sign * n * c[n])
    if rise >= 0.0 and _max_curvature(c, sign, span) >= 0.0:
        return -1.0
    curvature = ((last - first) / span - slope) / span
    theta = 2.0 * first / (math.sqrt(max(slope * slope - 4.0 * curvature * first, 0.0)) - slope)
    for _ in range(MAX_POLISH):
        y, w = evaluate(grid, c, theta)
        change = (offset + sign * y) / (sign * w * grid.dt)
        theta = min(max(theta - change, 0.0), span)
        # The error after this step is of the order of change^2: below rounding.
        if abs(change) <= 1e-9 * theta:
            return theta if first + max(slope, 0.0) * theta < distance else -1.0
    return -1.0


@jit_inline
def hop_end(grid, c, far, last, span) -> float:
    """Return the end of a hop; -1 if the hop is not certainly of this kind.

    The mass leaves the near support with speed (y = 0 at theta = 0), its gap is concave, y(span) = last <= 0, and it
    stays short of the support at `far`. While y is concave y/theta falls: Newton's method finds its one root, from that
    of the cubic Taylor polynomial.
    """
    if last > 0.0 or c[1] <= 0.0 or _max_curvature(c, 1.0, span) >= 0.0:
        return -1.0
    theta = 2.0 * c[1] / (math.sqrt(max(c[2] * c[2] - 4.0 * c[1] * c[3], 0.0)) - c[2])
    for _ in range(MAX_POLISH):
        theta = min(theta, span)
        y, w = evaluate(grid, c, theta)
        quotient = y / theta
        change = y / (w * grid.dt - quotient)
        theta -= change
        if abs(change) <= 1e-9 * theta:
            return theta if theta * c[1] < far else -1.0
    return -1.0


@jit
def _lengths(c, power, offset, load, theta):
    """Return the sum of the magnitudes that the gap over theta**power is computed from: the scale of its rounding."""
    terms = 0.0
    for n in range(c.size - 1, power - 1, -1):
        terms = terms * theta + abs(c[n])
    # A gap from its support is divided by theta**power: the load acts through the acceleration alone.
    return abs(offset) + terms + abs(load) * (theta if power == 1 else 1.0)


@jit
def _whole_power(base, exponent):
    """Return base ** exponent for an integer exponent >= 0; numba's own power can raise."""
    power = 1.0
    while exponent > 0:
        if exponent & 1:
            power *= base
        exponent >>= 1
        base *= base
    return power


@jit
def first_root(c, power, sign, offset, load, span, counts):
    """Locate the first contact of a polynomial gap on (0, span].

    c : (DEGREE + 1,) or (3,)
    power : power of theta that the gap is divided by: the `State.mode` of a departure, 0 in flight
    sign, offset : 1 and -near for the near support, -1 and far for the far one; offset 0 where power > 0
    load : constant load of the frame, for the scale of rounding only
    span : end of the search, in steps
    counts : counts[EVALUATIONS] grows by the evaluations made

    Returns theta, and NONE (theta = span), CROSSING, GRAZING (zero velocity within rounding) or STRIDE_LIMIT (after
    MAX_STRIDES).
    """
    if stays_open(c, power, sign, offset, span):
        return span, NONE
    # Squares of very small motions underflow: the search works on a gap scaled to size 1 by a power of two.
    _share, exponent = math.frexp(_lengths(c, power, offset, load, 1.0))
    unit = math.ldexp(1.0, min(-exponent, 1000))
    fourth = _fourth_derivative_bound(c, power, span) * unit
    theta, first = 0.0, 0.0
    for stride_number in range(MAX_STRIDES):
        value, slope, curvature, third = gap(c, power, sign, offset, theta)
        value, slope, curvature, third = value * unit, slope * unit, curvature * unit, third * unit
        counts[EVALUATIONS] += 1
        scale = _lengths(c, power, offset, load, theta) * unit
        max_opening, rounding = GRAZING_TOLERANCE * scale, VALUE_ROUNDING * scale
        if stride_number == 0:
            first = 0.5 * value
        # Strides end at a value of `shift` instead of zero, so a grazing is recognised from either side.
        shift = min(max_opening, first)
        remaining = span - theta
        # A falling gap within its rounding ends the search: strides would be zero.
        if value - shift > (rounding if slope < 0.0 else 0.0):
            stride = _stride(value - shift, slope, curvature, third, fourth, remaining)
            if stride >= remaining:
                return span, NONE
            theta += stride
            if stride > 2.0**-50 * theta:
                continue
        if curvature > 0.0:
            theta_min = theta - slope / curvature
            depth = value - 0.5 * slope * slope / curvature
            if depth * _whole_power(max(theta_min, 0.0), power) >= -MAX_GRAZING_DEPTH * scale:
                if theta_min > span:
                    return span, NONE
                if theta_min >= theta or power == 0:
                    return max(theta_min, 0.0), GRAZING
        theta = _polish(c, power, sign, offset, theta, span)
        if theta > span:
            return span, NONE
        return theta, CROSSING
    return theta, STRIDE_LIMIT
