"""The one marching loop: steps of a grid, contacts found inside them, rests jumped over, for both methods."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.jit import jit
from vibropipe.kernels.grid import evaluate, locate, stays_between
from vibropipe.kernels.record import (
    POLYNOMIALS,
    SHORT_FLIGHTS,
    STEPS,
    is_full,
    log_grazing,
    log_impact,
    log_rest,
    record,
)
from vibropipe.kernels.roots import BOUND, CROSSING, GRAZING, NONE, first_root, monotone_root
from vibropipe.physics.contact import (
    NEVER,
    chatter_duration,
    force_at,
    frame,
    release_turn,
    reset,
)
from vibropipe.physics.flow import combine
from vibropipe.physics.newmark import quadratic, step
from vibropipe.status import Status

OK, MAX_IMPACTS = int(Status.OK), int(Status.MAX_IMPACTS)
ROOT_BOUND, NOT_FINITE, LOG_FULL = (
    int(Status.ROOT_BOUND),
    int(Status.NOT_FINITE),
    int(Status.LOG_FULL),
)
# How a motion leaves the support it stands on: in flight, with speed, with acceleration, with its rate; or not.
FLIGHT, WITH_SPEED, WITH_PULL, WITH_RATE, REST = 0, 1, 2, 3, 9
# Rounding of a phase in turns: a contact this soon after the release belongs to it.
SAME_INSTANT = 1e-13
# Hops that lose no speed at the support, only by damping, end in algebraic time: once they are no higher than
# the rounding of x (this share of l, twice), the mass rests.
LOWEST_HOP = 2.0**-52
# Newmark flights under R = 1 shorter than this share of a step are none of that method's: the mass waits for
# the next step.
SHORTEST_FLIGHT = 1e-4


class State(NamedTuple):
    """Where a motion is: time as period, step, theta; place as distance y from `home` and its rate w.

    order: how it departs (FLIGHT ... REST); rest_start: in forcing periods, while it rests.
    """

    period: int
    step: int
    theta: float
    home: int
    y: float
    w: float
    order: int
    rest_start: float


@jit
def release_wait(e, p, home, turn):
    """Turns from `turn` until a mass resting on `home` is released; 0 at once, NEVER."""
    sigma, load, _near, _far = frame(p, home)
    f = sigma * p.f if e.forcing is not None else 0.0
    release = release_turn(f, load)
    if release < 0.0:
        return 0.0
    if release == NEVER:
        return NEVER
    wait = release - turn
    wait -= math.floor(wait)
    return 0.0 if wait > 1.0 - SAME_INSTANT else wait


@jit
def departure(e, p, grid, home, w, turn):
    """(order, wait) of a mass on `home` with speed of departure w: how it leaves, or REST after `wait` turns
    (the rest of a chatter, completed; 0 when it is at rest already)."""
    sigma, load, _near, _far = frame(p, home)
    s, c = 0.0, 0.0
    if e.forcing is not None:
        s, c = force_at(p, sigma, turn)
    push = s + load - p.h * w
    if w > 0.0:
        if push < 0.0:
            restitution = p.R1 if home == 1 else p.R2
            rate = p.nu * c - p.h * push - w
            wait = chatter_duration(w, push, rate, restitution, p.h, p.nu)
            if wait < NEVER:
                return REST, wait / (grid.steps * grid.dt)
            if restitution >= 1.0 and p.h > 0.0 and w * w <= LOWEST_HOP * p.l * -push:
                return REST, 0.0
        return WITH_SPEED, 0.0
    if push > 0.0:
        return WITH_PULL, 0.0
    return (WITH_RATE if release_wait(e, p, home, turn) == 0.0 else REST), 0.0


@jit
def begin(e, p, grid, turns, x, v):
    """State of a motion that starts at `turns` forcing periods from (x, v); on a support with its home there."""
    period, step, theta = locate(turns, grid.steps)
    upper, lower = p.l + p.delta, p.delta - p.l
    if x < upper and x > lower:
        return State(period, step, theta, 0, x, v, FLIGHT, 0.0)
    home = 1 if x >= upper else 2
    w = -v if home == 1 else v
    if w < 0.0:
        # Moving in: the support is met at once, and the march books the impact.
        return State(period, step, theta, 0, x, v, FLIGHT, 0.0)
    order, _wait = departure(e, p, grid, home, w, (step + theta) / grid.steps)
    return State(period, step, theta, home, 0.0, w, order, turns)


@jit
def coast(e, p, grid, state, end_period, end_step, counts):
    """Whole steps in flight while it is certified that neither support is reached in them."""
    sigma, load, near, far = frame(p, state.home)
    period, step, y, w = state.period, state.step, state.y, state.w
    load1, load2 = grid.b1 * load, grid.b2 * load
    made = 0
    while period < end_period or step < end_step:
        y1 = grid.a11 * y + grid.a12 * w + load1
        w1 = grid.a21 * y + grid.a22 * w + load2
        if e.forcing is not None:
            y1 += sigma * grid.table_p[step]
            w1 += sigma * grid.table_q[step]
        if not stays_between(grid, 0, y, w, y1, w1, 1.0, load, near, far):
            break
        y, w = y1, w1
        made += 1
        step += 1
        if step == grid.steps:
            step = 0
            period += 1
    counts[STEPS] += made
    return State(period, step, 0.0, state.home, y, w, FLIGHT, 0.0)


@jit
def fill(e, p, grid, state, sigma, load, limit, c):
    """Polynomial of the method's motion from the state to `limit` in its step, origin at the state."""
    s, s_rate = 0.0, 0.0
    if e.forcing is not None:
        s, s_rate = force_at(p, sigma, (state.step + state.theta) / grid.steps)
    if grid.exact is not None:
        combine(grid.basis, c, state.y, state.w, load, s, s_rate)
    else:
        end = s
        if e.forcing is not None:
            end, _rate = force_at(p, sigma, (state.step + limit) / grid.steps)
        span = (limit - state.theta) * grid.dt
        quadratic(c, state.y, state.w, s + load, end + load, p.h, span, grid.dt)
    if state.order == WITH_RATE:
        c[2] = 0.0 if grid.exact is not None else c[2]


