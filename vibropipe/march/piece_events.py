"""The polynomial of one linear piece, the first event on it, and the force of a soft support."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant, phase_at
from vibropipe.march.piece_crossing import crossing, largest_value
from vibropipe.march.piece_housing import SLIP_UP, housing_margin
from vibropipe.march.piece_log import DEPTH, ELAPSED, FORCE
from vibropipe.march.piece_state import coefficients, direction_of, is_beyond, is_in_contact
from vibropipe.march.roots import NONE, STRIDE_LIMIT, gap
from vibropipe.march.state import FLIGHT, LEAVES_BY_ACCELERATION, LEAVES_BY_SNAP, RELOADS, UNLOADS
from vibropipe.physics.contact import Frame
from vibropipe.physics.decay import ALIVE, Decay, decay_of
from vibropipe.physics.flow import REACH, combine
from vibropipe.physics.friction import friction_of
from vibropipe.physics.housing import inertia_factor, times_force
from vibropipe.physics.load import force_at, force_value, no_force
from vibropipe.physics.stiffness import (
    damping_of,
    only_pushes,
    piece_mean_acceleration,
    piece_rate,
    stiffness_of,
)

# What ends a step: nothing, the near or the far support of the frame, a zero of the velocity, or one of the force of a
# support that only pushes, falling or rising.
NOTHING, NEAR, FAR, ZERO, FORCE_ENDS, FORCE_BEGINS = range(6)
# What may happen in a step, as a sum: a zero of the gap to the near or far support, of the velocity, of the force of a
# support that only pushes, an event of the housing.
MAY_NEAR, MAY_FAR, MAY_TURN, MAY_PULL, MAY_MOVE, ANY = 1, 2, 4, 8, 16, 31
# Steps of Newton's method for the length of a Newmark step, and its last correction as a share of that length.
MAX_STEPS, STEP_TOLERANCE = 20, 2.0**-50

# Parts of a step of a contact above which it is looked at whether its exponentials have decayed: usual contacts have
# fewer and keep their bits. Parts above which the rounding of a time exceeds some parts.
MANY_PARTS, MAX_PARTS = 2.0**12, 2.0**44


class Piece(NamedTuple):
    """The linear motion y'' + damping y' + stiffness y = load + sigma F, and the zeros that it starts with.

    stiffness, damping, load : `load` includes the friction
    direction : sign of the velocity, in the frame
    in_contact : whether a soft support acts
    lets_go : whether the mass is beyond a support that only pushes
    gap_power, velocity_power, force_power : power of time with which the gap to `home`, the velocity, and the force of
        such a support leave zero; 0 where they are not zero
    factor : of the force: 1, or 1 + kappa where a housing slides; stiffness, damping and load have it
    """

    stiffness: float
    damping: float
    load: float
    direction: float
    in_contact: bool
    lets_go: bool
    gap_power: int
    velocity_power: int
    force_power: int
    factor: float


@jit_inline
def piece_at(e, p, frame, state) -> Piece:
    """Return the piece that a moving state is on; `frame` has the load of its housing."""
    in_contact = is_in_contact(e, p, state)
    stiffness, damping = coefficients(e, p, state.home, in_contact)
    direction = direction_of(state)
    velocity_power = 0
    if state.w == 0.0 and state.mode >= LEAVES_BY_ACCELERATION:
        velocity_power = state.mode - (1 if state.mode <= LEAVES_BY_SNAP else 4)
    gap_power = velocity_power + 1 if state.home > 0 and state.y == 0.0 else 0
    load, factor = frame.load - friction_of(e, p) * direction, inertia_factor(p, state.housing)
    if e.housing is not None:
        stiffness, damping, load = factor * stiffness, factor * damping, factor * load
    lets_go, force_power = False, 0
    if e.no_pull is not None and is_beyond(e, p, state):
        lets_go = only_pushes(e, p, state.home)
        starts = state.mode == UNLOADS or state.mode == RELOADS
        force_power = 1 if starts else velocity_power if state.y == 0.0 else 0
    return Piece(
        stiffness, damping, load, direction, in_contact, lets_go,
        gap_power, velocity_power, force_power, factor,
    )  # fmt: skip


@jit_inline
def force_on(e, p, grid, frame, piece, state):
    """Return the `Force` on a piece at a state, with the factor of the piece."""
    force = no_force()
    if e.forcing is not None:
        force = force_at(p, frame.sigma, phase_at(grid, state), e.second_harmonic)
        if e.housing is not None:
            force = times_force(piece.factor, force)
    return force


@jit_inline
def parts_of_step(e, p, grid, frame, piece, state):
    """Return into how many parts a step of the grid is divided, where a piece is stiffer than the spring; its `Decay`.

    The parts are 0 where they are too short for the times of the grid.
    """
    alive = Decay(ALIVE, 0.0, 0.0, 0.0, no_force())
    if grid.exact is None or not (piece.in_contact or piece.factor > 1.0):
        return 1, alive
    parts = piece_rate(piece.stiffness, piece.damping) * grid.dt / REACH
    if not parts <= MAX_PARTS:
        return 0, alive
    if parts <= MANY_PARTS or state.mode != FLIGHT or state.y == 0.0:
        return max(1, math.ceil(parts)), alive
    force, second = force_on(e, p, grid, frame, piece, state), e.second_harmonic
    decay = decay_of(state.y, state.w, force, piece.load, piece.stiffness, piece.damping, p, second)
    return max(1, math.ceil(decay.rate * grid.dt / REACH)), decay


@jit
def fill_newmark(e, p, grid, frame, piece, state, span, dt, c) -> None:
    """Fill c with the polynomial of a step of Newmark's method of length span, in t/dt, origin at the state."""
    second = e.second_harmonic
    mean = force_value(force_on(e, p, grid, frame, piece, state), second)
    if e.forcing is not None:
        turn = (state.step + state.theta + span) / grid.steps
        end = force_value(force_at(p, frame.sigma, turn, second), second)
        if e.housing is not None:
            end *= piece.factor
        mean = 0.5 * (mean + end)
    force, stiffness, damping = mean + piece.load, piece.stiffness, piece.damping
    mean = piece_mean_acceleration(state.y, state.w, force, stiffness, damping, span * dt)
    c[0], c[1], c[2] = state.y, state.w * dt, 0.5 * dt * dt * mean


