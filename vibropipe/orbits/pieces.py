"""Derivative, harmonics and energies of a motion with soft supports or friction, from its logged linear pieces."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    BEYOND,
    CAUSE,
    CONTACT,
    DIRECTION,
    ENTER,
    FORM,
    FREE,
    HELD,
    HOME,
    IMPACT,
    LEAVE,
    PIECES,
    RESTING,
    SLIP,
    SPAN,
    STICK,
    TURN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients, net_force
from vibropipe.march.state import restitution_of
from vibropipe.orbits.forces import IMPULSE, NODES, WEIGHTS, Integrals, Step, add_forces, note_still
from vibropipe.orbits.harmonics import RESONANT
from vibropipe.orbits.piece_terms import load_of_piece, terms_of, way_of
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.decay import ALIVE, FOLLOWING, decay_of, decay_of_kind, decayed_taylor
from vibropipe.physics.flow import DEGREE, REACH, displacement, velocity
from vibropipe.physics.friction import friction_of, jumps_at_slip
from vibropipe.physics.housing import momentum_rate, times_force
from vibropipe.physics.load import fastest_forcing, force_at, force_times, forcing_period, no_force
from vibropipe.physics.load_harmonics import reaction_integral
from vibropipe.physics.quotient import divide
from vibropipe.physics.saltation import product, saltation_matrix
from vibropipe.physics.stiffness import (
    damping_of,
    is_soft,
    piece_flow,
    piece_rate,
    piece_taylor,
    stiffness_of,
)
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral

# Steps of a piece above which it is looked at whether its exponentials have decayed.
MANY_STEPS = 2.0**12
# Steps between two such looks.
STRETCH = 32.0


@jit
def saltation_of_piece(e, p, pieces, i):
    """Return the saltation matrix (s11, s12, s21, s22) at the event that begins piece i.

    Entering and leaving a soft support changes the acceleration by its damping, unless that let go before; a turn
    reverses the friction; a stick takes the velocity, and keeps the displacement. A slip begins without velocity and,
    unless static friction is larger than kinetic, without acceleration: the flow is smooth.

    Reference: R. I. Leine, H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", Springer (2004),
    ch. 3.
    """
    codes, values = pieces.codes, pieces.values
    cause, home = codes[i, CAUSE], codes[i, HOME]
    if cause == STICK or (cause == BEGIN and codes[i, FORM] == HELD):
        return 1.0, 0.0, 0.0, 0.0
    if cause in (ENTER, LEAVE):
        # A support that has let go before does not act where the mass leaves.
        damping = 0.0 if cause == LEAVE and codes[i - 1, FORM] == BEYOND else damping_of(p, home)
        return 1.0, 0.0, -damping if cause == ENTER else damping, 1.0
    if cause in (TURN, IMPACT):
        force, _rate, _scale = net_force(e, p, home, values[i, Y], values[i, AT])
        friction, damping = friction_of(e, p), 0.0
        if e.damping is not None:
            damping = p.h
        after = force - friction * codes[i, DIRECTION] - damping * values[i, W]
        if cause == TURN:
            before = force + friction * codes[i, DIRECTION]
            return 1.0, 0.0, 0.0, after / before
        arrives = to_velocity(codes[i - 1, HOME], values[i - 1, W_END])
        arrives = to_velocity(home, arrives)
        before = force + friction - damping * arrives
        return saltation_matrix(restitution_of(e, p, home), arrives, before, after)
    if cause == SLIP and jumps_at_slip(e, p):
        # A mass that is held farther from the equilibrium slips at another time, and with an acceleration.
        _force, rate, _scale = net_force(e, p, home, values[i, Y], values[i, AT])
        stiffness, _damping = coefficients(e, p, home, codes[i, FORM] == CONTACT)
        jump = (p.friction_ratio - 1.0) * p.friction * codes[i, DIRECTION]
        return 1.0, 0.0, -jump * stiffness / rate, 1.0
    return 1.0, 0.0, 0.0, 1.0


@jit
def jacobian_of_pieces(e, p, pieces):
    """Return the Jacobian (j11, j12, j21, j22) of the motion over all logged pieces; zero after a rest."""
    j11, j12, j21, j22 = 1.0, 0.0, 0.0, 1.0
    for i in range(pieces.counts[PIECES]):
        form, home = pieces.codes[i, FORM], pieces.codes[i, HOME]
        if form == RESTING:
            return 0.0, 0.0, 0.0, 0.0
        s11, s12, s21, s22 = saltation_of_piece(e, p, pieces, i)
        j11, j12, j21, j22 = product(s11, s12, s21, s22, j11, j12, j21, j22)
        if form in (FREE, CONTACT, BEYOND):
            stiffness, damping = coefficients(e, p, home, form == CONTACT)
            e11, e12, e21, e22 = piece_flow(stiffness, damping, pieces.values[i, SPAN])
            j11, j12, j21, j22 = product(e11, e12, e21, e22, j11, j12, j21, j22)
    return j11, j12, j21, j22


@jit
def end_of_piece(p, pieces, i):
    """Return the time at which piece i ends, in forcing periods."""
    return pieces.values[i, AT] + pieces.values[i, SPAN] / forcing_period(p)


@jit
def stiffness_at(stiffness, damping, w):
    """Return stiffness - w^2 + i damping w, the dynamic stiffness of a piece."""
    root = math.sqrt(stiffness)
    return complex((root - w) * (root + w), damping * w)


@jit
def integral_of_piece(e, p, pieces, i, k, m):
    """Return the integral of x exp(-i k nu tau/m) over piece i, in forcing periods, in closed form.

    Also returns whether it is accurate: not near a resonance of the piece.
    """
    home, form = pieces.codes[i, HOME], pieces.codes[i, FORM]
    start, end = pieces.values[i, AT], end_of_piece(p, pieces, i)
    phase = phase_integral(k / m, start, end)
    if form in (HELD, RESTING):
        return to_displacement(p, home, pieces.values[i, Y]) * phase, True
    terms = terms_of(e, p, pieces, i)
    w = k * p.nu / m
    dynamic = stiffness_at(terms.stiffness, terms.damping, w)
    if abs(dynamic) < RESONANT * terms.stiffness:
        return complex(0.0, 0.0), False
    sigma = terms.sigma
    total = terms.load * phase
    if e.forcing is not None:
        total -= terms.factor * sigma * reaction_integral(p, k, m, start, end)
    rate = complex(terms.damping, w)
    first = (pieces.values[i, W] + rate * pieces.values[i, Y]) * phase_factor(k * start / m)
    last = (pieces.values[i, W_END] + rate * pieces.values[i, Y_END]) * phase_factor(k * end / m)
    total -= (last - first) * (p.nu / TWO_PI)
    return to_displacement(p, home, 0.0) * phase + sigma * divide(total, dynamic), True


@jit
def add_harmonics_of_pieces(e, p, pieces, m, out, direct) -> None:
    """Add the integrals of x exp(-i k nu tau/m) over all logged pieces to out[k], in forcing periods.

    Near a resonance of a piece they are taken by quadrature. direct : work array of the size of `out`.
    """
    is_complete = True
    for k in range(out.size):
        for i in range(pieces.counts[PIECES]):
            is_complete = is_complete and integral_of_piece(e, p, pieces, i, k, m)[1]
    if not is_complete:
        for k in range(out.size):
            direct[k] = 0.0
        for i in range(pieces.counts[PIECES]):
            sums = Integrals(pieces.energy, pieces.energy[:0], direct, m)
            integrate_piece(e, p, pieces, i, sums)
    for k in range(out.size):
        total, is_accurate = complex(0.0, 0.0), True
        for i in range(pieces.counts[PIECES]):
            part, is_part_accurate = integral_of_piece(e, p, pieces, i, k, m)
            total += part
            is_accurate = is_accurate and is_part_accurate
        out[k] += total if is_accurate else direct[k]


@jit
def steps_of_span(p, stiffness, damping, span, second):
    """Return the steps of a piece of the length `span` for which a polynomial is exact to rounding, a whole number."""
    return steps_at(max(fastest_forcing(p, second), piece_rate(stiffness, damping)), span)


@jit
def steps_at(rate, span) -> float:
    """Return the steps of a motion with a fastest rate for which a polynomial is exact to rounding, a whole number."""
    return max(1.0, float(np.ceil(span * rate / REACH)))


@jit
def decay_after(e, p, pieces, i, span, y, w):
    """Return the `Decay` of piece i in the state (y, w), a time span after its start."""
    terms = terms_of(e, p, pieces, i)
    force, second = no_force(), e.second_harmonic
    if e.forcing is not None:
        turn = pieces.values[i, AT] + span / forcing_period(p)
        force = times_force(terms.factor, force_at(p, terms.sigma, turn, second))
    return decay_of(y, w, force, terms.load, terms.stiffness, terms.damping, p, second)


@jit
def integrate_piece(e, p, pieces, i, sums) -> None:
    """Add the integrals over piece i by Gauss quadrature.

    e, p, pieces, i : piece i of a log
    sums : Integrals, whose energy (5,) is increased by the work of the force and the losses by damping, at support 1
        and 2, and by friction
    """
    home, form = pieces.codes[i, HOME], pieces.codes[i, FORM]
    start, span = pieces.values[i, AT], pieces.values[i, SPAN]
    if not span > 0.0:
        return
    y, w = pieces.values[i, Y], pieces.values[i, W]
    if form in (HELD, RESTING):
        x = to_displacement(p, home, y)
        for k in range(sums.harmonics.size):
            integral = phase_integral(k / sums.m, start, end_of_piece(p, pieces, i))
            sums.harmonics[k] += x * integral
        note_still(p, momentum_rate(p, way_of(pieces.housing, i)), span, sums.forces)
        if sums.forces.size > 0 and is_soft(e, p, home) and y < 0.0:
            sums.forces[IMPULSE + home - 1] -= stiffness_of(p, home) * y * span
        return
    friction = friction_of(e, p)
    if e.friction is not None:
        sums.energy[4] += friction * abs(pieces.values[i, Y_END] - y)
    if form == BEYOND:
        # What the spring stores when the support lets go is lost in its damper.
        last = pieces.values[i, Y_END]
        sums.energy[1 + home] += 0.5 * stiffness_of(p, home) * (y - last) * (y + last)
    terms = terms_of(e, p, pieces, i)
    steps = steps_of_span(p, terms.stiffness, terms.damping, span, e.second_harmonic)
    if steps <= MANY_STEPS:
        integrate_stretch(e, p, pieces, i, Stretch(0.0, span, ALIVE, steps), y, w, sums)
        return
    # In stretches, with steps as long as what is left of the motion allows.
    done = 0.0
    while done < span:
        decay = decay_after(e, p, pieces, i, done, y, w)
        length = min(span - done, STRETCH * REACH / decay.rate)
        if decay.kind == FOLLOWING:
            length = span - done
        stretch = Stretch(done, length, decay.kind, steps_at(decay.rate, length))
        y, w = integrate_stretch(e, p, pieces, i, stretch, y, w, sums)
        done += length


class Stretch(NamedTuple):
    """A stretch of a piece.

    start : time after that of the piece, in tau
    span : its length, in tau
    kind : what is left of the motion (`physics.decay`)
    steps : whole number of steps that it is divided into
    """

    start: float
    span: float
    kind: int
    steps: float


@jit
def integrate_stretch(e, p, pieces, i, stretch, y, w, sums):
    """Add what `integrate_piece` does over a `Stretch`; y, w : state at its start. Returns (y, w) at its end."""
    home, form, second = pieces.codes[i, HOME], pieces.codes[i, FORM], e.second_harmonic
    period, energy, out, kind = forcing_period(p), sums.energy, sums.harmonics, stretch.kind
    start = pieces.values[i, AT] + stretch.start / period
    terms = terms_of(e, p, pieces, i)
    load, stiffness, damping = terms.load, terms.stiffness, terms.damping
    parts = int(stretch.steps)
    dt, c = stretch.span / parts, pieces.polynomial
    touched = home if form == CONTACT else 0
    step = Step(stiffness, damping, load, terms.sigma, touched, dt)
    if e.housing is not None:
        # What the frame takes is the force on the mass, whether its housing slides or not.
        held_stiffness, held_damping = coefficients(e, p, home, form == CONTACT)
        sigma, held_load = load_of_piece(e, p, pieces, i)
        step = Step(held_stiffness, held_damping, held_load, sigma, touched, dt)
    for part in range(parts):
        begin = start + part * dt / period
        force = no_force()
        if e.forcing is not None:
            force = times_force(terms.factor, force_at(p, terms.sigma, begin, second))
        if kind == ALIVE:
            piece_taylor(c, y, w, force, load, stiffness, damping, p.nu, dt, second)
        else:
            left = decay_of_kind(kind, force, load, stiffness, damping, p, second)
            decayed_taylor(c, y, left, p.nu, dt, second)
        add_forces(e, p, step, begin, c, sums.forces)
        for g in range(NODES.size):
            phase = begin + NODES[g] * dt / period
            node_y = displacement(c, DEGREE, NODES[g])
            node_w = velocity(c, DEGREE, NODES[g], dt)
            weight = WEIGHTS[g] * dt
            if e.forcing is not None:
                energy[0] += force_times(p, weight, phase, second) * to_velocity(home, node_w)
            if e.damping is not None:
                energy[1] += weight * p.h * node_w * node_w
            if form == CONTACT:
                energy[1 + home] += weight * damping_of(p, home) * node_w * node_w
            x = to_displacement(p, home, node_y)
            for k in range(out.size):
                out[k] += weight / period * x * phase_factor(k * phase / sums.m)
        y, w = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return y, w


@jit
def add_energy_of_pieces(e, p, pieces, sums) -> None:
    """Add the energies and forces of the logged pieces, without impacts on rigid supports, to `Integrals`."""
    for i in range(pieces.counts[PIECES]):
        integrate_piece(e, p, pieces, i, sums)
