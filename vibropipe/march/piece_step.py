"""A step along one linear piece whose polynomial is known: to its first event, or its end."""

from __future__ import annotations

from vibropipe.compiler import jit_inline
from vibropipe.march.contacts import support_at
from vibropipe.march.grid import evaluate, steps_until
from vibropipe.march.log import SAMPLES, STEPS, record
from vibropipe.march.piece_events import (
    FAR,
    FORCE_BEGINS,
    FORCE_ENDS,
    MAY_MOVE,
    NEAR,
    NOTHING,
    ZERO,
    end_newmark_step,
    first_event,
    follow_contact,
    slides,
)
from vibropipe.march.piece_housing import (
    SLIP_UP,
    STOP,
    TOUCHES,
    first_housing_event,
    is_about_to_move,
    keep_housing,
    largest_housing_speed,
)
from vibropipe.march.piece_log import extend_piece
from vibropipe.march.piece_path import instant_after
from vibropipe.march.piece_state import is_unloaded
from vibropipe.march.piece_still import hold
from vibropipe.march.piece_transitions import after_event, hold_housing, housing_event
from vibropipe.march.roots import GRAZING, NONE, STRIDE_LIMIT
from vibropipe.march.state import FLIGHT, UNLOADED, State
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.housing import moved
from vibropipe.physics.stiffness import is_soft, pull_of_support
from vibropipe.words.status import Status

# Time, in steps, within which a mass has not started to move if it stops again.
SHORTEST = 2.0**-52
OK, ROOT_BOUND = int(Status.OK), int(Status.ROOT_BOUND)


@jit_inline
def missed_event(e, p, home, step, y, w):
    """Return the event that the end (y, w) of a step shows to have happened within rounding of that end."""
    frame, piece = step.frame, step.piece
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
    return ZERO if slides(e, p) and piece.direction * w <= 0.0 else NOTHING


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
def span_until(grid, state, goal, parts):
    """Return `left`, `span` and `is_whole` of a `PieceStep` of a state to a goal."""
    left = steps_until(grid, state, goal)
    span = left * parts
    is_whole = span <= 1.0
    if not is_whole:
        span = 1.0
    return left, span, is_whole


@jit_inline
def finish_step(e, p, grid, state, step, end, log, samples, c):
    """March a state along its piece by a `PieceStep`, with the polynomial c, to the first event or the end of it.

    Returns (state, status, whether there was an event).
    """
    frame, piece, parts, dt, may, goal, left, _span, is_whole = step
    theta, event, kind = first_event(e, p, state.home, step, c, log)
    if may & MAY_MOVE != 0 and kind != STRIDE_LIMIT:
        other, other_event, other_kind = first_housing_event(e, p, grid, state, step, c, log)
        if other_event != NOTHING and (event == NOTHING or other < theta):
            theta, event, kind = other, other_event, other_kind
    if kind == STRIDE_LIMIT:
        return state, ROOT_BOUND, False
    if does_not_start(e, p, grid, state, piece, event, theta, c):
        return hold(e, p, grid, state, end, log, samples, c)
    if event == STOP and theta <= SHORTEST and is_about_to_move(state.housing):
        return hold_housing(state.housing, e, p, grid, state, log), OK, True
    if event == TOUCHES:
        is_whole, event = False, NOTHING
    if grid.exact is None and event != NOTHING:
        theta = end_newmark_step(e, p, grid, state, step, event, theta, c, log)
    y, w = evaluate(grid, c, theta)
    w *= parts
    # After a contact at the end of a step no time is left in it: the mass departs in the next one.
    if event == NOTHING and theta > 0.0:
        event = missed_event(e, p, state.home, step, y, w)
        kind = NONE
    at, waited = goal, left
    if event != NOTHING or not is_whole:
        waited = min(theta / parts, left)
        if waited < left:
            at = instant_after(grid, state, 0, waited)
    if piece.in_contact:
        follow_contact(p, state.home, log.pieces.contact, c, theta, dt, log.pieces.work)
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
