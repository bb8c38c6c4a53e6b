"""Flight within a step: the polynomial of the method, its certificate and its first contact."""

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
from vibropipe.physics.load import force_at, force_value, no_force
from vibropipe.physics.newmark import quadratic, step
from vibropipe.words.status import Status

OK, ROOT_BOUND = int(Status.OK), int(Status.ROOT_BOUND)
# Iterations of the secant method before every other one becomes a bisection of the exponent, and all iterations, which
# then suffice for a bracket of rounding.
FREE_SECANTS, MAX_SECANTS = 12, 150
# Shortest flight of Newmark's method where R = 1, in steps: after a shorter one the mass is held until the next step,
# since the method cannot resolve it.
SHORTEST_FLIGHT = 1e-4


@jit_inline
def fill_polynomial(e, p, grid, frame, state, limit, c):
    """Fill c with the polynomial of the method's motion from the state to `limit` in its step, origin at the state.

    limit : in steps; c : (DEGREE + 1,) of the exact method, (3,) of Newmark's.
    """
    sigma, load, force = frame.sigma, frame.load, no_force()
    if e.forcing is not None:
        force = force_at(p, sigma, phase_at(grid, state), e.second_harmonic)
    s = force_value(force, e.second_harmonic)
    if grid.exact is not None:
        combine(e, grid.basis, c, state.y, state.w, load, force)
    else:
        end = s
        if e.forcing is not None:
            turn = (state.step + limit) / grid.steps
            end = force_value(force_at(p, sigma, turn, e.second_harmonic), e.second_harmonic)
        span = (limit - state.theta) * grid.dt
        if e.damping is not None:
            quadratic(c, state.y, state.w, s + load, end + load, p.h, span, grid.dt)
        else:
            quadratic(c, state.y, state.w, s + load, end + load, None, span, grid.dt)
    if e.rest is not None and grid.exact is not None and state.mode >= LEAVES_BY_ACCELERATION:
        # The derivatives that the mode declares zero are set to zero, without rounding.
        c[2] = 0.5 * grid.dt * grid.dt * (s + load) if state.mode == LEAVES_BY_ACCELERATION else 0.0
        c[3] = 0.0 if state.mode == LEAVES_BY_SNAP else c[3]


@jit_inline
def first_contact(grid, frame, state, c, y, span, counts):
    """Locate the first contact of a flight within `span`.

    Returns (theta, kind, at_near): theta from the state, in steps; kind of `roots.first_root`; whether the near support
    is met. y is the displacement at the end of `span`.
    """
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
            # Where the gap to the far support falls throughout, the near one only opens.
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
    # Both searches take the same span: strides depend on it, and mirrored motions must agree bit for bit. The power
    # is a zero that numba does not see as a literal, for which it would compile the search a second time.
    other, other_kind = first_root(c, power - power, -1.0, far, load, span, counts)
    if other_kind != NONE and (kind == NONE or other < theta):
        return other, other_kind, False
    return theta, kind, True


@jit
def step_by(e, p, grid, frame, state, theta):
    """Return (y, w) after one Newmark step of length theta, in steps of the grid."""
    load, start, end = frame.load, 0.0, 0.0
    if e.forcing is not None:
        turn = phase_at(grid, state)
        later, second = turn + theta / grid.steps, e.second_harmonic
        start = force_value(force_at(p, frame.sigma, turn, second), second)
        end = force_value(force_at(p, frame.sigma, later, second), second)
    if e.damping is None:
        return step(state.y, state.w, start + load, end + load, None, theta * grid.dt)
    return step(state.y, state.w, start + load, end + load, p.h, theta * grid.dt)


