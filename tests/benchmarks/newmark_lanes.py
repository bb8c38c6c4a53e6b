"""Newmark's method on many motions in lockstep: plain steps side by side, contacts one motion at a time.

A block is one flat array with WIDTH numbers per field. Fields then lie at constant offsets, so the compiler can prove
that no number written is read by another motion, and vectorises the loop. A motion leaves its block for everything but
plain flight (contact, chatter, sticking, its end) and is then advanced by the functions of `march.loop`, so it is
bitwise equal to a motion marched alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.contacts import advance_rest, impact_at_end, impact_at_start
from vibropipe.march.flight import fly
from vibropipe.march.grid import Instant, StepGrid, newmark_coefficients, whole_step
from vibropipe.march.log import Log, is_full
from vibropipe.march.loop import coast_newmark
from vibropipe.march.state import FLIGHT, REST, State, initial_state, is_before, is_watched
from vibropipe.orbits.return_map import state_xv
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.contact import frame_at
from vibropipe.physics.load import forcing_period
from vibropipe.physics.load_steps import load_contribution, sincos_at_step
from vibropipe.words.status import Status

# Motions in a block: a multiple of every vector width.
WIDTH = 64
# Steps of a block between two checks: enough to use each number several times once it is loaded from memory.
STRIDE = 8
# Fields of a block, by the index of their first number: the motion; its one-step map; factors of sin, of cos and the
# constant load in the forcing of y (P) and w (Q); half a step; limits of y beyond which a support may be met; the
# last step of the motion in the block; whether the motion is to be advanced by the caller.
Y, W, A11, A12, A21, A22, P_S, P_C, P_L, Q_S, Q_C, Q_L, HALF, LOW, HIGH, UNTIL, PENDING = (
    WIDTH * field for field in range(17)
)
SIZE = PENDING + WIDTH
# Rounding of y, as a share of the lengths that it is computed from: the limits LOW and HIGH lie inside the supports
# by as much.
SUPPORT_MARGIN = 2.0**-46
OK, MAX_IMPACTS = int(Status.OK), int(Status.MAX_IMPACTS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
SUPPORT_REACHED = int(Status.SUPPORT_REACHED)
# Length of a saved motion: its State, and at index EVENTS the number of its contacts and releases.
STATE, EVENTS = 9, 8


@jit
def load_lane(e, p, grid, home, y, w, until, block, i) -> None:
    """Load a motion in flight into lane i of a block.

    Parameters
    ----------
    e, p, grid, home : Effects, Parameters, StepGrid, int
    y, w : float
        State in the frame of `home`.
    until : float
        Step, counted from tau = 0, at which the motion leaves the block.
    block : ndarray, shape (SIZE,)
    i : int
    """
    frame = frame_at(e, p, home)
    sigma, near, far = frame.sigma, frame.near, frame.far
    block[Y + i], block[W + i] = y, w
    block[P_L + i], block[Q_L + i] = grid.b1 * frame.load, grid.b2 * frame.load
    block[P_S + i], block[P_C + i] = sigma * grid.force[0], sigma * grid.force[1]
    block[Q_S + i], block[Q_C + i] = sigma * grid.force[2], sigma * grid.force[3]
    if e.forcing is None:
        block[P_S + i] = block[P_C + i] = block[Q_S + i] = block[Q_C + i] = 0.0
    length = abs(near) + abs(far) + abs(block[P_L + i]) + grid.dt * abs(block[Q_L + i])
    length += abs(block[P_S + i]) + abs(block[P_C + i])
    length += grid.dt * (abs(block[Q_S + i]) + abs(block[Q_C + i]))
    block[LOW + i] = near + SUPPORT_MARGIN * length if frame.to_near else -math.inf
    block[HIGH + i] = far - SUPPORT_MARGIN * length if frame.to_far else math.inf
    block[UNTIL + i] = until


@jit
def park_lane(until, block, i) -> None:
    """Let lane i of a block stand still until a step."""
    for field in (Y, W, P_S, P_C, P_L, Q_S, Q_C, Q_L):
        block[field + i] = 0.0
    block[LOW + i], block[HIGH + i] = -math.inf, math.inf
    block[UNTIL + i] = until


@jit
def set_map(grid, block, i) -> None:
    """Write the one-step map of a grid into lane i of a block."""
    block[A11 + i], block[A12 + i] = grid.a11, grid.a12
    block[A21 + i], block[A22 + i] = grid.a21, grid.a22
    block[HALF + i] = 0.5 * grid.dt


@jit
def load_sincos(sines, cosines, steps, at_step, sin_cos) -> None:
    """Write sin and cos at the starts of STRIDE steps into sin_cos, shape (2 STRIDE,).

    sines, cosines : `sincos_tables`; steps : per forcing period; at_step : first step, counted from tau = 0.
    """
    step = at_step % steps
    for k in range(STRIDE):
        sin_cos[2 * k], sin_cos[2 * k + 1] = sincos_at_step(sines, cosines, steps, step)
        step = 0 if step + 1 == steps else step + 1


@jit
def advance_block(block, sin_cos, end) -> int:
    """Take STRIDE steps, up to step `end`, with all motions of a block that allow it.

    The others keep their state and have PENDING set: a support may be met (the hull of the Bezier points of some step
    reaches it), or the motion leaves the block before `end`.

    Returns
    -------
    int
        Number of motions pending.
    """
    n_pending = 0
    for i in range(WIDTH):
        y, w = block[Y + i], block[W + i]
        lowest = highest = y
        for k in range(STRIDE):
            s, c = sin_cos[2 * k], sin_cos[2 * k + 1]
            forcing_y = load_contribution(block[P_S + i], block[P_C + i], block[P_L + i], s, c)
            forcing_w = load_contribution(block[Q_S + i], block[Q_C + i], block[Q_L + i], s, c)
            between = y + block[HALF + i] * w
            y, w = whole_step(
                block[A11 + i],
                block[A12 + i],
                block[A21 + i],
                block[A22 + i],
                y,
                w,
                forcing_y,
                forcing_w,
            )
            lowest, highest = min(lowest, min(between, y)), max(highest, max(between, y))
        # The last y is tested too: nan persists in it, but minimum and maximum may skip nan.
        inside = (lowest > block[LOW + i]) & (highest < block[HIGH + i]) & (abs(y) < math.inf)
        advances = inside & (end <= block[UNTIL + i])
        block[Y + i] = y if advances else block[Y + i]
        block[W + i] = w if advances else block[W + i]
        block[PENDING + i] = 0.0 if advances else 1.0
        n_pending += 0 if advances else 1
    return n_pending


class LaneInput(NamedTuple):
    """Motions from (x, v) at tau = 0, one per row.

    parameters : (rows, n); starts : (rows, 2); ends : (rows, 3) as (period, step, theta); steps : per forcing period;
    max_events : limit of contacts and releases; sines, cosines : at every step of the period (`load.sincos_tables`);
    basis : empty.
    """

    parameters: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    steps: int
    max_events: int
    sines: np.ndarray
    cosines: np.ndarray
    basis: np.ndarray


class LaneResult(NamedTuple):
    """Results by row: end : (rows, 2) as (x, v); state : (rows, STATE) of a State; status : (rows,) of Status."""

    end: np.ndarray
    state: np.ndarray
    status: np.ndarray


class LaneWork(NamedTuple):
    """Work arrays of one block."""

    block: np.ndarray
    sin_cos: np.ndarray
    c: np.ndarray


@jit
def row_grid(inputs, p):
    """Return Newmark's grid of a row, with the tables that all rows share."""
    dt = forcing_period(p) / inputs.steps
    (a11, a12, b1, a21, a22, b2), force, force_2 = newmark_coefficients(p, dt, None)
    return StepGrid(
        None, inputs.steps, dt, a11, a12, b1, a21, a22, b2, 0.0, 0.0, force,
        inputs.sines, inputs.cosines, inputs.basis, None, force_2,
    )  # fmt: skip


