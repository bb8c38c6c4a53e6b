"""Integrals along an orbit by Gauss quadrature of the exact motion: energy, and harmonics at resonance."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.state import REST
from vibropipe.orbits.harmonics import ONE_PERIOD, RESONANT, dynamic_stiffness
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, REACH, displacement, fastest_rate, taylor, velocity
from vibropipe.physics.load import Force, force_at, force_times, forcing_period, phase_factor
from vibropipe.physics.quotient import divide

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@jit
def _add_flight(e, p, x, v, start, end, m, out, energy, c):
    """Add the integrals over one flight from (x, v) at `start` to `end` (forcing periods); returns (x, v)."""
    if end <= start:
        return x, v
    period = forcing_period(p)
    pieces = max(1, math.ceil((end - start) * period * fastest_rate(p.nu, p.h) / REACH))
    dt = (end - start) * period / pieces
    for piece in range(pieces):
        begin = start + (end - start) * piece / pieces
        force = Force(0.0, 0.0)
        if e.forcing is not None:
            force = force_at(p, 1.0, begin)
        taylor(c, x, v, force, 0.0, p.h, p.nu, dt)
        for g in range(NODES.size):
            turn = begin + NODES[g] * dt / period
            at_x = displacement(c, DEGREE, NODES[g])
            at_v = velocity(c, DEGREE, NODES[g], dt)
            share = WEIGHTS[g] * dt / period
            if e.forcing is not None:
                energy[0] += force_times(p, share * period, turn) * at_v
            if e.damping is not None:
                energy[1] += share * period * p.h * at_v * at_v
            for k in range(out.size):
                out[k] += share * at_x * phase_factor(k * turn / m)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return x, v


@jit
def _add_rest(x, start, end, m, out) -> None:
    """Add the integrals over one rest at x; the force does no work and nothing is lost."""
    for g in range(NODES.size):
        turn = start + NODES[g] * (end - start)
        for k in range(out.size):
            out[k] += WEIGHTS[g] * (end - start) * x * phase_factor(k * turn / m)


@jit
def integrate_along(e, p, x, v, start, stop, end, log, m, out, energy, c) -> None:
    """Integrals over a logged motion from (x, v) at `start` to the state `end` at `stop`, in forcing periods.

    out[k] += integral of x exp(-i k nu tau/m), in forcing periods; energy[0] += work of the force,
    energy[1] += loss by damping.
    """
    impacts = min(log.counts[IMPACTS], log.position.size)
    rests = min(log.counts[RESTS], log.rest_start.size)
    now, i, r = start, 0, 0
    chattered = False
    while now < stop:
        impact_at = log.position[i] if i < impacts else math.inf
        rest_at, until, side = math.inf, stop, end.home
        if r < rests:
            rest_at, until, side = (
                max(start, log.rest_start[r]),
                log.rest_end[r],
                int(log.rest_support[r]),
            )
        elif end.mode == REST and r == rests:
            rest_at = max(start, end.rest_start)
        upto = min(min(impact_at, rest_at), stop)
        tail = impact_at <= rest_at and impact_at < stop and log.support[i] < 0
        if tail or chattered:
            # The flights of a completed chatter are no higher than rounding; one over all its time would be.
            _add_rest(x, now, upto, m, out)
        else:
            x, v = _add_flight(e, p, x, v, now, upto, m, out, energy, c)
        now, chattered = upto, tail
        if impact_at <= rest_at and impact_at < stop:
            x = support_position(p, abs(log.support[i]))
            v = log.velocity[i] + log.impulse[i] if log.support[i] > 0 else 0.0
            i += 1
        elif rest_at < stop:
            x, v = support_position(p, side), 0.0
            _add_rest(x, now, until, m, out)
            now, r = until, r + 1


@jit
def tail_loss(p, impulse, side):
    """Energy lost in the completed tail of a chatter that carries `impulse`: all of its departure speed."""
    restitution = p.R1 if side == 0 else p.R2
    speed = (
        abs(impulse) * (1.0 - restitution) / (1.0 + restitution)
        if restitution < 1.0
        else abs(impulse)
    )
    return 0.5 * speed * speed


@jit
def add_losses(p, log, losses) -> None:
    """losses[0] and [1] += energy lost in the logged impacts on support 1 and 2."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        before, impulse = log.velocity[i], log.impulse[i]
        side = abs(log.support[i]) - 1
        if log.support[i] > 0:
            losses[side] -= impulse * (before + 0.5 * impulse)
        else:
            losses[side] += tail_loss(p, impulse, side)


@jit_allocating
def add_energy(e, p, x, v, start, stop, end, log, energy, c) -> None:
    """energy (4,) += work of the force, loss by damping, loss at support 1 and at support 2."""
    integrate_along(
        e, p, x, v, start, stop, end, log, ONE_PERIOD, np.zeros(0, np.complex128), energy, c
    )
    add_losses(p, log, energy[2:])


@jit_allocating
def replace_resonant_harmonics(e, p, x, v, end, log, m, out, energy, c) -> None:
    """Replace the harmonics that `harmonics.divide_by_stiffness` could not divide out by their quadrature."""
    direct = np.zeros(out.size, np.complex128)
    integrate_along(e, p, x, v, 0.0, float(m), end, log, m, direct, energy, c)
    for k in range(out.size):
        if abs(dynamic_stiffness(p, k, m)) < RESONANT:
            out[k] = divide(direct[k], complex(m, 0.0))
