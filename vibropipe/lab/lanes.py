"""Many motions by Newmark's method in lockstep: whole steps side by side, contacts one motion at a time.

A motion leaves the block for what is not plain flight (contact, chatter, rest, its end) and goes through the
very functions of `march.loop`, so it is the same motion to the last bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.contacts import advance_rest, impact_at_end, impact_at_start
from vibropipe.march.flight import fly
from vibropipe.march.grid import Instant, StepGrid, newmark_coefficients
from vibropipe.march.log import Log, is_full
from vibropipe.march.newmark_steps import (
    PENDING,
    STRIDE,
    UNTIL,
    WIDTH,
    W,
    Y,
    advance_block,
    coast_newmark,
    load_lane,
    load_sincos,
    park_lane,
    set_map,
)
from vibropipe.march.state import FLIGHT, REST, State, initial_state, is_before, is_watched
from vibropipe.orbits.return_map import state_xv
from vibropipe.orbits.row import row_parameters
from vibropipe.words.status import Status

OK, MAX_IMPACTS = int(Status.OK), int(Status.MAX_IMPACTS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED = int(Status.SUPPORT_REACHED)
# Numbers kept of a motion: its State, and at EVENTS the contacts and releases it has made.
STATE, EVENTS = 9, 8


class LaneInput(NamedTuple):
    """Motions from (x, v) at tau = 0, one per row: parameters (rows, 7), starts (rows, 2), ends (rows, 3) as
    (period, step, theta); sin and cos at every step of the period (`load.sincos_tables`), and an array of no size."""

    parameters: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    steps: int
    max_events: int
    sines: np.ndarray
    cosines: np.ndarray
    basis: np.ndarray


class LaneResult(NamedTuple):
    """What the motions leave: (x, v) at the end (rows, 2), State (rows, STATE) as numbers, Status (rows,)."""

    end: np.ndarray
    state: np.ndarray
    status: np.ndarray


class LaneWork(NamedTuple):
    """Work arrays of one block."""

    block: np.ndarray
    sin_cos: np.ndarray
    c: np.ndarray


@jit
def row_grid(tasks, p):
    """Newmark's grid of a row, on the tables that all rows share."""
    dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force = newmark_coefficients(p, tasks.steps)
    return StepGrid(
        None, tasks.steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force,
        tasks.sines, tasks.cosines, tasks.basis,
    )  # fmt: skip


@jit
def row_log(logs, row):
    """The log of a row, of logs (rows, room)."""
    return Log(
        logs.position[row], logs.velocity[row], logs.impulse[row], logs.support[row],
        logs.rest_start[row], logs.rest_end[row], logs.rest_support[row],
        logs.grazing[row], logs.grazing_support[row], logs.counts[row],
    )  # fmt: skip


@jit
def save_state(state, kept) -> None:
    """Write a state down as numbers."""
    kept[0], kept[1], kept[2], kept[3] = state.period, state.step, state.theta, state.home
    kept[4], kept[5], kept[6], kept[7] = state.y, state.w, state.mode, state.rest_start


@jit
def load_state(kept):
    """The state that was written down."""
    return State(
        int(kept[0]), int(kept[1]), kept[2], int(kept[3]), kept[4], kept[5], int(kept[6]), kept[7]
    )


