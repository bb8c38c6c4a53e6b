"""Which linear piece a motion with soft supports or friction is on, and how a mass without velocity goes on."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import grid_time, phase_at
from vibropipe.march.piece_log import CONTACT, FREE, HELD, RESTING
from vibropipe.march.state import (
    ACCELERATION_ROUNDING,
    DOWN_BY_ACCELERATION,
    DOWN_BY_JERK,
    DOWN_BY_SNAP,
    FLIGHT,
    IMPACTS_AT_START,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_JERK,
    LEAVES_BY_SNAP,
    LEAVES_BY_VELOCITY,
    REST,
    STUCK,
    State,
    departure_mode,
    initial_state,
)
from vibropipe.physics.contact import frame_at, support_position
from vibropipe.physics.decay import ALIVE, Decay, decay_of
from vibropipe.physics.flow import REACH
from vibropipe.physics.friction import friction_of
from vibropipe.physics.load import force_at, force_rate, force_value, largest_force, no_force
from vibropipe.physics.stiffness import damping_of, is_soft, piece_rate, stiffness_of

# Parts of a step of a contact above which it is looked at whether its exponentials have decayed: usual contacts have
# fewer and keep their bits. Parts above which the rounding of a time exceeds some parts.
MANY_PARTS, MAX_PARTS = 2.0**12, 2.0**44


class Piece(NamedTuple):
    """The linear motion y'' + damping y' + stiffness y = load + sigma F, and the zeros that it starts with.

    Attributes
    ----------
    stiffness, damping, load : float
        `load` includes the friction.
    direction : float
        Sign of the velocity, in the frame.
    in_contact : bool
        Whether a soft support acts.
    gap_power, velocity_power : int
        Power of time with which the gap to `home`, and the velocity, leave zero; 0 where they are not zero.
    """

    stiffness: float
    damping: float
    load: float
    direction: float
    in_contact: bool
    gap_power: int
    velocity_power: int


@jit
def direction_of(state) -> float:
    """Return the sign of the velocity of a state, or of the velocity that it is about to have; 0 if it is held."""
    if state.w != 0.0:
        return 1.0 if state.w > 0.0 else -1.0
    if LEAVES_BY_ACCELERATION <= state.mode <= LEAVES_BY_SNAP:
        return 1.0
    return -1.0 if DOWN_BY_ACCELERATION <= state.mode <= DOWN_BY_SNAP else 0.0


@jit
def is_in_contact(e, p, state) -> bool:
    """Return whether the soft support `home` acts on the mass, or is about to."""
    if not is_soft(e, p, state.home):
        return False
    return state.y < 0.0 or (state.y == 0.0 and direction_of(state) < 0.0)


@jit
def form_of(e, p, state) -> int:
    """Return what the piece of a state is: FREE, CONTACT, HELD or RESTING."""
    if state.mode == REST:
        return RESTING
    if state.mode == STUCK:
        return HELD
    return CONTACT if is_in_contact(e, p, state) else FREE


@jit
def coefficients(e, p, home, in_contact):
    """Return (stiffness, damping) of a piece."""
    stiffness, damping = 1.0, 0.0
    if e.damping is not None:
        damping = p.h
    if in_contact:
        stiffness, damping = stiffness + stiffness_of(p, home), damping + damping_of(p, home)
    return stiffness, damping


@jit
def piece_at(e, p, frame, state) -> Piece:
    """Return the piece that a moving state is on."""
    in_contact = is_in_contact(e, p, state)
    stiffness, damping = coefficients(e, p, state.home, in_contact)
    direction = direction_of(state)
    velocity_power = 0
    if state.w == 0.0 and state.mode >= LEAVES_BY_ACCELERATION:
        velocity_power = state.mode - (1 if state.mode <= LEAVES_BY_SNAP else 4)
    gap_power = velocity_power + 1 if state.home > 0 and state.y == 0.0 else 0
    load = frame.load - friction_of(e, p) * direction
    return Piece(stiffness, damping, load, direction, in_contact, gap_power, velocity_power)


@jit
def parts_of_step(e, p, grid, frame, piece, state):
    """Return into how many parts a step of the grid is divided, in contact with a soft support, and its `Decay`.

    The parts are 0 where they are too short for the times of the grid.
    """
    alive = Decay(ALIVE, 0.0, 0.0, 0.0, no_force())
    if grid.exact is None or not piece.in_contact:
        return 1, alive
    parts = piece_rate(piece.stiffness, piece.damping) * grid.dt / REACH
    if not parts <= MAX_PARTS:
        return 0, alive
    if parts <= MANY_PARTS or state.mode != FLIGHT or state.y == 0.0:
        return max(1, math.ceil(parts)), alive
    force, second = no_force(), e.second_harmonic
    if e.forcing is not None:
        force = force_at(p, frame.sigma, phase_at(grid, state), second)
    decay = decay_of(state.y, state.w, force, piece.load, piece.stiffness, piece.damping, p, second)
    return max(1, math.ceil(decay.rate * grid.dt / REACH)), decay


@jit
def net_force(e, p, home, y, turn):
    """Return the force on a mass without velocity, friction apart: value, rate of change, and scale of its rounding."""
    frame = frame_at(e, p, home)
    stiffness, _damping = coefficients(e, p, home, is_soft(e, p, home) and y < 0.0)
    value, rate = frame.load - stiffness * y, 0.0
    scale = abs(frame.load) + abs(stiffness * y)
    if e.forcing is not None:
        force = force_at(p, frame.sigma, turn, e.second_harmonic)
        value += force_value(force, e.second_harmonic)
        rate = force_rate(p, force, e.second_harmonic)
        scale += largest_force(p)
    return value, rate, scale


@jit
def mode_without_velocity(e, p, grid, home, y, turn) -> int:
    """Return how a mass without velocity goes on: moving either way, STUCK or, on a rigid support, REST.

    A force within rounding of the friction that grows moves it at once: otherwise the mass would be held for a whole
    period.
    """
    if home > 0 and y == 0.0 and not is_soft(e, p, home):
        mode, _wait = departure_mode(e, p, grid, home, 0.0, turn)
        return mode
    value, rate, scale = net_force(e, p, home, y, turn)
    friction = friction_of(e, p)
    rounding = ACCELERATION_ROUNDING * (scale + friction)
    if abs(value) > friction + rounding:
        return LEAVES_BY_ACCELERATION if value > 0.0 else DOWN_BY_ACCELERATION
    if (value * rate > 0.0 or (friction == 0.0 and rate != 0.0)) and abs(
        value
    ) >= friction - rounding:
        return LEAVES_BY_JERK if rate > 0.0 else DOWN_BY_JERK
    return STUCK


@jit
def resume(e, p, grid, at, home, y):
    """Return the state of a mass without velocity at an `Instant` or state."""
    turn = phase_at(grid, at)
    mode = mode_without_velocity(e, p, grid, home, y, turn)
    return State(at.period, at.step, at.theta, home, y, 0.0, mode, at.period + turn)


@jit
def piece_state(e, p, grid, at, home, y, w):
    """Return the state at (y, w) in the frame of `home`, at any side of a soft support."""
    if w == 0.0:
        return resume(e, p, grid, at, home, y)
    mode = FLIGHT
    if home > 0 and y == 0.0:
        mode = LEAVES_BY_VELOCITY if w > 0.0 else IMPACTS_AT_START
    return State(at.period, at.step, at.theta, home, y, w, mode, 0.0)


@jit
def initial_piece_state(e, p, grid, at, x, v):
    """Return the state of a motion that starts at (x, v): on or beyond a support its home is there."""
    home = 1 if x >= support_position(p, 1) else 2 if x <= support_position(p, 2) else 0
    if home == 0:
        return piece_state(e, p, grid, at, home, x, v)
    sigma = -1.0 if home == 1 else 1.0
    y = sigma * (x - support_position(p, home))
    if not is_soft(e, p, home):
        y = 0.0
    return piece_state(e, p, grid, at, home, y, sigma * v)


@jit_inline
def start_state(pieces, e, p, grid, turns, x, v):
    """Return `state.initial_state`, or that of a motion with soft supports or friction; pieces : `log.pieces`."""
    if pieces is not None:
        return initial_piece_state(e, p, grid, grid_time(turns, grid.steps), x, v)
    return initial_state(e, p, grid, turns, x, v)
