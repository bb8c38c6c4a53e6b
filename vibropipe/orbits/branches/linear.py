"""The branch of the motion without impacts, in closed form, up to where it touches a support."""

from __future__ import annotations

import cmath
import math

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.march.piece_log import HOME
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.problem import Problem
from vibropipe.physics.contact import support_offset, support_position
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.linear import linear_amplitude, second_linear_amplitude
from vibropipe.physics.load import has_second
from vibropipe.physics.turns import TWO_PI

# Points over the range of the parameter, and iterations that locate a zero or a minimum of the gap.
LINEAR_POINTS, MAX_ITERATIONS = 64, 200


def linear_state(p: Parameters) -> tuple[float, float]:
    """Return displacement, counted from the equilibrium, and velocity of the motion without impacts at the phase 0."""
    first, second = linear_amplitude(p), second_linear_amplitude(p)
    return 2.0 * (first + second).real, -2.0 * p.nu * (first + 2.0 * second).imag


def linear_extremes(p: Parameters) -> dict[int, tuple[float, float]]:
    """Return for each support the distance of the motion without impacts, and its phase at the nearest point.

    With z = exp(i nu tau) the velocity of 2 Re(X z + Y z^2) is zero where 2 Y z^4 + X z^3 - X* z - 2 Y* = 0.
    """
    first, second = linear_amplitude(p), second_linear_amplitude(p)
    roots = np.roots([2 * second, first, 0, -first.conjugate(), -2 * second.conjugate()])
    z = roots / np.abs(roots)
    x = 2 * (first * z + second * z**2).real
    turns = np.angle(z) / TWO_PI % 1.0
    top, bottom = int(np.argmax(x)), int(np.argmin(x))
    upper, lower = support_position(p, 1), support_position(p, 2)
    return {
        1: (float(upper - x[top]), float(turns[top])),
        2: (float(x[bottom] - lower), float(turns[bottom])),
    }


def linear_touch(p: Parameters) -> tuple[int, float]:
    """Return the support that the motion without impacts comes nearest to, and its phase there; 1 if both."""
    if has_second(p):
        extremes = linear_extremes(p)
        support = min(extremes, key=lambda each: extremes[each][0])
        return support, extremes[support][1]
    # x = 2 Re(X exp(i nu tau)) is largest where the phase of X is made up.
    top = (-cmath.phase(linear_amplitude(p)) / TWO_PI) % 1.0
    return (2, top + 0.5) if support_offset(p) > 0.0 else (1, top)


def linear_gap(problem: Problem, value: float) -> float:
    """Return the least distance of the motion without impacts from a support.

    With one harmonic it is l - |delta - load| - 2 |X|.
    """
    p = problem.parameters_at(value)
    if has_second(p):
        amplitudes = linear_amplitude(p), second_linear_amplitude(p)
        if not all(map(cmath.isfinite, amplitudes)):
            return -math.inf
        return min(distance for distance, _turn in linear_extremes(p).values())
    return p.l - abs(support_offset(p)) - 2.0 * abs(linear_amplitude(p))


def _zero(problem: Problem, inside: float, outside: float) -> float:
    """Return where the gap closes, by bisection; on the side where it is open."""
    for _ in range(MAX_ITERATIONS):
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        if linear_gap(problem, middle) > 0.0:
            inside = middle
        else:
            outside = middle
    return inside


def _least(problem: Problem, low: float, high: float) -> float:
    """Return where the gap is least between two values, by golden sections."""
    ratio = 0.5 * (math.sqrt(5.0) - 1.0)
    first, second = high - ratio * (high - low), low + ratio * (high - low)
    for _ in range(MAX_ITERATIONS):
        if linear_gap(problem, first) < linear_gap(problem, second):
            high, second = second, first
            first = high - ratio * (high - low)
        else:
            low, first = first, second
            second = low + ratio * (high - low)
        if min(linear_gap(problem, first), linear_gap(problem, second)) <= 0.0:
            break
    return first if linear_gap(problem, first) < linear_gap(problem, second) else second


def follow_linear(problem: Problem, value: float, sign: float) -> tuple[list[float], bool]:
    """Follow the motion without impacts from a value of the parameter, upwards or downwards.

    value : where its gap is open
    sign : 1 or -1

    Returns the parameter at the points after the start, and whether the motion touches a support at the last of them;
    else that is the limit of the range.
    """
    limit = problem.high if sign > 0 else problem.low
    if sign * (limit - value) <= 0.0:
        return [], False
    step = (problem.high - problem.low) / LINEAR_POINTS
    n = max(2, math.ceil(abs(limit - value) / step))
    wanted = [at for at in problem.at if 0.0 < sign * (at - value) < sign * (limit - value)]
    grid = [*np.linspace(value, limit, n + 1)[1:-1].tolist(), limit, *wanted]
    ordered = sorted({value, *grid}, key=lambda each: sign * each)
    gaps = [linear_gap(problem, each) for each in ordered]
    values: list[float] = []
    for k in range(1, len(ordered)):
        if gaps[k] <= 0.0:
            return [*values, _zero(problem, ordered[k - 1], ordered[k])], True
        after = ordered[k + 1] if k + 1 < len(ordered) else ordered[k]
        if gaps[k] < gaps[k - 1] and (k + 1 == len(ordered) or gaps[k] <= gaps[k + 1]):
            least = _least(problem, *sorted((ordered[k - 1], after)))
            if linear_gap(problem, least) <= 0.0:
                if sign * (least - ordered[k]) > 0.0:
                    values.append(ordered[k])
                inside = values[-1] if values else value
                return [*values, _zero(problem, inside, least)], True
        values.append(ordered[k])
    return values, False


def touches_both(p: Parameters) -> bool:
    """Return whether the motion without impacts touches both supports if it touches one."""
    return support_offset(p) == 0.0 and not has_second(p)


def speed_of_struck(p: Parameters) -> float:
    """Return a scale of impact velocities next to where the motion without impacts touches: its largest velocity."""
    amplitude = abs(linear_amplitude(p))
    amplitude += 2.0 * abs(second_linear_amplitude(p)) if has_second(p) else 0.0
    return max(2.0 * p.nu * amplitude, p.l)


def begin_struck(curve: LawCurve, u: list[float], index: int) -> tuple[LawCurve, Point] | None:
    """Return a branch at its point where the impact `index` has no speed, with its tangent towards impacts."""
    n = len(curve.sequence.supports)
    start = curve.settle(np.array(u), n + index)
    if start is None:
        return None
    if curve.sequence.codes[index, HOME] == 2:
        start = start.reversed()
    return curve, start
