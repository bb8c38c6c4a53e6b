"""Integrals along an orbit by Gauss quadrature of the exact motion: energies, and harmonics near resonance."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.state import REST
from vibropipe.orbits.harmonics import ONE_PERIOD, RESONANT, dynamic_stiffness
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, REACH, displacement, fastest_rate, taylor, velocity
from vibropipe.physics.load import fastest_forcing, force_at, force_times, forcing_period, no_force
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import phase_factor

# Gauss-Legendre rule on [0, 1] for each step of the polynomial motion; exact up to degree 19.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@jit
def _add_flight(e, p, x, v, start, end, m, out, energy, c):
    """Add the integrals over a flight from (x, v) at `start` to `end` (forcing periods); return (x, v) at its end."""
    if end <= start:
        return x, v
    period = forcing_period(p)
    second = e.second_harmonic
    rate = fastest_rate(fastest_forcing(p, second), p.h)
    pieces = max(1, math.ceil((end - start) * period * rate / REACH))
    dt = (end - start) * period / pieces
    for piece in range(pieces):
        begin = start + (end - start) * piece / pieces
        force = no_force()
        if e.forcing is not None:
            force = force_at(p, 1.0, begin, second)
        taylor(c, x, v, force, 0.0, p.h, p.nu, dt, second)
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
                    out[k] += weight * node_x * phase_factor(k * phase / m)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return x, v


@jit
def _add_rest(x, start, end, m, out) -> None:
    """Add the integrals of x over a rest, during which the force does no work and nothing is lost."""
    for g in range(NODES.size):
        phase = start + NODES[g] * (end - start)
        for k in range(out.size):
            out[k] += WEIGHTS[g] * (end - start) * x * phase_factor(k * phase / m)


@jit
def integrate_along(e, p, x, v, start, stop, end, log, m, out, energy, c) -> None:
    """Integrate over a logged motion.

    Parameters
    ----------
    e : Effects
    p : Parameters
    x, v : float
        Start of the motion.
    start, stop : float
        Start and end, in forcing periods.
    end : State
        State at `stop`.
    log : Log
        Contacts; positions in forcing periods.
    m : int
        Denominator of the frequencies k nu/m.
    out : (harmonics + 1,) complex
        out[k] is increased by the integral of x exp(-i k nu tau/m), in forcing periods.
    energy : (2,) float or longer
        energy[0] is increased by the work of the force, energy[1] by the loss by damping.
    c : (DEGREE + 1,) float
        Work array.
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
            _add_rest(x, position, flight_end, m, out)
        else:
            x, v = _add_flight(e, p, x, v, position, flight_end, m, out, energy, c)
        position, is_after_tail = flight_end, is_tail
        if next_impact <= next_rest and next_impact < stop:
            x = support_position(p, abs(log.support[i]))
            v = log.velocity[i] + log.impulse[i] if log.support[i] > 0 else 0.0
            i += 1
        elif next_rest < stop:
            x, v = support_position(p, side), 0.0
            _add_rest(x, position, rest_end, m, out)
            position, r = rest_end, r + 1


@jit
def tail_loss(p, impulse, side):
    """Return the energy lost in the tail of a chatter: the kinetic energy with which the tail began.

    Parameters
    ----------
    p : Parameters
    impulse : float
        Sum of the impulses of the tail.
    side : int
        Index of the support, 0 or 1.
    """
    restitution = p.R1 if side == 0 else p.R2
    speed = abs(impulse)
    if restitution < 1.0:
        speed = speed * (1.0 - restitution) / (1.0 + restitution)
    return 0.5 * speed * speed


@jit
def add_losses(p, log, losses) -> None:
    """Add the energies lost in the logged impacts on support 1 and 2 to losses[0] and losses[1]."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        before, impulse = log.velocity[i], log.impulse[i]
        side = abs(log.support[i]) - 1
        if log.support[i] > 0:
            losses[side] -= impulse * (before + 0.5 * impulse)
        else:
            losses[side] += tail_loss(p, impulse, side)


@jit
def add_energy(e, p, x, v, start, stop, end, log, none, energy, c) -> None:
    """Add the energies of a logged motion.

    Parameters
    ----------
    e, p, x, v, start, stop, end, log, c
        As for `integrate_along`.
    none : (0,) complex
        No harmonics.
    energy : (4,) float or longer
        Increased by the work of the force and the losses by damping, at support 1 and at support 2.
    """
    integrate_along(e, p, x, v, start, stop, end, log, ONE_PERIOD, none, energy, c)
    add_losses(p, log, energy[2:])


@jit
def replace_resonant_harmonics(e, p, x, v, end, log, m, length, out, work, c) -> None:
    """Replace the harmonics that `harmonics.divide_by_stiffness` left unchanged by quadrature.

    Parameters
    ----------
    e, p, x, v, end, log, m, c
        As for `integrate_along`, from 0 to `length` forcing periods.
    length : float
        Length of the orbit, in forcing periods.
    out : (harmonics + 1,) complex
        Amplitudes.
    work : tuple of ndarray
        Room for harmonics, complex and at least as long as `out`, and for energies, (2,).
    """
    direct, energy = work
    for k in range(out.size):
        direct[k] = 0.0
    integrate_along(e, p, x, v, 0.0, length, end, log, m, direct[: out.size], energy, c)
    for k in range(out.size):
        if abs(dynamic_stiffness(p, k, m)) < RESONANT:
            out[k] = divide(direct[k], complex(length, 0.0))
