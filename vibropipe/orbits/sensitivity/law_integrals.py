"""Derivatives of the integrals along an orbit of linear pieces, of its amplitudes and energies, by Gauss quadrature.

On a piece the derivative of the motion at a fixed phase follows in closed form from that of its start and from the
parameters. Amplitudes have no jumps; rates of energies do, and the events move.
"""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.piece_log import (
    BEYOND,
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    IMPACT,
    REST_BEGINS,
    RESTING,
)
from vibropipe.orbits.forces import NODES, WEIGHTS
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.law.flights import flight_of, flown_by, force_on
from vibropipe.orbits.law.states import sign_of
from vibropipe.orbits.sensitivity.law_orbit import (
    PLACE,
    RATE,
    TIME,
    ends_of_piece,
    fill_arrival,
    fill_departure,
)
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.decay import FOLLOWING, decay_of
from vibropipe.physics.derivatives import (
    FRICTION,
    H1,
    K1,
    MASS_RATIO,
    NU,
    H,
    force_derivative,
    restitution_derivative,
    support_derivative,
)
from vibropipe.physics.load import fastest_forcing, force_times, forcing_period
from vibropipe.physics.piece import acceleration_of, by_phase, flown, force_at_end
from vibropipe.physics.stiffness import damping_of, piece_rate, stiffness_of
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral

# Product of the fastest rate of an integrand and a step over which the nodes of one step integrate it to rounding.
REACH_OF_NODES = 5.0
# The same of a rule of fewer nodes, for pieces that are short.
FEW_REACH = 0.25
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
FEW_NODES, FEW_WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# Steps of a piece above which it is looked at what has decayed, and between two such looks.
MANY_STEPS, STRETCH = 256.0, 16.0
# Steps of a piece above which the integrals of its orbit are NaN: they would take a second.
MAX_STEPS = 1e5


@jit
def reference_derivative(home, k):
    """Return the derivative of the origin of a frame by parameter k."""
    return support_derivative(home, k) if home > 0 else 0.0


@jit_inline
def fill_node(e, p, law, i, start, changes, flight, columns, node):
    """Fill the derivatives (2, k) of (y, y') at the end of a flight along piece i, at a fixed phase.

    start : of the piece
    changes : (3, k), derivatives of its start
    columns : (k,) int64, parameters

    Returns y' there.
    """
    y, w = flown(flight, start.y, start.w)
    a = acceleration_of(flight, force_at_end(flight), y, w)
    (late, faster), period, free = by_phase(flight), forcing_period(p), flight.free
    by_start, rate_by_start = TWO_PI * late - period * w, TWO_PI * faster - period * a
    for j in range(columns.size):
        k, dy, dw = columns[j], changes[PLACE, j], changes[RATE, j]
        to_y, to_w = flown_by(e, p, law, i, flight, (start.y, start.w), start.t, k)
        if k == NU:
            to_y, to_w = to_y - flight.t / p.nu * w, to_w - flight.t / p.nu * a
        node[0, j] = to_y + free.c * dy + free.s * dw + by_start * changes[TIME, j]
        node[1, j] = to_w + free.ds * dw - flight.stiffness * free.s * dy
        node[1, j] += rate_by_start * changes[TIME, j]
    return w


@jit
def loss_rates(e, p, law, i, turn, w):
    """Return the rates at which work is done by the force, and lost by damping and in contact, on piece i."""
    home, work, damped, in_contact = law.codes[i, HOME], 0.0, 0.0, 0.0
    if e.forcing is not None:
        work = to_velocity(home, force_times(p, w, turn, e.second_harmonic))
    if e.damping is not None:
        damped = p.h * w * w
    if law.codes[i, FORM] == CONTACT:
        in_contact = damping_of(p, home) * w * w
    return work, damped, in_contact


@jit_inline
def add_waves(node, weight, turn, m, amplitudes) -> None:
    """Add a node of displacements (k,) to amplitudes (n, k) at the multiples of nu/m."""
    for q in range(amplitudes.shape[0]):
        factor = weight * phase_factor(q * turn / m)
        for j in range(amplitudes.shape[1]):
            amplitudes[q, j] += factor * node[j]


