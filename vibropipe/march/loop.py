"""The marching loop of both methods: grid steps, contacts located within them, rests skipped in one piece."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import advance_rest, impact_at_end, impact_at_start
from vibropipe.march.fast_path import coast, may_coast
from vibropipe.march.flight import fly
from vibropipe.march.grid import stays_between, whole_step
from vibropipe.march.log import COMPUTED, SAMPLES, STEPS, clear_log, is_full, is_spent
from vibropipe.march.pieces import march_pieces
from vibropipe.march.state import FLIGHT, REST, State, is_before, is_watched
from vibropipe.physics.contact import frame_at
from vibropipe.physics.limits import MAX_TABLE
from vibropipe.physics.load_steps import contribution_of_second, load_contribution, sincos_at_step
from vibropipe.words.status import Status

OK, MAX_IMPACTS = int(Status.OK), int(Status.MAX_IMPACTS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED, MAX_STEPS = int(Status.SUPPORT_REACHED), int(Status.MAX_STEPS)


@jit_inline
def march(e, p, grid, state, end, log, samples, c, max_events):
    """March from `state` to the end.

    An impact that falls on the end within rounding of time is applied: the returned state is the one after it.

    end : Instant
    log : contacts are appended
    samples : None leaves the code for samples out
    c : (DEGREE + 1,) of the exact method, (3,) of Newmark's, work array
    max_events : largest number of contacts and releases

    Returns the state at the end, or where the march stopped, and a code of `Status`: OK; LOG_FULL where the log has no
    room for another contact; MAX_IMPACTS after max_events; MAX_STEPS where the log allows no more work; SUPPORT_REACHED
    where the mass meets a watched support; NOT_FINITE; ROOT_BOUND.
    """
    if log.pieces is not None:
        return march_pieces(e, p, grid, state, end, log, samples, c, max_events)
    if log.plain is not None:
        return march_plain(e, p, grid, state, end, log, samples, c, max_events)
    return state, NOT_FINITE


@jit_inline
def march_plain(e, p, grid, state, end, log, samples, c, max_events):
    """March with rigid supports and without friction."""
    state, events = impact_at_start(e, p, grid, state, end, log)
    while is_before(state, end):
        if not (abs(state.y) < math.inf and abs(state.w) < math.inf):
            return state, NOT_FINITE
        if is_full(log):
            return state, LOG_FULL
        if is_watched(state.home, e.watched):
            return state, SUPPORT_REACHED
        if e.rest is not None and state.mode == REST:
            state = advance_rest(e, p, grid, state, end, log, samples)
            events += 1
        else:
            if samples is None:
                if grid.exact is None:
                    if state.mode == FLIGHT and state.theta == 0.0:
                        state = coast_newmark(e, p, grid, state, end, log.counts)
                elif may_coast(e, state):
                    events_left = max_events - events
                    state, struck = coast(e, p, grid, state, end, log, c, events_left)
                    events += struck
                if not is_before(state, end):
                    break
            state, status = fly(e, p, grid, state, end, log, samples, c)
            if status != OK:
                return state, status
            if is_spent(log):
                return state, MAX_STEPS
            events += state.mode != FLIGHT
        if events > max_events:
            return state, MAX_IMPACTS
    state = impact_at_end(e, p, grid, state, end, log)
    if is_watched(state.home, e.watched):
        return state, SUPPORT_REACHED
    return state, OK


@jit
def coast_newmark(e, p, grid, state, end, counts):
    """Take whole steps in flight while each is certified to reach no support; add them to counts[STEPS].

    state : in flight at the start of a step. Returns the state at the start of the first step not taken, or of that of
    `end`.
    """
    frame = frame_at(e, p, state.home)
    sigma, load_y, load_w = frame.sigma, grid.b1 * frame.load, grid.b2 * frame.load
    period, step, y, w = state.period, state.step, state.y, state.w
    n_steps = 0
    while period < end.period or step < end.step:
        forcing_y, forcing_w = load_y, load_w
        if e.forcing is not None:
            s, c = sincos_at_step(grid.table_1, grid.table_2, grid.steps, step)
            forcing_y = load_contribution(
                sigma * grid.force[0], sigma * grid.force[1], load_y, s, c
            )
            forcing_w = load_contribution(
                sigma * grid.force[2], sigma * grid.force[3], load_w, s, c
            )
            if e.second_harmonic is not None:
                second_y, second_w = contribution_of_second(grid.force_2, s, c)
                forcing_y += sigma * second_y
                forcing_w += sigma * second_w
        y1, w1 = whole_step(grid.a11, grid.a12, grid.a21, grid.a22, y, w, forcing_y, forcing_w)
        if not stays_between(grid, frame, 0, y, w, y1, w1, 1.0):
            break
        y, w = y1, w1
        n_steps += 1
        step += 1
        if step == grid.steps:
            step = 0
            period += 1
    counts[STEPS] += n_steps
    if e.forcing is not None and grid.steps > MAX_TABLE:
        counts[COMPUTED] += n_steps
    return State(period, step, 0.0, state.home, y, w, FLIGHT, 0.0, None)


@jit
def march_repeatedly(e, p, grid, state, end, log, samples, c, max_events, n_calls):
    """March `n_calls` times from the same state with an empty log: once for a motion, more often to time it.

    Motions and their times share this kernel. Other arguments and results as of `march`, of the last call.
    """
    after, status, first_sample = state, OK, log.counts[SAMPLES]
    for _ in range(n_calls):
        clear_log(log)
        log.counts[SAMPLES] = first_sample
        after, status = march(e, p, grid, state, end, log, samples, c, max_events)
    return after, status
