"""Rows in closed form: linear motions, which reach no support, and conservative ones, without loss or force."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.orbits.forces import (
    ACCELERATION,
    FORCE_MAX,
    IMPULSE,
    NODES,
    SQUARE,
    WEIGHTS,
    add_forces_of_flight,
)
from vibropipe.orbits.outputs import (
    NO_IMPACT,
    regime_of,
    write_largest,
    write_multipliers,
    write_orbit_exponent,
)
from vibropipe.physics.conservative import arc, arc_harmonic, arc_state, speed_at, top_support
from vibropipe.physics.contact import support_position
from vibropipe.physics.linear import (
    linear_amplitude,
    linear_exponent,
    linear_multipliers,
    second_linear_amplitude,
)
from vibropipe.physics.load import has_second
from vibropipe.physics.load_harmonics import work_of_force, work_of_second
from vibropipe.physics.turns import phase_factor


@jit_inline
def write_label(out, row, regime, m) -> None:
    """Write the regime and period multiple m of a row in closed form, whose residual is 0."""
    out.regime[row] = regime
    out.period_multiple[row] = m
    out.residual[row] = 0.0


@jit_inline
def linear_amplitudes(x, amplitudes, row) -> None:
    """Write the amplitudes of x = 2 Re(X exp(i nu tau)): X at the first harmonic, 0 at the others."""
    if amplitudes.size > 0 and amplitudes.shape[1] > 1:
        amplitudes[row, 1] = x


@jit_inline
def _linear_energy(p, x, energy, row) -> None:
    """Write work of the force and loss by damping of x = 2 Re(X exp(i nu tau)) over a forcing period."""
    if energy.size > 0:
        half_period = math.pi / p.nu
        energy[row, 0] = work_of_force(p, x)
        energy[row, 1] = p.h * (2.0 * p.nu * abs(x)) ** 2 * half_period


@jit_inline
def _linear_motion(p, x, motion, row) -> None:
    """Write samples of x = 2 Re(X exp(i nu tau)) and its velocity over a forcing period."""
    if motion.size > 0:
        for i in range(motion.shape[2]):
            rotated = 2.0 * x * phase_factor(-i / motion.shape[2])
            motion[row, 0, i] = rotated.real
            motion[row, 1, i] = -p.nu * rotated.imag


@jit
def _add_second(p, x, amplitudes, energy, motion, row) -> None:
    """Add the part 2 Re(X exp(2 i nu tau)) of a linear motion to its amplitudes, energies and samples."""
    if amplitudes.size > 0 and amplitudes.shape[1] > 2:
        amplitudes[row, 2] = x
    if energy.size > 0:
        energy[row, 0] += work_of_second(p, x)
        energy[row, 1] += p.h * (4.0 * p.nu * abs(x)) ** 2 * (math.pi / p.nu)
    if motion.size > 0:
        for i in range(motion.shape[2]):
            rotated = 2.0 * x * phase_factor(-2.0 * i / motion.shape[2])
            motion[row, 0, i] += rotated.real
            motion[row, 1, i] -= 2.0 * p.nu * rotated.imag


@jit
def write_forces_of_flight(e, p, x, v, out, row, c) -> None:
    """Write the forces of a solved row without contacts from its section (x, v), if requested; c : work array."""
    if out.forces.shape[1] > 0:
        add_forces_of_flight(e, p, x, v, float(out.period_multiple[row]), out.forces[row], c)


@jit_inline
def solve_linear(p, out, row):
    """Solve a row whose motion reaches no support: the steady state of eq. (5) in closed form.

    out : RowResults; outputs without entries are not computed

    Returns the stroboscopic section (x, v).
    """
    x, x_2 = linear_amplitude(p), second_linear_amplitude(p)
    write_label(out, row, NO_IMPACT, 1)
    out.frequency[row] = p.nu
    linear_amplitudes(x, out.amplitudes, row)
    if out.multipliers.size > 0:
        first, second = linear_multipliers(p)
        write_multipliers(first, second, out.multipliers, row)
    write_orbit_exponent(linear_exponent(p), out.exponent, row)
    _linear_energy(p, x, out.energy, row)
    _linear_motion(p, x, out.motion, row)
    if has_second(p):
        _add_second(p, x_2, out.amplitudes, out.energy, out.motion, row)
    if out.impact_velocity_max.size > 0:
        out.impact_velocity_max[row, 0], out.impact_velocity_max[row, 1] = math.nan, math.nan
    if has_second(p):
        return 2.0 * (x.real + x_2.real), -2.0 * p.nu * (x.imag + 2.0 * x_2.imag)
    return 2.0 * x.real, -2.0 * p.nu * x.imag


@jit
def _conservative_amplitudes(orbit, amplitudes, row) -> None:
    """Write the amplitudes of a conservative orbit at the multiples of its own frequency."""
    if amplitudes.size > 0:
        for k in range(amplitudes.shape[1]):
            amplitudes[row, k] = arc_harmonic(orbit, k)


@jit
def _conservative_motion(orbit, motion, row) -> None:
    """Write samples of a conservative orbit at equal fractions of its own period."""
    if motion.size > 0:
        for i in range(motion.shape[2]):
            tau = 2.0 * orbit.half * i / motion.shape[2]
            motion[row, 0, i], motion[row, 1, i] = arc_state(orbit, tau)


@jit
def _conservative_impacts(orbit, speeds, count, position, velocity, support, row, first) -> None:
    """Write the impacts of a conservative orbit in order of time; positions are fractions of its own period."""
    if count.size > 0:
        n = first
        for side in range(2):
            at_top = top_support(orbit) == side + 1
            if (orbit.meets_top if at_top else orbit.meets_bottom) == 1:
                phase = ((0.0 if at_top else orbit.half) - orbit.time_from_top) / (2.0 * orbit.half)
                position[n] = phase - math.floor(phase)
                velocity[n] = speeds[side] if side == 0 else -speeds[side]
                support[n] = side + 1
                n += 1
        i, j = first, first + 1
        if n == first + 2 and position[i] > position[j]:
            position[i], position[j] = position[j], position[i]
            velocity[i], velocity[j] = velocity[j], velocity[i]
            support[i], support[j] = support[j], support[i]
        count[row] = n - first


@jit
def _conservative_forces(p, orbit, speeds, forces) -> None:
    """Write the forces of a conservative orbit over its own period: x'' = -x, and twice the speed of each impact."""
    if forces.size > 0:
        for swing in range(2):
            from_top = orbit.half * swing - orbit.time_from_top
            for g in range(NODES.size):
                x, _v = arc_state(orbit, from_top + orbit.half * NODES[g])
                forces[ACCELERATION] -= WEIGHTS[g] * orbit.half * x
                forces[SQUARE] += WEIGHTS[g] * orbit.half * x * x
            end, _v = arc_state(orbit, from_top)
            forces[FORCE_MAX] = max(forces[FORCE_MAX], abs(p.load + end))
            forces[IMPULSE + swing] = 2.0 * speeds[swing]


@jit
def solve_conservative(p, x, v, out, row, first, c):
    """Solve a conservative row (h = f = 0, R1 = R2 = 1) in closed form.

    The orbit has its own period, not that of the force, and both Floquet multipliers are 1.

    x, v : start of the motion
    out : RowResults; outputs without entries are not computed
    first : index of the first impact of the row
    c : work space, at least two numbers

    Returns the start (x, v), which lies on the orbit.
    """
    orbit = arc(p, x, v)
    speeds, one = c[:2], complex(1.0, 0.0)
    for side in range(2):
        speeds[side] = 0.0
        meets = orbit.meets_top if top_support(orbit) == side + 1 else orbit.meets_bottom
        out.grazings[row, side] = 1.0 if meets == 2 else 0.0
        if meets == 1:
            out.impacts[row, side] = 1.0
            speeds[side] = speed_at(x, v, support_position(p, side + 1))
    write_label(out, row, regime_of(out.impacts[row], out.rests[row]), 1)
    _conservative_amplitudes(orbit, out.amplitudes, row)
    write_multipliers(one, one, out.multipliers, row)
    write_orbit_exponent(0.0, out.exponent, row)
    _conservative_impacts(
        orbit,
        speeds,
        out.impact_count,
        out.impact_position,
        out.impact_velocity,
        out.impact_support,
        row,
        first,
    )
    write_largest(speeds, out.impacts[row], out.impact_velocity_max, row)
    _conservative_motion(orbit, out.motion, row)
    _conservative_forces(p, orbit, speeds, out.forces[row])
    out.frequency[row] = math.pi / orbit.half
    return x, v
