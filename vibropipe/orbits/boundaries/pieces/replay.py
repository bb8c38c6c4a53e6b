"""An orbit with soft supports or friction flown through a given sequence of events, whether or not it is a motion.

A march finds what happens first; here each piece ends where its given event does. What the unknowns of a boundary are
changed to is then a smooth function of them, also where the orbit touches a support or nearly sticks.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
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
from vibropipe.orbits.pieces import (
    MANY_STEPS,
    load_of_piece,
    saltation_of_piece,
    steps_of_span,
)
from vibropipe.orbits.sensitivity.pieces.events import acceleration_of_piece
from vibropipe.physics.contact import support_position, to_displacement, to_velocity
from vibropipe.physics.decay import FOLLOWING, decay_of_kind
from vibropipe.physics.flow import DEGREE, displacement, velocity
from vibropipe.physics.friction import friction_of
from vibropipe.physics.load import (
    force_at,
    force_slope,
    force_value,
    forcing_period,
    no_force,
)
from vibropipe.physics.saltation import product
from vibropipe.physics.stiffness import piece_flow, piece_taylor

# Newton's iterations for the end of a piece; the change, in forcing periods, that is rounding, and the largest that may
# stall.
MAX_ITERATIONS, EXACT, STALLED = 30, 1e-16, 1e-12


@jit
def gap_to(p, home, y, support):
    """Return the distance from `support` of a mass at y in the frame of `home`."""
    reference, x = support_position(p, support), to_displacement(p, home, y)
    return reference - x if support == 1 else x - reference


@jit
def gap_rate(home, w, support):
    """Return the rate of that distance."""
    v = to_velocity(home, w)
    return -v if support == 1 else v


@jit
def forced_state(e, p, pieces, i, span):
    """Return (y, w) of the forced motion of piece i a time span after its start."""
    stiffness, damping = coefficients(e, p, pieces.codes[i, HOME], pieces.codes[i, FORM] == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    force, second = no_force(), e.second_harmonic
    if e.forcing is not None:
        force = force_at(p, sigma, pieces.values[i, AT] + span / forcing_period(p), second)
    forced = decay_of_kind(FOLLOWING, force, load, stiffness, damping, p, second)
    y, w = force_value(forced.force, second), p.nu * force_slope(forced.force, second)
    return forced.load + y, w


@jit
def stiff_state_within(e, p, pieces, i, span):
    """Return what `state_within` does, in closed form, which is accurate far from resonance."""
    stiffness, damping = coefficients(e, p, pieces.codes[i, HOME], pieces.codes[i, FORM] == CONTACT)
    y, w = forced_state(e, p, pieces, i, 0.0)
    dy, dw = pieces.values[i, Y] - y, pieces.values[i, W] - w
    y, w = forced_state(e, p, pieces, i, span)
    e11, e12, e21, e22 = piece_flow(stiffness, damping, span)
    return y + (e11 * dy + e12 * dw), w + (e21 * dy + e22 * dw)


@jit
def state_within(e, p, pieces, i, span):
    """Return (y, w) of piece i after a time span, whatever ends it."""
    y, w = pieces.values[i, Y], pieces.values[i, W]
    if pieces.codes[i, FORM] == HELD:
        return y, w
    stiffness, damping = coefficients(e, p, pieces.codes[i, HOME], pieces.codes[i, FORM] == CONTACT)
    sigma, load = load_of_piece(e, p, pieces, i)
    steps = steps_of_span(p, stiffness, damping, abs(span), e.second_harmonic)
    if steps > MANY_STEPS:
        return stiff_state_within(e, p, pieces, i, span)
    dt, period, c = span / steps, forcing_period(p), pieces.polynomial
    for part in range(int(steps)):
        force = no_force()
        if e.forcing is not None:
            begin = pieces.values[i, AT] + part * dt / period
            force = force_at(p, sigma, begin, e.second_harmonic)
        piece_taylor(c, y, w, force, load, stiffness, damping, p.nu, dt, e.second_harmonic)
        y, w = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return y, w


@jit
def event_at(e, p, pieces, i, cause, home, direction, span):
    """Return the function that is zero where piece i ends, its rate in tau, and (y, w), after a time span.

    cause, home, direction : of the piece that follows
    """
    y, w = state_within(e, p, pieces, i, span)
    turn = pieces.values[i, AT] + span / forcing_period(p)
    if cause == SLIP:
        value, rate, _scale = net_force(e, p, pieces.codes[i, HOME], y, turn)
        return value - direction * friction_of(e, p), rate, y, w
    if cause in (TURN, STICK):
        return w, acceleration_of_piece(e, p, pieces, i, turn, y, w), y, w
    support = home
    if cause == LEAVE:
        support = pieces.codes[i, HOME]
    here = pieces.codes[i, HOME]
    return gap_to(p, here, y, support), gap_rate(here, w, support), y, w


@jit
def end_piece(e, p, pieces, i, cause, home, direction, longest) -> bool:
    """Fill the span and the end of piece i, near its span; return whether there is one, up to `longest`."""
    span, previous, period = pieces.values[i, SPAN], math.inf, forcing_period(p)
    for _ in range(MAX_ITERATIONS):
        value, rate, y, w = event_at(e, p, pieces, i, cause, home, direction, span)
        if rate == 0.0:
            return False
        change = value / rate
        size = abs(change) / period
        if not size <= longest:
            return False
        if size <= EXACT or (size <= STALLED and size >= 0.5 * previous):
            pieces.values[i, SPAN], pieces.values[i, Y_END], pieces.values[i, W_END] = span, y, w
            return span >= 0.0
        span, previous = span - change, size
    return False


@jit
def begin_next(e, p, pieces, i) -> None:
    """Fill the start of piece i from the end of the piece before."""
    before, home, cause = pieces.codes[i - 1, HOME], pieces.codes[i, HOME], pieces.codes[i, CAUSE]
    values = pieces.values
    values[i, AT] = values[i - 1, AT] + values[i - 1, SPAN] / forcing_period(p)
    y = values[i - 1, Y_END]
    if home != before:
        y = to_displacement(p, before, y) if home == 0 else gap_to(p, before, y, home)
    w = to_velocity(home, to_velocity(before, values[i - 1, W_END]))
    if cause in (ENTER, LEAVE, IMPACT):
        y = 0.0
    if cause == IMPACT:
        w = -restitution_of(e, p, home) * w
    elif cause in (TURN, STICK, SLIP):
        w = 0.0
    values[i, Y], values[i, W] = y, w


@jit
def replay(e, p, pieces, mirrored, at, start, span):
    """Fly an orbit from its first event through all others to that one again, or to its mirror image.

    Parameters
    ----------
    e, p : Effects, Parameters
    pieces : PieceLog
        Of n + 1 pieces. The codes of 1 to n are given, and their spans as a guess; row 0 is filled with how the orbit
        arrives at the first event.
    mirrored : int
        1 where the last event is the mirror image of the first.
    at : float
        Phase of the first event, in forcing periods.
    start : float
        Velocity before it, in its frame; of a turn or a stick the displacement.
    span : float
        Length of the sequence in forcing periods.

    Returns
    -------
    late : float
        By how much the last event comes later than after `span`, in forcing periods.
    missed : float
        By how much its velocity (displacement) differs from `start`.
    is_replayed : bool
        Whether each event was found.
    """
    codes, values, n = pieces.codes, pieces.values, pieces.values.shape[0] - 1
    first, home = codes[1, CAUSE], codes[1, HOME]
    is_struck = first in (ENTER, IMPACT)
    codes[0, HOME], values[0, AT], values[0, SPAN] = home, at, 0.0
    values[0, Y_END], values[0, W_END] = 0.0, start
    if not is_struck:
        values[0, Y_END], values[0, W_END] = start, 0.0
    longest = 2.0 * span
    for i in range(1, n + 1):
        begin_next(e, p, pieces, i)
        cause, towards, direction = first, home, codes[1, DIRECTION]
        if i < n:
            cause, towards, direction = (
                codes[i + 1, CAUSE],
                codes[i + 1, HOME],
                codes[i + 1, DIRECTION],
            )
        elif mirrored == 1 and home > 0:
            towards = 3 - home
        if not end_piece(e, p, pieces, i, cause, towards, direction, longest):
            return 0.0, 0.0, False
    last = codes[n, HOME]
    late = values[n, AT] + values[n, SPAN] / forcing_period(p) - at - span
    if is_struck:
        support = 3 - home if mirrored == 1 else home
        return late, gap_rate(last, values[n, W_END], support) - start, True
    y = to_displacement(p, last, values[n, Y_END])
    if mirrored == 1:
        y = -y
    if home > 0:
        y = gap_to(p, 0, y, home)
    return late, y - start, True


@jit
def derivative_of_replay(e, p, pieces, mirrored, speed):
    """Return trace, determinant and scale of the derivative of the return map (of the map to the mirror image).

    scale : product of the speeds of all impacts on rigid supports over `speed`, by which the derivative is divided
    """
    j11, j12, j21, j22, scale = 1.0, 0.0, 0.0, 1.0, 1.0
    for i in range(1, pieces.values.shape[0]):
        s11, s12, s21, s22 = saltation_of_piece(e, p, pieces, i)
        j11, j12, j21, j22 = product(s11, s12, s21, s22, j11, j12, j21, j22)
        form, home = pieces.codes[i, FORM], pieces.codes[i, HOME]
        if pieces.codes[i, CAUSE] == IMPACT:
            scale *= abs(pieces.values[i - 1, W_END]) / speed
        if form in (FREE, CONTACT):
            stiffness, damping = coefficients(e, p, home, form == CONTACT)
            e11, e12, e21, e22 = piece_flow(stiffness, damping, pieces.values[i, SPAN])
            j11, j12, j21, j22 = product(e11, e12, e21, e22, j11, j12, j21, j22)
    trace = j11 + j22
    return (-trace if mirrored == 1 else trace), j11 * j22 - j12 * j21, scale


@jit
def touch_at(e, p, pieces, flight, side, turn):
    """Return the gap between flight and support `side` at a phase in forcing periods, and its rate."""
    span = (turn - pieces.values[flight, AT]) * forcing_period(p)
    y, w = state_within(e, p, pieces, flight, span)
    home = pieces.codes[flight, HOME]
    return gap_to(p, home, y, side), gap_rate(home, w, side)


@jit
def slowest_contact(pieces):
    """Return the least speed with which an orbit arrives at a support; infinite without contacts."""
    slowest = math.inf
    for i in range(1, pieces.values.shape[0]):
        if pieces.codes[i, CAUSE] in (ENTER, IMPACT):
            before, home = pieces.codes[i - 1, HOME], pieces.codes[i, HOME]
            arrives = -gap_rate(before, pieces.values[i - 1, W_END], home)
            slowest = min(slowest, arrives)
    return slowest
