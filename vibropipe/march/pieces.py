"""The march of motions with soft supports or dry friction: from one linear piece to the next.

A piece is free flight, contact with a soft support, sliding either way, rest, or held by friction. What ends it, a zero
of a gap or of the velocity, is a certified first root (`march.roots`) of the piece's own Taylor polynomial. A contact
is stepped at its own frequency, in its gap: the depth and the duration of a stiff one keep all digits.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import impact_at_end, support_at
from vibropipe.march.grid import phase_at
from vibropipe.march.log import GRAZINGS, IMPACTS, POLYNOMIALS, RESTS, is_full, is_spent
from vibropipe.march.piece_events import (
    ANY,
    MANY_PARTS,
    MAX_PARTS,
    PieceStep,
    fill_exact,
    fill_newmark,
    force_on,
    parts_of_step,
    piece_at,
)
from vibropipe.march.piece_housing import is_held_a_step, until_stop
from vibropipe.march.piece_log import IMPACT, REST_BEGINS, is_full_of_pieces
from vibropipe.march.piece_path import Track, coast, ensure_flow, flow_index
from vibropipe.march.piece_state import is_beyond
from vibropipe.march.piece_step import finish_step, span_until
from vibropipe.march.piece_still import advance_held, advance_resting, step_end
from vibropipe.march.piece_transitions import begin, departed_with, start, stop_housing
from vibropipe.march.state import FLIGHT, REST, STUCK, is_before, is_watched
from vibropipe.physics.contact import frame_at
from vibropipe.physics.decay import ALIVE, decayed_taylor
from vibropipe.physics.frequency import ramp_of
from vibropipe.physics.ramp import parts_on_ramp, piece_taylor_on_ramp
from vibropipe.physics.stiffness import is_soft
from vibropipe.words.status import Status

# Largest number of events of a march, turning points included, which no limit of contacts bounds.
MAX_TURNS = 100_000_000
OK, MAX_IMPACTS, MAX_STEPS = int(Status.OK), int(Status.MAX_IMPACTS), int(Status.MAX_STEPS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED = int(Status.SUPPORT_REACHED)


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
            track = Track(frame, piece, parts, dt)
            state, force, may, n = coast(e, p, grid, track, state, end, force, log, samples, c)
            if n > 0:
                piece = piece_at(e, p, frame, state)
    # The steps of Newmark's method are those of its grid.
    goal = end
    if grid.exact is None or is_held_a_step(state.housing):
        goal = step_end(grid, state, end)
    left, span, is_whole = span_until(grid, state, goal, parts)
    if not is_alive:
        decayed_taylor(c, state.y, decay, p.nu, dt, e.second_harmonic)
    elif grid.exact is not None:
        fill_exact(e, piece, flow, state, force, dt, c)
    else:
        fill_newmark(e, p, grid, frame, piece, state, span, dt, c)
    log.counts[POLYNOMIALS] += 1
    step = PieceStep(frame, piece, parts, dt, may, goal, left, span, is_whole)
    return finish_step(e, p, grid, state, step, end, log, samples, c)


@jit
def fill_on_ramp(e, p, grid, frame, piece, state, dt, c) -> None:
    """Fill c with the motion on a piece from a state, in t/dt."""
    scale, second = frame.sigma * piece.factor, e.second_harmonic
    moment = phase_at(grid, state)
    piece_taylor_on_ramp(c, state.y, state.w, p, moment, scale, piece, dt, second)
    # The derivatives that the mode declares zero are set to zero, without rounding.
    if piece.velocity_power >= 2:
        c[2] = 0.0
    if piece.velocity_power >= 3:
        c[3] = 0.0


@jit_inline
def advance_on_ramp(e, p, grid, state, end, log, samples, c):
    """March a moving state to its next event, or by a step without one: `advance_piece` on a `RampGrid`."""
    frame = frame_at(e, p, state.home, state.housing)
    piece = piece_at(e, p, frame, state)
    parts = 1.0
    if piece.in_contact or piece.factor > 1.0:
        parts = parts_on_ramp(piece, grid.dt)
    if not parts <= MAX_PARTS:
        return state, MAX_STEPS, False
    dt = grid.dt / parts
    fill_on_ramp(e, p, grid, frame, piece, state, dt, c)
    log.counts[POLYNOMIALS] += 1
    goal = step_end(grid, state, end) if is_held_a_step(state.housing) else end
    left, span, is_whole = span_until(grid, state, goal, parts)
    step = PieceStep(frame, piece, parts, dt, ANY, goal, left, span, is_whole)
    return finish_step(e, p, grid, state, step, end, log, samples, c)


@jit_inline
def advance(ramp, e, p, grid, state, end, log, samples, c):
    """Do as `advance_piece`; ramp : of the grid, as an argument, so that only one of both is compiled."""
    if ramp is not None:
        return advance_on_ramp(e, p, grid, state, end, log, samples, c)
    return advance_piece(e, p, grid, state, end, log, samples, c)


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
            state, status, is_event = advance(
                ramp_of(grid), e, p, grid, state, end, log, samples, c
            )
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
