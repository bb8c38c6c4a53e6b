"""State of a motion, and how a mass on a support goes on: it flies, sticks (`rest` in names) or is released."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, grid_time, phase_at
from vibropipe.physics.contact import chatter_duration, frame_at, support_position
from vibropipe.physics.frequency import moment_of
from vibropipe.physics.friction import chatter_with_friction, friction_of, hold_of, jumps_at_slip
from vibropipe.physics.housing import Housing, inertia_factor, stays_on_its_way
from vibropipe.physics.load import (
    NEVER,
    fastest_forcing,
    force_at,
    force_rate,
    force_value,
    largest_force,
    no_force,
    release_turn,
    release_wait_of_second,
)
from vibropipe.physics.ramp import wait_from_moment

# Modes of a state. FLIGHT: off its home, or written from the equilibrium. LEAVES_BY_*: on its support; the name is
# the leading derivative of the gap, the number the power of time with which the gap begins to grow. DOWN_BY_*: the
# same towards the home, or past a soft one. Away from supports they say how a mass without velocity starts to move.
# IMPACTS_AT_START: a start on a support with a velocity into it. REST: sticking to a support. STUCK: held by friction.
# UNLOADS, UNLOADED: beyond a soft support that only pushes, and free of it, from the instant on at which its force is
# zero, and later. RELOADS: at the instant at which it begins to push again.
(
    FLIGHT,
    LEAVES_BY_VELOCITY,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_JERK,
    LEAVES_BY_SNAP,
    DOWN_BY_ACCELERATION,
    DOWN_BY_JERK,
    DOWN_BY_SNAP,
    IMPACTS_AT_START,
    REST,
    STUCK,
    UNLOADS,
    UNLOADED,
    RELOADS,
) = range(14)
# Rounding of a phase, in turns: times closer than this are one instant.
TIME_TOLERANCE = 1e-13
# Twice the height of the lowest hop that is marched, as a share of l; the height is the rounding of x. Where R = 1
# damping alone shortens the hops, algebraically, so no geometric series ends them: lower ones count as sticking.
MIN_HOP_HEIGHT = 2.0**-52
# Rounding of a gap acceleration, as a share of its largest magnitude.
ACCELERATION_ROUNDING = 2.0**-51
# Departure speed, as a share of the largest gap acceleration a, above which no chatter can be completed: the term of
# the velocity alone, 4 (w/a)^3, exceeds the tolerance of `chatter_duration`. Nearly all departures are faster.
MAX_CHATTER_SPEED = 2e-5


class State(NamedTuple):
    """State of a motion: a time on the grid, and the distance y from `home` with its rate w.

    period, step, theta : time, as in `Instant`
    home : reference of y: 0 the equilibrium, 1 or 2 that support (`physics.contact.Frame`)
    y, w : distance from `home` and its derivative by tau
    mode : FLIGHT to RELOADS; w < 0 where it is IMPACTS_AT_START
    rest_start : start of a rest, or of a stick, in forcing periods; read in the modes REST and STUCK only
    housing : the housing, where it may slide
    """

    period: int
    step: int
    theta: float
    home: int
    y: float
    w: float
    mode: int
    rest_start: float
    housing: Housing | None


@jit
def is_before(at, end) -> bool:
    """Return whether an `Instant` or a state lies strictly before an `Instant`."""
    if at.period != end.period:
        return at.period < end.period
    if at.step != end.step:
        return at.step < end.step
    return at.theta < end.theta


@jit
def advance_time(grid, at, wait):
    """Return the `Instant` that lies `wait` turns after an `Instant` or a state."""
    theta = at.theta + wait * grid.steps
    whole_steps = math.floor(theta)
    theta -= whole_steps
    if theta > 1.0 - TIME_TOLERANCE:
        # A departure within rounding of the next step's start is moved there: in the time between them the mass
        # would cover a distance below rounding.
        whole_steps, theta = whole_steps + 1.0, 0.0
    step = at.step + int(whole_steps)
    return Instant(at.period + step // grid.steps, step % grid.steps, theta)


@jit
def restitution_of(e, p, home):
    """Return the coefficient of restitution of the support `home`; 1 where the effect is absent."""
    restitution = 1.0
    if e.restitution is not None:
        restitution = p.R1 if home == 1 else p.R2
    return restitution


@jit
def is_watched(home, watched) -> bool:
    """Return whether `home` is a watched support; watched: `Effects.watched` (1, 2, 3 for both, or None)."""
    if watched is None:
        return False
    return home & watched != 0


@jit
def release_wait(e, p, home, turn, housing=None):
    """Return the turns from phase `turn` to the release of a mass sticking to `home`: 0 at once, or NEVER.

    A housing is taken to go on as it does.
    """
    frame = frame_at(e, p, home, housing)
    load = frame.load
    if e.friction is not None:
        load -= hold_of(e, p)
    if e.forcing is None:
        return 0.0 if load > 0.0 else NEVER
    return _forced_release_wait(moment_of(turn), e, p, frame.sigma, load, turn)


@jit_inline
def _forced_release_wait(moment, e, p, sigma, load, turn):
    """Return `release_wait` under a force; moment : `moment_of` the phase, as an argument, which decides the code."""
    if moment is not None:
        wait = wait_from_moment(moment, e, p, sigma, load, moment.ramp.span - moment.s)
        return 0.0 if wait < TIME_TOLERANCE else wait
    if e.second_harmonic is not None:
        wait = release_wait_of_second(p, sigma, load, turn)
        return 0.0 if wait < TIME_TOLERANCE else wait
    release = release_turn(p, sigma, load)
    if release < 0.0:
        return 0.0
    if release == NEVER:
        return NEVER
    wait = release - turn
    wait -= math.floor(wait)
    return 0.0 if wait > 1.0 - TIME_TOLERANCE else wait


@jit
def release_mode(e, p, gap_jerk):
    """Return the mode of a release, where the gap acceleration is zero, unless friction drops as the mass moves.

    The mass leaves by jerk or, if the force amplitude equals the constant pull so that the jerk vanishes too, by snap.
    """
    if jumps_at_slip(e, p):
        return LEAVES_BY_ACCELERATION
    return LEAVES_BY_JERK if gap_jerk > 0.0 else LEAVES_BY_SNAP


@jit_inline
def departure_mode(e, p, grid, home, w, turn, housing=None):
    """Return how a mass on `home` with departure speed w >= 0 goes on at the phase `turn`, and with a `Housing`.

    Returns the mode, LEAVES_BY_VELOCITY to LEAVES_BY_SNAP, or REST, and the turns until the rest begins: the remaining
    time of a chatter, 0 if the mass sticks already.
    """
    if e.rest is None:
        # The force never presses the mass on its support: there is no chatter.
        return (LEAVES_BY_VELOCITY if w > 0.0 else LEAVES_BY_ACCELERATION), 0.0
    max_acceleration = largest_force(p) + abs(frame_at(e, p, home, housing).load) + p.h * w
    if e.friction is not None:
        max_acceleration += p.friction
    if housing is not None:
        max_acceleration *= inertia_factor(p, housing)
    if w > MAX_CHATTER_SPEED * max_acceleration and w * w > MIN_HOP_HEIGHT * p.l * max_acceleration:
        return LEAVES_BY_VELOCITY, 0.0
    # The grid itself is not passed: copying it takes longer than the usual departure above.
    return _slow_departure(e, p, grid.steps * grid.dt, home, w, turn, max_acceleration, housing)


@jit
def _slow_departure(e, p, period, home, w, turn, max_acceleration, housing=None):
    """Return `departure_mode` of a speed that may be part of a chatter; max_acceleration bounds |gap acceleration|."""
    frame, factor = frame_at(e, p, home, housing), inertia_factor(p, housing)
    force, second = no_force(), e.second_harmonic
    if e.forcing is not None:
        force = force_at(p, frame.sigma, turn, second)
    gap_acceleration, h = force_value(force, second) + frame.load, 0.0
    gap_jerk = force_rate(p, force, second)
    if e.damping is not None:
        h = p.h
        gap_acceleration -= h * w
        gap_jerk -= h * gap_acceleration
    friction = friction_of(e, p)
    if e.friction is not None:
        gap_acceleration -= friction
    if housing is not None:
        # The jerk has one damping too few: it only bounds the rate of a small speed.
        h, friction = h * factor, friction * factor
        gap_acceleration, gap_jerk = gap_acceleration * factor, gap_jerk * factor
    if w > 0.0:
        if gap_acceleration < 0.0:
            restitution, fastest = restitution_of(e, p, home), fastest_forcing(p, second)
            # A bound by the sum of both rates: where they cancel for an instant, the next order counts.
            rate = abs(gap_jerk) + w
            if e.friction is not None:
                press = -gap_acceleration - friction
                hold = friction * p.friction_ratio
                wait = chatter_with_friction(
                    w, press, friction, hold, rate, restitution, h, fastest
                )
            else:
                wait = chatter_duration(w, gap_acceleration, rate, restitution, h, fastest)
            if wait < NEVER and stays_on_its_way(p, housing, w, wait):
                return REST, wait / period
            if restitution >= 1.0 and h > 0.0 and w * w <= MIN_HOP_HEIGHT * p.l * -gap_acceleration:
                return REST, 0.0
        return LEAVES_BY_VELOCITY, 0.0
    if e.friction is not None:
        gap_acceleration -= friction * p.friction_ratio - friction
    if gap_acceleration > 0.0:
        return LEAVES_BY_ACCELERATION, 0.0
    release = release_wait(e, p, home, turn, housing)
    # Where the acceleration is zero within rounding and grows, the release is now: otherwise the mass would stick
    # for a whole period.
    if release == 0.0 or (
        release < NEVER
        and gap_jerk > 0.0
        and gap_acceleration >= -ACCELERATION_ROUNDING * max_acceleration
    ):
        return release_mode(e, p, gap_jerk), 0.0
    return REST, 0.0


@jit
def initial_state(e, p, grid, turns, x, v, housing):
    """Return the state of a motion that starts at (x, v); a start on a support has its home there.

    turns : time of the start, in forcing periods
    x, v : displacement and velocity
    housing : None: there is none, as its type says; motions with one are marched by pieces
    """
    at = grid_time(turns, grid.steps)
    upper, lower = support_position(p, 1), support_position(p, 2)
    home, y, w, mode, rest_start = 0, x, v, FLIGHT, 0.0
    if not (x < upper and x > lower):
        home = 1 if x >= upper else 2
        y, w = 0.0, -v if home == 1 else v
        if w < 0.0:
            mode = IMPACTS_AT_START
        elif w > 0.0:
            # At any speed: a chatter is completed only after an impact, which is logged.
            mode = LEAVES_BY_VELOCITY
        else:
            mode, _wait = departure_mode(e, p, grid, home, w, phase_at(grid, at))
            rest_start = turns
    return State(at.period, at.step, at.theta, home, y, w, mode, rest_start, housing)
