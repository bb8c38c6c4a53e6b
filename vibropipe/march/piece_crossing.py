"""First roots and largest values on a polynomial piece, certified from both ends of the step where that is enough.

A polynomial whose coefficients show that it falls, or is concave or convex, over the step has no root or exactly one
there, which its values at the ends tell. Any other is searched as `roots.first_root` does.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.fast_path import MIN_SLOPE_RATIO
from vibropipe.march.log import EVALUATIONS
from vibropipe.march.roots import CROSSING, NONE, first_root, gap
from vibropipe.physics.contact import GRAZING_TOLERANCE
from vibropipe.physics.flow import DEGREE, motion_with_curvature

# Iterations of Halley's method, and its last correction as a share of the root: its cube is below rounding.
MAX_STEPS, LAST_STEP = 12, 2.0**-22
# Iterations for the place of a largest value, and the last one as a share of the step: its cube is below rounding.
MAX_PEAK_STEPS, LAST_PEAK_STEP = 40, 2.0**-18


@jit_inline
def first_guess(first, last, slope0, slope1):
    """Return about where on [0, 1] a gap is zero that has a sign at either end, as `fast_path.refine_root` does.

    By the cubic through both ends of the inverse of the gap or, of one that is steep at neither end, the parabola.
    """
    change = last - first
    if slope0 < MIN_SLOPE_RATIO * change and slope1 < MIN_SLOPE_RATIO * change:
        s = -first / change
        r = 1.0 - s
        return s * s * (1.0 + 2.0 * r) + s * r * (r * (change / slope0) - s * (change / slope1))
    root = math.sqrt(max(slope0 * slope0 - 4.0 * (change - slope0) * first, 0.0))
    return 2.0 * first / (root - slope0)


@jit_inline
def gap_with_curvature(c, power, sign, offset, theta):
    """Return value, slope and curvature of the gap at theta: those of `roots.gap`, sooner where it has all terms."""
    if power == 0 and c.size == DEGREE + 1:
        value, slope, curvature = motion_with_curvature(c, theta)
        return offset + sign * value, sign * slope, sign * curvature
    value, slope, curvature, _third = gap(c, power, sign, offset, theta)
    return value, slope, curvature


@jit
def refined(c, power, sign, offset, span, theta) -> float:
    """Return the one root of a gap on (0, span], positive at 0, by Halley's method in a bracket; 0 without success.

    theta : where to begin.
    """
    low, high = 0.0, span
    for _ in range(MAX_STEPS):
        if not low < theta < high:
            theta = 0.5 * (low + high)
        value, slope, curvature = gap_with_curvature(c, power, sign, offset, theta)
        if value > 0.0:
            low = theta
        else:
            high = theta
        inverse = 1.0 / slope
        newton = -value * inverse
        change = newton * (1.0 - 0.5 * newton * (curvature * inverse))
        theta += change
        if abs(change) <= LAST_STEP * theta:
            return theta
    return 0.0


@jit
def crossing(c, power, sign, offset, load, span, counts):
    """Locate the first root of a gap on (0, span]: arguments and results of `roots.first_root`."""
    first, start_slope, start_bend, reach = offset + sign * c[power], 0.0, 0.0, span
    if c.size > power + 1:
        start_slope = sign * c[power + 1] * span
    if c.size > power + 2:
        reach *= span
        start_bend = 2.0 * (sign * c[power + 2] * reach)
    # The further terms of the gap, of its slope times span and of its curvature times the square of it, at the end.
    # Within the step each is between zero and that: the sums lie between half their sums less and plus their sizes.
    last, slope, slopes, bend, bends = 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(3, c.size - power):
        reach *= span
        term = sign * c[n + power] * reach
        rate = n * term
        rate_change = (n - 1) * rate
        last += term
        slope += rate
        slopes += abs(rate)
        bend += rate_change
        bends += abs(rate_change)
    last += first + start_slope + 0.5 * start_bend
    slope, slopes = slope + start_bend, slopes + abs(start_bend)
    rounding = GRAZING_TOLERANCE * (
        abs(offset) + abs(c[power]) + abs(load) + abs(start_slope) + slopes
    )
    if not first > rounding or abs(last) <= rounding:
        return first_root(c, power, sign, offset, load, span, counts)
    middle_slope, middle_bend = start_slope + 0.5 * slope, start_bend + 0.5 * bend
    is_concave, is_convex = (
        middle_bend + 0.5 * bends < -rounding,
        middle_bend - 0.5 * bends > rounding,
    )
    falls = middle_slope + 0.5 * slopes < -rounding
    slope += start_slope
    if last > 0.0:
        # A convex gap lies above its tangents at both ends, which meet between them.
        meeting = first + start_slope * ((last - slope - first) / (start_slope - slope))
        is_above = start_slope >= 0.0 or slope <= 0.0 or meeting > rounding
        rises = middle_slope - 0.5 * slopes > rounding
        if falls or rises or is_concave or (is_convex and is_above):
            return span, NONE
    elif falls or is_concave or is_convex:
        theta = refined(
            c, power, sign, offset, span, span * first_guess(first, last, start_slope, slope)
        )
        counts[EVALUATIONS] += 1
        if 0.0 < theta <= span:
            return theta, CROSSING
    return first_root(c, power, sign, offset, load, span, counts)


@jit
def largest_value(c, sign, theta) -> float:
    """Return the largest value of sign times a polynomial from 0 to theta.

    It is at an end, or inside where the polynomial rises at the start and falls at the end.
    """
    first, rises = sign * c[0], sign * c[1]
    last, falls, bend = gap_with_curvature(c, 0, sign, 0.0, theta)
    # A value without slope at the start, as the speed of a housing that slips, may rise.
    if not (rises >= 0.0 and falls < 0.0):
        return max(first, last)
    low, high, at = 0.0, theta, 0.5 * theta
    if rises > 0.0:
        at = theta * first_guess(rises, falls, 2.0 * sign * c[2] * theta, bend * theta)
    value = last
    for _ in range(MAX_PEAK_STEPS):
        if not low < at < high:
            at = 0.5 * (low + high)
        value, slope, bend = gap_with_curvature(c, 0, sign, 0.0, at)
        if slope > 0.0:
            low = at
        else:
            high = at
        change = -slope / bend
        if abs(change) <= LAST_PEAK_STEP * theta:
            value += 0.5 * slope * change
            break
        at += change
    return max(value, max(first, last))