@jit
def march_until_step(e, p, grid, state, at_step, end, log, c, max_events):
    """(state, events, Status, whether it goes on) of a motion outside the block, on to flight at the start of
    step `at_step` or a later one, or to its end: the loop of `march`, paused at whole steps."""
    pause = Instant(at_step // grid.steps, at_step % grid.steps, 0.0)
    if is_before(end, pause):
        pause = Instant(end.period, end.step, 0.0)
    state, events = impact_at_start(e, p, grid, state, end, log)
    while is_before(state, end):
        if not (abs(state.y) < math.inf and abs(state.w) < math.inf):
            return state, events, NOT_FINITE, False
        if is_full(log):
            return state, events, LOG_FULL, False
        if is_watched(state.home, e.watched):
            return state, events, SUPPORT_REACHED, False
        if e.rest is not None and state.mode == REST:
            state = advance_rest(e, p, grid, state, end, log, None)
            events += 1
        else:
            if state.mode == FLIGHT and state.theta == 0.0:
                if is_before(state, pause):
                    state = coast_newmark(e, p, grid, state, pause, log.counts)
                if not is_before(state, end):
                    break
                if state.period * grid.steps + state.step >= at_step:
                    return state, events, OK, True
            state, status = fly(e, p, grid, state, end, log, None, c)
            if status != OK:
                return state, events, status, False
            events += state.mode != FLIGHT
        if events > max_events:
            return state, events, MAX_IMPACTS, False
    state = impact_at_end(e, p, grid, state, end, log)
    status = SUPPORT_REACHED if is_watched(state.home, e.watched) else OK
    return state, events, status, False


@jit
def advance_lane(e, tasks, left, logs, scratch, row, i, now) -> bool:
    """Bring the motion of a row, in place i of a block, through the stride that begins at step `now`; whether it
    goes on after that."""
    p = row_parameters(tasks.parameters, row)
    grid, log = row_grid(tasks, p), row_log(logs, row)
    kept, last, block = left.state[row], tasks.ends[row], scratch.block
    end = Instant(int(last[0]), int(last[1]), last[2])
    state = load_state(kept)
    if state.period * grid.steps + state.step < now:
        # It has flown in the block since it was written down.
        y, w, steps = block[Y + i], block[W + i], grid.steps
        state = State(now // steps, now % steps, 0.0, state.home, y, w, FLIGHT, 0.0)
    after = now + STRIDE
    events_left = tasks.max_events - int(kept[EVENTS])
    state, events, status, goes_on = march_until_step(
        e, p, grid, state, after, end, log, scratch.c, events_left
    )
    save_state(state, kept)
    kept[EVENTS] += events
    left.status[row] = status
    at_step = state.period * grid.steps + state.step
    if not goes_on:
        park_lane(math.inf, block, i)
        left.end[row, 0], left.end[row, 1] = state_xv(p, state)
    elif at_step > after:
        park_lane(at_step, block, i)
    else:
        until = last[0] * grid.steps + last[1]
        load_lane(e, p, grid, state.home, state.y, state.w, until, block, i)
    return goes_on


@jit
def init_block(e, tasks, left, scratch, first) -> int:
    """Line up the motions of WIDTH rows from `first`; returns how many there are."""
    rows = min(WIDTH, tasks.parameters.shape[0] - first)
    scratch.block[:] = 0.0
    for i in range(WIDTH):
        park_lane(math.inf, scratch.block, i)
    for i in range(rows):
        row = first + i
        p = row_parameters(tasks.parameters, row)
        grid = row_grid(tasks, p)
        save_state(
            initial_state(e, p, grid, 0.0, tasks.starts[row, 0], tasks.starts[row, 1]),
            left.state[row],
        )
        left.state[row, EVENTS] = 0.0
        set_map(grid, scratch.block, i)
        scratch.block[UNTIL + i] = 0.0
    return rows


@jit
def march_block(e, tasks, left, logs, scratch, first) -> None:
    """March the motions of WIDTH rows from `first` to their ends.

    A row whose log has no room for another contact ends with LOG_FULL, one that makes more than max_events
    contacts and releases with MAX_IMPACTS.
    """
    going = init_block(e, tasks, left, scratch, first)
    now = 0
    while going > 0:
        load_sincos(tasks.sines, tasks.cosines, tasks.steps, now, scratch.sin_cos)
        if advance_block(scratch.block, scratch.sin_cos, now + STRIDE) > 0:
            for i in range(WIDTH):
                if scratch.block[PENDING + i] != 0.0:
                    going -= not advance_lane(e, tasks, left, logs, scratch, first + i, i, now)
        now += STRIDE
