"""Contacts of a march: impact and graze, the end of a chatter, rest and release."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import evaluate
from vibropipe.march.log import SHORT_FLIGHTS, log_grazing, log_impact, log_rest, record
from vibropipe.march.roots import GRAZING
from vibropipe.march.state import (
    FLIGHT,
    REST,
    SAME_INSTANT,
    STRIKES,
    WITH_SPEED,
    State,
    departure,
    is_before,
    looked_at,
    place,
    release_order,
    release_wait,
    restitution_of,
)
from vibropipe.physics.contact import frame, reset
from vibropipe.physics.load import NEVER, force_at


@jit
def side_of(home, at_near):
    """The support that stands near or far of a motion written from `home`."""
    if home == 0:
        return 2 if at_near else 1
    return home if at_near else 3 - home


@jit_inline
def impact(e, p, grid, state, at_near, approach, theta, log):
    """State after an impact with speed `approach` at `theta` of the state's step, by eq. (6)."""
    side = side_of(state.home, at_near)
    sign = 1.0 if side == 1 else -1.0
    w = reset(restitution_of(e, p, side), approach)
    position = state.period + (state.step + theta) / grid.steps
    log_impact(log, position, side, sign * approach, -sign * (approach + w))
    return State(state.period, state.step, theta, side, 0.0, w, WITH_SPEED, 0.0)


@jit_inline
def contact(e, p, grid, state, kind, at_near, c, theta, log):
    """State after an impact or a graze at `theta` past the state."""
    at = state.theta + theta
    _y, rate = evaluate(grid, c, theta)
    approach = -rate if at_near else rate
    if kind == GRAZING or approach <= 0.0:
        side = side_of(state.home, at_near)
        log_grazing(log, state.period + (state.step + at) / grid.steps, side)
        return State(state.period, state.step, at, side, 0.0, 0.0, WITH_SPEED, 0.0)
    if state.order != FLIGHT:
        log.counts[SHORT_FLIGHTS] += 1
    return impact(e, p, grid, state, at_near, approach, at, log)


@jit_inline
def strike_first(e, p, grid, state, end_period, end_step, end_theta, log):
    """(state, impacts made) after the impact of a motion that starts on a support moving in, if it does."""
    if state.order != STRIKES:
        return state, 0
    after = impact(e, p, grid, state, True, -state.w, state.theta, log)
    return settle(e, p, grid, after, end_period, end_step, end_theta, log), 1


@jit_inline
def settle(e, p, grid, state, end_period, end_step, end_theta, log):
    """Decide how a mass that has just met its support goes on: fly, or complete its chatter and rest."""
    turn = (state.step + state.theta) / grid.steps
    order, wait = departure(e, p, grid, state.home, state.w, turn)
    if order != REST:
        return State(state.period, state.step, state.theta, state.home, 0.0, state.w, order, 0.0)
    period, step, theta = place(grid, state.period, state.step, state.theta, wait)
    if not is_before(period, step, theta, end_period, end_step, end_theta) and wait > 0.0:
        # The accumulation lies beyond the end: the impacts up to the end are marched.
        return State(
            state.period, state.step, state.theta, state.home, 0.0, state.w, WITH_SPEED, 0.0
        )
    start = period + (step + theta) / grid.steps
    if state.w > 0.0:
        restitution = restitution_of(e, p, state.home)
        tail = state.w * (1.0 + restitution) / (1.0 - restitution) if restitution < 1.0 else state.w
        sign = -1.0 if state.home == 1 else 1.0
        middle = state.period + (state.step + state.theta) / grid.steps + 0.5 * wait
        log_impact(log, middle, -state.home, 0.0, sign * tail)
    return State(period, step, theta, state.home, 0.0, 0.0, REST, start)


@jit
def rest(e, p, grid, state, end_period, end_step, end_theta, log, samples):
    """Jump from a rest to its release, or to the end if that comes first."""
    wait = release_wait(e, p, state.home, (state.step + state.theta) / grid.steps)
    period, step, theta = end_period, end_step, end_theta
    released = False
    if wait < NEVER:
        at_period, at_step, at_theta = place(grid, state.period, state.step, state.theta, wait)
        released = is_before(at_period, at_step, at_theta, end_period, end_step, end_theta)
        if released:
            period, step, theta = at_period, at_step, at_theta
    record(samples, log.counts, p, grid, state.home, None, period * grid.steps + step, 0.0, theta)
    if not released:
        return State(period, step, theta, state.home, 0.0, 0.0, REST, state.rest_start)
    log_rest(log, state.rest_start, period + (step + theta) / grid.steps, state.home)
    rate = 0.0
    if e.forcing is not None:
        sigma, _load, _near, _far = frame(p, state.home)
        rate = force_at(p, sigma, (step + theta) / grid.steps).cosine
    return State(period, step, theta, state.home, 0.0, 0.0, release_order(rate), 0.0)


@jit_inline
def meet_at_end(e, p, grid, state, end_period, end_step, end_theta, log):
    """The state after the impact that falls on the end of a march, if one does; else the state."""
    if state.order != FLIGHT:
        return state
    _sigma, _load, near, far = frame(p, state.home)
    at_near = state.w < 0.0
    to_near, to_far = looked_at(e, state.home)
    if not (to_near if at_near else to_far):
        return state
    room = state.y - near if at_near else far - state.y
    # Rounding of a time counted in steps, beside that of a phase.
    steps = state.period * grid.steps + state.step + state.theta
    instant = SAME_INSTANT * min(1.0, steps) + 2.0**-50 * steps
    if not (room <= instant * abs(state.w) * grid.dt and state.w != 0.0):
        return state
    after = impact(e, p, grid, state, at_near, abs(state.w), state.theta, log)
    return settle(e, p, grid, after, end_period, end_step, end_theta, log)
