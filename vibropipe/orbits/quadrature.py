"""Integrals along an orbit by Gauss quadrature of the exact motion: energies, forces, harmonics near resonance."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.state import REST
from vibropipe.orbits.forces import (
    ACCELERATION,
    IMPULSE,
    NODES,
    SQUARE,
    WEIGHTS,
    Integrals,
    add_forces,
    note_still,
    step_of_flight,
)
from vibropipe.orbits.harmonics import RESONANT, dynamic_stiffness
from vibropipe.orbits.return_map import state_xv
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, displacement, taylor, velocity
from vibropipe.physics.load import (
    first_harmonic,
    force_at,
    force_times,
    forcing_period,
    no_force,
    second_harmonic,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import phase_factor


@jit
def _add_flight(e, p, x, v, start, end, sums, c):
    """Add the integrals over a flight from (x, v) at `start` to `end` (forcing periods); return (x, v) at its end."""
    if end <= start:
        return x, v
    period, energy, out = forcing_period(p), sums.energy, sums.harmonics
    second = e.second_harmonic
    pieces, step = step_of_flight(e, p, end - start)
    dt = step.dt
    for piece in range(pieces):
        begin = start + (end - start) * piece / pieces
        force = no_force()
        if e.forcing is not None:
            force = force_at(p, 1.0, begin, second)
        taylor(c, x, v, force, 0.0, p.h, p.nu, dt, second)
        add_forces(e, p, step, begin, c, sums.forces)
        for g in range(NODES.size):
            phase = begin + NODES[g] * dt / period
            node_v = velocity(c, DEGREE, NODES[g], dt)
            weight = WEIGHTS[g] * dt / period
            if e.forcing is not None:
                energy[0] += force_times(p, weight * period, phase, second) * node_v
            if e.damping is not None:
                energy[1] += weight * period * p.h * node_v * node_v
            if out.size > 0:
                node_x = displacement(c, DEGREE, NODES[g])
                for k in range(out.size):
                    out[k] += weight * node_x * phase_factor(k * phase / sums.m)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return x, v


@jit
def _add_rest(x, start, end, sums) -> None:
    """Add the integrals of x over a rest, during which the force does no work and nothing is lost."""
    out = sums.harmonics
    for g in range(NODES.size):
        phase = start + NODES[g] * (end - start)
        for k in range(out.size):
            out[k] += WEIGHTS[g] * (end - start) * x * phase_factor(k * phase / sums.m)


@jit
def integrate_along(e, p, x, v, start, stop, end, log, sums, c) -> None:
    """Integrate over a logged motion.

    x, v : start of the motion
    start, stop : start and end, in forcing periods
    end : state at `stop`
    log : contacts; positions in forcing periods
    sums : Integrals, energy[0] is increased by the work of the force, energy[1] by the loss by damping; forces by those
        of flights and rests; harmonics
    c : (DEGREE + 1,), work array
    """
    n_impacts = min(log.counts[IMPACTS], log.position.size)
    n_rests = min(log.counts[RESTS], log.rest_start.size)
    position, i, r = start, 0, 0
    is_after_tail = False
    while position < stop:
        next_impact = log.position[i] if i < n_impacts else math.inf
        next_rest, rest_end, side = math.inf, stop, end.home
        if r < n_rests:
            next_rest, rest_end = max(start, log.rest_start[r]), log.rest_end[r]
            side = int(log.rest_support[r])
        elif end.mode == REST and r == n_rests:
            next_rest = max(start, end.rest_start)
        flight_end = min(min(next_impact, next_rest), stop)
        is_tail = next_impact <= next_rest and next_impact < stop and log.support[i] < 0
        if is_tail or is_after_tail:
            # The remaining flights of a chatter are no higher than rounding; a single flight over all its time is not.
            _add_rest(x, position, flight_end, sums)
        else:
            x, v = _add_flight(e, p, x, v, position, flight_end, sums, c)
        position, is_after_tail = flight_end, is_tail
        if next_impact <= next_rest and next_impact < stop:
            x = support_position(p, abs(log.support[i]))
            v = log.velocity[i] + log.impulse[i] if log.support[i] > 0 else 0.0
            i += 1
        elif next_rest < stop:
            x, v = support_position(p, side), 0.0
            _add_rest(x, position, rest_end, sums)
            note_still(p, 0.0, 0.0, sums.forces)
            position, r = rest_end, r + 1


@jit
def tail_speed(p, impulse, side):
    """Return the speed with which the tail of a chatter began; it loses the kinetic energy of that.

    impulse : sum of the impulses of the tail
    side : index of the support, 0 or 1
    """
    restitution = p.R1 if side == 0 else p.R2
    speed = abs(impulse)
    if restitution < 1.0:
        speed = speed * (1.0 - restitution) / (1.0 + restitution)
    return speed


@jit
def add_forces_of_tail(p, turn, speed, impulse, side, forces) -> None:
    """Add the forces between the impacts of the tail of a chatter: its acceleration hardly changes.

    turn : middle of the tail, in forcing periods; speed : with which it began; impulse, side : as for `tail_speed`
    """
    # What the flights do to the momentum, the impulses take from it, and the speed at the start.
    turned = (speed + abs(impulse)) * (1.0 if side == 0 else -1.0) / (1.0 + p.mass_ratio)
    pull = first_harmonic(p, turn) + second_harmonic(p, turn) - support_position(p, side + 1)
    forces[ACCELERATION] += turned
    forces[SQUARE] += pull * turned


@jit
def add_losses(p, log, sums) -> None:
    """Add the energies lost in the logged impacts on rigid supports, and what impulses these take, to `Integrals`.

    An impact on a housing changes the motion of one body in the other alone, whose mass is 1/(1 + kappa).
    """
    losses, inertia = sums.energy[2:], 1.0 / (1.0 + p.mass_ratio)
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        before, impulse = log.velocity[i], log.impulse[i]
        side = abs(log.support[i]) - 1
        if log.support[i] > 0:
            losses[side] -= inertia * impulse * (before + 0.5 * impulse)
        else:
            speed = tail_speed(p, impulse, side)
            losses[side] += inertia * 0.5 * speed * speed
            if sums.forces.size > 0:
                add_forces_of_tail(p, log.position[i], speed, impulse, side, sums.forces)
        if sums.forces.size > 0:
            sums.forces[IMPULSE + side] += inertia * abs(impulse)


@jit
def add_energy(e, p, x, v, start, stop, end, log, sums, c) -> None:
    """Add the energies of a logged motion, and its forces if requested.

    e, p, x, v, start, stop, end, log, c : as for `integrate_along`
    sums : Integrals, whose energy, (4,) or longer, is increased by the work of the force and the losses by damping, at
        support 1 and at support 2
    """
    integrate_along(e, p, x, v, start, stop, end, log, sums, c)
    add_losses(p, log, sums)


@jit
def replace_resonant_harmonics(e, p, steady, log, m, out, work, c) -> None:
    """Replace the harmonics of an orbit that `harmonics.divide_by_stiffness` left unchanged by quadrature.

    e, p, log, c : as for `integrate_along`
    steady : SteadyState, the orbit
    m : denominator of the frequencies k nu/m
    out : (harmonics + 1,) complex, amplitudes
    work : tuple of ndarray, room for harmonics, complex and at least as long as `out`, and for energies, (2,)
    """
    direct, energy = work
    for k in range(out.size):
        direct[k] = 0.0
    length, (x, v) = float(steady.m), state_xv(p, steady.state)
    sums = Integrals(energy, energy[:0], direct[: out.size], m)
    integrate_along(e, p, x, v, 0.0, length, steady.end, log, sums, c)
    for k in range(out.size):
        if abs(dynamic_stiffness(p, k, m)) < RESONANT:
            out[k] = divide(direct[k], complex(length, 0.0))
