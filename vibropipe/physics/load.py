"""The load of eq. (5): the force f sin(nu tau) and its constant part. No other module holds its form.

A phase is counted in turns (forcing periods), so its reduction is exact. In the frame y = sigma (x - x_ref) of a motion
the load is a constant part plus the `Force` sigma f sin(nu tau). Displacements of kernels are counted from the
equilibrium, so an external constant load is in the positions of the supports (`contact.support_position`).

The second harmonic f2 sin(2 nu tau + phi2) has parts of `Force` and columns of its own. Functions of the march take
`second`, the effect `second_harmonic`: None leaves its code out. Others, called once for a row, look at f2.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline, jit_unfused

TWO_PI = 2.0 * math.pi
NEVER = math.inf
# Columns of a basis of motions: y, w, constant load, force in phase and force in quadrature; then the same of the
# second harmonic.
COLUMNS, COLUMNS_OF_SECOND = 5, 2
# Rounding of the load on a sticking mass, as a share of its largest magnitude, and the largest number of strides to
# its release.
LOAD_ROUNDING, MAX_STRIDES = 2.0**-51, 100_000
# Largest number of steps per forcing period whose force is tabulated: both tables then fit a second-level cache.
MAX_TABLE = 8192


class Force(NamedTuple):
    """sigma f sin(nu tau) at an instant, and sigma f cos(nu tau), which determines its continuation.

    `sine_2` and `cosine_2` are sigma f2 sin(2 nu tau + phi2) and sigma f2 cos(2 nu tau + phi2).
    """

    sine: float
    cosine: float
    sine_2: float = 0.0
    cosine_2: float = 0.0


@jit_inline
def no_force():
    """Return the `Force` of a motion without one."""
    return Force(0.0, 0.0, 0.0, 0.0)


@jit_inline
def second_parts(p):
    """Return the factors of sin(2 nu tau) and cos(2 nu tau) in the second harmonic."""
    return p.f2 * math.cos(p.phi2), p.f2 * math.sin(p.phi2)


@jit_inline
def double_angle(s, c):
    """Return sine and cosine of twice an angle from those of the angle."""
    return 2.0 * s * c, (c - s) * (c + s)


@jit
def sincos_turns(u: float) -> tuple[float, float]:
    """Return sin(2 pi u) and cos(2 pi u) for |u| < 2^30 turns, with an absolute error below 2.3e-16.

    The reduction to a quarter turn is exact in u. The remainder is a short odd and even polynomial, several times
    faster than the C library and free of branches.

    References
    ----------
    Coefficients: minimax on [-pi/4, pi/4], of `__kernel_sin` and `__kernel_cos` in Sun Microsystems' fdlibm 5.3 (1993),
    k_sin.c and k_cos.c.
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
    """Return exp(-2 pi i turns)."""
    s, c = sincos_turns(turns)
    return complex(c, -s)


@jit
def phase_integral(cycles, start, end):
    """Return the integral of exp(-2 pi i cycles t) over t from start to end, in forcing periods."""
    if cycles == 0.0:
        return complex(end - start, 0.0)
    # By the half difference of the phases: the difference of two exponentials cancels for a short rest.
    s, _c = sincos_turns(0.5 * cycles * (end - start))
    return phase_factor(0.5 * cycles * (start + end)) * (2.0 * s / (TWO_PI * cycles))


@jit_inline
def forcing_period(p):
    """Return the forcing period 2 pi / nu in tau."""
    return TWO_PI / p.nu


@jit_inline
def constant_load(sigma, reference):
    """Return the constant load in the frame y = sigma (x - reference): the spring force there."""
    # A subtraction, since a negation would give a negative zero where the spring force is zero.
    return 0.0 - sigma * reference