@jit_inline
def fill_exact(e, piece, flow, state, force, dt, c) -> None:
    """Fill c with the motion on a piece from a state under a `Force`, in t/dt; flow : of `piece_path.fill_flow`."""
    combine(e, flow, c, state.y, state.w, piece.load, force)
    # The derivatives that the mode declares zero are set to zero, without rounding.
    if piece.velocity_power == 1:
        push = force_value(force, e.second_harmonic) + piece.load
        c[2] = 0.5 * (dt * dt * push - piece.stiffness * (dt * dt) * state.y)
    if piece.velocity_power >= 2:
        c[2] = 0.0
    if piece.velocity_power >= 3:
        c[3] = 0.0


@jit_inline
def fill_support_force(p, home, c, dt, work) -> None:
    """Fill work, (c.size,), with the polynomial of stiffness y + damping y' of a soft support on the piece of c."""
    stiffness, damping, last = stiffness_of(p, home), damping_of(p, home) / dt, c.size - 1
    for n in range(last):
        work[n] = stiffness * c[n] + damping * (n + 1) * c[n + 1]
    work[last] = stiffness * c[last]


@jit_inline
def first_event_beyond(p, home, piece, may, c, span, dt, work, counts):
    """Locate the first event of a piece beyond a support that only pushes: as `first_event` does."""
    if may & (MAY_PULL | MAY_NEAR) == 0:
        return span, NOTHING, NONE
    fill_support_force(p, home, c, dt, work)
    power, sign = min(piece.force_power, c.size - 2), -1.0 if piece.in_contact else 1.0
    if power == 1 and work[1] * sign <= 0.0:
        # By rounding, or where the force only touches zero.
        work[1], power = 0.0, 2
    theta, kind = crossing(work, power, sign, 0.0, 0.0, span, counts)
    event = NOTHING
    if kind != NONE:
        event = FORCE_ENDS if piece.in_contact else FORCE_BEGINS
    if not piece.in_contact and kind != STRIDE_LIMIT:
        other, other_kind = crossing(c, power - power, -1.0, 0.0, 0.0, span, counts)
        if other_kind != NONE and (kind == NONE or other <= theta):
            theta, event, kind = other, NEAR, other_kind
    return theta, event, kind


class PieceStep(NamedTuple):
    """A step along a piece from a state, whose polynomial is known.

    parts : parts of a step of the grid that a step of the polynomial is
    dt : length of such a step, in tau
    may : what may happen in it: MAY_NEAR to MAY_MOVE
    goal, left : where the march along the piece is to end, and the time until then in steps of the grid
    span : length, in steps of the polynomial: 1, or less to reach the goal
    is_whole : whether it reaches the goal
    """

    frame: Frame
    piece: Piece
    parts: float
    dt: float
    may: int
    goal: Instant
    left: float
    span: float
    is_whole: bool


