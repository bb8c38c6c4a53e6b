"""Flight over any time in closed form, eq. (5): the free flow plus the response to the force, also at resonance."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load import (
    first_harmonic,
    first_response,
    force_at,
    forcing_period,
    has_second,
    second_harmonic,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import sincos_turns

# Modulus below which sinh(w)/w is summed from its series, whose first neglected term is then below 1e-18.
SERIES_REACH = 0.5
_SINHC = (1.0, 1 / 6, 1 / 120, 1 / 5040, 1 / 362880, 1 / 39916800, 1 / 6227020800)


@jit
def exponential(z: complex) -> complex:
    """Return exp(z)."""
    size = math.exp(z.real)
    return complex(size * math.cos(z.imag), size * math.sin(z.imag))


@jit
def _exponential_difference(a: complex, b: complex, t: float, forced: complex) -> complex:
    """Return the divided difference (exp(a t) - exp(b t)) / (a - b), also where a is b; forced is exp(a t)."""
    half = 0.5 * t * (a - b)
    if abs(half) > SERIES_REACH:
        return divide(forced - exponential(b * t), a - b)
    square, total = half * half, complex(0.0, 0.0)
    for n in range(len(_SINHC) - 1, -1, -1):
        total = total * square + _SINHC[n]
    return t * exponential(0.5 * t * (a + b)) * total


@jit
def force_response(
    h: float, nu: float, turns: float, t: float, odd: float
) -> tuple[complex, complex]:
    """Return the motion y'' + h y' + y = exp(i nu tau) that starts at rest, and its rate, after a time t.

    The motion is the divided difference of exp(s t) over s = i nu and the roots s1, s2 of s^2 + h s + 1. Taken first
    over i nu and the root s1 next to it, then over s1 and s2 (which is e12), it keeps its digits at resonance without
    damping and at critical damping, where the difference of steady and free motion cancels: |i nu - s2| is at least 1.

    h, nu : damping and frequency of the force
    turns, t : the time in forcing periods and in tau
    odd : element e12 of `free_flow` over t

    Reference: C. de Boor, "Divided differences", Surveys in Approximation Theory 1 (2005) 46-69.
    """
    b = 0.5 * h
    square = (1.0 - b) * (1.0 + b)
    if square > 0.0:
        root = math.sqrt(square)
        near, far = complex(-b, root), complex(-b, -root)
    else:
        root = math.sqrt(-square)
        near, far = complex(-1.0 / (b + root), 0.0), complex(-(b + root), 0.0)
    rate = complex(0.0, nu)
    sine, cosine = sincos_turns(turns)
    first = _exponential_difference(rate, near, t, complex(cosine, sine))
    y = divide(first - odd, rate - far)
    return y, rate * y + odd


@jit
def acceleration(p, x: float, v: float, turn: float) -> float:
    """Return x'' of eq. (5) at the phase `turn`, in turns."""
    return (first_harmonic(p, turn) - p.h * v - x) + second_harmonic(p, turn)


@jit
def _fly_under_two(p, start: float, end: float, x: float, v: float):
    """Return `fly_freely` under two harmonics."""
    turns = end - start
    t = turns * forcing_period(p)
    e11, e12, e21, e22 = free_flow(p.h, t)
    at = force_at(p, 1.0, start, 1)
    first, first_rate = force_response(p.h, p.nu, turns, t, e12)
    second, second_rate = force_response(p.h, 2.0 * p.nu, 2.0 * turns, t, e12)
    x1, v1 = e11 * x + e12 * v, e21 * x + e22 * v
    x1 += at.cosine * first.imag + at.sine * first.real
    v1 += at.cosine * first_rate.imag + at.sine * first_rate.real
    x1 += at.cosine_2 * second.imag + at.sine_2 * second.real
    v1 += at.cosine_2 * second_rate.imag + at.sine_2 * second_rate.real
    return x1, v1, e11, e12, e21, e22


@jit
def fly_freely(p, start: float, end: float, x: float, v: float):
    """Return the state after a flight without contact, and its derivative by the state at the start.

    start, end : times in forcing periods
    x, v : state at the start

    Returns the state (x, v) at the end, and the matrix (e11, e12, e21, e22) of `free_flow`.
    """
    if has_second(p):
        return _fly_under_two(p, start, end, x, v)
    turns = end - start
    t = turns * forcing_period(p)
    e11, e12, e21, e22 = free_flow(p.h, t)
    response, rate = force_response(p.h, p.nu, turns, t, e12)
    sine, cosine = sincos_turns(start)
    x1 = (e11 * x + e12 * v) + first_response(p, sine, cosine, response)
    v1 = (e21 * x + e22 * v) + first_response(p, sine, cosine, rate)
    return x1, v1, e11, e12, e21, e22