@jit
def force_at(p, sigma: float, u: float, second=None) -> Force:
    """Return the `Force` at a phase.

    Parameters
    ----------
    p : Parameters
    sigma : float
        Sign of the frame, 1 or -1.
    u : float
        Phase in turns.
    second : int or None
        The effect `second_harmonic`.
    """
    s, c = sincos_turns(u)
    sine_2, cosine_2 = 0.0, 0.0
    if second is not None:
        s2, c2 = double_angle(s, c)
        in_phase, ahead = second_parts(p)
        sine_2 = sigma * (in_phase * s2 + ahead * c2)
        cosine_2 = sigma * (in_phase * c2 - ahead * s2)
    return Force(sigma * (p.f * s), sigma * (p.f * c), sine_2, cosine_2)


@jit_inline
def force_value(force: Force, second=None):
    """Return the force."""
    if second is None:
        return force.sine
    return force.sine + force.sine_2


@jit_inline
def force_rate(p, force: Force, second=None):
    """Return the derivative of the force by tau."""
    if second is None:
        return p.nu * force.cosine
    return p.nu * (force.cosine + 2.0 * force.cosine_2)


@jit_inline
def force_times(p, factor, u, second=None):
    """Return the product of a factor with the force, from the left, as integrals over the force are summed."""
    if second is None:
        return factor * p.f * sincos_turns(u)[0]
    return factor * force_value(force_at(p, 1.0, u, second), second)


@jit_inline
def fastest_forcing(p, second=None):
    """Return the highest frequency of the force."""
    return p.nu if second is None else 2.0 * p.nu


@jit_inline
def fastest_of_row(p):
    """Return the highest frequency of the force, as `fastest_forcing` without the effects of a kernel."""
    return p.nu if p.f2 == 0.0 else 2.0 * p.nu


@jit_inline
def largest_force(p):
    """Return a bound of the magnitude of the force, sharp with one harmonic; 0 without force."""
    return abs(p.f) + abs(p.f2)


@jit_inline
def force_bounds(p):
    """Return bounds of the force and of its first and second derivative by tau, sharp with one harmonic."""
    first, second = abs(p.f), abs(p.f2)
    return (
        first + second,
        p.nu * (first + 2.0 * second),
        p.nu * p.nu * (first + 4.0 * second),
    )


@jit
def release_turn(p, sigma: float, load: float) -> float:
    """Return the phase at which the force on a sticking mass turns positive.

    Parameters
    ----------
    p : Parameters
    sigma, load : float
        The force is sigma f sin + load.

    Returns
    -------
    float
        Phase in [0, 1) turns; `NEVER` if the force never turns positive, -1 if it always is.
    """
    f = sigma * p.f
    amplitude = abs(f)
    if load > amplitude:
        return -1.0
    if -load >= amplitude:
        return NEVER
    turn = math.asin(-load / amplitude) / TWO_PI
    if f < 0.0:
        turn += 0.5
    turn -= math.floor(turn)
    return 0.0 if turn >= 1.0 else turn


@jit
def release_wait_of_second(p, sigma: float, load: float, turn: float) -> float:
    """Return the turns from a phase to the release of a sticking mass under two harmonics; `NEVER` without one.

    Parameters
    ----------
    p : Parameters
    sigma, load : float
        The load on the mass is sigma times the force, plus load.
    turn : float
        The phase.

    Notes
    -----
    The release is the first zero at which the load turns positive. A parabola above the load, whose curvature is the
    largest one of the load, has no zero before its own, so no release is passed; near a zero these strides converge
    like Newton's method.
    """
    force, _rate, second = force_bounds(p)
    per_turn = TWO_PI / p.nu
    curvature = second * per_turn * per_turn
    rounding = LOAD_ROUNDING * (force + abs(load))
    wait = 0.0
    for _ in range(MAX_STRIDES):
        at = force_at(p, sigma, turn + wait, 1)
        value, slope = force_value(at, 1) + load, force_rate(p, at, 1) * per_turn
        if value > rounding or (value >= -rounding and slope > 0.0):
            return wait
        # The stride is that of a load pressed by its rounding at least, so a maximum that touches zero is passed.
        press = max(-value, rounding)
        root = math.sqrt(slope * slope + 2.0 * curvature * press)
        wait += 2.0 * press / (root + slope) if slope > 0.0 else (root - slope) / curvature
        if wait >= 1.0:
            return NEVER
    return NEVER


