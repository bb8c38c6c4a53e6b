"""The load of eq. (5), f sin(nu tau) and what is constant beside it: all that is known of it stands here.

A phase is counted in turns (forcing periods), so that it is reduced exactly. In the frame of a motion, y = sigma
(x - x_ref), the load is a constant part and the `Force` sigma f sin(nu tau). A constant external load enters at
`constant_load`, a second harmonic as further parts of `Force`, with further columns beside the two of the first.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline, jit_unfused

TWO_PI = 2.0 * math.pi
NEVER = math.inf
# A motion is linear in a unit y, w, constant load, and force in phase and in quadrature: one column each.
COLUMNS = 5
# Steps per forcing period up to which the force's part of each is tabulated.
MAX_TABLE = 8192


class Force(NamedTuple):
    """sigma f sin(nu tau) at an instant, and sigma f cos(nu tau), from which it goes on."""

    sine: float
    cosine: float


@jit
def sincos_turns(u: float) -> tuple[float, float]:
    """sin(2 pi u), cos(2 pi u) for |u| < 2^30 turns, absolute error below 2.3e-16.

    The reduction to a quarter turn is exact in u; the remainder is a short odd and even polynomial, several times
    cheaper than the C library and free of branches.

    References
    ----------
    Coefficients: minimax on [-pi/4, pi/4], of `__kernel_sin` and `__kernel_cos` in Sun Microsystems' fdlibm 5.3
    (1993), k_sin.c and k_cos.c.
    """
    quarter = math.floor(4.0 * u + 0.5)
    t = TWO_PI * (u - 0.25 * quarter)
    z = t * t
    a = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    a = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * a)
    s = t + t * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * a))
    b = 2.08757232129817482790e-09 - z * 1.13596475577881948265e-11
    b = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * b)
    b = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * b)
    c = 1.0 - (0.5 * z - z * z * b)
    k = int(quarter) & 3
    sine = c if k & 1 else s
    cosine = s if k & 1 else c
    return (-sine if k & 2 else sine), (-cosine if (k + 1) & 2 else cosine)


@jit_inline
def phase_factor(turns):
    """exp(-2 pi i turns)."""
    s, c = sincos_turns(turns)
    return complex(c, -s)


@jit
def phase_integral(cycles, start, end):
    """Integral of exp(-2 pi i cycles t) over t from start to end, in forcing periods."""
    if cycles == 0.0:
        return complex(end - start, 0.0)
    # Written with the half difference: the difference of two exponentials cancels for a short rest.
    s, _c = sincos_turns(0.5 * cycles * (end - start))
    return phase_factor(0.5 * cycles * (start + end)) * (2.0 * s / (TWO_PI * cycles))


@jit_inline
def forcing_period(p):
    """Forcing period in tau."""
    return TWO_PI / p.nu


@jit_inline
def constant_load(sigma, reference):
    """The constant part of the load in the frame y = sigma (x - reference): the pull of the spring there."""
    # Not a negative: where the spring does not pull the load is a positive zero.
    return 0.0 - sigma * reference


@jit
def force_at(p, sigma: float, u: float) -> Force:
    """The `Force` at the phase u in turns."""
    s, c = sincos_turns(u)
    return Force(sigma * (p.f * s), sigma * (p.f * c))


@jit_inline
def force_rate(p, force: Force):
    """Rate of the force by tau."""
    return p.nu * force.cosine


@jit_inline
def force_times(p, factor, u):
    """factor f sin at the phase u, the factor first: so an integral over the force is summed."""
    return factor * p.f * sincos_turns(u)[0]


@jit_inline
def largest_force(p):
    """Largest size of the force; 0 where there is none."""
    return abs(p.f)


@jit_inline
def force_bounds(p):
    """Largest size of the force, of its rate by tau, and of its second derivative."""
    size = abs(p.f)
    return size, p.nu * size, p.nu * p.nu * size


@jit
def release_turn(p, sigma: float, load: float) -> float:
    """Phase in [0, 1) turns at which the force sigma f sin + load on a resting mass turns positive.

    Returns
    -------
    float
        The phase; `NEVER` if the force never turns positive, -1 if it always is.
    """
    f = sigma * p.f
    size = abs(f)
    if load > size:
        return -1.0
    if -load >= size:
        return NEVER
    turn = math.asin(-load / size) / TWO_PI
    if f < 0.0:
        turn += 0.5
    turn -= math.floor(turn)
    return 0.0 if turn >= 1.0 else turn


# Columns of the Taylor polynomials.


@jit_inline
def load_of(unit):
    """(constant load, `Force`) of an array (COLUMNS,) of y, w and the parts of the load."""
    return unit[2], Force(unit[3], unit[4])


@jit_inline
def first_terms(force: Force, angle):
    """The first two Taylor coefficients of the force by theta; angle: nu dt."""
    return force.sine, force.cosine * angle


@jit_inline
def next_term(before, angle, factor):
    """The coefficient of theta^(n + 1) from that of theta^(n - 1); factor: 1 / (n (n + 1))."""
    return -(angle * angle) * before * factor


@jit_inline
def load_terms(e, basis, n, load, force: Force):
    """The part of the load in the coefficient of theta^n, from the columns of a basis (COLUMNS, degrees)."""
    if e.forcing is None:
        return load * basis[2, n]
    return load * basis[2, n] + (force.sine * basis[3, n] + force.cosine * basis[4, n])


# The force's part of a whole step, from sin and cos at its start.


@jit_inline
def exact_factors(p, p_s, p_c, q_s, q_c):
    """Factors of sin and cos in a step's y and w, from those of a unit force."""
    return p.f * p_s, p.f * p_c, p.f * q_s, p.f * q_c


