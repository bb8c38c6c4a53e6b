"""The march of motions with soft supports or dry friction: from one linear piece to the next.

A piece is free flight, contact with a soft support, sliding either way, rest, or held by friction. What ends it, a zero
of a gap or of the velocity, is a certified first root (`march.roots`) of the piece's own Taylor polynomial. A contact
is stepped at its own frequency, in its gap: the depth and the duration of a stiff one keep all digits.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.contacts import (
    advance_rest,
    impact_at_end,
    support_at,
)
from vibropipe.march.grid import Instant, evaluate, phase_at
from vibropipe.march.log import (
    GRAZINGS,
    IMPACTS,
    POLYNOMIALS,
    RESTS,
    SHORT_FLIGHTS,
    STEPS,
    is_full,
    is_spent,
    record,
)
from vibropipe.march.piece_events import (
    FAR,
    NEAR,
    NOTHING,
    ZERO,
    end_newmark_step,
    fill_piece,
    first_event,
    follow_contact,
)
from vibropipe.march.piece_log import (
    ELAPSED,
    IMPACT,
    RELEASE,
    REST_BEGINS,
    SLIP,
    STICK,
    TOUCH,
    extend_piece,
    is_full_of_pieces,
)
from vibropipe.march.piece_state import (
    coefficients,
    is_in_contact,
    net_force,
    parts_of_step,
    piece_at,
    resume,
)
from vibropipe.march.piece_transitions import after_event, begin, start
from vibropipe.march.roots import GRAZING, NONE, STRIDE_LIMIT
from vibropipe.march.state import (
    DOWN_BY_JERK,
    DOWN_BY_SNAP,
    FLIGHT,
    LEAVES_BY_JERK,
    LEAVES_BY_SNAP,
    REST,
    STUCK,
    State,
    advance_time,
    is_before,
    is_watched,
)
from vibropipe.physics.contact import frame_at
from vibropipe.physics.decay import ALIVE, decayed_taylor
from vibropipe.physics.friction import slip_wait
from vibropipe.physics.load import NEVER
from vibropipe.physics.stiffness import is_soft
from vibropipe.words.status import Status

# One part of a step; a numpy integer, as the causes of pieces.
ONE_PART = np.int64(1)
# Time, in steps, within which a mass has not started to move if it stops again.
SHORTEST = 2.0**-52
# Largest number of events of a march, turning points included, which no limit of contacts bounds.
MAX_TURNS = 100_000_000
OK, MAX_IMPACTS, MAX_STEPS = int(Status.OK), int(Status.MAX_IMPACTS), int(Status.MAX_STEPS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED, ROOT_BOUND = int(Status.SUPPORT_REACHED), int(Status.ROOT_BOUND)


@jit
def missed_event(frame, piece, has_friction, y, w):
    """Return the event that the end (y, w) of a step shows to have happened within rounding of that end."""
    if piece.in_contact:
        if y >= 0.0:
            return NEAR
    elif frame.to_near and y <= frame.near:
        return NEAR
    elif frame.to_far and y >= frame.far:
        return FAR
    return ZERO if has_friction and piece.direction * w <= 0.0 else NOTHING


@jit
def next_instant(grid, at, theta):
    """Return (period, step, theta) at theta of the step of `at`; theta = 1 is the start of the next step."""
    if theta < 1.0:
        return at.period, at.step, theta
    if at.step + 1 < grid.steps:
        return at.period, at.step + 1, 0.0
    return at.period + 1, 0, 0.0


@jit
def hold(e, p, grid, state, limit, log, samples, c):
    """Hold a mass until `limit` that does not start to move within this step; return what `advance_piece` returns."""
    for n in range(1, c.size):
        c[n] = 0.0
    at_step = state.period * grid.steps + state.step
    record(samples, log.counts, p, grid, state.home, c, at_step, state.theta, limit, ONE_PART)
    span = (limit - state.theta) * grid.dt
    extend_piece(log.pieces, span, state.y, 0.0)
    if is_in_contact(e, p, state):
        log.pieces.contact[ELAPSED] += span
    period, step, theta = next_instant(grid, state, limit)
    after = resume(e, p, grid, Instant(period, step, theta), state.home, state.y)
    log.counts[STEPS] += 1
    if grid.exact is None:
        log.counts[SHORT_FLIGHTS] += 1
    begin(e, p, grid, log, STICK if after.mode == STUCK else TOUCH, after)
    return after, OK, False


@jit
def does_not_start(e, p, grid, state, piece, event, theta, c) -> bool:
    """Return whether a mass without velocity does not start to move the way that its mode says.

    Newmark's step may begin to move later. By the exact method the force then grows beyond the friction by less than
    rounding per step, which gives the coefficient any sign: the mass would stop at once, again and again.
    """
    if (
        piece.velocity_power == 0
        or c[min(piece.velocity_power + 1, c.size - 1)] * piece.direction > 0.0
    ):
        return False
    if grid.exact is None:
        return True
    if event == NOTHING or theta > SHORTEST:
        return False
    return event == ZERO or is_soft(e, p, support_at(state.home, event == NEAR))


@jit
def advance_piece(e, p, grid, state, end, log, samples, c):
    """March a moving state to its next event, or to the end of its step or part of a step.

    Returns (state, status, whether there was an event).
    """
    frame = frame_at(e, p, state.home)
    piece = piece_at(e, p, frame, state)
    parts, decay = parts_of_step(e, p, grid, frame, piece, state)
    if parts == 0:
        return state, MAX_STEPS, False
    last = state.period == end.period and state.step == end.step
    limit = end.theta if last else 1.0
    span = (limit - state.theta) * parts
    is_whole = span <= 1.0
    if not is_whole:
        span = 1.0
    dt = grid.dt / parts
    if decay.kind == ALIVE:
        fill_piece(e, p, grid, frame, piece, state, span, dt, c)
    else:
        decayed_taylor(c, state.y, decay, p.nu, dt, e.second_harmonic)
    log.counts[POLYNOMIALS] += 1
    has_friction = e.friction is not None and p.friction > 0.0
    theta, event, kind = first_event(
        e, frame, piece, has_friction, c, span, log.pieces.work, log.counts
    )
    if kind == STRIDE_LIMIT:
        return state, ROOT_BOUND, False
    if does_not_start(e, p, grid, state, piece, event, theta, c):
        return hold(e, p, grid, state, limit, log, samples, c)
    if grid.exact is None and event != NOTHING:
        theta = end_newmark_step(e, p, grid, frame, piece, state, event, theta, span, dt, c)
    y, w = evaluate(grid, c, theta)
    w *= parts
    # After a contact at the end of a step no time is left in it: the mass departs in the next one.
    if event == NOTHING and theta > 0.0:
        event = missed_event(frame, piece, has_friction, y, w)
        kind = NONE
    at = limit
    if event != NOTHING or not is_whole:
        at = min(state.theta + theta / parts, limit)
    if piece.in_contact:
        follow_contact(p, state.home, log.pieces.contact, c, theta, dt)
    at_step = state.period * grid.steps + state.step
    record(samples, log.counts, p, grid, state.home, c, at_step, state.theta, at, parts)
    extend_piece(log.pieces, theta * dt, y, w)
    if event != NOTHING:
        is_grazing = kind == GRAZING
        after = after_event(e, p, grid, state, at, piece, event, is_grazing, y, w, end, log)
        return after, OK, True
    log.counts[STEPS] += 1
    period, step, at = next_instant(grid, state, at)
    mode = FLIGHT if theta > 0.0 else state.mode
    return State(period, step, at, state.home, y, w, mode, 0.0), OK, False


@jit
def advance_held(e, p, grid, state, end, log, samples, c):
    """Skip a stick: return the state at its slip, or the held state at the end if that comes first."""
    frame = frame_at(e, p, state.home)
    in_contact = is_in_contact(e, p, state)
    stiffness, _damping = coefficients(e, p, state.home, in_contact)
    pull = frame.load - stiffness * state.y
    wait, direction = slip_wait(e, p, frame.sigma, pull, phase_at(grid, state))
    at, slips = end, False
    if wait < NEVER:
        slip = advance_time(grid, state, wait)
        slips = is_before(slip, end)
        if slips:
            at = slip
    for n in range(1, c.size):
        c[n] = 0.0
    c[0] = state.y
    at_step = at.period * grid.steps + at.step
    record(samples, log.counts, p, grid, state.home, c, at_step, state.theta, at.theta, ONE_PART)
    waited = (at.period - state.period) * grid.steps + (at.step - state.step)
    span = (waited + (at.theta - state.theta)) * grid.dt
    extend_piece(log.pieces, span, state.y, 0.0)
    if in_contact:
        log.pieces.contact[ELAPSED] += span
    home, y = state.home, state.y
    if not slips:
        return State(at.period, at.step, at.theta, home, y, 0.0, STUCK, state.rest_start), False
    _value, rate, _scale = net_force(e, p, home, y, phase_at(grid, at))
    by_jerk = rate * direction > 0.0
    mode = LEAVES_BY_JERK if by_jerk else LEAVES_BY_SNAP
    if direction < 0.0:
        mode = DOWN_BY_JERK if by_jerk else DOWN_BY_SNAP
    after = State(at.period, at.step, at.theta, home, y, 0.0, mode, 0.0)
    begin(e, p, grid, log, SLIP, after)
    return after, True


@jit
def advance_resting(e, p, grid, state, end, log, samples):
    """Skip a rest on a rigid support, as `advance_rest`, and log its pieces; return (state, whether released)."""
    after = advance_rest(e, p, grid, state, end, log, samples)
    waited = (after.period - state.period) * grid.steps + (after.step - state.step)
    extend_piece(log.pieces, (waited + (after.theta - state.theta)) * grid.dt, 0.0, 0.0)
    if after.mode == REST:
        return after, False
    begin(e, p, grid, log, RELEASE, after)
    return after, True


@jit
def impact_of_end(e, p, grid, state, end, log):
    """Return the state after the impact on a rigid support that falls on the end of a march within rounding."""
    if state.mode != FLIGHT or state.w == 0.0:
        return state
    side = support_at(state.home, state.w < 0.0)
    if is_in_contact(e, p, state) or is_soft(e, p, side):
        return state
    after = impact_at_end(e, p, grid, state, end, log)
    if after.home != state.home or after.mode != FLIGHT:
        begin(e, p, grid, log, REST_BEGINS if after.mode == REST else IMPACT, after)
    return after


@jit
def march_pieces(e, p, grid, state, end, log, samples, c, max_events):
    """March from `state` to the end: `march.loop.march` for exciters with soft supports or friction."""
    counts = log.counts
    before = counts[IMPACTS] + counts[RESTS] + counts[GRAZINGS]
    state, turns = start(e, p, grid, log, state, end), 0
    while is_before(state, end):
        if not (abs(state.y) < math.inf and abs(state.w) < math.inf):
            return state, NOT_FINITE
        if is_full(log) or is_full_of_pieces(log.pieces):
            return state, LOG_FULL
        if is_watched(state.home, e.watched):
            return state, SUPPORT_REACHED
        status = OK
        if state.mode == REST:
            state, is_event = advance_resting(e, p, grid, state, end, log, samples)
        elif state.mode == STUCK:
            state, is_event = advance_held(e, p, grid, state, end, log, samples, c)
        else:
            state, status, is_event = advance_piece(e, p, grid, state, end, log, samples, c)
        if status != OK:
            return state, status
        turns += is_event
        contacts = counts[IMPACTS] + counts[RESTS] + counts[GRAZINGS] - before
        if contacts > max_events or turns > MAX_TURNS:
            return state, MAX_IMPACTS
        if is_spent(log):
            return state, MAX_STEPS
    state = impact_of_end(e, p, grid, state, end, log)
    if is_watched(state.home, e.watched):
        return state, SUPPORT_REACHED
    return state, OK