@jit_inline
def slides(e, p) -> bool:
    """Return whether dry friction acts on the mass."""
    return e.friction is not None and p.friction > 0.0


@jit_inline
def first_event(e, p, home, step, c, log):
    """Locate the first event of a `PieceStep` with the polynomial c.

    Returns (theta, event, kind): theta in steps of the polynomial, kind of `roots.first_root`, STRIDE_LIMIT where a
    search has failed.
    """
    frame, piece, may, span, dt = step.frame, step.piece, step.may, step.span, step.dt
    work, counts = log.pieces.work, log.counts
    power = min(piece.gap_power, c.size - 1)
    theta, event, kind = span, NOTHING, NONE
    if e.no_pull is not None and piece.lets_go:
        theta, event, kind = first_event_beyond(p, home, piece, may, c, span, dt, work, counts)
    elif piece.in_contact and may & MAY_NEAR != 0:
        theta, kind = crossing(c, power, -1.0, 0.0, 0.0, span, counts)
        event = NEAR if kind != NONE else NOTHING
    elif not piece.in_contact:
        if frame.to_near and may & MAY_NEAR != 0:
            offset = -frame.near if power == 0 else 0.0
            theta, kind = crossing(c, power, 1.0, offset, frame.load, span, counts)
            event = NEAR if kind != NONE else NOTHING
        if frame.to_far and may & MAY_FAR != 0 and kind != STRIDE_LIMIT:
            other, other_kind = crossing(
                c, power - power, -1.0, frame.far, frame.load, span, counts
            )
            if other_kind != NONE and (kind == NONE or other < theta):
                theta, event, kind = other, FAR, other_kind
    if slides(e, p) and may & MAY_TURN != 0 and kind != STRIDE_LIMIT:
        # The velocity, divided by the power of time with which it leaves zero.
        power = min(piece.velocity_power, c.size - 2)
        last = c.size - 1 - power
        for n in range(last):
            work[n] = (n + power + 1) * c[n + power + 1]
        work[last:] = 0.0
        other, other_kind = crossing(work, 0, piece.direction, 0.0, 0.0, span, counts)
        if other_kind != NONE and (kind == NONE or other < theta):
            theta, event, kind = other, ZERO, other_kind
    return theta, event, kind


@jit_inline
def follow_contact(p, home, contact, c, theta, dt, work) -> None:
    """Add a part of a contact, from 0 to theta of its polynomial, to the record of the contact; work : (c.size,)."""
    fill_support_force(p, home, c, dt, work)
    contact[FORCE] = max(contact[FORCE], largest_value(work, -1.0, theta))
    contact[DEPTH] = max(contact[DEPTH], largest_value(c, -1.0, theta))
    contact[ELAPSED] += theta * dt


@jit
def end_newmark_step(e, p, grid, state, step, event, theta, c, log) -> float:
    """Return the length of the Newmark step that ends at an event, near theta, and fill c with that step.

    A step that ends at the event keeps the error smooth in the step size (`flight.step_to_contact`). Where Newton's
    method finds none, or one that is passed the wrong way, length theta and polynomial of the whole step are kept.
    """
    frame, piece, span, dt = step.frame, step.piece, step.span, step.dt
    target, way = (frame.far, 1.0) if event == FAR else (frame.near, -1.0)
    if piece.in_contact or piece.lets_go:
        way = 1.0
    length = theta
    for _ in range(MAX_STEPS):
        fill_newmark(e, p, grid, frame, piece, state, length, dt, c)
        value, slope, curvature, _third = gap(c, 0, 1.0, -target, length)
        if event == ZERO:
            value, slope, way = slope, curvature, -piece.direction
        if e.no_pull is not None and event in (FORCE_ENDS, FORCE_BEGINS):
            stiffness, share = stiffness_of(p, state.home), damping_of(p, state.home) / dt
            value, slope = (
                -stiffness * (value + target) - share * slope,
                -stiffness * slope - share * curvature,
            )
            way = -1.0 if event == FORCE_ENDS else 1.0
        if e.housing is not None and event >= SLIP_UP:
            value, slope = housing_margin(e, p, grid, state, step, event, length, c, log)
            way = -1.0
        if not slope * way > 0.0:
            break
        change = value / slope
        length -= change
        if not 0.0 < length <= span:
            break
        if abs(change) <= STEP_TOLERANCE * length:
            fill_newmark(e, p, grid, frame, piece, state, length, dt, c)
            return length
    fill_newmark(e, p, grid, frame, piece, state, span, dt, c)
    return theta
