"""Variations along a linear piece, and of the integrals over it.

On a piece y'' + d y' + s y = load + sigma F the derivative by a parameter at a fixed phase obeys the same equation with
another right-hand side (`physics.variation`), here by Taylor polynomials.
"""

from __future__ import annotations

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
from vibropipe.orbits.pieces import end_of_piece, load_of_piece, steps_of_span
from vibropipe.orbits.quadrature import NODES, WEIGHTS
from vibropipe.orbits.sensitivity.pieces.columns import COLUMNS, PARAMETER
from vibropipe.orbits.sensitivity.pieces.events import loss_rates, reference_derivative, sign_of
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.derivatives import FRICTION, H1, K1, N_OF_PIECES, NU, F, H, load_derivative
from vibropipe.physics.flow import DEGREE, displacement, velocity
from vibropipe.physics.friction import friction_of
from vibropipe.physics.load import (
    Force,
    first_terms,
    force_at,
    force_times,
    forcing_period,
    next_term,
    no_force,
)
from vibropipe.physics.stiffness import damping_of, piece_taylor
from vibropipe.physics.turns import phase_factor, phase_integral, sincos_turns
from vibropipe.physics.variation import FACTORS, SHARES


@jit
def vary_step_of_piece(p, c, unit, stiffness, damping, home, contact, direction, dt, columns, out):
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
    columns : int
        WITHOUT_PARAMETERS or COLUMNS.
    out : PieceVariations
    """
    ends, z, square, by = out.ends, out.z, dt * dt, PARAMETER
    term, term_next = first_terms(unit, p.nu * dt)
    for v in range(columns):
        z[0, v], z[1, v] = ends[0, v], ends[1, v] * dt
        ends[0, v], ends[1, v] = z[0, v] + z[1, v], z[1, v]
    for n in range(DEGREE - 1):
        to_next, share = square * FACTORS[n], dt * SHARES[n]
        for v in range(columns):
            z[n + 2, v] = -stiffness * to_next * z[n, v] - damping * share * z[n + 1, v]
        if columns == COLUMNS:
            z[n + 2, by + NU] -= (2.0 * c[n + 2] + damping * share * c[n + 1]) / p.nu
            z[n + 2, by + H] -= share * c[n + 1]
            z[n + 2, by + F] += to_next * term
            term, term_next = term_next, next_term(term, p.nu * dt, FACTORS[n])
            if contact:
                z[n + 2, by + K1 + home - 1] -= to_next * c[n]
                z[n + 2, by + H1 + home - 1] -= share * c[n + 1]
            if n == 0:
                z[2, by + FRICTION] -= 0.5 * square * direction
                for k in range(N_OF_PIECES):
                    if home > 0:
                        z[2, by + k] += 0.5 * square * load_derivative(home, k)
        for v in range(columns):
            ends[0, v] += z[n + 2, v]
            ends[1, v] += (n + 2) * z[n + 2, v]
    for v in range(columns):
        ends[1, v] /= dt


@jit
def add_step(e, p, pieces, i, m, begin, dt, c, columns, out) -> None:
    """Add the integrals over a step of piece i that begins at a phase, by Gauss quadrature."""
    home, period, sign = pieces.codes[i, HOME], forcing_period(p), sign_of(pieces.codes[i, HOME])
    in_contact, damped = pieces.codes[i, FORM] == CONTACT, 0.0
    if e.damping is not None:
        damped = p.h
    for g in range(NODES.size):
        theta, weight = NODES[g], WEIGHTS[g] * dt
        turn, w = begin + theta * dt / period, velocity(c, DEGREE, theta, dt)
        work, lost, lost_in_contact, _rubbed = loss_rates(e, p, pieces, i, turn, w)
        for v in range(columns):
            y, rate = out.z[DEGREE, v], DEGREE * out.z[DEGREE, v]
            for n in range(DEGREE - 1, 0, -1):
                y = y * theta + out.z[n, v]
                rate = rate * theta + n * out.z[n, v]
            y, rate = y * theta + out.z[0, v], rate / dt
            x = reference_derivative(home, v) + sign * y
            for k in range(out.amplitudes.shape[0]):
                out.amplitudes[k, v] += weight / (m * period) * x * phase_factor(k * turn)
            for k in range(out.subharmonics.shape[0]):
                out.subharmonics[k, v] += weight / (m * period) * x * phase_factor(k * turn / m)
            if out.energy.shape[0] > 0:
                if v == PARAMETER + NU:
                    rate += w / p.nu
                energy = out.energy[:, v]
                if e.forcing is not None:
                    energy[0] += to_velocity(
                        home, force_times(p, weight * rate, turn, e.second_harmonic)
                    )
                energy[1] += weight * 2.0 * damped * w * rate
                if in_contact:
                    energy[1 + home] += weight * 2.0 * damping_of(p, home) * w * rate
                if v == PARAMETER + NU:
                    energy[0] -= weight * work / p.nu
                    energy[1] -= weight * lost / p.nu
                    if in_contact:
                        energy[1 + home] -= weight * lost_in_contact / p.nu
                elif v == PARAMETER + F and e.forcing is not None:
                    energy[0] += weight * to_velocity(home, w) * sincos_turns(turn)[0]
                elif v == PARAMETER + H:
                    energy[1] += weight * w * w
                elif in_contact and v == PARAMETER + H1 + home - 1:
                    energy[1 + home] += weight * w * w


@jit
def vary_piece(e, p, pieces, i, m, columns, out) -> None:
    """Carry the variations along piece i, and add its integrals; m : period multiple."""
    home, form, ends = pieces.codes[i, HOME], pieces.codes[i, FORM], out.ends
    start, span, period = pieces.values[i, AT], pieces.values[i, SPAN], forcing_period(p)
    is_still, second = form in (HELD, RESTING), e.second_harmonic
    if is_still:
        for v in range(columns):
            x = reference_derivative(home, v) + sign_of(home) * ends[0, v]
            for k in range(out.amplitudes.shape[0]):
                share = phase_integral(float(k), start, end_of_piece(p, pieces, i))
                out.amplitudes[k, v] += x / m * share
            for k in range(out.subharmonics.shape[0]):
                share = phase_integral(k / m, start, end_of_piece(p, pieces, i))
                out.subharmonics[k, v] += x / m * share
    if is_still or not span > 0.0:
        return
    y, w = pieces.values[i, Y], pieces.values[i, W]
    stiffness, damping = coefficients(e, p, home, form == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    parts = steps_of_span(p, stiffness, damping, span, second)
    direction = float(pieces.codes[i, DIRECTION])
    dt, c, by_nu = span / parts, pieces.polynomial, PARAMETER + NU
    # The polynomials are of derivatives at a fixed share of the period; y' has the factor nu besides.
    if columns == COLUMNS:
        ends[1, by_nu] -= w / p.nu
    if out.energy.shape[0] > 0:
        slid = abs(pieces.values[i, Y_END] - y)
        out.energy[4, PARAMETER + FRICTION] += slid
        for v in range(columns):
            out.energy[4, v] -= friction_of(e, p) * direction * ends[0, v]
    for part in range(parts):
        begin = start + part * dt / period
        force, unit = no_force(), no_force()
        if e.forcing is not None:
            force = force_at(p, sigma, begin, second)
            sine, cosine = sincos_turns(begin)
            unit = Force(sigma * sine, sigma * cosine, 0.0, 0.0)
        piece_taylor(c, y, w, force, load, stiffness, damping, p.nu, dt, second)
        vary_step_of_piece(
            p, c, unit, stiffness, damping, home, form == CONTACT, direction, dt, columns, out
        )
        if out.amplitudes.shape[0] + out.subharmonics.shape[0] + out.energy.shape[0] > 0:
            add_step(e, p, pieces, i, m, begin, dt, c, columns, out)
        y, w = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    if columns == COLUMNS:
        ends[1, by_nu] += w / p.nu
    if out.energy.shape[0] > 0:
        for v in range(columns):
            out.energy[4, v] += friction_of(e, p) * direction * ends[0, v]
