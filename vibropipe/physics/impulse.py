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
from vibropipe.physics.forced_flow import force_response
from vibropipe.physics.quotient import divide
from vibropipe.physics.stiffness import piece_rate

# Product of the fastest rate and the span below which functions are summed from their series, and its terms.
SHORT, TERMS = 1.0, 24
# Product of rates and span below which quotients of differences are summed from series.
NEAR = 0.5
# Share of the dynamic stiffness below which a force is near resonance.
RESONANT = 0.1


class Impulse(NamedTuple):
    """Responses of a piece from rest at a time.

    Attributes
    ----------
    c, s, ds : float
        Motion from a unit displacement, from a unit velocity, and the rate of the latter.
    g : float
        Motion under a unit load.
    s2, ds2, g2 : float
        Those of 1/q^2: minus the derivatives of `s`, `ds` and `g` by the stiffness are `s2`, `ds2` and `g2`.
    """

    c: float
    s: float
    ds: float
    g: float
    s2: float
    ds2: float
    g2: float


class Response(NamedTuple):
    """Response from rest to exp(i w tau) at a time: 1/((s - i w) q), the same with q^2, and with (s - i w)^2."""

    w: complex
    w2: complex
    w3: complex


@jit
def impulse_response(stiffness: float, damping: float, t: float) -> Impulse:
    """Return the `Impulse` at the time t; negative times only as far as they are short."""
    if piece_rate(stiffness, damping) * abs(t) < SHORT:
        return _impulse_series(stiffness, damping, t)
    root = math.sqrt(stiffness)
    b, scaled = 0.5 * damping / root, root * t
    c, odd, _minus, ds = free_flow(2.0 * b, scaled)
    even, share = ds + b * odd, (1.0 - b) * (1.0 + b)
    z = share * scaled * scaled
    if abs(z) < NEAR:
        # The sum of (-z)^n (2n + 2) / (2n + 3)! by Horner's rule, each term over the one before.
        total = 0.0
        for n in range(8, -1, -1):
            total = 1.0 - total * z * (n + 2) / ((n + 1) * (2 * n + 4) * (2 * n + 5))
        s2 = math.exp(-b * scaled) * scaled * scaled * scaled * total / 6.0
    else:
        s2 = 0.5 * (odd - scaled * even) / share
    ds2 = 0.5 * scaled * odd - b * s2
    g = 1.0 - c
    g2 = g - ds2 - 2.0 * b * s2
    k = stiffness
    return Impulse(c, odd / root, ds, g / k, s2 / (root * k), ds2 / k, g2 / (k * k))


@jit
def _impulse_series(stiffness, damping, t):
    """Return the `Impulse` at a short time."""
    s, ds, g, s2, ds2, g2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    e, before, e2, before2, term = 1.0, 0.0, 1.0, 0.0, 1.0
    # term is t^n / n!; e and e2 are the coefficients of 1/q and 1/q^2 in powers of 1/s.
    for n in range(TERMS):
        one = term * t / (n + 1)
        two = one * t / (n + 2)
        three = two * t / (n + 3)
        ds += e * term
        s += e * one
        g += e * two
        ds2 += e2 * two
        s2 += e2 * three
        g2 += e2 * three * t / (n + 4)
        e, before = -damping * e - stiffness * before, e
        e2, before2 = e - damping * e2 - stiffness * before2, e2
        term = one
    return Impulse(1.0 - stiffness * g, s, ds, g, s2, ds2, g2)


@jit
def _two_nodes(one: complex, other: complex, t: float) -> complex:
    """Return the divided difference of exp(s t) over (one, one, other), also where they are close."""
    delta = (other - one) * t
    if abs(delta) < NEAR:
        total = complex(1.0, 0.0)
        for n in range(16, 0, -1):
            total = 1.0 + delta * total / (n + 2)
        return 0.5 * t * t * _exponential(one * t) * total
    change = other - one
    return divide(_exponential(other * t) - _exponential(one * t) * (1.0 + delta), change * change)


@jit
def _exponential(z: complex) -> complex:
    """Return exp(z)."""
    size = math.exp(z.real)
    return complex(size * math.cos(z.imag), size * math.sin(z.imag))


@jit
def force_responses(
    stiffness: float, damping: float, w: float, turns: float, t: float, free: Impulse
) -> Response:
    """Return the `Response` to exp(i w tau) at the time t, which is `turns` periods of w; free : of that time."""
    if max(piece_rate(stiffness, damping), w) * abs(t) < SHORT:
        return _response_series(stiffness, damping, w, t)
    root = math.sqrt(stiffness)
    b = 0.5 * damping / root
    y, _rate = force_response(2.0 * b, w / root, turns, root * t, root * free.s)
    response, iw = y / stiffness, complex(0.0, w)
    dynamic = complex((root - w) * (root + w), damping * w)
    square = (1.0 - b) * (1.0 + b)
    if square > 0.0:
        near, far = complex(-b, math.sqrt(square)), complex(-b, -math.sqrt(square))
    else:
        near = complex(-1.0 / (b + math.sqrt(-square)), 0.0)
        far = complex(-(b + math.sqrt(-square)), 0.0)
    near, far = root * near, root * far
    w3 = divide(_two_nodes(iw, near, t) - response, iw - far)
    if abs(dynamic) > RESONANT * stiffness or square <= RESONANT:
        rest = complex(response.real - free.ds2 - damping * free.s2, response.imag - w * free.s2)
        return Response(response, divide(rest, dynamic), w3)
    twice = divide(t * _exponential(near * t) - free.s, near - far)
    first = divide(_two_nodes(near, iw, t) - twice, iw - far)
    return Response(response, divide(first - free.s2, iw - far), w3)


@jit
def _response_series(stiffness, damping, w, t):
    """Return the `Response` at a short time."""
    iw = complex(0.0, w)
    one, two, three = complex(0.0, 0.0), complex(0.0, 0.0), complex(0.0, 0.0)
    e, before, e2, before2, term = 1.0, 0.0, 1.0, 0.0, 0.5 * t * t
    g, g2, g3 = complex(1.0, 0.0), complex(1.0, 0.0), complex(1.0, 0.0)
    # term is t^(n + 2) / (n + 2)!; g, g2 and g3 are coefficients in powers of 1/s.
    for n in range(TERMS):
        third = term * t / (n + 3)
        one += g * term
        three += g3 * third
        two += g2 * (third * t / (n + 4))
        e, before = -damping * e - stiffness * before, e
        e2, before2 = e - damping * e2 - stiffness * before2, e2
        g = e + iw * g
        g2 = e2 + iw * g2
        g3 = g + iw * g3
        term = third
    return Response(one, two, three)
