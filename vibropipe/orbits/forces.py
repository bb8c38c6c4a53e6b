"""The forces of a motion between impacts, along its steps: on the frame and on soft supports, and of the drive.

The frame takes load - x'': spring, damper, friction, supports and the reaction of the drive together (docs/theory.md).
One that is a housing that slides takes load - (x'' + X''); what stands below for x'' is then x'' + X''.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.flow import DEGREE, REACH, displacement, fastest_rate, taylor, velocity
from vibropipe.physics.load import fastest_forcing, force_at, force_times, forcing_period, no_force
from vibropipe.physics.stiffness import damping_of, stiffness_of

# Gauss-Legendre rule on [0, 1] for each step of the polynomial motion; exact up to degree 19.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# Columns of `Integrals.forces`, and their number. Integrals of x'' and x''^2 over tau; impulses that the supports take;
# largest power of the drive and largest force on the frame.
ACCELERATION, SQUARE, IMPULSE, _IMPULSE_2, POWER_MAX, FORCE_MAX, FORCES = range(7)
# Intervals of a step between which its largest values are looked for; the width of a bracket, in steps, at which the
# value at its middle is a maximum to rounding.
INTERVALS, BRACKET = 4, 1e-8
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


class Integrals(NamedTuple):
    """Sums that grow along a motion.

    energy : (2,) or longer, work of the force, loss by damping, and so on (`RowResults`)
    forces : (FORCES,), its columns are named above; without entries if not requested
    harmonics : (n,) complex, of x exp(-i k nu tau/m), k = 0, 1, ..., in forcing periods; without entries if not
        requested
    m : denominator of the frequencies k nu/m
    """

    energy: np.ndarray
    forces: np.ndarray
    harmonics: np.ndarray
    m: np.int64


class Step(NamedTuple):
    """A step of a motion by its polynomial, y'' = load + sigma force - stiffness y - damping y'.

    stiffness, damping, load, sigma : coefficients, and the sign of x in y
    support : the soft support that it touches, or 0
    dt : length in tau
    """

    stiffness: float
    damping: float
    load: float
    sigma: float
    support: int
    dt: float


@jit
def forces_at(e, p, step, begin, c, theta):
    """Return (x'', power of the drive, force on the soft support) at a share theta of a step.

    begin : its start in forcing periods; c : its polynomial.
    """
    y, w = displacement(c, DEGREE, theta), velocity(c, DEGREE, theta, step.dt)
    x_rate = step.sigma * w
    a, power, contact = step.load - step.stiffness * y - step.damping * w, 0.0, 0.0
    a *= step.sigma
    if e.forcing is not None:
        turn = begin + theta * step.dt / forcing_period(p)
        force = force_times(p, 1.0, turn, e.second_harmonic)
        a, power = a + force, force * x_rate
    if step.support > 0:
        contact = -stiffness_of(p, step.support) * y - damping_of(p, step.support) * w
    return a, power, contact


@jit
def sought_at(e, p, step, begin, c, theta, column):
    """Return the power of the drive or the size of the force on the frame at a share of a step."""
    a, power, _contact = forces_at(e, p, step, begin, c, theta)
    return power if column == POWER_MAX else abs(p.load - a)


@jit
def note_largest(e, p, step, begin, c, column, forces) -> None:
    """Let `forces[column]` be at least the largest value in a step, found by golden section where one may be larger."""
    best, place, bend, last, first_change, change = -math.inf, 0, 0.0, 0.0, 0.0, 0.0
    for i in range(INTERVALS + 1):
        value = sought_at(e, p, step, begin, c, i / INTERVALS, column)
        if i == 1:
            first_change = value - last
        elif i > 1:
            bend = max(bend, abs(value - last - change))
        if value > best:
            best, place = value, i
        last, change = value, value - last
    known = forces[column]
    forces[column] = max(known, best)
    # A parabola rises between its points by an eighth of its second difference at most, and has no vertex next to an
    # end where it still changes by more than that; the bound is twice that for what is no parabola.
    leaves = (place == 0 and -first_change > bend) or (place == INTERVALS and change > bend)
    if leaves or best + 0.25 * bend <= known:
        return
    low, high = max(0, place - 1) / INTERVALS, min(INTERVALS, place + 1) / INTERVALS
    one, two = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_one = sought_at(e, p, step, begin, c, one, column)
    at_two = sought_at(e, p, step, begin, c, two, column)
    while high - low > BRACKET:
        if at_one > at_two:
            high, two, at_two = two, one, at_one
            one = high - GOLDEN * (high - low)
            at_one = sought_at(e, p, step, begin, c, one, column)
        else:
            low, one, at_one = one, two, at_two
            two = low + GOLDEN * (high - low)
            at_two = sought_at(e, p, step, begin, c, two, column)
    forces[column] = max(forces[column], max(at_one, at_two))


@jit
def add_forces(e, p, step, begin, c, forces) -> None:
    """Add the forces of a step to `forces`, (FORCES,) or without entries; arguments as for `forces_at`."""
    if forces.size == 0:
        return
    for g in range(NODES.size):
        a, _power, contact = forces_at(e, p, step, begin, c, NODES[g])
        forces[ACCELERATION] += WEIGHTS[g] * step.dt * a
        forces[SQUARE] += WEIGHTS[g] * step.dt * a * a
        if step.support > 0:
            forces[IMPULSE + step.support - 1] += WEIGHTS[g] * step.dt * contact
    note_largest(e, p, step, begin, c, POWER_MAX, forces)
    note_largest(e, p, step, begin, c, FORCE_MAX, forces)


@jit
def note_still(p, acceleration, span, forces) -> None:
    """Note the force on the frame, for a time `span`, of a mass that lies still in a frame with an acceleration."""
    if forces.size > 0:
        forces[ACCELERATION] += acceleration * span
        forces[SQUARE] += acceleration * acceleration * span
        forces[FORCE_MAX] = max(forces[FORCE_MAX], abs(p.load - acceleration))


@jit
def step_of_flight(e, p, span):
    """Return the number of steps of a flight over `span` forcing periods, and what each is."""
    tau, damping = span * forcing_period(p), 0.0
    rate = fastest_rate(fastest_forcing(p, e.second_harmonic), p.h)
    steps = max(1, math.ceil(tau * rate / REACH))
    if e.damping is not None:
        damping = p.h
    return steps, Step(1.0, damping, 0.0, 1.0, 0, tau / steps)


@jit
def add_forces_of_flight(e, p, x, v, span, forces, c) -> None:
    """Add the forces of a motion without contact from (x, v), over `span` forcing periods; c : work array."""
    steps, step = step_of_flight(e, p, span)
    for i in range(steps):
        begin, force = span * i / steps, no_force()
        if e.forcing is not None:
            force = force_at(p, 1.0, begin, e.second_harmonic)
        taylor(c, x, v, force, 0.0, p.h, p.nu, step.dt, e.second_harmonic)
        add_forces(e, p, step, begin, c, forces)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, step.dt)
