"""The march on a ramp, with rigid supports: Taylor steps over the whole motion, and certified first contacts.

The grid has one step per "period", so that a time on it counts steps since the start of the ramp. Parameters have the
highest frequency of the ramp: it enters bounds, and signs that do not depend on the frequency.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.contacts import (
    apply_contact,
    apply_impact,
    depart,
    leave_support,
    release_before,
    strikes_at_end,
)
from vibropipe.march.flight import first_contact
from vibropipe.march.grid import StepGrid, evaluate, margins, stays_between, turns_at
from vibropipe.march.log import POLYNOMIALS, STEPS, is_full, is_spent, record
from vibropipe.march.roots import NONE, STRIDE_LIMIT
from vibropipe.march.state import (
    FLIGHT,
    IMPACTS_AT_START,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_SNAP,
    LEAVES_BY_VELOCITY,
    REST,
    State,
    is_before,
)
from vibropipe.physics.contact import frame_at
from vibropipe.physics.frequency import frequency_at, turn_at
from vibropipe.physics.load import force_at, force_value
from vibropipe.physics.ramp import (
    longest_step,
    release_wait_on_ramp,
    taylor_on_ramp,
)
from vibropipe.words.status import Status

OK, MAX_IMPACTS, MAX_STEPS = int(Status.OK), int(Status.MAX_IMPACTS), int(Status.MAX_STEPS)
NOT_FINITE, LOG_FULL = int(Status.NOT_FINITE), int(Status.LOG_FULL)
ROOT_BOUND = int(Status.ROOT_BOUND)


def steps_on_ramp(e, p, ramp) -> int:
    """Return the fewest steps in a period of the highest frequency of a ramp, that of p."""
    return math.ceil(2.0 * math.pi / p.nu / longest_step(e, p, ramp.change))


def grid_on_ramp(e, p, ramp, steps: int) -> StepGrid:
    """Return the grid of a ramp with a number of steps in a period of its highest frequency, that of p.

    It has what certifies flights; its one-step map is not used and zero.
    """
    dt = 2.0 * math.pi / p.nu / steps
    margin0, margin1 = margins(p, dt, abs(ramp.change) * (abs(p.f) + 2.0 * abs(p.f2)))
    empty, basis = np.empty(0), np.zeros((0, 0))
    return StepGrid(
        1, 1, dt, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, margin0, margin1, (0.0, 0.0, 0.0, 0.0), empty,
        empty, basis, e.second_harmonic, (0.0, 0.0, 0.0, 0.0),
    )  # fmt: skip


@jit
def _turn(ramp, grid, at):
    """Return the phase of an `Instant` or a state, in turns."""
    return turn_at(ramp, turns_at(grid, at) * grid.dt)


@jit
def _fly(e, p, ramp, grid, state, end, log, samples, c):
    """March from a state in flight to its next contact, or to the end of its step; as `flight.fly`."""
    frame, mode = frame_at(e, p, state.home), state.mode
    limit = end.theta if state.period == end.period else 1.0
    s, second = turns_at(grid, state) * grid.dt, e.second_harmonic
    force = force_at(p, frame.sigma, turn_at(ramp, s), second)
    taylor_on_ramp(
        c, state.y, state.w, force, frame.load, p.h, frequency_at(ramp, s), ramp.change, grid.dt
    )
    if mode >= LEAVES_BY_ACCELERATION:
        # The derivatives that the mode declares zero are set to zero, without rounding.
        of_load = 0.5 * grid.dt * grid.dt * (force_value(force, second) + frame.load)
        c[2] = of_load if mode == LEAVES_BY_ACCELERATION else 0.0
        c[3] = 0.0 if mode == LEAVES_BY_SNAP else c[3]
    log.counts[POLYNOMIALS] += 1
    held = mode >= LEAVES_BY_ACCELERATION and not c[mode] > 0.0
    kind, at_near, theta = NONE, True, limit - state.theta
    y, w = evaluate(grid, c, theta)
    if not held and not (
        mode <= LEAVES_BY_VELOCITY
        and stays_between(grid, frame, mode, state.y, state.w, y, w, theta)
    ):
        theta, kind, at_near = first_contact(grid, frame, state, c, y, theta, log.counts)
    if kind == STRIDE_LIMIT:
        return state, ROOT_BOUND
    motion = None if held else c
    record(samples, log.counts, p, grid, state, motion, 0.0, theta)
    if kind != NONE:
        after = apply_contact(e, p, grid, state, kind, at_near, c, theta, log)
        return depart(e, p, grid, after, _turn(ramp, grid, after), end, log), OK
    log.counts[STEPS] += 1
    period, at = (state.period, limit) if limit < 1.0 else (state.period + 1, 0.0)
    if held:
        after = State(period, 0, at, state.home, 0.0, 0.0, LEAVES_BY_VELOCITY, 0.0, None)
        return depart(e, p, grid, after, _turn(ramp, grid, after), end, log), OK
    # After an impact at the end of a step no time is left in it: the mass departs in the next one.
    return State(period, 0, at, state.home, y, w, FLIGHT if theta > 0.0 else mode, 0.0, None), OK


@jit
def march_on_ramp(e, p, ramp, grid, state, end, log, samples, c, max_events):
    """March from `state` to the end on a ramp; arguments and results as of `march`, with `Ramp` and `grid_on_ramp`."""
    events = 0
    if state.mode == IMPACTS_AT_START:
        after = apply_impact(e, p, grid, state, True, -state.w, state.theta, log)
        state = depart(e, p, grid, after, _turn(ramp, grid, after), end, log)
        events = 1
    while is_before(state, end):
        if not (abs(state.y) < math.inf and abs(state.w) < math.inf):
            return state, NOT_FINITE
        if is_full(log):
            return state, LOG_FULL
        if state.mode == REST:
            frame, s = frame_at(e, p, state.home), turns_at(grid, state) * grid.dt
            span = turns_at(grid, end) * grid.dt - s
            wait = release_wait_on_ramp(e, p, ramp, frame.sigma, frame.load, s, span)
            at, released = release_before(grid, state, wait / grid.dt, end)
            state = leave_support(
                e, p, grid, state, at, released, _turn(ramp, grid, at), log, samples
            )
            events += 1
        else:
            state, status = _fly(e, p, ramp, grid, state, end, log, samples, c)
            if status != OK:
                return state, status
            if is_spent(log):
                return state, MAX_STEPS
            events += state.mode != FLIGHT
        if events > max_events:
            return state, MAX_IMPACTS
    if strikes_at_end(e, p, grid, state):
        after = apply_impact(e, p, grid, state, state.w < 0.0, abs(state.w), state.theta, log)
        state = depart(e, p, grid, after, _turn(ramp, grid, after), end, log)
    return state, OK
