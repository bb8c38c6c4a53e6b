"""Variations at the events between linear pieces.

A variation is the derivative of (x, x') at a fixed phase. At an event, a zero g = 0 of a gap or of a velocity, the
phase of the event changes by dphase = -dg / (dg/dphase), and by it what the jump of the acceleration, and of the
velocity, leaves at a fixed phase. Displacements are continuous.

References
----------
R. I. Leine, H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", Springer (2004), ch. 7.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    CAUSE,
    CONTACT,
    ENTER,
    FORM,
    HELD,
    HOME,
    IMPACT,
    LEAVE,
    RELEASE,
    REST_BEGINS,
    RESTING,
    SLIP,
    STICK,
    TURN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.march.state import restitution_of
from vibropipe.orbits.piece_terms import load_of_piece
from vibropipe.orbits.sensitivity.pieces.columns import BY_V, BY_X, COLUMNS, PARAMETER, columns_of
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.derivatives import restitution_derivative, support_derivative
from vibropipe.physics.load import force_at, force_times, force_value, forcing_period
from vibropipe.physics.stiffness import damping_of


@jit
def reference_derivative(home, column):
    """Return the derivative of the origin of a frame by a column."""
    if home == 0 or column < PARAMETER:
        return 0.0
    return support_derivative(home, column - PARAMETER)


@jit
def sign_of(home):
    """Return the sign of a frame, x = x_ref + sign y."""
    return to_velocity(home, 1.0)


@jit
def begin_variations(home, columns, ends) -> None:
    """Fill the variations at the start of an orbit, in the frame of `home`: of a start that is given."""
    sign = sign_of(home)
    for v in range(columns):
        ends[0, v], ends[1, v] = -sign * reference_derivative(home, v), 0.0
    ends[0, BY_X] = ends[1, BY_V] = sign


@jit
def change_frame(before, home, columns, ends) -> None:
    """Write the variations in the frame of `home` instead of that of `before`."""
    if home == before:
        return
    sign, turned = sign_of(home), sign_of(before) * sign_of(home)
    for v in range(columns):
        moved = reference_derivative(before, v) - reference_derivative(home, v)
        ends[0, v] = sign * moved + turned * ends[0, v]
        ends[1, v] *= turned


@jit
def acceleration_of_piece(e, p, pieces, i, turn, y, w):
    """Return y'' on piece i at a phase in turns; 0 where it is held or at rest."""
    form, home = pieces.codes[i, FORM], pieces.codes[i, HOME]
    if form in (HELD, RESTING):
        return 0.0
    stiffness, damping = coefficients(e, p, home, form == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    total = load - damping * w - stiffness * y
    if e.forcing is not None:
        total += force_value(force_at(p, sigma, turn, e.second_harmonic), e.second_harmonic)
    return total


@jit
def loss_rates(e, p, pieces, i, turn, w):
    """Return the rates at which work is done by the force, and lost by damping, in contact, and by friction."""
    home, work, damped, friction = pieces.codes[i, HOME], 0.0, 0.0, 0.0
    if e.forcing is not None:
        work = to_velocity(home, force_times(p, w, turn, e.second_harmonic))
    if e.damping is not None:
        damped = p.h * w * w
    if e.friction is not None:
        friction = p.friction * abs(w)
    in_contact = 0.0
    if pieces.codes[i, FORM] == CONTACT:
        in_contact = damping_of(p, home) * w * w
    return work, damped, in_contact, friction


@jit
def note_contact(change, speed, v, out) -> None:
    """Note the change of phase and of velocity of the contact that begins, in column v."""
    n = out.counts[0]
    out.contacts[n, 0, v], out.contacts[n, 1, v] = change, speed


@jit
def add_jumps(e, p, pieces, i, later, energy) -> None:
    """Add to the energies (5, COLUMNS) what the event that begins piece i changes.

    later : (2, COLUMNS), by how much tau of the event, and what is lost at once, change.
    """
    turn, before, home = pieces.values[i, AT], pieces.codes[i - 1, HOME], pieces.codes[i, HOME]
    work1, damped1, contact1, friction1 = loss_rates(
        e, p, pieces, i - 1, turn, pieces.values[i - 1, W_END]
    )
    work0, damped0, contact0, friction0 = loss_rates(e, p, pieces, i, turn, pieces.values[i, W])
    for v in range(COLUMNS):
        tau, lost = later[0, v], later[1, v]
        energy[0, v] += (work1 - work0) * tau
        energy[1, v] += (damped1 - damped0) * tau
        energy[4, v] += (friction1 - friction0) * tau
        if before > 0:
            energy[1 + before, v] += contact1 * tau
        if home > 0:
            energy[1 + home, v] += lost - contact0 * tau


@jit
def pass_event(e, p, pieces, i, by, out) -> bool:
    """Carry the variations over the event between piece i - 1 and piece i.

    Returns
    -------
    bool
        False where the motion is not smooth in its start: at a touch without velocity.
    """
    cause, home, turn = pieces.codes[i, CAUSE], pieces.codes[i, HOME], pieces.values[i, AT]
    before, ends, period = pieces.codes[i - 1, HOME], out.ends, forcing_period(p)
    columns = columns_of(by)
    change_frame(before, home, columns, ends)
    turned = sign_of(before) * sign_of(home)
    y1, w1 = pieces.values[i - 1, Y_END], pieces.values[i - 1, W_END]
    a1 = turned * acceleration_of_piece(e, p, pieces, i - 1, turn, y1, w1)
    arrives, departs = turned * w1, pieces.values[i, W]
    a0 = acceleration_of_piece(e, p, pieces, i, turn, pieces.values[i, Y], departs)
    is_struck = cause in (ENTER, IMPACT) or (cause == REST_BEGINS and arrives != 0.0)
    if is_struck and (out.counts[0] == out.contacts.shape[0] or not arrives < 0.0):
        return False
    r = restitution_of(e, p, home)
    for v in range(columns):
        y, w, tau, lost = ends[0, v], ends[1, v], 0.0, 0.0
        if cause in (ENTER, LEAVE):
            tau = -y / arrives
            ends[1, v] += (a1 - a0) * tau
        elif cause == TURN:
            tau = -w / a1
            ends[1, v] = -a0 * tau
        elif cause == IMPACT:
            tau, by_law = -y / arrives, 0.0
            if v >= PARAMETER:
                by_law = restitution_derivative(home, v - PARAMETER)
            struck = w + a1 * tau
            leaves = -r * struck - by_law * arrives
            ends[0, v], ends[1, v] = -departs * tau, leaves - a0 * tau
            lost = arrives * struck - departs * leaves
        elif cause in (STICK, SLIP):
            ends[1, v] = 0.0
        elif cause in (REST_BEGINS, RELEASE):
            if is_struck:
                tau = -y / arrives
                lost = arrives * (w + a1 * tau)
            ends[0, v] = ends[1, v] = 0.0
        else:
            return False
        if is_struck:
            note_contact(tau / period, sign_of(home) * (w + a1 * tau), v, out)
        out.node[0, v], out.node[1, v] = tau, lost
    if by is not None and out.energy.shape[0] > 0:
        add_jumps(e, p, pieces, i, out.node, out.energy)
    if is_struck:
        out.counts[0] += 1
    return True
