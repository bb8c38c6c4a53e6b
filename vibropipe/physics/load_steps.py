"""The load over a whole step of a grid, from sin and cos at its start."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.physics.limits import MAX_TABLE
from vibropipe.physics.load import double_angle, second_parts
from vibropipe.physics.turns import sincos_turns


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


@jit_inline
def force_contribution(factors, s, c):
    """Return the contributions of the force to y and w over a step, from sin and cos at its start."""
    return factors[0] * s + factors[1] * c, factors[2] * s + factors[3] * c


@jit_inline
def contribution_of_second(factors, s, c):
    """Return the contributions of the second harmonic to y and w over a step, from sin and cos of nu tau."""
    s2, c2 = double_angle(s, c)
    return factors[0] * s2 + factors[1] * c2, factors[2] * s2 + factors[3] * c2


@jit_inline
def load_contribution(force_s, force_c, of_load, s, c):
    """Return the contribution of force and constant load over a step, to y or to w."""
    return (force_s * s + force_c * c) + of_load


@jit_allocating
def sincos_tables(e, steps):
    """Return sin and cos at the start of every step of a forcing period.

    Returns arrays (steps,), or (0,): without force, or for more than MAX_TABLE steps.
    """
    size = table_size(e, steps)
    sines, cosines = np.empty(size), np.empty(size)
    fill_sincos(sines, cosines, steps)
    return sines, cosines


@jit
def table_size(e, steps):
    """Return the length of `sincos_tables`."""
    return steps if e.forcing is not None and steps <= MAX_TABLE else 0


@jit
def fill_sincos(sines, cosines, steps) -> None:
    """Write `sincos_tables` into arrays of their length."""
    for j in range(sines.size):
        sines[j], cosines[j] = sincos_turns(j / steps)


@jit
def sincos_at_step(sines, cosines, steps, step):
    """Return sin and cos at the start of a step, from the tables unless they are empty."""
    if sines.size > 0:
        return sines[step], cosines[step]
    return sincos_turns(step / steps)
