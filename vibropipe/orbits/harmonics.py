"""Fourier amplitudes of a piecewise exact motion from its contacts alone, in closed form.

Multiply eq. (5), with the forces of the supports written out, by exp(-i w tau) and integrate over an orbit:
(1 - w^2 + i h w) X(w) = F(w) + sum of impulses exp(-i w tau_i) + integral over rests of (x_s - F) exp(-i w tau),
all over the orbit's length. Nothing is sampled and nothing aliases.
"""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import (
    TWO_PI,
    phase_factor,
    phase_integral,
    reaction_integral,
    with_force,
)
from vibropipe.physics.quotient import divide

# Below this modulus of 1 - w^2 + i h w the closed form loses more than three digits: quadrature takes over.
RESONANT = 1e-3
# One period, as a numpy integer: numba compiles a plain constant to code of its own, march and all.
ONE_PERIOD = np.int64(1)


@jit
def rest_force(p, support, k, m, start, end):
    """Integral over a rest, in forcing periods, of (x_s - f sin nu tau) exp(-i k nu tau / m)."""
    x = support_position(p, support)
    return x * phase_integral(k / m, start, end) + reaction_integral(p, k, m, start, end)


@jit_inline
def add_support_forces(p, log, resting, rest_start, m, until, out) -> None:
    """Add to out[k] the support forces of a log, k = 0 .. len(out) - 1 multiples of nu/m.

    In units of impulse times nu/(2 pi); times in the log count from 0 to `until` periods; a rest that began
    earlier is counted from 0, one that goes on (`resting`: its support, or 0) up to `until`.
    """
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        impulse = log.impulse[i] * p.nu / TWO_PI
        turn, power = phase_factor(log.position[i] / m), complex(1.0, 0.0)
        for k in range(out.size):
            out[k] += impulse * power
            power *= turn
    for i in range(min(log.counts[RESTS], log.rest_start.size)):
        for k in range(out.size):
            start = max(0.0, log.rest_start[i])
            out[k] += rest_force(p, log.rest_support[i], k, m, start, log.rest_end[i])
    if resting > 0:
        for k in range(out.size):
            out[k] += rest_force(p, resting, k, m, max(0.0, rest_start), until)


@jit
def dynamic_stiffness(p, k, m):
    """1 - w^2 + i h w at w = k nu / m: the force over the displacement that it causes."""
    w = k * p.nu / m
    return complex((1.0 - w) * (1.0 + w), p.h * w)


@jit
def divide_by_stiffness(p, m, length, out) -> bool:
    """Turn the support forces summed over `length` periods into amplitudes X(k nu/m), in place.

    False if some harmonic is too near resonance for the closed form; those are left as they are.
    """
    good = True
    for k in range(out.size):
        force = with_force(p, k, m, divide(out[k], complex(length, 0.0)))
        d = dynamic_stiffness(p, k, m)
        if abs(d) < RESONANT:
            good = False
        else:
            out[k] = divide(force, d)
    return good