@jit_inline
def mean_factors(p, b1, b2, dt):
    """The same where a step takes the mean of the force at both its ends: in y with b1, in w with b2."""
    half_c, half_s = 0.5 + 0.5 * math.cos(p.nu * dt), 0.5 * math.sin(p.nu * dt)
    return b1 * p.f * half_c, b1 * p.f * half_s, b2 * p.f * half_c, b2 * p.f * half_s


@jit_unfused
def force_contribution(factors, s, c):
    """The force's part of a step in y and in w, from sin and cos at its start."""
    return factors[0] * s + factors[1] * c, factors[2] * s + factors[3] * c


@jit_unfused
def load_contribution(force_s, force_c, of_load, s, c):
    """The part of force and constant load of a step, in y or in w."""
    return (force_s * s + force_c * c) + of_load


@jit_allocating
def sincos_tables(e, steps):
    """sin and cos at the start of every step of a forcing period.

    Returns
    -------
    tuple of ndarray, shape (steps,) each
        Empty without force, or where a table would not fit a cache.
    """
    size = steps if e.forcing is not None and steps <= MAX_TABLE else 0
    sines, cosines = np.empty(size), np.empty(size)
    for j in range(size):
        sines[j], cosines[j] = sincos_turns(j / steps)
    return sines, cosines


@jit
def sincos_at_step(sines, cosines, steps, step):
    """sin and cos at the start of a step, from the tables if there are any."""
    if sines.size > 0:
        return sines[step], cosines[step]
    return sincos_turns(step / steps)


# Harmonics.


@jit_inline
def force_amplitude(p):
    """F of the force 2 Re(F exp(i nu tau))."""
    return complex(0.0, -0.5 * p.f)


@jit_inline
def with_force(p, k, m, amplitude):
    """`amplitude` of a force at k nu / m, with that of the external force added."""
    return amplitude + force_amplitude(p) if k == m else amplitude


@jit_inline
def reaction_integral(p, k, m, start, end):
    """Integral of -f sin(nu tau) exp(-i k nu tau / m), in forcing periods: of what holds a mass against the force."""
    cycles = k / m
    up = phase_integral(cycles - 1.0 if k != m else 0.0, start, end)
    down = phase_integral(cycles + 1.0, start, end)
    # sin = (exp(i nu tau) - exp(-i nu tau)) / 2i
    return complex(0.0, 0.5 * p.f) * (up - down)


@jit_inline
def work_of_force(p, x):
    """Work of the force over a forcing period of the motion 2 Re(x exp(i nu tau))."""
    return -2.0 * p.nu * x.real * p.f * (math.pi / p.nu)


def force_values(f: float, turns: Any) -> np.ndarray:
    """The force at phases in turns, for records of a motion."""
    values: np.ndarray = f * np.sin(2 * math.pi * np.asarray(turns))
    return values
