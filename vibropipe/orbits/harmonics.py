"""Fourier amplitudes of a motion from its contacts, in closed form.

Multiply eq. (5), with the support forces written out, by exp(-i w tau) and integrate over the length of an orbit:
(1 - w^2 + i h w) X(w) = F(w) + sum of impulses exp(-i w tau_i) + integral over rests of (x_s - F) exp(-i w tau),
divided by that length. The amplitudes need no samples and have no aliasing error.
"""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.physics.contact import support_position
from vibropipe.physics.load_harmonics import reaction_integral, with_force
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral

# Modulus of the dynamic stiffness 1 - w^2 + i h w below which the closed form loses more than three digits and the
# amplitude is computed by quadrature.
RESONANT = 1e-3
# One forcing period. It is a numpy integer because numba compiles another copy of the march for a literal constant.
ONE_PERIOD = np.int64(1)


@jit
def rest_force(p, support, k, m, start, end):
    """Integrate the support force x_s - f sin(nu tau) times exp(-i k nu tau / m) over a rest.

    k, m : numerator and denominator of the frequency k nu/m
    start, end : of the rest, in forcing periods

    Returns the integral, in forcing periods.
    """
    x = support_position(p, support)
    return x * phase_integral(k / m, start, end) + reaction_integral(p, k, m, start, end)


@jit_inline
def add_support_forces(p, log, resting, rest_start, m, until, out) -> None:
    """Add the support forces of logged contacts to the sums at the frequencies k nu/m, k = 0, 1, ...

    log : contacts; times in forcing periods from 0 to `until`
    resting : support of a rest that has not ended at `until`; 0 for none
    rest_start : start of that rest. A rest counts from 0 if it began earlier
    m : denominator of the frequencies k nu/m: 1 for harmonics of the force
    until : end of the log, in forcing periods
    out : (harmonics + 1,) complex, sums, increased in place, in units of impulse times nu/(2 pi)
    """
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        impulse = log.impulse[i] * p.nu / TWO_PI
        rotation, power = phase_factor(log.position[i] / m), complex(1.0, 0.0)
        for k in range(out.size):
            out[k] += impulse * power
            power *= rotation
    for i in range(min(log.counts[RESTS], log.rest_start.size)):
        for k in range(out.size):
            start = max(0.0, log.rest_start[i])
            out[k] += rest_force(p, log.rest_support[i], k, m, start, log.rest_end[i])
    if resting > 0:
        for k in range(out.size):
            out[k] += rest_force(p, resting, k, m, max(0.0, rest_start), until)


@jit
def dynamic_stiffness(p, k, m):
    """Return the dynamic stiffness 1 - w^2 + i h w, force over displacement, at w = k nu/m."""
    w = k * p.nu / m
    return complex((1.0 - w) * (1.0 + w), p.h * w)


@jit
def divide_by_stiffness(p, m, length, out) -> bool:
    """Convert sums of support forces to amplitudes X(k nu/m), in place.

    m : denominator of the frequencies k nu/m: 1 for harmonics of the force
    length : forcing periods that the sums extend over
    out : (harmonics + 1,) complex, sums of `add_support_forces`; amplitudes on return. Harmonics near resonance are
        left unchanged

    Returns whether all harmonics were converted; False if one is too near resonance for the closed form.
    """
    is_complete = True
    for k in range(out.size):
        force = with_force(p, k, m, divide(out[k], complex(length, 0.0)))
        stiffness = dynamic_stiffness(p, k, m)
        if abs(stiffness) < RESONANT:
            is_complete = False
        else:
            out[k] = divide(force, stiffness)
    return is_complete
