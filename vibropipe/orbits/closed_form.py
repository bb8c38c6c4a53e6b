"""Rows that need no march: nothing struck (linear), or nothing lost and nothing driven (conservative)."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.orbits.outputs import NO_IMPACT, regime_of, write_largest, write_multipliers
from vibropipe.physics.conservative import arc, arc_harmonic, arc_state, speed_at, top_support
from vibropipe.physics.contact import support_position
from vibropipe.physics.linear import linear_amplitude, linear_multipliers
from vibropipe.physics.load import phase_factor, work_of_force


@jit_inline
def _write_label(out, row, regime, m) -> None:
    """A row known in closed form: nothing marched, nothing left over."""
    out.regime[row] = regime
    out.period_multiple[row] = m
    out.residual[row] = 0.0


@jit_inline
def _linear_amplitudes(x, amplitudes, row) -> None:
    if amplitudes.size > 0 and amplitudes.shape[1] > 1:
        amplitudes[row, 1] = x


@jit_inline
def _linear_energy(p, x, energy, row) -> None:
    """Work of the force and loss by damping of x = 2 Re(X exp(i nu tau)) over a forcing period."""
    if energy.size > 0:
        half_period = math.pi / p.nu
        energy[row, 0] = work_of_force(p, x)
        energy[row, 1] = p.h * (2.0 * p.nu * abs(x)) ** 2 * half_period


@jit_inline
def _linear_motion(p, x, motion, row) -> None:
    if motion.size > 0:
        for i in range(motion.shape[2]):
            turned = 2.0 * x * phase_factor(-i / motion.shape[2])
            motion[row, 0, i] = turned.real
            motion[row, 1, i] = -p.nu * turned.imag


@jit_inline
def solve_linear(p, out, row):
    """A row whose motion strikes nothing: the steady state of eq. (5) in closed form; returns its section."""
    x = linear_amplitude(p)
    _write_label(out, row, NO_IMPACT, 1)
    out.frequency[row] = p.nu
    _linear_amplitudes(x, out.amplitudes, row)
    if out.multipliers.size > 0:
        first, second = linear_multipliers(p)
        write_multipliers(first, second, out.multipliers, row)
    _linear_energy(p, x, out.energy, row)
    _linear_motion(p, x, out.motion, row)
    if out.impact_velocity_max.size > 0:
        out.impact_velocity_max[row, 0], out.impact_velocity_max[row, 1] = math.nan, math.nan
    return 2.0 * x.real, -2.0 * p.nu * x.imag


@jit
def _conservative_amplitudes(a, amplitudes, row) -> None:
    if amplitudes.size > 0:
        for k in range(amplitudes.shape[1]):
            amplitudes[row, k] = arc_harmonic(a, k)


@jit
def _conservative_motion(a, motion, row) -> None:
    if motion.size > 0:
        for i in range(motion.shape[2]):
            motion[row, 0, i], motion[row, 1, i] = arc_state(a, 2.0 * a.half * i / motion.shape[2])


@jit
def _conservative_impacts(a, speeds, count, position, velocity, support, row) -> None:
    """Impacts of a conservative orbit; positions as fractions of its own period."""
    if count.size > 0:
        n = 0
        for side in range(2):
            at_top = top_support(a) == side + 1
            if (a.meets_top if at_top else a.meets_bottom) == 1:
                at = ((0.0 if at_top else a.half) - a.time_from_top) / (2.0 * a.half)
                position[n, row] = at - math.floor(at)
                velocity[n, row] = speeds[side] if side == 0 else -speeds[side]
                support[n, row] = side + 1
                n += 1
        if n == 2 and position[0, row] > position[1, row]:
            position[0, row], position[1, row] = position[1, row], position[0, row]
            velocity[0, row], velocity[1, row] = velocity[1, row], velocity[0, row]
            support[0, row], support[1, row] = support[1, row], support[0, row]
        count[row] = n


@jit_allocating
def solve_conservative(p, x, v, out, row):
    """A conservative row in closed form: its period is its own, its multipliers are 1; returns (x, v)."""
    a = arc(p, x, v)
    speeds, one = np.zeros(2), complex(1.0, 0.0)
    for side in range(2):
        if (a.meets_top if top_support(a) == side + 1 else a.meets_bottom) == 1:
            out.impacts[row, side] = 1.0
            speeds[side] = speed_at(x, v, support_position(p, side + 1))
    _write_label(out, row, regime_of(out.impacts[row], out.rests[row]), 1)
    _conservative_amplitudes(a, out.amplitudes, row)
    write_multipliers(one, one, out.multipliers, row)
    _conservative_impacts(
        a,
        speeds,
        out.impact_count,
        out.impact_position,
        out.impact_velocity,
        out.impact_support,
        row,
    )
    write_largest(speeds, out.impacts[row], out.impact_velocity_max, row)
    _conservative_motion(a, out.motion, row)
    out.frequency[row] = math.pi / a.half
    return x, v
