"""Where a motion is, and how a mass on a support goes on: fly, rest, be released."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, grid_time, phase_at
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
# rate's rate; or not, and one that starts on a support moving in strikes it first. Up to LEAVES_BY_SNAP the number
# is the power of time with which the distance begins to grow.
(
    FLIGHT,
    LEAVES_BY_VELOCITY,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_JERK,
    LEAVES_BY_SNAP,
    IMPACTS_AT_START,
    REST,
) = 0, 1, 2, 3, 4, 8, 9
# Rounding of a phase in turns: a contact this soon after the release belongs to it.
TIME_TOLERANCE = 1e-13
# Hops that lose no speed at the support, only by damping, end in algebraic time: once they are no higher than
# the rounding of x (this share of l, twice), the mass rests.
MIN_HOP_HEIGHT = 2.0**-52
# Rounding of a push, as a share of the largest there can be.
ACCELERATION_ROUNDING = 2.0**-51
# Departures faster than this share of the largest push there can be are part of no complete chatter: by the
# velocity alone, 4 (w/push)^3, the push changes by more than `chatter_duration` allows. Nearly all are.
MAX_CHATTER_SPEED = 2e-5


class State(NamedTuple):
    """Where a motion is: time as period, step, theta; place as distance y from `home` and its rate w.

    mode: how it departs (FLIGHT ... REST; w < 0 where it IMPACTS_AT_START); rest_start: in forcing periods, while it
    rests.
    """

    period: int
    step: int
    theta: float
    home: int
    y: float
    w: float
    mode: int
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
def advance_time(grid, at, wait):
    """The `Instant` a time of `wait` turns after an `Instant` or a state."""
    later = at.theta + wait * grid.steps
    whole = math.floor(later)
    later -= whole
    if later > 1.0 - TIME_TOLERANCE:
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
    return 0.0 if wait > 1.0 - TIME_TOLERANCE else wait


@jit
def release_mode(gap_jerk):
    """How a mass leaves at its release. Where the force is as large as the pull of the support the push only
    touches zero, from above: neither it nor its rate acts at that instant."""
    return LEAVES_BY_JERK if gap_jerk > 0.0 else LEAVES_BY_SNAP


@jit_inline
def departure_mode(e, p, grid, home, w, turn):
    """(order, wait) of a mass on `home` with speed of departure w: how it leaves, or REST after `wait` turns
    (the rest of a chatter, completed; 0 when it is at rest already)."""
    if e.rest is None:
        # Whatever the force, the mass is pulled off its support: no flight is part of a chatter.
        return (LEAVES_BY_VELOCITY if w > 0.0 else LEAVES_BY_ACCELERATION), 0.0
    max_acceleration = largest_force(p) + abs(frame_at(e, p, home).load) + p.h * w
    if w > MAX_CHATTER_SPEED * max_acceleration and w * w > MIN_HOP_HEIGHT * p.l * max_acceleration:
        return LEAVES_BY_VELOCITY, 0.0
    # Not the grid itself: to hand it over takes longer than to tell the plain departure above.
    return _slow_departure(e, p, grid.steps * grid.dt, home, w, turn, max_acceleration)


@jit
def _slow_departure(e, p, period, home, w, turn, max_acceleration):
    """`departure_mode` with a speed that may be part of a chatter, or none; max_acceleration: the largest push there
    can be."""
    frame = frame_at(e, p, home)
    force = Force(0.0, 0.0)
    if e.forcing is not None:
        force = force_at(p, frame.sigma, turn)
    gap_acceleration, gap_jerk, h = force.sine + frame.load, force_rate(p, force), 0.0
    if e.damping is not None:
        h = p.h
        gap_acceleration -= h * w
        gap_jerk -= h * gap_acceleration
    if w > 0.0:
        if gap_acceleration < 0.0:
            restitution = restitution_of(e, p, home)
            # The rates side by side: where they cancel for an instant, the next order counts.
            wait = chatter_duration(w, gap_acceleration, abs(gap_jerk) + w, restitution, h, p.nu)
            if wait < NEVER:
                return REST, wait / period
            if restitution >= 1.0 and h > 0.0 and w * w <= MIN_HOP_HEIGHT * p.l * -gap_acceleration:
                return REST, 0.0
        return LEAVES_BY_VELOCITY, 0.0
    if gap_acceleration > 0.0:
        return LEAVES_BY_ACCELERATION, 0.0
    release = release_wait(e, p, home, turn)
    # Within the rounding of a push its rate tells whether the release is just over: were it taken for one to
    # come, the mass would rest for a whole period.
    if release == 0.0 or (
        release < NEVER
        and gap_jerk > 0.0
        and gap_acceleration >= -ACCELERATION_ROUNDING * max_acceleration
    ):
        return release_mode(gap_jerk), 0.0
    return REST, 0.0


@jit
def initial_state(e, p, grid, turns, x, v):
    """State of a motion that starts at `turns` forcing periods from (x, v); on a support with its home there."""
    at = grid_time(turns, grid.steps)
    upper, lower = support_position(p, 1), support_position(p, 2)
    home, y, w, mode, rest_start = 0, x, v, FLIGHT, 0.0
    if not (x < upper and x > lower):
        home = 1 if x >= upper else 2
        y, w = 0.0, -v if home == 1 else v
        if w < 0.0:
            mode = IMPACTS_AT_START
        elif w > 0.0:
            # However slow: where it ends in a chatter, that is one after an impact, which is logged.
            mode = LEAVES_BY_VELOCITY
        else:
            mode, _wait = departure_mode(e, p, grid, home, w, phase_at(grid, at))
            rest_start = turns
    return State(at.period, at.step, at.theta, home, y, w, mode, rest_start)
