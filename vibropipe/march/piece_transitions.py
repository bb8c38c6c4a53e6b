"""From one linear piece to the next: what is logged of the event between them, and the state after it."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import apply_impact, impact_at_start, resolve_departure, support_at
from vibropipe.march.grid import Instant, turns_at
from vibropipe.march.log import log_grazing, log_impact, log_rest
from vibropipe.march.piece_events import FAR, FORCE_BEGINS, FORCE_ENDS, ZERO
from vibropipe.march.piece_housing import SLIP_UP, STOP
from vibropipe.march.piece_log import (
    BEGIN,
    ENTER,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    IS_OPEN,
    LEAVE,
    PIECES,
    RELEASE,
    RELOAD,
    REST_BEGINS,
    SLIP,
    STICK,
    TOUCH,
    TURN,
    UNLOAD,
    UNSEEN,
    begin_contact,
    begin_housing,
    begin_piece,
    end_contact,
    extend_housing,
    extend_piece,
)
from vibropipe.march.piece_state import (
    direction_of,
    form_of,
    is_beyond,
    resume,
    state_with,
    way_without_velocity,
    with_housing,
)
from vibropipe.march.state import (
    FLIGHT,
    IMPACTS_AT_START,
    LEAVES_BY_VELOCITY,
    RELOADS,
    REST,
    STUCK,
    UNLOADS,
    State,
)
from vibropipe.physics.contact import support_position, to_velocity
from vibropipe.physics.housing import (
    BY_ACCELERATION,
    BY_JERK,
    STANDS,
    UNWATCHED,
    before_chatter,
    stopped,
)
from vibropipe.physics.load import largest_force
from vibropipe.physics.stiffness import damping_of, is_soft

# Speed of an approach that is rounding, as a share of the speeds in the step: a contact with it is a grazing.
SPEED_ROUNDING = 2.0**-48


@jit_inline
def speed_rounding(p, grid, home, w):
    """Return the rounding of the speed of an approach within a step that begins in the frame of `home` with w."""
    offset = support_position(p, home) if home > 0 else 0.0
    return SPEED_ROUNDING * (abs(w) + (abs(offset) + largest_force(p)) * grid.dt)


@jit_inline
def begin(e, p, grid, log, cause, state):
    """Log the piece that a state begins, and the contact with a soft support that begins or ends there."""
    pieces = log.pieces
    was_beyond, is_there = pieces.contact[IS_OPEN] > 0.0, is_beyond(e, p, state)
    position = turns_at(grid, state)
    velocity = to_velocity(state.home, state.w)
    if was_beyond and not is_there:
        end_contact(pieces, velocity)
    if is_there and not was_beyond:
        log_impact(log, position, state.home, velocity, 0.0)
        begin_contact(pieces, -damping_of(p, state.home) * state.w)
    form, direction = form_of(e, p, state), direction_of(state)
    begin_housing(pieces.housing, pieces.counts[PIECES], state.housing)
    begin_piece(pieces, position, cause, form, state.home, direction, state.y, state.w)


@jit
def start(e, p, grid, log, state, end):
    """Log the first piece of a march, and apply the impact of a motion that starts on a support; return the state."""
    if state.mode != IMPACTS_AT_START:
        # A contact that begins here without velocity is logged; another one was, in the march before.
        contact, is_old = log.pieces.contact, state.y != 0.0 or state.w != 0.0
        if not (is_old and is_beyond(e, p, state)):
            contact[IS_OPEN] = 0.0
        elif contact[IS_OPEN] == 0.0:
            contact[IS_OPEN] = UNSEEN
        begin(e, p, grid, log, BEGIN, state)
        return state
    log.pieces.contact[IS_OPEN] = 0.0
    housing = state.housing
    if not -state.w > speed_rounding(p, grid, state.home, 0.0):
        log_grazing(log, turns_at(grid, state), state.home)
        after = resume(e, p, grid, state, state.home, 0.0, state.housing)
        begin(e, p, grid, log, STICK if after.mode == STUCK else TOUCH, after)
        return after
    if is_soft(e, p, state.home):
        after = State(
            state.period, state.step, state.theta, state.home, 0.0, state.w, FLIGHT, 0.0, housing
        )
        after = with_housing(e, p, grid, after, housing)
        begin(e, p, grid, log, ENTER, after)
        return after
    begin(e, p, grid, log, BEGIN, state)
    after, _impacts = impact_at_start(e, p, grid, state, end, log)
    after = departed_with(e, p, grid, after, after.housing)
    begin(e, p, grid, log, REST_BEGINS if after.mode == REST else IMPACT, after)
    return after


@jit_inline
def departed_with(e, p, grid, state, housing):
    """Return the state of a mass that goes on from a rigid support, with its housing where that has no velocity."""
    if housing is None:
        return state
    if state.w > 0.0:
        return with_housing(e, p, grid, state, housing)
    return resume(e, p, grid, state, state.home, 0.0, housing)


@jit_inline
def housing_event(housing, e, p, grid, state, event, w, log):
    """Return the state after a housing slips or stops, from the state at that event; itself without one.

    housing, w : of the state.
    """
    if housing is None:
        return state
    still = stopped(p, housing, to_velocity(state.home, w))
    after = State(
        state.period, state.step, state.theta, state.home, state.y, w, state.mode,
        state.rest_start, still,
    )  # fmt: skip
    if event == STOP:
        way, power = way_without_velocity(e, p, grid, after)
        # A housing that stops although the force pushes it on does so by rounding.
        if way == housing.way and power == BY_ACCELERATION:
            way, power = STANDS, UNWATCHED
        cause = HOUSING_STOP
    else:
        way, power, cause = 1 if event == SLIP_UP else -1, BY_JERK, HOUSING_SLIP
    after = state_with(after, after.mode, way, power, still)
    begin(e, p, grid, log, cause, after)
    return after


@jit_inline
def hold_housing(housing, e, p, grid, state, log):
    """Return a state whose housing, about to move, does not start, and is held within the step; itself without one."""
    if housing is None:
        return state
    still = stopped(p, housing, to_velocity(state.home, state.w))
    after = state_with(state, state.mode, STANDS, UNWATCHED, still)
    begin(e, p, grid, log, HOUSING_STOP, after)
    return after


@jit_inline
def stop_housing(effect, e, p, grid, state, log):
    """Return the state after the stop of a housing in which the mass lies still, and log it; itself without one.

    effect : that of a housing, or None.
    """
    if effect is None:
        return state
    still, since, home, mode = (
        stopped(p, state.housing, 0.0),
        state.rest_start,
        state.home,
        state.mode,
    )
    after = resume(e, p, grid, state, home, state.y, still)
    stays = State(
        state.period, state.step, state.theta, home, state.y, 0.0, mode, since, after.housing
    )
    begin(e, p, grid, log, HOUSING_STOP, stays)
    if after.mode == mode:
        return stays
    if mode == REST:
        log_rest(log, since, turns_at(grid, state), home)
    begin(e, p, grid, log, RELEASE if mode == REST else SLIP, after)
    return after


@jit_inline
def touch_rigid(e, p, grid, state, side, approach, end, log):
    """Return the state after the mass has met a rigid support with a speed, 0 where it only touches it."""
    period, step, at, housing = state.period, state.step, state.theta, state.housing
    if approach > 0.0:
        moved = State(period, step, at, side, 0.0, -approach, FLIGHT, 0.0, housing)
        after = apply_impact(e, p, grid, moved, True, approach, at, log)
    else:
        log_grazing(log, turns_at(grid, Instant(period, step, at)), side)
        after = State(period, step, at, side, 0.0, 0.0, LEAVES_BY_VELOCITY, 0.0, housing)
    departed = resolve_departure(e, p, grid, after, end, log)
    departed = departed_with(e, p, grid, departed, departed.housing)
    cause = REST_BEGINS if departed.mode == REST else IMPACT if approach > 0.0 else TOUCH
    w, mode, goes = departed.w, departed.mode, before_chatter(after.housing, departed.housing)
    began = State(after.period, after.step, after.theta, side, 0.0, w, mode, 0.0, goes)
    begin(e, p, grid, log, cause, began)
    if departed.mode == REST:
        waited = (departed.period - after.period) * grid.steps + (departed.step - after.step)
        extend_housing(log.pieces.housing, log.pieces.counts[PIECES] - 1, departed.housing, 0.0)
        extend_piece(log.pieces, (waited + departed.theta - after.theta) * grid.dt, 0.0, 0.0)
    return departed


@jit_inline
def after_event(e, p, grid, state, speed, piece, event, is_grazing, end, log):
    """Return the state after an event, from the one just before it; speed : w at the start of the step."""
    period, step, at, home, y, w = (
        state.period,
        state.step,
        state.theta,
        state.home,
        state.y,
        state.w,
    )
    instant = Instant(period, step, at)
    if event == ZERO:
        after = resume(e, p, grid, instant, home, y, state.housing)
        cause = TURN if direction_of(after) == -piece.direction else TOUCH
        cause = STICK if after.mode == STUCK else cause
        begin(e, p, grid, log, cause, after)
        return after
    if e.no_pull is not None and event in (FORCE_ENDS, FORCE_BEGINS) and y < 0.0:
        ends = event == FORCE_ENDS
        mode, cause = (UNLOADS, UNLOAD) if ends else (RELOADS, RELOAD)
        after = State(period, step, at, home, y, w, mode, 0.0, state.housing)
        after = with_housing(e, p, grid, after, state.housing)
        begin(e, p, grid, log, cause, after)
        return after
    leaves = piece.in_contact or piece.lets_go
    side = support_at(home, event != FAR)
    approach = w if event == FAR or leaves else -w
    if is_grazing or not approach > speed_rounding(p, grid, home, speed):
        approach = 0.0
    if not is_soft(e, p, side):
        return touch_rigid(e, p, grid, state, side, approach, end, log)
    if approach == 0.0:
        if not leaves:
            log_grazing(log, turns_at(grid, instant), side)
        after = resume(e, p, grid, instant, side, 0.0, state.housing)
        begin(e, p, grid, log, STICK if after.mode == STUCK else TOUCH, after)
        return after
    if leaves:
        after = State(period, step, at, side, 0.0, approach, LEAVES_BY_VELOCITY, 0.0, state.housing)
        after = with_housing(e, p, grid, after, state.housing)
        begin(e, p, grid, log, LEAVE, after)
    else:
        after = State(period, step, at, side, 0.0, -approach, FLIGHT, 0.0, state.housing)
        after = with_housing(e, p, grid, after, state.housing)
        begin(e, p, grid, log, ENTER, after)
    return after
