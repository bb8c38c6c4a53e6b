"""Flight: certified whole steps, and inside a step the polynomial of the method and its first contact."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import apply_contact, resolve_departure
from vibropipe.march.grid import evaluate, phase_at, stays_between
from vibropipe.march.log import POLYNOMIALS, SHORT_FLIGHTS, STEPS, record
from vibropipe.march.roots import CROSSING, NONE, STRIDE_LIMIT, first_root, hop_end, unique_root
from vibropipe.march.state import (
    FLIGHT,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_SNAP,
    LEAVES_BY_VELOCITY,
    State,
    departure_mode,
    restitution_of,
)
from vibropipe.physics.contact import frame_at
from vibropipe.physics.flow import combine
from vibropipe.physics.load import Force, force_at
from vibropipe.physics.newmark import quadratic, step
from vibropipe.words.status import Status

OK, ROOT_BOUND = int(Status.OK), int(Status.ROOT_BOUND)
# Secants free to go where they like, and all of them: from then on every other one is a bisection, of the
# exponent, so that the last leave a bracket of rounding.
FREE_SECANTS, MAX_SECANTS = 12, 150
# Newmark flights under R = 1 shorter than this share of a step are none of that method's: the mass waits for
# the next step.
SHORTEST_FLIGHT = 1e-4


@jit_inline
def fill_polynomial(e, p, grid, frame, state, limit, c):
    """Polynomial of the method's motion from the state to `limit` in its step, origin at the state."""
    sigma, load, force = frame.sigma, frame.load, Force(0.0, 0.0)
    if e.forcing is not None:
        force = force_at(p, sigma, phase_at(grid, state))
    s = force.sine
    if grid.exact is not None:
        combine(e, grid.basis, c, state.y, state.w, load, force)
    else:
        end = s
        if e.forcing is not None:
            end = force_at(p, sigma, (state.step + limit) / grid.steps).sine
        span = (limit - state.theta) * grid.dt
        if e.damping is not None:
            quadratic(c, state.y, state.w, s + load, end + load, p.h, span, grid.dt)
        else:
            quadratic(c, state.y, state.w, s + load, end + load, None, span, grid.dt)
    if e.rest is not None and grid.exact is not None and state.mode >= LEAVES_BY_ACCELERATION:
        # As `departure_mode` has it: to the last bit, or zero but for rounding.
        c[2] = 0.5 * grid.dt * grid.dt * (s + load) if state.mode == LEAVES_BY_ACCELERATION else 0.0
        c[3] = 0.0 if state.mode == LEAVES_BY_SNAP else c[3]


@jit_inline
def first_contact(grid, frame, state, c, y, span, counts):
    """(theta from the state, kind, on the near support) of the first contact within `span`; y: its end."""
    load, near, far = frame.load, frame.near, frame.far
    if state.mode == FLIGHT:
        if frame.to_near:
            theta = unique_root(grid, c, 1.0, -near, state.y - near, y - near, span, far - near)
            if theta >= 0.0:
                return theta, CROSSING, True
        if frame.to_far:
            theta = unique_root(grid, c, -1.0, far, far - state.y, far - y, span, far - near)
            if theta >= 0.0:
                return theta, CROSSING, False
    elif grid.exact is not None and state.mode == LEAVES_BY_VELOCITY:
        if frame.to_near:
            theta = hop_end(grid, c, far, y, span)
            if theta >= 0.0:
                return theta, CROSSING, True
        if frame.to_far:
            # A gap to the far support that falls all the way is a near one that only opens.
            theta = unique_root(grid, c, -1.0, far, far, far - y, span, math.inf)
            if theta >= 0.0:
                return theta, CROSSING, False
    power = 0
    if state.mode > FLIGHT:
        power = state.mode if grid.exact is not None else min(state.mode, 2)
    offset = -near if power == 0 else 0.0
    theta, kind = span, NONE
    if frame.to_near:
        theta, kind = first_root(c, power, 1.0, offset, load, span, counts)
    if not frame.to_far:
        return theta, kind, True
    # Both over the same span: the way to a root goes by it, and mirrored motions shall agree to the last bit.
    # numba compiles a literal zero to code of its own: the order of flight is the same number.
    other, other_kind = first_root(c, power - power, -1.0, far, load, span, counts)
    if other_kind != NONE and (kind == NONE or other < theta):
        return other, other_kind, False
    return theta, kind, True


@jit
def step_by(e, p, grid, frame, state, theta):
    """(y, w) by one Newmark step over `theta` of the grid's step."""
    load, start, end = frame.load, 0.0, 0.0
    if e.forcing is not None:
        turn = phase_at(grid, state)
        start = force_at(p, frame.sigma, turn).sine
        end = force_at(p, frame.sigma, turn + theta / grid.steps).sine
    if e.damping is None:
        return step(state.y, state.w, start + load, end + load, None, theta * grid.dt)
    return step(state.y, state.w, start + load, end + load, p.h, theta * grid.dt)