# -- Taylor coefficients ------------------------------------------------------------------------


@jit_inline
def load_of(unit):
    """Return (constant load, `Force`) of a unit array of y, w and the parts of the load, with the second harmonic's."""
    return unit[2], Force(unit[3], unit[4], unit[5], unit[6])


@jit_inline
def first_terms(force: Force, angle):
    """Return the first two Taylor coefficients of the first harmonic by theta; angle is nu dt."""
    return force.sine, force.cosine * angle


@jit_inline
def first_terms_of_second(force: Force, angle):
    """Return the first two Taylor coefficients of the second harmonic by theta; angle is 2 nu dt."""
    return force.sine_2, force.cosine_2 * angle


@jit_inline
def next_term(before, angle, factor):
    """Return the coefficient of theta^(n + 1) from that of theta^(n - 1); factor is 1 / (n (n + 1))."""
    return -(angle * angle) * before * factor


@jit_inline
def load_terms(e, basis, n, load, force: Force):
    """Return the contribution of the load to the coefficient of theta^n, from a basis (COLUMNS, degree + 1)."""
    if e.forcing is None:
        return load * basis[2, n]
    of_load = load * basis[2, n] + (force.sine * basis[3, n] + force.cosine * basis[4, n])
    if e.second_harmonic is not None:
        of_load += force.sine_2 * basis[5, n] + force.cosine_2 * basis[6, n]
    return of_load


# -- contribution to a whole step, from sin and cos at its start ----------------------------------


@jit_inline
def exact_factors(p, p_s, p_c, q_s, q_c):
    """Return the factors of sin and cos in y and w after an exact step, from those of a unit force."""
    return p.f * p_s, p.f * p_c, p.f * q_s, p.f * q_c


@jit_inline
def mean_factors(p, b1, b2, dt):
    """Return the factors of sin and cos in y and w after a step under the mean of the force at both its ends.

    b1, b2 : response of y and of w to a unit constant force.
    """
    half_c, half_s = 0.5 + 0.5 * math.cos(p.nu * dt), 0.5 * math.sin(p.nu * dt)
    return b1 * p.f * half_c, b1 * p.f * half_s, b2 * p.f * half_c, b2 * p.f * half_s


@jit_inline
def exact_factors_of_second(p, p_s, p_c, q_s, q_c):
    """Return the factors of sin and cos of 2 nu tau in y and w after an exact step; as `exact_factors`."""
    a, b = second_parts(p)
    return a * p_s - b * p_c, a * p_c + b * p_s, a * q_s - b * q_c, a * q_c + b * q_s


@jit_inline
def mean_factors_of_second(p, b1, b2, dt):
    """Return the factors of sin and cos of 2 nu tau in y and w after a step; as `mean_factors`."""
    half_c, half_s = 0.5 + 0.5 * math.cos(2.0 * p.nu * dt), 0.5 * math.sin(2.0 * p.nu * dt)
    a, b = second_parts(p)
    of_s, of_c = a * half_c - b * half_s, a * half_s + b * half_c
    return b1 * of_s, b1 * of_c, b2 * of_s, b2 * of_c


@jit_unfused
def force_contribution(factors, s, c):
    """Return the contributions of the force to y and w over a step, from sin and cos at its start."""
    return factors[0] * s + factors[1] * c, factors[2] * s + factors[3] * c


@jit_unfused
def contribution_of_second(factors, s, c):
    """Return the contributions of the second harmonic to y and w over a step, from sin and cos of nu tau."""
    s2, c2 = double_angle(s, c)
    return factors[0] * s2 + factors[1] * c2, factors[2] * s2 + factors[3] * c2


