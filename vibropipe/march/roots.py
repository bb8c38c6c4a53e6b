"""The first instant at which a polynomial gap closes, certified: no earlier one exists.

A gap is g(theta) = offset + sign * sum_{n >= p} c[n] theta^(n-p) on [0, span]; dividing by theta^p takes out
the known start on the support, so that no nudge off it is needed. The search marches from the left. Each
stride is as long as a parabola that lies below g stays positive, so it can not jump over a closing, and
near one it converges like Newton's method.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import evaluate
from vibropipe.march.log import EVALUATIONS

NONE, CROSSING, GRAZING, STRIDE_LIMIT = 0, 1, 2, 3
MAX_STRIDES = 400
MAX_POLISH = 12
MAX_GROWTHS = 600
# A gap that stays open by no more than this share of the lengths at hand is touching.
GRAZING_TOLERANCE = 2.0**-44
# Rounding of a gap's value, in the same lengths.
VALUE_ROUNDING = 2.0**-51
# What closes by no more than the rounding of a flight of some steps touches as well: without loss or force a mass
# comes back to the support on which it lost its speed to touch it, for ever. A deeper graze is an impact, however
# slow: its speed goes as the root of its depth, and is far above rounding.
MAX_GRAZING_DEPTH = 2.0**-48


@jit
def gap(c, power, sign, offset, theta):
    """Value, slope, curvature and third derivative of the gap at theta."""
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
    """Quick certificate: even with every opening term left out the gap does not close on [0, span]."""
    span_power, least = 1.0, offset + sign * c[power]
    for n in range(power + 1, c.size):
        span_power *= span
        least += min(0.0, sign * c[n] * span_power)
    return least > 0.0


@jit
def _fourth_derivative_bound(c, power, span):
    bound = 0.0
    for n in range(c.size - 1, power + 3, -1):
        k = n - power
        bound = bound * span + k * (k - 1) * (k - 2) * (k - 3) * abs(c[n])
    return bound


@jit
def _first_zero(a, b, curvature):
    """Smallest positive zero of a + b s + curvature s^2/2 with a > 0; inf if there is none."""
    square = b * b - 2.0 * a * curvature
    if square < 0.0 or (b >= 0.0 and curvature >= 0.0):
        return math.inf
    root = math.sqrt(square)
    if b >= 0.0:
        return (b + root) / -curvature
    return 2.0 * a / (root - b)


@jit
def _stride(value, slope, curvature, third, fourth, remaining):
    """How far the gap surely stays positive: the zero of a parabola below it, whose curvature holds over the
    way it is used for; that way is grown while the zero stays ahead. While the gap opens, slope and curvature
    both positive, the cubic below it is positive up to 3 curvature over the fall of the curvature.

    third: at the start; fourth: a bound. Near a tangent force all up to the third vanish together, and by a
    bound on the third alone the strides would be as short as its square.
    """
    fall = max(0.0, -third)
    most = fall + fourth * remaining
    if slope >= 0.0 and curvature * 3.0 >= most * remaining:
        return remaining
    stride = _first_zero(value, slope, curvature - most * remaining)
    if stride >= remaining:
        return remaining
    if slope >= 0.0 and curvature > 0.0:
        stride = max(stride, 3.0 * curvature / most)
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
    """Newton's method on the gap from just before its simple zero."""
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
    """Upper bound of the curvature of a gap on [0, span]."""
    curvature, power = sign * 2.0 * c[2], 1.0
    for n in range(3, c.size):
        power *= span
        curvature += max(0.0, sign * n * (n - 1) * c[n] * power)
    return curvature


