"""Contacts of a march: impact and grazing, the end of a chatter, sticking and release."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, evaluate, phase_at, steps_until, turns_at
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
from vibropipe.physics.housing import moved, struck
from vibropipe.physics.load import NEVER, force_at, force_rate


@jit
def support_at(home, at_near):
    """Return the support (1 or 2) at the near or far end of the frame of `home`."""
    if home == 0:
        return 2 if at_near else 1
    return home if at_near else 3 - home


@jit_inline
def apply_impact(e, p, grid, state, at_near, approach, theta, log):
    """Log an impact and return the state after it, eq. (6).

    at_near : whether the near support of the frame is struck
    approach : speed of approach, > 0
    theta : time of the impact in the step of the state
    """
    side = support_at(state.home, at_near)
    sign = 1.0 if side == 1 else -1.0
    w = reset(restitution_of(e, p, side), approach)
    position = turns_at(grid, Instant(state.period, state.step, theta))
    log_impact(log, position, side, sign * approach, -sign * (approach + w))
    housing = struck(p, state.housing, sign * approach, -sign * w)
    return State(state.period, state.step, theta, side, 0.0, w, LEAVES_BY_VELOCITY, 0.0, housing)


@jit_inline
def apply_contact(e, p, grid, state, kind, at_near, c, theta, log):
    """Log an impact or a grazing and return the state after it.

    theta : time from the state, in steps; kind : CROSSING or GRAZING; c : polynomial of the flight, origin at the
    state.
    """
    at = state.theta + theta
    _y, rate = evaluate(grid, c, theta)
    approach = -rate if at_near else rate
    if kind == GRAZING or approach <= 0.0:
        side = support_at(state.home, at_near)
        log_grazing(log, turns_at(grid, Instant(state.period, state.step, at)), side)
        return State(
            state.period, state.step, at, side, 0.0, 0.0, LEAVES_BY_VELOCITY, 0.0, state.housing
        )
    if state.mode != FLIGHT:
        log.counts[SHORT_FLIGHTS] += 1
    return apply_impact(e, p, grid, state, at_near, approach, at, log)


@jit_inline
def impact_at_start(e, p, grid, state, end, log):
    """Apply the impact of a motion that starts on a support with a velocity into it.

    Returns (state, impacts): the state unchanged and 0 in any other mode, else the state after it and 1.
    """
    if state.mode != IMPACTS_AT_START:
        return state, 0
    after = apply_impact(e, p, grid, state, True, -state.w, state.theta, log)
    return resolve_departure(e, p, grid, after, end, log), 1


@jit_inline
def resolve_departure(e, p, grid, state, end, log):
    """Return the state after a contact: in flight, or sticking after the remaining chatter.

    The chatter is summed as a geometric series. Its impacts are marched singly if the accumulation point lies beyond
    the end.
    """
    housing, phase = state.housing, phase_at(grid, state)
    mode, wait = departure_mode(e, p, grid, state.home, state.w, phase, housing)
    period, step, theta, home, w = state.period, state.step, state.theta, state.home, state.w
    if mode != REST:
        return State(period, step, theta, home, 0.0, w, mode, 0.0, housing)
    at = advance_time(grid, state, wait)
    if not is_before(at, end) and wait > 0.0:
        # The accumulation point lies beyond the end: the impacts up to the end are marched.
        return State(period, step, theta, home, 0.0, w, LEAVES_BY_VELOCITY, 0.0, housing)
    sign = -1.0 if home == 1 else 1.0
    if w > 0.0:
        restitution = restitution_of(e, p, home)
        tail_impulse = w * (1.0 + restitution) / (1.0 - restitution) if restitution < 1.0 else w
        middle = turns_at(grid, state) + 0.5 * wait
        log_impact(log, middle, -home, 0.0, sign * tail_impulse)
    start, span = turns_at(grid, at), wait * (grid.steps * grid.dt)
    settled = moved(p, housing, span, 0.0, 0.0)
    return State(at.period, at.step, at.theta, home, 0.0, 0.0, REST, start, settled)


@jit
def advance_rest(e, p, grid, state, end, log, samples):
    """Skip a rest: log it and return the state at its release, or the resting state at the end if that comes first.

    samples : `Samples` to write, or None.
    """
    wait = release_wait(e, p, state.home, phase_at(grid, state), state.housing)
    at, released = end, False
    if wait < NEVER:
        release = advance_time(grid, state, wait)
        released = is_before(release, end)
        if released:
            at = release
    waited = steps_until(grid, state, at)
    record(samples, log.counts, p, grid, state, None, 0.0, waited, 1)
    span = waited * grid.dt
    housing, home = moved(p, state.housing, span, 0.0, 0.0), state.home
    if not released:
        return State(at.period, at.step, at.theta, home, 0.0, 0.0, REST, state.rest_start, housing)
    log_rest(log, state.rest_start, turns_at(grid, at), state.home)
    jerk, second = 0.0, e.second_harmonic
    if e.forcing is not None:
        sigma = frame_at(e, p, state.home).sigma
        jerk = force_rate(p, force_at(p, sigma, phase_at(grid, at), second), second)
    return State(
        at.period, at.step, at.theta, home, 0.0, 0.0, release_mode(e, p, jerk), 0.0, housing
    )


@jit_inline
def impact_at_end(e, p, grid, state, end, log):
    """Return the state after the impact that falls on the end of a march within rounding; without one, the state."""
    if state.mode != FLIGHT:
        return state
    frame = frame_at(e, p, state.home)
    at_near = state.w < 0.0
    if not (frame.to_near if at_near else frame.to_far):
        return state
    distance = state.y - frame.near if at_near else frame.far - state.y
    # In steps: rounding of a phase, and of the absolute time.
    steps = state.period * grid.steps + state.step + state.theta
    tolerance = TIME_TOLERANCE * min(1.0, steps) + 2.0**-50 * steps
    if state.w == 0.0 or not distance <= tolerance * abs(state.w) * grid.dt:
        return state
    after = apply_impact(e, p, grid, state, at_near, abs(state.w), state.theta, log)
    return resolve_departure(e, p, grid, after, end, log)