@jit_unfused
def load_contribution(force_s, force_c, of_load, s, c):
    """Return the contribution of force and constant load over a step, to y or to w."""
    return (force_s * s + force_c * c) + of_load


@jit_allocating
def sincos_tables(e, steps):
    """Return sin and cos at the start of every step of a forcing period.

    Returns
    -------
    tuple of ndarray, shape (steps,) or (0,)
        Empty without force, or for more than MAX_TABLE steps.
    """
    size = steps if e.forcing is not None and steps <= MAX_TABLE else 0
    sines, cosines = np.empty(size), np.empty(size)
    for j in range(size):
        sines[j], cosines[j] = sincos_turns(j / steps)
    return sines, cosines


@jit
def sincos_at_step(sines, cosines, steps, step):
    """Return sin and cos at the start of a step, from the tables unless they are empty."""
    if sines.size > 0:
        return sines[step], cosines[step]
    return sincos_turns(step / steps)


# -- harmonics -----------------------------------------------------------------------------------


@jit_inline
def force_amplitude(p):
    """Return F of the force 2 Re(F exp(i nu tau))."""
    return complex(0.0, -0.5 * p.f)


@jit_inline
def second_amplitude(p):
    """Return F of the second harmonic 2 Re(F exp(2 i nu tau)) of the force."""
    return complex(0.5 * p.f2 * math.sin(p.phi2), -0.5 * p.f2 * math.cos(p.phi2))


@jit_inline
def with_force(p, k, m, amplitude):
    """Return a complex amplitude at k nu / m, with that of the external force added where k = m or 2 m."""
    if k == 2 * m and p.f2 != 0.0:
        return amplitude + second_amplitude(p)
    return amplitude + force_amplitude(p) if k == m else amplitude


@jit_inline
def reaction_integral(p, k, m, start, end):
    """Return a harmonic of the part of the support force that balances the external force during a rest.

    Parameters
    ----------
    p : Parameters
    k, m : int
        Harmonic of the frequency k nu / m.
    start, end : float
        The rest, in forcing periods.

    Returns
    -------
    complex
        Integral of minus the force times exp(-i k nu tau / m) over the rest, in forcing periods.
    """
    cycles = k / m
    up = phase_integral(cycles - 1.0 if k != m else 0.0, start, end)
    down = phase_integral(cycles + 1.0, start, end)
    # sin = (exp(i nu tau) - exp(-i nu tau)) / 2i
    first = complex(0.0, 0.5 * p.f) * (up - down)
    if p.f2 == 0.0:
        return first
    amplitude = second_amplitude(p)
    up = phase_integral(cycles - 2.0 if k != 2 * m else 0.0, start, end)
    down = phase_integral(cycles + 2.0, start, end)
    return first - (amplitude * up + amplitude.conjugate() * down)


@jit_inline
def work_of_force(p, x):
    """Return the work of the first harmonic over a forcing period of the motion 2 Re(x exp(i nu tau))."""
    return -2.0 * p.nu * x.real * p.f * (math.pi / p.nu)


@jit_inline
def work_of_second(p, x):
    """Return the work of the second harmonic over a forcing period of the motion 2 Re(x exp(2 i nu tau))."""
    # The mean power is that of 2 Re(F exp) with 2 Re(2 i nu x exp).
    power = 2.0 * (second_amplitude(p) * complex(0.0, 2.0 * p.nu) * x.conjugate()).real
    return -power * (TWO_PI / p.nu)


def force_values(f: float, turns: Any, f2: float = 0.0, phi2: float = 0.0) -> np.ndarray:
    """Return the force at phases in turns, for records of a motion."""
    angles = 2 * math.pi * np.asarray(turns)
    values: np.ndarray = f * np.sin(angles)
    return values + f2 * np.sin(2 * angles + phi2) if f2 else values