@jit
def first_contact(grid, state, load, near, far, c, y, span, counts):
    """(theta from the state, kind, on the near support) of the first contact within `span`; y: its end."""
    if state.order == FLIGHT:
        theta = monotone_root(grid, c, 1.0, -near, state.y - near, y - near, span)
        if theta >= 0.0:
            return theta, CROSSING, True
        theta = monotone_root(grid, c, -1.0, far, far - state.y, far - y, span)
        if theta >= 0.0:
            return theta, CROSSING, False
    p = 0
    if state.order > FLIGHT:
        p = state.order if grid.exact is not None else min(state.order, 2)
    offset = -near if p == 0 else 0.0
    theta, kind = first_root(c, p, 1.0, offset, load, span, counts)
    reach = theta if kind != NONE else span
    # numba compiles a literal zero to code of its own: the order of flight is the same number.
    other, other_kind = first_root(c, p - p, -1.0, far, load, reach, counts)
    if other_kind != NONE and (kind == NONE or other < theta):
        return other, other_kind, False
    return theta, kind, True


@jit
def step_by(e, p, grid, state, sigma, load, theta):
    """(y, w) by one Newmark step over `theta` of the grid's step."""
    start, end = 0.0, 0.0
    if e.forcing is not None:
        turn = (state.step + state.theta) / grid.steps
        start, _rate = force_at(p, sigma, turn)
        end, _rate = force_at(p, sigma, turn + theta / grid.steps)
    return step(state.y, state.w, start + load, end + load, p.h, theta * grid.dt)


@jit
def step_to_contact(e, p, grid, state, sigma, load, target, theta, room):
    """(theta, rate) at the support by a Newmark step that ends on it, from the quadratic's theta.

    Linear interpolation of the velocity errs by the square of the step, differently at every impact; a
    step of the method down to the contact keeps that error smooth in the step. The quadratic's own contact
    stays where the search leaves the step (a graze, nearly).
    """
    found, rate = theta, 0.0
    for _ in range(8):
        y, rate = step_by(e, p, grid, state, sigma, load, found)
        if rate == 0.0 or not 0.0 < found <= room:
            return theta, 0.0
        change = (target - y) / (rate * grid.dt)
        found += change
        if abs(change) <= 2.0**-51 * found:
            break
    return (found, rate) if 0.0 < found <= room else (theta, 0.0)


@jit
def contact(e, p, grid, state, kind, at_near, c, theta, room, log):
    """State after an impact or a graze at `theta` past the state; `room` is left in the step."""
    home = state.home
    side = (2 if at_near else 1) if home == 0 else home if at_near else 3 - home
    sigma, load, near, far = frame(p, home)
    _y, rate = evaluate(grid, c, theta)
    if grid.exact is None and kind != GRAZING:
        target = near if at_near else far
        refined, at_rate = step_to_contact(e, p, grid, state, sigma, load, target, theta, room)
        # A step's end that moves away from the support is not a contact.
        if (at_rate < 0.0) if at_near else (at_rate > 0.0):
            theta, rate = refined, at_rate
    at = state.theta + theta
    position = state.period + (state.step + at) / grid.steps
    sign = 1.0 if side == 1 else -1.0
    if kind == GRAZING:
        log_grazing(log, position, side)
        return State(state.period, state.step, at, side, 0.0, 0.0, WITH_PULL, 0.0)
    approach = max(0.0, -rate if at_near else rate)
    w = reset(p.R1 if side == 1 else p.R2, approach)
    log_impact(log, position, side, sign * approach, -sign * (approach + w))
    if state.order != FLIGHT:
        log.counts[SHORT_FLIGHTS] += 1
    return State(state.period, state.step, at, side, 0.0, w, WITH_SPEED, 0.0)