@jit_inline
def add_energies(e, p, law, i, weight, turn, w, rates, columns, energy) -> None:
    """Add a node of piece i with the velocity w to the derivatives of energies (5, k); rates : (k,) of w."""
    home = law.codes[i, HOME]
    work, damped, in_contact = loss_rates(e, p, law, i, turn, w)
    force, by_w, by_w_in_contact, square = 0.0, 0.0, 0.0, weight * w * w
    if e.forcing is not None:
        force = to_velocity(home, force_times(p, weight, turn, e.second_harmonic))
    if e.damping is not None:
        by_w = weight * 2.0 * p.h * w
    is_contact = law.codes[i, FORM] == CONTACT
    if is_contact:
        by_w_in_contact = weight * 2.0 * damping_of(p, home) * w
    for j in range(columns.size):
        k = columns[j]
        by_force = force_derivative(p, turn, k, e.second_harmonic)
        energy[0, j] += force * rates[j] + weight * to_velocity(home, w) * by_force
        energy[1, j] += by_w * rates[j]
        lost = by_w_in_contact * rates[j]
        if k == NU:
            energy[0, j] -= weight * work / p.nu
            energy[1, j] -= weight * damped / p.nu
            lost -= weight * in_contact / p.nu
        elif k == H:
            energy[1, j] += square
        elif is_contact and k == H1 + home - 1:
            lost += square
        if is_contact:
            energy[1 + home, j] += lost


@jit
def add_stretch(e, p, law, i, m, start, stretch, by, out) -> None:
    """Add the integrals over a stretch of piece i.

    start : of the piece
    stretch : tuple of begin after the start and length, in forcing periods, number of steps, and whether each is short
    by : tuple of parameters (k,), derivatives (3, k) of the start, and a work array (2, k)
    """
    (begin, length, steps, is_short), (columns, changes, node), home = (
        stretch,
        by,
        law.codes[i, HOME],
    )
    amplitudes, subharmonics, energy = out
    nodes, weights = (FEW_NODES, FEW_WEIGHTS) if is_short else (NODES, WEIGHTS)
    for step in range(int(steps)):
        for g in range(nodes.size):
            span = begin + length * (step + nodes[g]) / steps
            flight = flight_of(e, p, law, i, start.t, span)
            w = fill_node(e, p, law, i, start, changes, flight, columns, node)
            share, turn = weights[g] * length / steps, start.t + span
            if energy.shape[0] > 0:
                weight = share * forcing_period(p)
                add_energies(e, p, law, i, weight, turn, w, node[1], columns, energy)
            for j in range(columns.size):
                origin = reference_derivative(home, columns[j])
                node[0, j] = origin + sign_of(home) * node[0, j]
            add_waves(node[0], share / m, turn, ONE_PERIOD, amplitudes)
            add_waves(node[0], share / m, turn, m, subharmonics)


@jit
def add_moving(e, p, orbit, i, m, changes, node, out):
    """Add the integrals over piece i, a moving one, from the derivatives (3, k) of its start.

    Returns its steps, and whether they suffice.
    """
    (start, _end, turns), law, period = ends_of_piece(e, p, orbit, i), orbit.law, forcing_period(p)
    second = e.second_harmonic
    (amplitudes, subharmonics, _energy), by = out, (orbit.columns, changes, node)
    whole = flight_of(e, p, law, i, start.t, turns)
    wave = max(amplitudes.shape[0], subharmonics.shape[0] / m) * p.nu
    rate = max(piece_rate(whole.stiffness, whole.damping), fastest_forcing(p, second))
    done, total, y, w, flown_to = 0.0, 0.0, start.y, start.w, 0.0
    if whole.damping == 0.0 and 2.0 * rate * turns * period > MAX_STEPS * REACH_OF_NODES:
        return total, False
    while done < turns:
        length = turns - done
        if length * period * (rate + max(rate, wave)) > MANY_STEPS * REACH_OF_NODES:
            # With steps as long as what is left of the motion allows. It is flown on from the last look: from the start
            # the rounding of a large velocity there would hide a slow creep.
            y, w = flown(flight_of(e, p, law, i, start.t + flown_to, done - flown_to), y, w)
            flown_to, force = done, force_on(e, p, law, i, start.t + done)
            decay = decay_of(y, w, force, whole.load, whole.stiffness, whole.damping, p, second)
            rate = decay.rate
            if decay.kind != FOLLOWING:
                length = min(length, STRETCH * REACH_OF_NODES / rate / period)
        reach = length * period * (rate + max(rate, wave))
        steps = np.ceil(reach / REACH_OF_NODES)
        total += steps
        if total > MAX_STEPS:
            return total, False
        add_stretch(e, p, law, i, m, start, (done, length, steps, reach < FEW_REACH), by, out)
        done = turns if length == turns - done else done + length
    return total, True


@jit
def add_still(e, p, orbit, i, m, changes, out) -> None:
    """Add the integrals over piece i, which is held or at rest."""
    (start, _end, turns), home = ends_of_piece(e, p, orbit, i), orbit.law.codes[i, HOME]
    amplitudes, subharmonics, _energy = out
    is_at_rest = orbit.law.codes[i, FORM] == RESTING
    for j in range(orbit.columns.size):
        moved = 0.0 if is_at_rest else sign_of(home) * changes[PLACE, j]
        moved += reference_derivative(home, orbit.columns[j])
        for q in range(amplitudes.shape[0]):
            factor = phase_integral(float(q), start.t, start.t + turns)
            amplitudes[q, j] += moved / m * factor
        for q in range(subharmonics.shape[0]):
            factor = phase_integral(q / m, start.t, start.t + turns)
            subharmonics[q, j] += moved / m * factor


