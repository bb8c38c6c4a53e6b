"""Contacts of a march: impact and graze, the end of a chatter, rest and release."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, evaluate, phase_at, turns_at
from vibropipe.march.log import SHORT_FLIGHTS, log_grazing, log_impact, log_rest, record
from vibropipe.march.roots import GRAZING
from vibropipe.march.state import (
    FLIGHT,
    IMPACTS_AT_START,
    LEAVES_BY_VELOCITY,
    REST,
    TIME_TOLERANCE,
    State,
    advance_time,
    departure_mode,
    is_before,
    release_mode,
    release_wait,
    restitution_of,
)
from vibropipe.physics.contact import frame_at, reset
from vibropipe.physics.load import NEVER, force_at


@jit
def support_at(home, at_near):
    """The support that stands near or far of a motion written from `home`."""
    if home == 0:
        return 2 if at_near else 1
    return home if at_near else 3 - home


@jit_inline
def apply_impact(e, p, grid, state, at_near, approach, theta, log):
    """State after an impact with speed `approach` at `theta` of the state's step, by eq. (6)."""
    side = support_at(state.home, at_near)
    sign = 1.0 if side == 1 else -1.0
    w = reset(restitution_of(e, p, side), approach)
    position = turns_at(grid, Instant(state.period, state.step, theta))
    log_impact(log, position, side, sign * approach, -sign * (approach + w))
    return State(state.period, state.step, theta, side, 0.0, w, LEAVES_BY_VELOCITY, 0.0)


@jit_inline
def apply_contact(e, p, grid, state, kind, at_near, c, theta, log):
    """State after an impact or a graze at `theta` past the state."""
    at = state.theta + theta
    _y, rate = evaluate(grid, c, theta)
    approach = -rate if at_near else rate
    if kind == GRAZING or approach <= 0.0:
        side = support_at(state.home, at_near)
        log_grazing(log, turns_at(grid, Instant(state.period, state.step, at)), side)
        return State(state.period, state.step, at, side, 0.0, 0.0, LEAVES_BY_VELOCITY, 0.0)
    if state.mode != FLIGHT:
        log.counts[SHORT_FLIGHTS] += 1
    return apply_impact(e, p, grid, state, at_near, approach, at, log)


@jit_inline
def impact_at_start(e, p, grid, state, end, log):
    """(state, impacts made) after the impact of a motion that starts on a support moving in, if it does."""
    if state.mode != IMPACTS_AT_START:
        return state, 0
    after = apply_impact(e, p, grid, state, True, -state.w, state.theta, log)
    return resolve_departure(e, p, grid, after, end, log), 1


@jit_inline
def resolve_departure(e, p, grid, state, end, log):
    """Decide how a mass that has just met its support goes on: fly, or complete its chatter and rest."""
    mode, wait = departure_mode(e, p, grid, state.home, state.w, phase_at(grid, state))
    if mode != REST:
        return State(state.period, state.step, state.theta, state.home, 0.0, state.w, mode, 0.0)
    at = advance_time(grid, state, wait)
    if not is_before(at, end) and wait > 0.0:
        # The accumulation lies beyond the end: the impacts up to the end are marched.
        return State(
            state.period, state.step, state.theta, state.home, 0.0, state.w, LEAVES_BY_VELOCITY, 0.0
        )
    if state.w > 0.0:
        restitution = restitution_of(e, p, state.home)
        tail_impulse = (
            state.w * (1.0 + restitution) / (1.0 - restitution) if restitution < 1.0 else state.w
        )
        sign = -1.0 if state.home == 1 else 1.0
        middle = turns_at(grid, state) + 0.5 * wait
        log_impact(log, middle, -state.home, 0.0, sign * tail_impulse)
    start = turns_at(grid, at)
    return State(at.period, at.step, at.theta, state.home, 0.0, 0.0, REST, start)


@jit
def advance_rest(e, p, grid, state, end, log, samples):
    """Jump from a rest to its release, or to the end if that comes first."""
    wait = release_wait(e, p, state.home, phase_at(grid, state))
    at, released = end, False
    if wait < NEVER:
        release = advance_time(grid, state, wait)
        released = is_before(release, end)
        if released:
            at = release
    at_step = at.period * grid.steps + at.step
    record(samples, log.counts, p, grid, state.home, None, at_step, 0.0, at.theta)
    if not released:
        return State(at.period, at.step, at.theta, state.home, 0.0, 0.0, REST, state.rest_start)
    log_rest(log, state.rest_start, turns_at(grid, at), state.home)
    rate = 0.0
    if e.forcing is not None:
        rate = force_at(p, frame_at(e, p, state.home).sigma, phase_at(grid, at)).cosine
    return State(at.period, at.step, at.theta, state.home, 0.0, 0.0, release_mode(rate), 0.0)


@jit_inline
def impact_at_end(e, p, grid, state, end, log):
    """The state after the impact that falls on the end of a march, if one does; else the state."""
    if state.mode != FLIGHT:
        return state
    frame = frame_at(e, p, state.home)
    at_near = state.w < 0.0
    if not (frame.to_near if at_near else frame.to_far):
        return state
    distance = state.y - frame.near if at_near else frame.far - state.y
    # Rounding of a time counted in steps, beside that of a phase.
    steps = state.period * grid.steps + state.step + state.theta
    instant = TIME_TOLERANCE * min(1.0, steps) + 2.0**-50 * steps
    if not (distance <= instant * abs(state.w) * grid.dt and state.w != 0.0):
        return state
    after = apply_impact(e, p, grid, state, at_near, abs(state.w), state.theta, log)
    return resolve_departure(e, p, grid, after, end, log)
