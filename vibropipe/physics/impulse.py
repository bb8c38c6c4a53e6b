"""Responses of a linear piece y'' + H y' + K y from rest: to an impulse, to a load, and to a force exp(i w tau).

With q(s) = s^2 + H s + K each is a divided difference of exp(s t) over the roots of q and further nodes: S = 1/q is the
response to an impulse, G = 1/(s q) to a load, W = 1/((s - i w) q) to exp(i w tau). Derivatives by K and H have q^2 in
place of q. Short spans are summed from series, so that quotients by powers of the span keep their digits.

References
----------
C. de Boor, "Divided differences", Surveys in Approximation Theory 1 (2005) 46-69.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.physics.flow import free_flow
from vibropipe.physics.quotient import divide
from vibropipe.physics.stiffness import piece_rate
from vibropipe.physics.turns import sincos_turns

# Product of the fastest rate and the span below which functions are summed from their series, and its terms; further
# bounds below which fewer reach rounding.
SHORT, TERMS = 1.0, 24
FEWER_TERMS = ((0.3, 15), (0.1, 13), (0.01, 9), (1e-4, 6))
# Product of rates and span below which quotients of differences are summed from series.
NEAR = 0.5
# Share of the dynamic stiffness below which a force is near resonance.
RESONANT = 0.1
# Modulus below which sinh(w)/w is summed from its series, whose first neglected term is then below 1e-18.
SERIES_REACH = 0.5
_SINHC = (1.0, 1 / 6, 1 / 120, 1 / 5040, 1 / 362880, 1 / 39916800, 1 / 6227020800)


class Impulse(NamedTuple):
    """Responses of a piece from rest at a time.

    c, s, ds : motion from a unit displacement, from a unit velocity, and the rate of the latter
    g : motion under a unit load
    """

    c: float
    s: float
    ds: float
    g: float


class Square(NamedTuple):
    """The `Impulse` of 1/q^2: minus the derivatives of `s`, `ds` and `g` by the stiffness."""

    s: float
    ds: float
    g: float


@jit
def terms_within(reach: float) -> int:
    """Return how many terms of a series give all digits at a product of the fastest rate and the span below SHORT."""
    terms = TERMS
    for limit, fewer in FEWER_TERMS:
        if reach < limit:
            terms = fewer
    return terms


@jit
def impulse_response(stiffness: float, damping: float, t: float) -> Impulse:
    """Return the `Impulse` at the time t; negative times only as far as they are short."""
    reach = piece_rate(stiffness, damping) * abs(t)
    if reach < SHORT:
        return _impulse_series(stiffness, damping, t, reach)
    root = math.sqrt(stiffness)
    c, odd, _minus, ds = free_flow(damping / root, root * t)
    return Impulse(c, odd / root, ds, (1.0 - c) / stiffness)


@jit
def _impulse_series(stiffness, damping, t, reach):
    """Return the `Impulse` at a short time."""
    s, ds, g = 0.0, 0.0, 0.0
    e, before, term = 1.0, 0.0, 1.0
    # term is t^n / n!; e is the coefficient of 1/q in powers of 1/s.
    for n in range(terms_within(reach)):
        one = term * t / (n + 1)
        ds += e * term
        s += e * one
        g += e * one * t / (n + 2)
        e, before = -damping * e - stiffness * before, e
        term = one
    return Impulse(1.0 - stiffness * g, s, ds, g)


@jit
def square_response(stiffness: float, damping: float, t: float, free: Impulse) -> Square:
    """Return the `Square` at the time t; free : of that time."""
    reach = piece_rate(stiffness, damping) * abs(t)
    if reach < SHORT:
        return _square_series(stiffness, damping, t, reach)
    k, root = stiffness, math.sqrt(stiffness)
    b, scaled, odd = 0.5 * damping / root, root * t, root * free.s
    even, share = free.ds + b * odd, (1.0 - b) * (1.0 + b)
    z = share * scaled * scaled
    if abs(z) < NEAR:
        # The sum of (-z)^n (2n + 2) / (2n + 3)! by Horner's rule, each term over the one before.
        total = 0.0
        for n in range(8, -1, -1):
            total = 1.0 - total * z * (n + 2) / ((n + 1) * (2 * n + 4) * (2 * n + 5))
        s = math.exp(-b * scaled) * scaled * scaled * scaled * total / 6.0
    else:
        s = 0.5 * (odd - scaled * even) / share
    ds = 0.5 * scaled * odd - b * s
    g = (1.0 - free.c) - ds - 2.0 * b * s
    return Square(s / (root * k), ds / k, g / (k * k))


@jit
def free_flow_by_h(h: float, t: float):
    """Return the derivative of the matrix of `flow.free_flow` by h, as (e11, e12, e21, e22)."""
    free = impulse_response(1.0, h, t)
    square = square_response(1.0, h, t, free)
    return square.s, -square.ds, square.ds, -(free.s - h * square.ds - square.s)


@jit
def _square_series(stiffness, damping, t, reach):
    """Return the `Square` at a short time."""
    s, ds, g = 0.0, 0.0, 0.0
    e, before, e2, before2, term = 1.0, 0.0, 1.0, 0.0, 1.0
    # term is t^n / n!; e and e2 are the coefficients of 1/q and 1/q^2 in powers of 1/s.
    for n in range(terms_within(reach)):
        one = term * t / (n + 1)
        two = one * t / (n + 2)
        three = two * t / (n + 3)
        ds += e2 * two
        s += e2 * three
        g += e2 * three * t / (n + 4)
        e, before = -damping * e - stiffness * before, e
        e2, before2 = e - damping * e2 - stiffness * before2, e2
        term = one
    return Square(s, ds, g)


@jit
def _two_nodes(one: complex, other: complex, t: float) -> complex:
    """Return the divided difference of exp(s t) over (one, one, other), also where they are close."""
    delta = (other - one) * t
    if abs(delta) < NEAR:
        total = complex(1.0, 0.0)
        for n in range(16, 0, -1):
            # By its parts: a division of complex numbers may raise.
            more = delta * total
            total = complex(1.0 + more.real / (n + 2), more.imag / (n + 2))
        return 0.5 * t * t * exponential(one * t) * total
    change = other - one
    return divide(exponential(other * t) - exponential(one * t) * (1.0 + delta), change * change)


@jit
def reach_of(stiffness: float, damping: float, w: float, t: float) -> float:
    """Return the product of the fastest rate and the time t of a response to exp(i w tau)."""
    return max(piece_rate(stiffness, damping), w) * abs(t)


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
def harmonic_motion(
    stiffness: float, damping: float, w: float, turns: float, t: float, s: float
) -> complex:
    """Return the response W from rest to exp(i w tau) at the time t.

    turns : t in periods of w; s : that of the `Impulse` at t.
    """
    reach = reach_of(stiffness, damping, w, t)
    if reach < SHORT:
        return _harmonic_series(stiffness, damping, w, t, reach)
    root = math.sqrt(stiffness)
    y, _rate = force_response(damping / root, w / root, turns, root * t, root * s)
    return complex(y.real / stiffness, y.imag / stiffness)


@jit
def _roots(stiffness, damping):
    """Return the roots of q, that next to the imaginary axis from above first."""
    root = math.sqrt(stiffness)
    b = 0.5 * damping / root
    square = (1.0 - b) * (1.0 + b)
    if square > 0.0:
        near, far = complex(-b, math.sqrt(square)), complex(-b, -math.sqrt(square))
    else:
        near = complex(-1.0 / (b + math.sqrt(-square)), 0.0)
        far = complex(-(b + math.sqrt(-square)), 0.0)
    return root * near, root * far, square


@jit
def motion_by_rate(
    stiffness: float, damping: float, w: float, t: float, response: complex
) -> complex:
    """Return 1/((s - i w)^2 q) at the time t, the derivative of W by i w; response : W."""
    reach = reach_of(stiffness, damping, w, t)
    if reach < SHORT:
        return _rate_series(stiffness, damping, w, t, reach)
    near, far, _square = _roots(stiffness, damping)
    iw = complex(0.0, w)
    return divide(_two_nodes(iw, near, t) - response, iw - far)


@jit
def square_motion(
    stiffness: float,
    damping: float,
    w: float,
    t: float,
    response: complex,
    s: float,
    square: Square,
) -> complex:
    """Return 1/((s - i w) q^2) at the time t; response, s, square : W, that of the `Impulse`, and the `Square`."""
    reach = reach_of(stiffness, damping, w, t)
    if reach < SHORT:
        return _square_motion_series(stiffness, damping, w, t, reach)
    root, iw = math.sqrt(stiffness), complex(0.0, w)
    near, far, share = _roots(stiffness, damping)
    dynamic = complex((root - w) * (root + w), damping * w)
    if abs(dynamic) > RESONANT * stiffness or share <= RESONANT:
        rest = complex(response.real - square.ds - damping * square.s, response.imag - w * square.s)
        return divide(rest, dynamic)
    twice = divide(t * exponential(near * t) - s, near - far)
    first = divide(_two_nodes(near, iw, t) - twice, iw - far)
    return divide(first - square.s, iw - far)


@jit
def _harmonic_series(stiffness, damping, w, t, reach):
    """Return W at a short time."""
    iw, total, g = complex(0.0, w), complex(0.0, 0.0), complex(1.0, 0.0)
    e, before, term = 1.0, 0.0, 0.5 * t * t
    # term is t^(n + 2) / (n + 2)!; e and g are coefficients of 1/q and 1/((s - i w) q) in powers of 1/s.
    for n in range(terms_within(reach)):
        total += g * term
        e, before = -damping * e - stiffness * before, e
        g = e + iw * g
        term *= t / (n + 3)
    return total


@jit
def _rate_series(stiffness, damping, w, t, reach):
    """Return 1/((s - i w)^2 q) at a short time."""
    iw, total = complex(0.0, w), complex(0.0, 0.0)
    g, twice = complex(1.0, 0.0), complex(1.0, 0.0)
    e, before, term = 1.0, 0.0, t * t * t / 6.0
    for n in range(terms_within(reach)):
        total += twice * term
        e, before = -damping * e - stiffness * before, e
        g = e + iw * g
        twice = g + iw * twice
        term *= t / (n + 4)
    return total


@jit
def _square_motion_series(stiffness, damping, w, t, reach):
    """Return 1/((s - i w) q^2) at a short time."""
    iw, total, g = complex(0.0, w), complex(0.0, 0.0), complex(1.0, 0.0)
    e, before, e2, before2, term = 1.0, 0.0, 1.0, 0.0, (t * t) * (t * t) / 24.0
    for n in range(terms_within(reach)):
        total += g * term
        e, before = -damping * e - stiffness * before, e
        e2, before2 = e - damping * e2 - stiffness * before2, e2
        g = e2 + iw * g
        term *= t / (n + 5)
    return total