@jit
def add_event(e, p, orbit, i, energy) -> None:
    """Add to the energies (5, k) what event i changes: rates jump where it moves, and an impact loses at once."""
    law, kind, home = orbit.law, orbit.law.codes[i, CAUSE], orbit.law.codes[i, HOME]
    n, columns, period = orbit.u.shape[0], orbit.columns, forcing_period(p)
    start, _end, _turns = ends_of_piece(e, p, orbit, i)
    _start, end, _turns = ends_of_piece(e, p, orbit, (i - 1) % n)
    work1, damped1, contact1 = loss_rates(e, p, law, (i - 1) % n, end.t, end.w)
    work0, damped0, contact0 = 0.0, 0.0, 0.0
    if law.codes[i, FORM] not in (HELD, RESTING):
        work0, damped0, contact0 = loss_rates(e, p, law, i, start.t, start.w)
    before, inertia = law.codes[(i - 1) % n, HOME], 1.0 / (1.0 + p.mass_ratio)
    for j in range(columns.size):
        later = period * end.timed * orbit.du[i, 0, j]
        energy[0, j] += (work1 - work0) * later
        energy[1, j] += (damped1 - damped0) * later
        if before > 0:
            energy[1 + before, j] += contact1 * later
        if home > 0:
            energy[1 + home, j] -= contact0 * later
        if kind in (IMPACT, REST_BEGINS):
            v, kept = orbit.u[i, 1], 0.0
            if kind == IMPACT:
                kept = p.R1 if home == 1 else p.R2
            lost = (1.0 - kept) * (1.0 + kept) * v * orbit.du[i, 1, j]
            lost -= kept * restitution_derivative(home, columns[j]) * v * v
            energy[1 + home, j] += inertia * lost
            if columns[j] == MASS_RATIO:
                energy[1 + home, j] -= 0.5 * (1.0 - kept) * (1.0 + kept) * v * v * inertia * inertia


@jit
def add_friction(e, p, orbit, i, changes, later, energy) -> None:
    """Add to the energies (5, k) the loss by friction on piece i, from the derivatives of its start and of its end."""
    start, end, _turns = ends_of_piece(e, p, orbit, i)
    direction = orbit.law.codes[i, DIRECTION]
    for j in range(orbit.columns.size):
        energy[4, j] += p.friction * direction * (later[PLACE, j] - changes[PLACE, j])
        if orbit.columns[j] == FRICTION:
            energy[4, j] += abs(end.y - start.y)


@jit
def add_let_go(e, p, orbit, i, changes, later, energy) -> None:
    """Add to the energies (5, k) what piece i loses of the spring of a support that let go, as `add_friction`."""
    start, end, _turns = ends_of_piece(e, p, orbit, i)
    home = orbit.law.codes[i, HOME]
    for j in range(orbit.columns.size):
        lost = start.y * changes[PLACE, j] - end.y * later[PLACE, j]
        energy[1 + home, j] += stiffness_of(p, home) * lost
        if orbit.columns[j] == K1 + home - 1:
            energy[1 + home, j] += 0.5 * (start.y - end.y) * (start.y + end.y)


@jit_allocating
def add_integrals(e, p, orbit, m, out):
    """Add the derivatives of all integrals along an orbit.

    orbit : VariedOrbit
    out : tuple of amplitudes (harmonics + 1, k) and subharmonics (n, k) complex, and energies (5, k) float; or without
        rows

    Returns the steps taken.
    """
    changes, later = np.zeros((3, orbit.columns.size)), np.zeros((3, orbit.columns.size))
    node, energy, steps = np.zeros((2, orbit.columns.size)), out[2], 0.0
    for i in range(orbit.u.shape[0]):
        fill_departure(e, p, orbit, i, changes)
        if energy.shape[0] > 0:
            add_event(e, p, orbit, i, energy)
        if orbit.law.codes[i, FORM] in (HELD, RESTING):
            add_still(e, p, orbit, i, m, changes, out)
            continue
        taken, is_known = add_moving(e, p, orbit, i, m, changes, node, out)
        steps += taken
        if not is_known:
            out[0][:], out[1][:], energy[:] = np.nan, np.nan, np.nan
            break
        if energy.shape[0] == 0:
            continue
        fill_arrival(e, p, orbit, (i + 1) % orbit.u.shape[0], later)
        if e.friction is not None:
            add_friction(e, p, orbit, i, changes, later, energy)
        if e.no_pull is not None and orbit.law.codes[i, FORM] == BEYOND:
            add_let_go(e, p, orbit, i, changes, later, energy)
    return steps
