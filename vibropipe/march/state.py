"""Where a motion is, and how a mass on a support goes on: fly, rest, be released."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, locate, phase_at
from vibropipe.physics.contact import chatter_duration, frame_at, support_position
from vibropipe.physics.load import (
    NEVER,
    Force,
    force_at,
    force_rate,
    largest_force,
    release_turn,
)

# How a motion leaves the support it stands on: in flight, with speed, with acceleration, with its rate, with the
# rate's rate; or not, and one that starts on a support moving in strikes it first. Up to WITH_CURVATURE the number
# is the power of time with which the distance begins to grow.
FLIGHT, WITH_SPEED, WITH_PULL, WITH_RATE, WITH_CURVATURE, STRIKES, REST = 0, 1, 2, 3, 4, 8, 9
# Rounding of a phase in turns: a contact this soon after the release belongs to it.
SAME_INSTANT = 1e-13
# Hops that lose no speed at the support, only by damping, end in algebraic time: once they are no higher than
# the rounding of x (this share of l, twice), the mass rests.
LOWEST_HOP = 2.0**-52
# Rounding of a push, as a share of the largest there can be.
PUSH_NOISE = 2.0**-51
# Departures faster than this share of the largest push there can be are part of no complete chatter: by the
# velocity alone, 4 (w/push)^3, the push changes by more than `chatter_duration` allows. Nearly all are.
FASTEST_CHATTER = 2e-5


class State(NamedTuple):
    """Where a motion is: time as period, step, theta; place as distance y from `home` and its rate w.

    order: how it departs (FLIGHT ... REST; w < 0 where it STRIKES); rest_start: in forcing periods, while it rests.
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
def is_before(at, end) -> bool:
    """Whether an `Instant` or a state lies strictly before an `Instant`."""
    if at.period != end.period:
        return at.period < end.period
    if at.step != end.step:
        return at.step < end.step
    return at.theta < end.theta


@jit
def place(grid, at, wait):
    """The `Instant` a time of `wait` turns after an `Instant` or a state."""
    later = at.theta + wait * grid.steps
    whole = math.floor(later)
    later -= whole
    if later > 1.0 - SAME_INSTANT:
        # A departure within rounding of the next step's start is its start: the sliver between them would
        # leave the mass at a distance below rounding.
        whole, later = whole + 1.0, 0.0
    step = at.step + int(whole)
    return Instant(at.period + step // grid.steps, step % grid.steps, later)


@jit
def restitution_of(e, p, home):
    """Restitution of the support `home`; 1 where no support reached has less."""
    restitution = 1.0
    if e.restitution is not None:
        restitution = p.R1 if home == 1 else p.R2
    return restitution


@jit
def is_watched(home, watched) -> bool:
    """Whether `home` is one of the supports left out (1, 2 or 3 for both; None for none of them)."""
    if watched is None:
        return False
    return home & watched != 0


@jit
def release_wait(e, p, home, turn):
    """Turns from `turn` until a mass resting on `home` is released; 0 at once, NEVER."""
    frame = frame_at(e, p, home)
    if e.forcing is None:
        return 0.0 if frame.load > 0.0 else NEVER
    release = release_turn(p, frame.sigma, frame.load)
    if release < 0.0:
        return 0.0
    if release == NEVER:
        return NEVER
    wait = release - turn
    wait -= math.floor(wait)
    return 0.0 if wait > 1.0 - SAME_INSTANT else wait


@jit
def release_order(push_rate):
    """How a mass leaves at its release. Where the force is as large as the pull of the support the push only
    touches zero, from above: neither it nor its rate acts at that instant."""
    return WITH_RATE if push_rate > 0.0 else WITH_CURVATURE


@jit_inline
def departure(e, p, grid, home, w, turn):
    """(order, wait) of a mass on `home` with speed of departure w: how it leaves, or REST after `wait` turns
    (the rest of a chatter, completed; 0 when it is at rest already)."""
    if e.rest is None:
        # Whatever the force, the mass is pulled off its support: no flight is part of a chatter.
        return (WITH_SPEED if w > 0.0 else WITH_PULL), 0.0
    most = largest_force(p) + abs(frame_at(e, p, home).load) + p.h * w
    if w > FASTEST_CHATTER * most and w * w > LOWEST_HOP * p.l * most:
        return WITH_SPEED, 0.0
    # Not the grid itself: to hand it over takes longer than to tell the plain departure above.
    return _slow_departure(e, p, grid.steps * grid.dt, home, w, turn, most)


@jit
def _slow_departure(e, p, period, home, w, turn, most):
    """`departure` with a speed that may be part of a chatter, or none; most: the largest push there can be."""
    frame = frame_at(e, p, home)
    force = Force(0.0, 0.0)
    if e.forcing is not None:
        force = force_at(p, frame.sigma, turn)
    push, rate, h = force.sine + frame.load, force_rate(p, force), 0.0
    if e.damping is not None:
        h = p.h
        push -= h * w
        rate -= h * push
    if w > 0.0:
        if push < 0.0:
            restitution = restitution_of(e, p, home)
            # The rates side by side: where they cancel for an instant, the next order counts.
            wait = chatter_duration(w, push, abs(rate) + w, restitution, h, p.nu)
            if wait < NEVER:
                return REST, wait / period
            if restitution >= 1.0 and h > 0.0 and w * w <= LOWEST_HOP * p.l * -push:
                return REST, 0.0
        return WITH_SPEED, 0.0
    if push > 0.0:
        return WITH_PULL, 0.0
    release = release_wait(e, p, home, turn)
    # Within the rounding of a push its rate tells whether the release is just over: were it taken for one to
    # come, the mass would rest for a whole period.
    if release == 0.0 or (release < NEVER and rate > 0.0 and push >= -PUSH_NOISE * most):
        return release_order(rate), 0.0
    return REST, 0.0


@jit
def begin(e, p, grid, turns, x, v):
    """State of a motion that starts at `turns` forcing periods from (x, v); on a support with its home there."""
    at = locate(turns, grid.steps)
    upper, lower = support_position(p, 1), support_position(p, 2)
    home, y, w, order, rest_start = 0, x, v, FLIGHT, 0.0
    if not (x < upper and x > lower):
        home = 1 if x >= upper else 2
        y, w = 0.0, -v if home == 1 else v
        if w < 0.0:
            order = STRIKES
        elif w > 0.0:
            # However slow: where it ends in a chatter, that is one after an impact, which is logged.
            order = WITH_SPEED
        else:
            order, _wait = departure(e, p, grid, home, w, phase_at(grid, at))
            rest_start = turns
    return State(at.period, at.step, at.theta, home, y, w, order, rest_start)