@jit_inline
def unique_root(grid, c, sign, offset, first, last, span, distance) -> float:
    """Root of a gap with surely no more than one on [0, span], from `first` > 0 to `last` <= 0; -1 if not sure.

    The quick way: nearly all impacts arrive so. The gap falls all the way, or it is concave and stays below
    `distance` before. Newton's method from the root of the quadratic through both ends with the gap's initial slope.
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
        # Newton's error after this step is of the order of change^2: below rounding.
        if abs(change) <= 1e-9 * theta:
            return theta if first + max(slope, 0.0) * theta < distance else -1.0
    return -1.0


@jit_inline
def hop_end(grid, c, far, last, span) -> float:
    """End of a hop: of a gap that leaves 0 with speed and is bent back all the way to `last` <= 0 at `span`,
    short of the support at `far`; -1 if it is not surely of this kind.

    While the gap y is concave y/theta falls: its one root is found by Newton's method, from that of the cubic
    that the gap begins as.
    """
    if last > 0.0 or c[1] <= 0.0 or _max_curvature(c, 1.0, span) >= 0.0:
        return -1.0
    theta = 2.0 * c[1] / (math.sqrt(max(c[2] * c[2] - 4.0 * c[1] * c[3], 0.0)) - c[2])
    for _ in range(MAX_POLISH):
        theta = min(theta, span)
        y, w = evaluate(grid, c, theta)
        mean = y / theta
        change = y / (w * grid.dt - mean)
        theta -= change
        if abs(change) <= 1e-9 * theta:
            return theta if theta * c[1] < far else -1.0
    return -1.0


@jit
def _lengths(c, power, offset, load, theta):
    """Sum of the lengths that the gap over theta^p is made of at theta: what its rounding is a share of."""
    terms = 0.0
    for n in range(c.size - 1, power - 1, -1):
        terms = terms * theta + abs(c[n])
    # Past the start on the support the load acts by its acceleration alone.
    return abs(offset) + terms + abs(load) * (theta if power == 1 else 1.0)


@jit
def _whole_power(base, exponent):
    """base ** exponent for a whole exponent >= 0; numba's own can raise."""
    power = 1.0
    while exponent > 0:
        if exponent & 1:
            power *= base
        exponent >>= 1
        base *= base
    return power


@jit
def first_root(c, power, sign, offset, load, span, counts):
    """(theta, kind) of the first closing of the gap on (0, span]: NONE, CROSSING, GRAZING (touched with zero
    velocity, within rounding) or STRIDE_LIMIT (MAX_STRIDES reached). Adds the evaluations made to
    counts[EVALUATIONS]."""
    if stays_open(c, power, sign, offset, span):
        return span, NONE
    # Squares of very small motions would vanish: the search works on a gap of size 1, scaled by a power of two.
    _share, exponent = math.frexp(_lengths(c, power, offset, load, 1.0))
    unit = math.ldexp(1.0, min(-exponent, 1000))
    fourth = _fourth_derivative_bound(c, power, span) * unit
    theta, first = 0.0, 0.0
    for stride_number in range(MAX_STRIDES):
        value, slope, curvature, third = gap(c, power, sign, offset, theta)
        value, slope, curvature, third = value * unit, slope * unit, curvature * unit, third * unit
        counts[EVALUATIONS] += 1
        scale = _lengths(c, power, offset, load, theta) * unit
        touch, noise = GRAZING_TOLERANCE * scale, VALUE_ROUNDING * scale
        if stride_number == 0:
            first = 0.5 * value
        # Stopping short of zero by `shift` lets a graze be recognised from either side of it.
        shift = min(touch, first)
        remaining = span - theta
        # Strides of a falling gap that is within its rounding would get nowhere.
        if value - shift > (noise if slope < 0.0 else 0.0):
            stride = _stride(value - shift, slope, curvature, third, fourth, remaining)
            if stride >= remaining:
                return span, NONE
            theta += stride
            if stride > 2.0**-50 * theta:
                continue
        if curvature > 0.0:
            least = theta - slope / curvature
            depth = value - 0.5 * slope * slope / curvature
            if depth * _whole_power(max(least, 0.0), power) >= -MAX_GRAZING_DEPTH * scale:
                if least > span:
                    return span, NONE
                if least >= theta or power == 0:
                    return max(least, 0.0), GRAZING
        theta = _polish(c, power, sign, offset, theta, span)
        if theta > span:
            return span, NONE
        return theta, CROSSING
    return theta, STRIDE_LIMIT
