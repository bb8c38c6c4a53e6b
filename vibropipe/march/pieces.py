"""The march of motions with soft supports or dry friction: from one linear piece to the next.

A piece is free flight, contact with a soft support, sliding either way, rest, or held by friction. What ends it, a zero
of a gap or of the velocity, is a certified first root (`march.roots`) of the piece's own Taylor polynomial. A contact
is stepped at its own frequency, in its gap: the depth and the duration of a stiff one keep all digits.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import (
    impact_at_end,
    support_at,
)
from vibropipe.march.grid import evaluate, steps_until
from vibropipe.march.log import (
    GRAZINGS,
    IMPACTS,
    POLYNOMIALS,
    RESTS,
    SAMPLES,
    STEPS,
    is_full,
    is_spent,
    record,
)
from vibropipe.march.piece_events import (
    ANY,
    FAR,
    FORCE_BEGINS,
    FORCE_ENDS,
    MANY_PARTS,
    MAY_MOVE,
    NEAR,
    NOTHING,
    ZERO,
    end_newmark_step,
    fill_exact,
    fill_newmark,
    first_event,
    follow_contact,
    force_on,
    parts_of_step,
    piece_at,
)
from vibropipe.march.piece_housing import (
    SLIP_UP,
    STOP,
    TOUCHES,
    first_housing_event,
    is_about_to_move,
    is_held_a_step,
    keep_housing,
    largest_housing_speed,
    until_stop,
)
from vibropipe.march.piece_log import (
    IMPACT,
    REST_BEGINS,
    extend_piece,
    is_full_of_pieces,
)
from vibropipe.march.piece_path import (
    coast,
    ensure_flow,
    flow_index,
    instant_after,
)
from vibropipe.march.piece_state import is_beyond, is_unloaded
from vibropipe.march.piece_still import advance_held, advance_resting, hold, step_end
from vibropipe.march.piece_transitions import (
    after_event,
    begin,
    departed_with,
    hold_housing,
    housing_event,
    start,
    stop_housing,
)
from vibropipe.march.roots import GRAZING, NONE, STRIDE_LIMIT
from vibropipe.march.state import (
    FLIGHT,
    REST,
    STUCK,
    UNLOADED,
    State,
    is_before,
    is_watched,
)
from vibropipe.physics.contact import frame_at, to_velocity
from vibropipe.physics.decay import ALIVE, decayed_taylor
from vibropipe.physics.housing import moved
from vibropipe.physics.stiffness import is_soft, pull_of_support
from vibropipe.words.status import Status

# Time, in steps, within which a mass has not started to move if it stops again.
SHORTEST = 2.0**-52
# Largest number of events of a march, turning points included, which no limit of contacts bounds.
MAX_TURNS = 100_000_000
OK, MAX_IMPACTS, MAX_STEPS = int(Status.OK), int(Status.MAX_IMPACTS), int(Status.MAX_STEPS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED, ROOT_BOUND = int(Status.SUPPORT_REACHED), int(Status.ROOT_BOUND)


@jit_inline
def missed_event(e, p, home, frame, piece, has_friction, y, w):
    """Return the event that the end (y, w) of a step shows to have happened within rounding of that end."""
    if e.no_pull is not None and piece.lets_go:
        pull = pull_of_support(p, home, y, w)
        if piece.in_contact and pull >= 0.0:
            return FORCE_ENDS
        if not piece.in_contact and (y >= 0.0 or pull <= 0.0):
            return NEAR if y >= 0.0 else FORCE_BEGINS
    elif piece.in_contact:
        if y >= 0.0:
            return NEAR
    elif frame.to_near and y <= frame.near:
        return NEAR
    elif frame.to_far and y >= frame.far:
        return FAR
    return ZERO if has_friction and piece.direction * w <= 0.0 else NOTHING


@jit_inline
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
    if event == ZERO:
        return True
    return event < SLIP_UP and is_soft(e, p, support_at(state.home, event != FAR))


@jit_inline
def advance_piece(e, p, grid, state, end, log, samples, c):
    """March a moving state to its next event, or by steps that have none.

    Returns (state, status, whether there was an event).
    """
    frame = frame_at(e, p, state.home, state.housing)
    piece = piece_at(e, p, frame, state)
    parts, decay = parts_of_step(e, p, grid, frame, piece, state)
    if parts == 0:
        return state, MAX_STEPS, False
    dt, is_alive = grid.dt / parts, decay.kind == ALIVE
    flow = log.pieces.flows[flow_index(state.home, piece)]
    force, may = force_on(e, p, grid, frame, piece, state), ANY
    if grid.exact is not None and is_alive:
        ensure_flow(flow, p, piece, dt, e.second_harmonic)
        if parts <= MANY_PARTS and piece.force_power == 0:
            state, force, may, n = coast(
                e, p, grid, frame, piece, flow, parts, state, end, force, log, samples, c
            )
            if n > 0:
                piece = piece_at(e, p, frame, state)
    # The steps of Newmark's method are those of its grid.
    goal = end
    if grid.exact is None or is_held_a_step(state.housing):
        goal = step_end(grid, state, end)
    left = steps_until(grid, state, goal)
    span = left * parts
    is_whole = span <= 1.0
    if not is_whole:
        span = 1.0
    if not is_alive:
        decayed_taylor(c, state.y, decay, p.nu, dt, e.second_harmonic)
    elif grid.exact is not None:
        fill_exact(e, piece, flow, state, force, dt, c)
    else:
        fill_newmark(e, p, grid, frame, piece, state, span, dt, c)
    log.counts[POLYNOMIALS] += 1
    has_friction = e.friction is not None and p.friction > 0.0
    theta, event, kind = first_event(
        e, p, state.home, frame, piece, has_friction, may, c, span, dt, log.pieces.work, log.counts
    )
    if may & MAY_MOVE != 0 and kind != STRIDE_LIMIT:
        other, other_event, other_kind = first_housing_event(
            log.pieces.housing, e, p, grid, frame, piece, state, span, dt, c, log.counts
        )
        if other_event != NOTHING and (event == NOTHING or other < theta):
            theta, event, kind = other, other_event, other_kind
    if kind == STRIDE_LIMIT:
        return state, ROOT_BOUND, False
    if does_not_start(e, p, grid, state, piece, event, theta, c):
        return hold(e, p, grid, state, end, log, samples, c)
    if event == STOP and theta <= SHORTEST and is_about_to_move(state.housing):
        return hold_housing(state.housing, e, p, grid, state, log), OK, True
    if event == TOUCHES:
        is_whole, event, span = False, NOTHING, theta
    if grid.exact is None and event != NOTHING:
        theta = end_newmark_step(
            e, p, grid, frame, piece, state, event, theta, span, dt, c, log.pieces.housing
        )
    y, w = evaluate(grid, c, theta)
    w *= parts
    # After a contact at the end of a step no time is left in it: the mass departs in the next one.
    if event == NOTHING and theta > 0.0:
        event = missed_event(e, p, state.home, frame, piece, has_friction, y, w)
        kind = NONE
    at, waited = goal, left
    if event != NOTHING or not is_whole:
        waited = min(theta / parts, left)
        if waited < left:
            at = instant_after(grid, state, 0, waited)
    if piece.in_contact:
        follow_contact(p, state.home, log.pieces.contact, c, theta, dt)
    first = log.counts[SAMPLES]
    record(samples, log.counts, p, grid, state, c, 0.0, waited, parts)
    home, mode = state.home, state.mode
    if theta > 0.0:
        mode = UNLOADED if is_unloaded(e, state) else FLIGHT
    housing = moved(p, state.housing, theta * dt, frame.sigma * (y - state.y), to_velocity(home, w))
    speed = largest_housing_speed(log.pieces.housing, p, frame.sigma, state.housing, c, dt, theta)
    keep_housing(log, samples, first, p, grid, state, housing, speed)
    extend_piece(log.pieces, theta * dt, y, w)
    after = State(at.period, at.step, at.theta, home, y, w, mode, 0.0, housing)
    if event >= SLIP_UP:
        return housing_event(housing, e, p, grid, after, event, w, log), OK, True
    if event != NOTHING:
        is_grazing = kind == GRAZING
        after = after_event(e, p, grid, after, state.w, piece, event, is_grazing, end, log)
        return after, OK, True
    log.counts[STEPS] += 1
    return after, OK, False


@jit
def impact_of_end(e, p, grid, state, end, log):
    """Return the state after the impact on a rigid support that falls on the end of a march within rounding."""
    if state.mode != FLIGHT or state.w == 0.0:
        return state
    side = support_at(state.home, state.w < 0.0)
    if is_beyond(e, p, state) or is_soft(e, p, side):
        return state
    after = impact_at_end(e, p, grid, state, end, log)
    if after.home != state.home or after.mode != FLIGHT:
        after = departed_with(e, p, grid, after, after.housing)
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
        if state.mode in (REST, STUCK):
            until = until_stop(e.housing, p, grid, state, end)
            if state.mode == REST:
                state, is_event = advance_resting(e, p, grid, state, until, log, samples)
            else:
                state, is_event = advance_held(e, p, grid, state, until, log, samples, c)
            if not is_event and is_before(until, end):
                state = stop_housing(e.housing, e, p, grid, state, log)
                is_event = True
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