@jit
def step_to_contact(e, p, grid, frame, state, target, at_near, theta, remaining):
    """theta of the support by a Newmark step that ends on it, from the quadratic's theta; -1 if none does.

    The velocity of a quadratic over the whole step errs by the square of the step, differently at every
    impact; a step of the method down to the contact keeps that error smooth in the step. Secants, kept
    between a step that ends inside and one that ends outside; where the whole step ends inside (a graze,
    nearly) there may be no such contact. Where the force hardly acts yet the step is far longer than the
    quadratic's, and secants from both alike get nowhere.
    """
    # What rounding leaves of a distance made of these terms.
    least = 2.0**-51 * (abs(target) + abs(state.y) + abs(state.w) * theta * grid.dt)
    outside, y_outside = remaining, step_by(e, p, grid, frame, state, remaining)[0] - target
    side = -1.0 if at_near else 1.0
    if not y_outside * side > 0.0:
        return -1.0
    inside, theta_contact = 0.0, theta
    before, y_before = outside, y_outside
    for secant in range(MAX_SECANTS):
        y = step_by(e, p, grid, frame, state, theta_contact)[0] - target
        if abs(y) <= least:
            return theta_contact
        if y * side > 0.0:
            outside = theta_contact
        else:
            inside = theta_contact
        change = y * (theta_contact - before) / (y - y_before) if y != y_before else 0.0
        before, y_before = theta_contact, y
        theta_contact -= change
        if not inside < theta_contact < outside or (secant > FREE_SECANTS and secant % 2 == 1):
            theta_contact = math.sqrt(inside * outside) if inside > 0.0 else 0.5 * outside
        if abs(theta_contact - before) <= 2.0**-51 * theta_contact:
            return theta_contact
    return theta_contact


@jit
def refine_newmark_contact(e, p, grid, frame, state, limit, at_near, theta, c):
    """theta of a Newmark contact, with the polynomial made that of the step which ends there; where that step
    would arrive moving away, or pass the other support, both stay those of the quadratic."""
    target = frame.near if at_near else frame.far
    remaining = limit - state.theta
    theta_contact = step_to_contact(e, p, grid, frame, state, target, at_near, theta, remaining)
    if theta_contact < 0.0:
        return theta
    fill_polynomial(e, p, grid, frame, state, state.theta + theta_contact, c)
    _y, rate = evaluate(grid, c, theta_contact)
    theta_vertex = -0.5 * c[1] / c[2] if c[2] != 0.0 else 0.0
    extreme = evaluate(grid, c, min(max(theta_vertex, 0.0), theta_contact))[0]
    if (rate < 0.0 and extreme <= frame.far) if at_near else (rate > 0.0 and extreme >= frame.near):
        return theta_contact
    fill_polynomial(e, p, grid, frame, state, limit, c)
    return theta


@jit_inline
def fly(e, p, grid, state, end, log, samples, c):
    """(state, status) from a state in flight to its next contact, or to the end of its step."""
    frame = frame_at(e, p, state.home)
    last = state.period == end.period and state.step == end.step
    limit = end.theta if last else 1.0
    fill_polynomial(e, p, grid, frame, state, limit, c)
    log.counts[POLYNOMIALS] += 1
    at_step = state.period * grid.steps + state.step
    mode = state.mode
    held_on_support = False
    if e.rest is not None:
        held_on_support = (
            mode >= LEAVES_BY_ACCELERATION and not c[mode if grid.exact is not None else 2] > 0.0
        )
    kind, at_near, theta = NONE, True, limit - state.theta
    y, w = evaluate(grid, c, theta)
    if not held_on_support and not (
        mode <= LEAVES_BY_VELOCITY
        and stays_between(grid, frame, mode, state.y, state.w, y, w, theta)
    ):
        theta, kind, at_near = first_contact(grid, frame, state, c, y, theta, log.counts)
    if kind == STRIDE_LIMIT:
        return state, ROOT_BOUND
    if grid.exact is None and kind == CROSSING:
        theta = refine_newmark_contact(e, p, grid, frame, state, limit, at_near, theta, c)
    until = limit if kind == NONE else state.theta + theta
    record(
        samples,
        log.counts,
        p,
        grid,
        state.home,
        None if held_on_support else c,
        at_step,
        state.theta,
        until,
    )
    if kind != NONE:
        after = apply_contact(e, p, grid, state, kind, at_near, c, theta, log)
        hops = grid.exact is None and at_near and mode != FLIGHT and theta <= SHORTEST_FLIGHT
        if hops and restitution_of(e, p, after.home) >= 1.0:
            return State(
                state.period,
                state.step,
                after.theta,
                after.home,
                0.0,
                0.0,
                LEAVES_BY_ACCELERATION,
                0.0,
            ), OK
        return resolve_departure(e, p, grid, after, end, log), OK
    log.counts[STEPS] += 1
    period, step, at = state.period, state.step, limit
    if not last:
        step, at = (state.step + 1, 0.0)
        if step == grid.steps:
            period, step = period + 1, 0
    if held_on_support:
        # The method's own motion can not leave within this step: the mass stays until the next one.
        log.counts[SHORT_FLIGHTS] += 1
        turn = (step + at) / grid.steps
        mode, _wait = departure_mode(e, p, grid, state.home, 0.0, turn)
        return State(period, step, at, state.home, 0.0, 0.0, mode, period + turn), OK
    # An impact at the very end of a step leaves nothing of it to fly in: the mass departs in the next one.
    left = FLIGHT if theta > 0.0 else mode
    return State(period, step, at, state.home, y, w, left, 0.0), OK