@jit
def place(grid, period, step, theta, wait):
    """(period, step, theta) a time of `wait` turns later."""
    later = theta + wait * grid.steps
    whole = math.floor(later)
    later -= whole
    if later > 1.0 - SAME_INSTANT:
        # A departure within rounding of the next step's start is its start: the sliver between them would
        # leave the mass at a distance below rounding.
        whole, later = whole + 1.0, 0.0
    step += int(whole)
    return period + step // grid.steps, step % grid.steps, later


@jit
def is_before(period, step, theta, end_period, end_step, end_theta) -> bool:
    """Whether a time lies strictly before the end."""
    if period != end_period:
        return period < end_period
    if step != end_step:
        return step < end_step
    return theta < end_theta


@jit
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
        restitution = p.R1 if state.home == 1 else p.R2
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
    return State(period, step, theta, state.home, 0.0, 0.0, WITH_RATE, 0.0)


@jit
def fly(e, p, grid, state, end_period, end_step, end_theta, log, samples, c):
    """(state, status) from a state in flight to its next contact, or to the end of its step."""
    sigma, load, near, far = frame(p, state.home)
    last = state.period == end_period and state.step == end_step
    limit = end_theta if last else 1.0
    fill(e, p, grid, state, sigma, load, limit, c)
    log.counts[POLYNOMIALS] += 1
    at_step = state.period * grid.steps + state.step
    order = state.order
    stuck = order >= WITH_PULL and not c[order if grid.exact is not None else 2] > 0.0
    kind, at_near, theta = NONE, True, limit - state.theta
    y, w = evaluate(grid, c, theta)
    if not stuck and not (
        order <= WITH_SPEED
        and stays_between(grid, order, state.y, state.w, y, w, theta, load, near, far)
    ):
        theta, kind, at_near = first_contact(grid, state, load, near, far, c, y, theta, log.counts)
    if kind == BOUND:
        return state, ROOT_BOUND
    until = limit if kind == NONE else state.theta + theta
    record(
        samples, log.counts, p, grid, state.home, None if stuck else c, at_step, state.theta, until
    )
    if kind != NONE:
        after = contact(e, p, grid, state, kind, at_near, c, theta, limit - state.theta, log)
        if kind == GRAZING:
            return after, OK
        if grid.exact is None and at_near and order != FLIGHT and theta <= SHORTEST_FLIGHT:
            if (p.R1 if after.home == 1 else p.R2) >= 1.0:
                at = after.theta
                return State(state.period, state.step, at, after.home, 0.0, 0.0, WITH_PULL, 0.0), OK
        return settle(e, p, grid, after, end_period, end_step, end_theta, log), OK
    log.counts[STEPS] += 1
    period, step, at = state.period, state.step, limit
    if not last:
        step, at = (state.step + 1, 0.0)
        if step == grid.steps:
            period, step = period + 1, 0
    if stuck:
        # The method's own motion can not leave within this step: the mass stays until the next one.
        log.counts[SHORT_FLIGHTS] += 1
        turn = (step + at) / grid.steps
        order, _wait = departure(e, p, grid, state.home, 0.0, turn)
        return State(period, step, at, state.home, 0.0, 0.0, order, period + turn), OK
    return State(period, step, at, state.home, y, w, FLIGHT, 0.0), OK


@jit
def march(e, p, grid, state, end_period, end_step, end_theta, log, samples, c, max_events):
    """March from `state` to the end; returns (state, Status).

    log: contacts are appended; LOG_FULL with the state reached when it has no room and `stop` rules say so;
    samples: Samples or None (then no code for them exists); c: work array of ORDER + 1.
    At most max_events contacts and releases are made, then MAX_IMPACTS is returned.
    """
    events = 0
    while is_before(state.period, state.step, state.theta, end_period, end_step, end_theta):
        if not (abs(state.y) < math.inf and abs(state.w) < math.inf):
            return state, NOT_FINITE
        if is_full(log):
            return state, LOG_FULL
        if state.order == REST:
            state = rest(e, p, grid, state, end_period, end_step, end_theta, log, samples)
            events += 1
        else:
            if state.order == FLIGHT and state.theta == 0.0 and samples is None:
                state = coast(e, p, grid, state, end_period, end_step, log.counts)
                if not is_before(
                    state.period, state.step, state.theta, end_period, end_step, end_theta
                ):
                    break
            state, status = fly(e, p, grid, state, end_period, end_step, end_theta, log, samples, c)
            if status != OK:
                return state, status
            events += state.order != FLIGHT
        if events > max_events:
            return state, MAX_IMPACTS
    return state, OK
