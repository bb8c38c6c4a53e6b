"""The exact motion between impacts, eq. (5), as a Taylor polynomial about any instant.

One recurrence covers resonance at h = 0, critical and supercritical damping, and f = 0. Motions are written as
y = sigma (x - x_ref), the distance from a reference: a support just left (then y is the gap) or the equilibrium. With
load = -sigma x_ref eq. (5) reads y'' + h y' + y = load + sigma f sin(nu tau).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.physics.load import (
    COLUMNS,
    COLUMNS_OF_SECOND,
    first_terms,
    first_terms_of_second,
    load_terms,
    next_term,
    unit_load,
)

# Degree of the polynomial.
DEGREE = 15
# Largest product of a rate and the step: the first neglected term is then below 1e-18 of the motion.
REACH = 0.5
# Factors 1 / ((n + 1) (n + 2)) of the recurrence.
TAYLOR_FACTORS = tuple(1.0 / ((n + 1) * (n + 2)) for n in range(DEGREE - 1))


@jit
def fastest_rate(nu: float, h: float) -> float:
    """Return the largest rate in eq. (5): the frequency of the force, or the root of s^2 = h s + 1."""
    return max(nu, 0.5 * (h + math.sqrt(h * h + 4.0)))


@jit
def steps_for_exact(nu: float, h: float, fastest: float = 0.0) -> int:
    """Return the steps per forcing period, at least 8, for which one polynomial covers a step to rounding.

    fastest : highest frequency of the force (default: nu).
    """
    return max(8, math.ceil(2.0 * math.pi / nu * fastest_rate(max(nu, fastest), h) / REACH))


@jit
def taylor(c, y, w, force, load, h, nu, dt, second=None) -> None:
    """Fill c so that y(t0 + theta dt) = sum(c[n] theta**n) for 0 <= theta <= 1, eq. (5).

    c : (DEGREE + 1,)
    y, w : displacement and velocity at t0
    force : at t0
    load : constant load
    h, nu, dt : damping, frequency of the force, the step
    second : the effect `second_harmonic`

    Taylor series by recurrence: E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd
    ed., Springer (1993), sec. I.8.
    """
    d2 = dt * dt
    hd = h * dt
    term, term_next = first_terms(force, nu * dt)
    c[0] = y
    c[1] = w * dt
    c[2] = 0.5 * d2 * ((term + load) - h * w - y)
    if second is not None:
        other, other_next = first_terms_of_second(force, 2.0 * nu * dt)
        c[2] += 0.5 * d2 * other
    for n in range(1, DEGREE - 1):
        c[n + 2] = (d2 * (term_next - c[n]) - hd * (n + 1) * c[n + 1]) * TAYLOR_FACTORS[n]
        term, term_next = term_next, next_term(term, nu * dt, TAYLOR_FACTORS[n - 1])
        if second is not None:
            c[n + 2] += d2 * other_next * TAYLOR_FACTORS[n]
            other, other_next = other_next, next_term(other, 2.0 * nu * dt, TAYLOR_FACTORS[n - 1])


@jit
def displacement(c, degree: int, theta: float) -> float:
    """Return sum(c[n] theta**n) for n up to `degree`."""
    y = c[degree]
    for n in range(degree - 1, -1, -1):
        y = y * theta + c[n]
    return y


@jit
def velocity(c, degree: int, theta: float, dt: float) -> float:
    """Return the derivative by tau of the polynomial at theta."""
    w = degree * c[degree]
    for n in range(degree - 1, 0, -1):
        w = w * theta + n * c[n]
    return w / dt


@jit_inline
def motion_with_curvature(c, t: float):
    """Return value, slope and curvature by theta of the polynomial of degree DEGREE at theta = t, by Estrin's scheme.

    Its products are independent of each other: it takes a third of the time of Horner's scheme.

    Reference: G. Estrin, "Organization of computer systems: the fixed plus variable structure computer", Proceedings of
    the Western Joint IRE-AIEE-ACM Computer Conference (1960) 33-40.
    """
    t2 = t * t
    t4 = t2 * t2
    t8 = t4 * t4
    low = (c[0] + c[1] * t) + (c[2] + c[3] * t) * t2
    low += ((c[4] + c[5] * t) + (c[6] + c[7] * t) * t2) * t4
    high = (c[8] + c[9] * t) + (c[10] + c[11] * t) * t2
    high += ((c[12] + c[13] * t) + (c[14] + c[15] * t) * t2) * t4
    slope_low = (c[1] + 2.0 * c[2] * t) + (3.0 * c[3] + 4.0 * c[4] * t) * t2
    slope_low += ((5.0 * c[5] + 6.0 * c[6] * t) + (7.0 * c[7] + 8.0 * c[8] * t) * t2) * t4
    slope_high = (9.0 * c[9] + 10.0 * c[10] * t) + (11.0 * c[11] + 12.0 * c[12] * t) * t2
    slope_high += ((13.0 * c[13] + 14.0 * c[14] * t) + 15.0 * c[15] * t2) * t4
    curvature_low = (2.0 * c[2] + 6.0 * c[3] * t) + (12.0 * c[4] + 20.0 * c[5] * t) * t2
    curvature_low += ((30.0 * c[6] + 42.0 * c[7] * t) + (56.0 * c[8] + 72.0 * c[9] * t) * t2) * t4
    curvature_high = (90.0 * c[10] + 110.0 * c[11] * t) + (132.0 * c[12] + 156.0 * c[13] * t) * t2
    curvature_high += (182.0 * c[14] + 210.0 * c[15] * t) * t4
    return low + high * t8, slope_low + slope_high * t8, curvature_low + curvature_high * t8


@jit_inline
def motion(c, t: float, dt: float):
    """Return (y, w) of the polynomial of degree DEGREE at theta = t."""
    y, slope, _curvature = motion_with_curvature(c, t)
    return y, slope / dt


@jit_allocating
def new_basis(second):
    """Return an array for a basis, shape (COLUMNS, DEGREE + 1); with the second harmonic, COLUMNS_OF_SECOND follow."""
    return np.empty((COLUMNS if second is None else COLUMNS + COLUMNS_OF_SECOND, DEGREE + 1))


@jit
def fill_basis(basis, h, nu, dt, second) -> None:
    """Fill a basis with the polynomials of a unit y, w and each part of the load at t0.

    The motion is linear in these, so any polynomial is a sum of COLUMNS vectors, which vector units add much faster
    than the recurrence runs.
    """
    for column in range(basis.shape[0]):
        load, force = unit_load(column)
        y, w = (1.0 if column == 0 else 0.0), (1.0 if column == 1 else 0.0)
        taylor(basis[column], y, w, force, load, h, nu, dt, second)


@jit_inline
def combine(e, basis, c, y, w, load, force) -> None:
    """Fill c, shape (DEGREE + 1,), with the motion from (y, w) under a constant load and a `Force`."""
    # The length is read from the array: a constant length would be unrolled instead of vectorised.
    for n in range(basis.shape[1]):
        c[n] = (y * basis[0, n] + w * basis[1, n]) + load_terms(e, basis, n, load, force)


@jit
def _step_end(c, dt):
    """Return (y, w) of a polynomial at the end of its step."""
    return displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)


class StepMap(NamedTuple):
    """A step from (y, w) to (a11 y + a12 w + b1 load, a21 y + a22 w + b2 load)."""

    a11: float
    a12: float
    b1: float
    a21: float
    a22: float
    b2: float


@jit
def exact_map(basis, dt: float):
    """Return the exact one-step map of a basis, and what a force adds to it.

    basis : (COLUMNS, DEGREE + 1), of `fill_basis`

    Returns a `StepMap`, whose b1 is the response to a constant force: 1 - a11 would cancel for short steps; and (p1,
    p2, q1, q2): a `Force` (s, c) at the start adds p1 s + p2 c to y and q1 s + q2 c to w.
    """
    a11, a21 = _step_end(basis[0], dt)
    a12, a22 = _step_end(basis[1], dt)
    b1, b2 = _step_end(basis[2], dt)
    p1, q1 = _step_end(basis[3], dt)
    p2, q2 = _step_end(basis[4], dt)
    return StepMap(a11, a12, b1, a21, a22, b2), (p1, p2, q1, q2)


@jit
def exact_map_of_second(basis, dt: float):
    """Return the (p1, p2, q1, q2) of `exact_map` for the second harmonic."""
    y0, y1 = (
        displacement(basis[COLUMNS], DEGREE, 1.0),
        displacement(basis[COLUMNS + 1], DEGREE, 1.0),
    )
    w0, w1 = (
        velocity(basis[COLUMNS], DEGREE, 1.0, dt),
        velocity(basis[COLUMNS + 1], DEGREE, 1.0, dt),
    )
    return y0, y1, w0, w1


@jit
def free_flow(h: float, t: float):
    """Return the matrix of the unforced motion y'' + h y' + y = 0, the derivative of the flow between impacts.

    Closed form. Near critical damping the sine (or hyperbolic sine) over its argument is summed from its series.

    h : damping, >= 0
    t : time, >= 0

    Returns (e11, e12, e21, e22); the determinant is exp(-h t).
    """
    b = 0.5 * h
    g = (b - 1.0) * (b + 1.0)
    z = g * t * t
    if z < -1e-3:
        root = math.sqrt(-g)
        decay = math.exp(-b * t)
        even, odd = decay * math.cos(root * t), decay * math.sin(root * t) / root
    elif z <= 1e-3:
        decay = math.exp(-b * t)
        even = decay * (1.0 + z * (0.5 + z * (1.0 / 24.0 + z * (1.0 / 720.0 + z / 40320.0))))
        odd = (
            decay
            * t
            * (1.0 + z * (1.0 / 6.0 + z * (1.0 / 120.0 + z * (1.0 / 5040.0 + z / 362880.0))))
        )
    else:
        root = math.sqrt(g)
        # The slow rate b - root cancels for strong damping; the product of both rates is 1, so it is 1/(b + root).
        slow, fast = math.exp(-t / (b + root)), math.exp(-(b + root) * t)
        even, odd = 0.5 * (slow + fast), 0.5 * (slow - fast) / root
    return even + b * odd, odd, -odd, even - b * odd
