"""Variations along a linear piece, and of the integrals over it.

On a piece y'' + d y' + s y = load + sigma F the derivative by a parameter at a fixed phase obeys the same equation with
another right-hand side (`physics.variation`), here by Taylor polynomials.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    RESTING,
    SPAN,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.orbits.forces import NODES, WEIGHTS
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.piece_terms import load_of_piece
from vibropipe.orbits.pieces import end_of_piece, steps_of_span
from vibropipe.orbits.sensitivity.pieces.columns import COLUMNS, PARAMETER
from vibropipe.orbits.sensitivity.pieces.events import loss_rates, reference_derivative, sign_of
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.derivatives import (
    F2,
    FRICTION,
    H1,
    K1,
    N_OF_PIECES,
    NU,
    PHI2,
    F,
    H,
    force_derivative,
    load_derivative,
)
from vibropipe.physics.flow import DEGREE, displacement, velocity
from vibropipe.physics.friction import friction_of
from vibropipe.physics.load import (
    first_terms,
    first_terms_of_phase,
    first_terms_of_second,
    force_of_angle,
    force_times,
    forcing_period,
    next_term,
    no_force,
    unit_force,
)
from vibropipe.physics.stiffness import damping_of, piece_flow, piece_taylor
from vibropipe.physics.turns import phase_factor, phase_integral, sincos_turns
from vibropipe.physics.variation import FACTORS, SHARES

# Steps of a piece above which derivatives are not computed, of a contact that is that stiff: they would take a second.
MAX_STEPS = 1e6


@jit
def vary_step_of_piece(p, c, unit, stiffness, damping, home, contact, direction, dt, out, second):
    """Fill the polynomials of the variations over a step of a piece, and move the variations to its end.

    Parameters
    ----------
    p : Parameters
    c : (DEGREE + 1,) float
        The motion over the step (`stiffness.piece_taylor`).
    unit : Force
        The force of a unit amplitude at the start of the step, in the frame.
    stiffness, damping : float
        Of the piece.
    home : int
        Its frame.
    contact : bool
        Whether the soft support `home` acts.
    direction : float
        Direction of sliding, in the frame.
    dt : float
        The step.
    out : PieceVariations
    second : int or None
        The effect `second_harmonic`.
    """
    ends, z, square, first = out.ends, out.z, dt * dt, PARAMETER
    term, term_next = first_terms(unit, p.nu * dt)
    twice = 2.0 * p.nu * dt
    f2, f2_next = first_terms_of_second(unit, twice)
    phase, phase_next = first_terms_of_phase(p, unit, twice)
    for v in range(COLUMNS):
        z[0, v], z[1, v] = ends[0, v], ends[1, v] * dt
        ends[0, v], ends[1, v] = z[0, v] + z[1, v], z[1, v]
    for n in range(DEGREE - 1):
        to_next, share = square * FACTORS[n], dt * SHARES[n]
        for v in range(COLUMNS):
            z[n + 2, v] = -stiffness * to_next * z[n, v] - damping * share * z[n + 1, v]
        z[n + 2, first + NU] -= (2.0 * c[n + 2] + damping * share * c[n + 1]) / p.nu
        z[n + 2, first + H] -= share * c[n + 1]
        z[n + 2, first + F] += to_next * term
        term, term_next = term_next, next_term(term, p.nu * dt, FACTORS[n])
        if second is not None:
            z[n + 2, first + F2] += to_next * f2
            z[n + 2, first + PHI2] += to_next * phase
            f2, f2_next = f2_next, next_term(f2, twice, FACTORS[n])
            phase, phase_next = phase_next, next_term(phase, twice, FACTORS[n])
        if contact:
            z[n + 2, first + K1 + home - 1] -= to_next * c[n]
            z[n + 2, first + H1 + home - 1] -= share * c[n + 1]
        if n == 0:
            z[2, first + FRICTION] -= 0.5 * square * direction
            for k in range(N_OF_PIECES):
                if home > 0:
                    z[2, first + k] += 0.5 * square * load_derivative(home, k)
        for v in range(COLUMNS):
            ends[0, v] += z[n + 2, v]
            ends[1, v] += (n + 2) * z[n + 2, v]
    for v in range(COLUMNS):
        ends[1, v] /= dt


@jit
def fill_node(z, theta, dt, node) -> None:
    """Fill node (2, COLUMNS) with the variations of (y, y') at theta of a step, from their polynomials."""
    for v in range(COLUMNS):
        node[0, v], node[1, v] = z[DEGREE, v], DEGREE * z[DEGREE, v]
    for n in range(DEGREE - 1, 0, -1):
        for v in range(COLUMNS):
            node[0, v] = node[0, v] * theta + z[n, v]
            node[1, v] = node[1, v] * theta + n * z[n, v]
    for v in range(COLUMNS):
        node[0, v], node[1, v] = node[0, v] * theta + z[0, v], node[1, v] / dt


@jit
def add_waves(node, weight, turn, m, amplitudes) -> None:
    """Add a node of displacements to amplitudes (n, COLUMNS) at the multiples of nu/m."""
    for k in range(amplitudes.shape[0]):
        factor = weight * phase_factor(k * turn / m)
        for v in range(COLUMNS):
            amplitudes[k, v] += factor * node[v]


@jit
def add_energies_of_node(e, p, pieces, i, weight, turn, w, rates, energy) -> None:
    """Add a node of piece i with the velocity w to the variations of energies (5, COLUMNS); rates : (COLUMNS,) of w."""
    home, in_contact = pieces.codes[i, HOME], pieces.codes[i, FORM] == CONTACT
    work, lost, lost_in_contact, _rubbed = loss_rates(e, p, pieces, i, turn, w)
    force, damped, damped_in_contact = 0.0, 0.0, 0.0
    if e.forcing is not None:
        force = to_velocity(home, force_times(p, weight, turn, e.second_harmonic))
        power = weight * to_velocity(home, w)
        energy[0, PARAMETER + F] += power * sincos_turns(turn)[0]
        if e.second_harmonic is not None:
            energy[0, PARAMETER + F2] += power * force_derivative(p, turn, F2, e.second_harmonic)
            energy[0, PARAMETER + PHI2] += power * force_derivative(
                p, turn, PHI2, e.second_harmonic
            )
    if e.damping is not None:
        damped = weight * 2.0 * p.h * w
    if in_contact:
        damped_in_contact = weight * 2.0 * damping_of(p, home) * w
    for v in range(COLUMNS):
        energy[0, v] += force * rates[v]
        energy[1, v] += damped * rates[v]
    energy[0, PARAMETER + NU] -= weight * work / p.nu
    energy[1, PARAMETER + NU] -= weight * lost / p.nu
    energy[1, PARAMETER + H] += weight * w * w
    if in_contact:
        for v in range(COLUMNS):
            energy[1 + home, v] += damped_in_contact * rates[v]
        energy[1 + home, PARAMETER + NU] -= weight * lost_in_contact / p.nu
        energy[1 + home, PARAMETER + H1 + home - 1] += weight * w * w


@jit
def add_step(e, p, pieces, i, m, begin, dt, c, out) -> None:
    """Add the integrals over a step of piece i that begins at a phase, by Gauss quadrature."""
    home, period, node = pieces.codes[i, HOME], forcing_period(p), out.node
    for g in range(NODES.size):
        theta, weight = NODES[g], WEIGHTS[g] * dt
        turn, w = begin + theta * dt / period, velocity(c, DEGREE, theta, dt)
        fill_node(out.z, theta, dt, node)
        node[1, PARAMETER + NU] += w / p.nu
        if out.energy.shape[0] > 0:
            add_energies_of_node(e, p, pieces, i, weight, turn, w, node[1], out.energy)
        for v in range(COLUMNS):
            node[0, v] = reference_derivative(home, v) + sign_of(home) * node[0, v]
        share = weight / (m * period)
        add_waves(node[0], share, turn, ONE_PERIOD, out.amplitudes)
        add_waves(node[0], share, turn, m, out.subharmonics)


@jit
def add_still(p, pieces, i, m, out) -> None:
    """Add the integrals over piece i, which is held or at rest."""
    home, start, end = pieces.codes[i, HOME], pieces.values[i, AT], end_of_piece(p, pieces, i)
    node = out.node[0]
    for v in range(COLUMNS):
        node[v] = (reference_derivative(home, v) + sign_of(home) * out.ends[0, v]) / m
    for k in range(out.amplitudes.shape[0]):
        factor = phase_integral(float(k), start, end)
        for v in range(COLUMNS):
            out.amplitudes[k, v] += node[v] * factor
    for k in range(out.subharmonics.shape[0]):
        factor = phase_integral(k / m, start, end)
        for v in range(COLUMNS):
            out.subharmonics[k, v] += node[v] * factor


@jit
def add_sliding(e, p, pieces, i, sign, out) -> None:
    """Add to the loss by friction over piece i what its start (sign -1) or its end (1) changes."""
    if out.energy.shape[0] > 0:
        push = sign * friction_of(e, p) * pieces.codes[i, DIRECTION]
        for v in range(COLUMNS):
            out.energy[4, v] += push * out.ends[0, v]


@jit
def vary_by_parameters(e, p, pieces, i, m, out) -> None:
    """Carry all variations along piece i, a moving one, and add its integrals."""
    home, form, ends = pieces.codes[i, HOME], pieces.codes[i, FORM], out.ends
    start, span, period = pieces.values[i, AT], pieces.values[i, SPAN], forcing_period(p)
    y, w, second = pieces.values[i, Y], pieces.values[i, W], e.second_harmonic
    stiffness, damping = coefficients(e, p, home, form == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    parts = int(min(steps_of_span(p, stiffness, damping, span, second), MAX_STEPS))
    if parts == MAX_STEPS:
        # Derivatives of a contact that is as stiff are not computed.
        ends[:] = math.nan
        return
    direction = float(pieces.codes[i, DIRECTION])
    dt, c, by_nu = span / parts, pieces.polynomial, PARAMETER + NU
    # The polynomials are of derivatives at a fixed share of the period; y' has the factor nu besides.
    ends[1, by_nu] -= w / p.nu
    add_sliding(e, p, pieces, i, -1.0, out)
    if out.energy.shape[0] > 0:
        out.energy[4, PARAMETER + FRICTION] += abs(pieces.values[i, Y_END] - y)
    for part in range(parts):
        begin = start + part * dt / period
        force, unit = no_force(), no_force()
        if e.forcing is not None:
            sine, cosine = sincos_turns(begin)
            force = force_of_angle(p, sigma, sine, cosine, second)
            unit = unit_force(p, sigma, sine, cosine, second)
        piece_taylor(c, y, w, force, load, stiffness, damping, p.nu, dt, second)
        vary_step_of_piece(
            p, c, unit, stiffness, damping, home, form == CONTACT, direction, dt, out, second
        )
        if out.amplitudes.shape[0] + out.subharmonics.shape[0] + out.energy.shape[0] > 0:
            add_step(e, p, pieces, i, m, begin, dt, c, out)
        y, w = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    ends[1, by_nu] += w / p.nu
    add_sliding(e, p, pieces, i, 1.0, out)


@jit
def vary_piece(e, p, pieces, i, m, by, out) -> None:
    """Carry the variations along piece i, and add its integrals; m : period multiple, by : as for `columns_of`."""
    form, span = pieces.codes[i, FORM], pieces.values[i, SPAN]
    is_still, ends = form in (HELD, RESTING), out.ends
    if by is not None:
        if is_still:
            add_still(p, pieces, i, m, out)
        elif span > 0.0:
            vary_by_parameters(e, p, pieces, i, m, out)
    elif not is_still:
        stiffness, damping = coefficients(e, p, pieces.codes[i, HOME], form == CONTACT)
        e11, e12, e21, e22 = piece_flow(stiffness, damping, span)
        for v in range(PARAMETER):
            y, w = ends[0, v], ends[1, v]
            ends[0, v], ends[1, v] = e11 * y + e12 * w, e21 * y + e22 * w