@jit
def step_to_contact(e, p, grid, frame, state, target, at_near, theta, remaining):
    """Return the length of the Newmark step that ends on a support; -1 if the full step ends short of it.

    The velocity of the quadratic over the whole step has an error of the order of the step squared, different at every
    impact; a step of the method that ends at the contact keeps the error smooth in the step size. The root is found by
    secants within a bracket of one step that ends inside and one that ends outside. Where the whole step ends inside
    (nearly a grazing) there may be no such contact. Where the force is still small the step is much longer than the
    root of the quadratic, and secants from two similar steps do not converge: every other one is then a bisection.

    target : y of the support; theta : root of the quadratic; remaining : largest length; all lengths in steps.
    """
    # Rounding of a distance computed from these terms.
    tolerance = 2.0**-51 * (abs(target) + abs(state.y) + abs(state.w) * theta * grid.dt)
    outside, y_outside = remaining, step_by(e, p, grid, frame, state, remaining)[0] - target
    outward = -1.0 if at_near else 1.0
    if not y_outside * outward > 0.0:
        return -1.0
    inside, theta_contact = 0.0, theta
    previous, y_previous = outside, y_outside
    for secant in range(MAX_SECANTS):
        y = step_by(e, p, grid, frame, state, theta_contact)[0] - target
        if abs(y) <= tolerance:
            return theta_contact
        if y * outward > 0.0:
            outside = theta_contact
        else:
            inside = theta_contact
        change = y * (theta_contact - previous) / (y - y_previous) if y != y_previous else 0.0
        previous, y_previous = theta_contact, y
        theta_contact -= change
        if not inside < theta_contact < outside or (secant > FREE_SECANTS and secant % 2 == 1):
            theta_contact = math.sqrt(inside * outside) if inside > 0.0 else 0.5 * outside
        if abs(theta_contact - previous) <= 2.0**-51 * theta_contact:
            return theta_contact
    return theta_contact


@jit
def refine_newmark_contact(e, p, grid, frame, state, limit, at_near, theta, c):
    """Return theta of a Newmark contact and fill c with the step that ends there.

    Both stay those of the quadratic, theta unchanged, where that step would arrive moving away or pass the other
    support.
    """
    target = frame.near if at_near else frame.far
    remaining = limit - state.theta
    theta_contact = step_to_contact(e, p, grid, frame, state, target, at_near, theta, remaining)
    if theta_contact < 0.0:
        return theta
    fill_polynomial(e, p, grid, frame, state, state.theta + theta_contact, c)
    _y, rate = evaluate(grid, c, theta_contact)
    theta_vertex = -0.5 * c[1] / c[2] if c[2] != 0.0 else 0.0
    y_vertex = evaluate(grid, c, min(max(theta_vertex, 0.0), theta_contact))[0]
    if (
        (rate < 0.0 and y_vertex <= frame.far)
        if at_near
        else (rate > 0.0 and y_vertex >= frame.near)
    ):
        return theta_contact
    fill_polynomial(e, p, grid, frame, state, limit, c)
    return theta


@jit_inline
def fly(e, p, grid, state, end, log, samples, c):
    """March from a state in flight to its next contact, or to the end of its step.

    state : in any mode but REST and IMPACTS_AT_START
    end : Instant
    log, samples : Log, Samples or None
    c : (DEGREE + 1,) or (3,), work array

    Returns the state, and OK, or ROOT_BOUND where the search for a contact reached its limit; the state is then the one
    passed in.
    """
    frame = frame_at(e, p, state.home)
    last = state.period == end.period and state.step == end.step
    limit = end.theta if last else 1.0
    fill_polynomial(e, p, grid, frame, state, limit, c)
    log.counts[POLYNOMIALS] += 1
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
    motion = None if held_on_support else c
    record(samples, log.counts, p, grid, state, motion, 0.0, theta, 1)
    if kind != NONE:
        after = apply_contact(e, p, grid, state, kind, at_near, c, theta, log)
        is_hop = grid.exact is None and at_near and mode != FLIGHT and theta <= SHORTEST_FLIGHT
        if is_hop and restitution_of(e, p, after.home) >= 1.0:
            return State(
                state.period,
                state.step,
                after.theta,
                after.home,
                0.0,
                0.0,
                LEAVES_BY_ACCELERATION,
                0.0,
                None,
            ), OK
        return resolve_departure(e, p, grid, after, end, log), OK
    log.counts[STEPS] += 1
    period, step, at = state.period, state.step, limit
    if not last:
        step, at = (state.step + 1, 0.0)
        if step == grid.steps:
            period, step = period + 1, 0
    if held_on_support:
        # The method's motion does not leave within this step: the mass is held until the next one.
        log.counts[SHORT_FLIGHTS] += 1
        turn = (step + at) / grid.steps
        mode, _wait = departure_mode(e, p, grid, state.home, 0.0, turn)
        return State(period, step, at, state.home, 0.0, 0.0, mode, period + turn, None), OK
    # After an impact at the end of a step no time is left in it: the mass departs in the next one.
    next_mode = FLIGHT if theta > 0.0 else mode
    return State(period, step, at, state.home, y, w, next_mode, 0.0, None), OK