@jit
def row_log(logs, row):
    """Return the log of a row from the logs of all rows (rows, capacity)."""
    return Log(
        logs.position[row], logs.velocity[row], logs.impulse[row], logs.support[row],
        logs.rest_start[row], logs.rest_end[row], logs.rest_support[row],
        logs.grazing[row], logs.grazing_support[row], logs.counts[row],
    )  # fmt: skip


@jit
def save_state(state, data) -> None:
    """Write a State into a row of numbers."""
    data[0], data[1], data[2], data[3] = state.period, state.step, state.theta, state.home
    data[4], data[5], data[6], data[7] = state.y, state.w, state.mode, state.rest_start


@jit
def load_state(data):
    """Return the State that `save_state` wrote."""
    return State(
        int(data[0]),
        int(data[1]),
        data[2],
        int(data[3]),
        data[4],
        data[5],
        int(data[6]),
        data[7],
        None,
    )


@jit
def march_until_step(e, p, grid, state, at_step, end, log, c, max_events):
    """March a motion outside its block until it is in flight at the start of a step, or ends.

    This is the loop of `march`, paused at whole steps. at_step : the earliest step at which it pauses; max_events :
    limit of contacts and releases. Returns (state, events, status, is_going): the state, contacts and releases made,
    Status, and whether the motion continues.
    """
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
def advance_lane(e, inputs, results, logs, scratch, row, i, now) -> bool:
    """Advance the motion in lane i through the stride that begins at step `now`; return whether it continues."""
    p = row_parameters(inputs.parameters, row)
    grid, log = row_grid(inputs, p), row_log(logs, row)
    data, row_end, block = results.state[row], inputs.ends[row], scratch.block
    end = Instant(int(row_end[0]), int(row_end[1]), row_end[2])
    state = load_state(data)
    if state.period * grid.steps + state.step < now:
        # it has flown in the block since it was saved
        y, w, steps = block[Y + i], block[W + i], grid.steps
        state = State(now // steps, now % steps, 0.0, state.home, y, w, FLIGHT, 0.0, None)
    after = now + STRIDE
    events_left = inputs.max_events - int(data[EVENTS])
    state, events, status, goes_on = march_until_step(
        e, p, grid, state, after, end, log, scratch.c, events_left
    )
    save_state(state, data)
    data[EVENTS] += events
    results.status[row] = status
    at_step = state.period * grid.steps + state.step
    if not goes_on:
        park_lane(math.inf, block, i)
        results.end[row, 0], results.end[row, 1] = state_xv(p, state)
    elif at_step > after:
        park_lane(at_step, block, i)
    else:
        end_step = row_end[0] * grid.steps + row_end[1]
        load_lane(e, p, grid, state.home, state.y, state.w, end_step, block, i)
    return goes_on


@jit
def init_block(e, inputs, results, scratch, first) -> int:
    """Load the motions of WIDTH rows from `first` into the block; return their number."""
    rows = min(WIDTH, inputs.parameters.shape[0] - first)
    scratch.block[:] = 0.0
    for i in range(WIDTH):
        park_lane(math.inf, scratch.block, i)
    for i in range(rows):
        row = first + i
        p = row_parameters(inputs.parameters, row)
        grid = row_grid(inputs, p)
        save_state(
            initial_state(e, p, grid, 0.0, inputs.starts[row, 0], inputs.starts[row, 1], None),
            results.state[row],
        )
        results.state[row, EVENTS] = 0.0
        set_map(grid, scratch.block, i)
        scratch.block[UNTIL + i] = 0.0
    return rows


@jit
def march_block(e, inputs, results, logs, scratch, first) -> None:
    """March the motions of WIDTH rows from `first` to their ends.

    A row whose log is full ends with LOG_FULL, one with more than max_events contacts and releases with MAX_IMPACTS.
    """
    going = init_block(e, inputs, results, scratch, first)
    now = 0
    while going > 0:
        load_sincos(inputs.sines, inputs.cosines, inputs.steps, now, scratch.sin_cos)
        if advance_block(scratch.block, scratch.sin_cos, now + STRIDE) > 0:
            for i in range(WIDTH):
                if scratch.block[PENDING + i] != 0.0:
                    going -= not advance_lane(e, inputs, results, logs, scratch, first + i, i, now)
        now += STRIDE
