"""Which linear piece a motion with soft supports or friction is on, and how a mass without velocity goes on."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import grid_time, phase_at, turns_at
from vibropipe.march.piece_log import BEYOND, CONTACT, FREE, HELD, RESTING
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
    UNLOADED,
    UNLOADS,
    State,
    departure_mode,
    initial_state,
)
from vibropipe.physics.contact import frame_at, support_position
from vibropipe.physics.friction import friction_of, hold_of, jumps_at_slip
from vibropipe.physics.housing import (
    BY_ACCELERATION,
    BY_JERK,
    MOVES,
    STANDS,
    Housing,
    start_of_housing,
    total_load,
)
from vibropipe.physics.load import force_at, force_rate, force_value, largest_force
from vibropipe.physics.stiffness import (
    damping_of,
    is_soft,
    only_pushes,
    pull_of_support,
    stiffness_of,
)


@jit_inline
def direction_of(state) -> float:
    """Return the sign of the velocity of a state, or of the velocity that it is about to have; 0 if it is held."""
    if state.w != 0.0:
        return 1.0 if state.w > 0.0 else -1.0
    if LEAVES_BY_ACCELERATION <= state.mode <= LEAVES_BY_SNAP:
        return 1.0
    return -1.0 if DOWN_BY_ACCELERATION <= state.mode <= DOWN_BY_SNAP else 0.0


@jit_inline
def is_beyond(e, p, state) -> bool:
    """Return whether the mass is beyond the soft support `home`, or is about to be."""
    if not is_soft(e, p, state.home):
        return False
    return state.y < 0.0 or (state.y == 0.0 and direction_of(state) < 0.0)


@jit
def is_in_contact(e, p, state) -> bool:
    """Return whether the soft support `home` acts on the mass, or is about to."""
    return is_beyond(e, p, state) and not is_unloaded(e, state)


@jit_inline
def is_unloaded(e, state) -> bool:
    """Return whether a mass is free of the support that it is beyond, which only pushes."""
    if e.no_pull is None:
        return False
    return state.mode in (UNLOADS, UNLOADED)


@jit
def mode_beyond(e, p, home, y, w) -> int:
    """Return the mode of a mass that moves beyond a soft support: free of one that only pushes where it would pull."""
    if e.no_pull is None:
        return FLIGHT
    if only_pushes(e, p, home) and pull_of_support(p, home, y, w) > 0.0:
        return UNLOADED
    return FLIGHT


@jit_inline
def form_of(e, p, state) -> int:
    """Return what the piece of a state is: FREE, CONTACT, HELD, RESTING or BEYOND."""
    if state.mode == REST:
        return RESTING
    if state.mode == STUCK:
        return HELD
    if not is_beyond(e, p, state):
        return FREE
    return BEYOND if is_unloaded(e, state) else CONTACT


@jit_inline
def coefficients(e, p, home, in_contact):
    """Return (stiffness, damping) of a piece whose housing is held."""
    stiffness, damping = 1.0, 0.0
    if e.damping is not None:
        damping = p.h
    if in_contact:
        stiffness, damping = stiffness + stiffness_of(p, home), damping + damping_of(p, home)
    return stiffness, damping


@jit_inline
def net_force(e, p, home, y, turn, housing=None):
    """Return the force on a mass without velocity, friction apart: value, rate of change, and scale of its rounding.

    Beside a housing that slides it is the force less that which moves the mass along with it.
    """
    frame = frame_at(e, p, home, housing)
    stiffness, _damping = coefficients(e, p, home, is_soft(e, p, home) and y < 0.0)
    value, rate = frame.load - stiffness * y, 0.0
    scale = abs(frame.load) + abs(stiffness * y)
    if e.forcing is not None:
        force = force_at(p, frame.sigma, turn, e.second_harmonic)
        value += force_value(force, e.second_harmonic)
        rate = force_rate(p, force, e.second_harmonic)
        scale += largest_force(p)
    return value, rate, scale


@jit_inline
def mode_without_velocity(e, p, grid, home, y, turn, housing=None) -> int:
    """Return how a mass without velocity goes on: moving either way, STUCK or, on a rigid support, REST.

    A `Housing` is taken to go on as it does.

    A force within rounding of what holds it that grows moves it at once: otherwise the mass would be held for a whole
    period.
    """
    if home > 0 and y == 0.0 and not is_soft(e, p, home):
        mode, _wait = departure_mode(e, p, grid, home, 0.0, turn, housing)
        return mode
    value, rate, scale = net_force(e, p, home, y, turn, housing)
    hold = hold_of(e, p)
    rounding = ACCELERATION_ROUNDING * (scale + hold)
    if abs(value) > hold + rounding:
        return LEAVES_BY_ACCELERATION if value > 0.0 else DOWN_BY_ACCELERATION
    if (value * rate > 0.0 or (hold == 0.0 and rate != 0.0)) and abs(value) >= hold - rounding:
        if jumps_at_slip(e, p):
            return LEAVES_BY_ACCELERATION if rate > 0.0 else DOWN_BY_ACCELERATION
        return LEAVES_BY_JERK if rate > 0.0 else DOWN_BY_JERK
    return STUCK


@jit
def net_on_housing(e, p, grid, state):
    """Return the force that would act on a held housing, its friction apart, as `net_force`: value, rate, scale."""
    load = total_load(p)
    if state.mode in (REST, STUCK):
        return load, 0.0, abs(load)
    frame, second = frame_at(e, p, state.home), e.second_harmonic
    stiffness, damping = coefficients(e, p, state.home, is_in_contact(e, p, state))
    friction = friction_of(e, p)
    value = frame.load - stiffness * state.y - damping * state.w - friction * direction_of(state)
    scale = abs(frame.load) + abs(stiffness * state.y) + abs(damping * state.w) + friction
    rate = -stiffness * state.w
    if e.forcing is not None:
        force = force_at(p, frame.sigma, phase_at(grid, state), second)
        value += force_value(force, second)
        rate += force_rate(p, force, second)
        scale += largest_force(p)
    rate -= damping * value
    return load - frame.sigma * value, -frame.sigma * rate, abs(load) + scale


@jit
def way_without_velocity(e, p, grid, state):
    """Return (way, power) of a `Housing` without velocity: it goes where the force on it exceeds the friction.

    A force within rounding of the friction that grows moves it at once, as it does a mass. One of infinite mass stands.
    """
    if p.mass_ratio == 0.0:
        return STANDS, MOVES
    value, rate, scale = net_on_housing(e, p, grid, state)
    up, down = p.housing_friction_1, -p.housing_friction_2
    rounding = ACCELERATION_ROUNDING * (scale + up - down)
    if value > up + rounding:
        return 1, BY_ACCELERATION
    if value < down - rounding:
        return -1, BY_ACCELERATION
    if value >= up - rounding and rate > 0.0:
        return 1, BY_JERK
    if value <= down + rounding and rate < 0.0:
        return -1, BY_JERK
    return STANDS, MOVES


@jit
def state_with(state, mode, way, power, housing):
    """Return a state in a mode, whose housing goes a way."""
    after = Housing(way, power, housing.momentum, housing.displacement)
    return State(
        state.period, state.step, state.theta, state.home, state.y, state.w, mode,
        state.rest_start, after,
    )  # fmt: skip


@jit_inline
def with_housing(e, p, grid, state, housing):
    """Return a state with a `Housing`; on one without velocity the force decides how it goes on."""
    if housing is None:
        return state
    after = state_with(state, state.mode, housing.way, housing.power, housing)
    if housing.way != STANDS and housing.power == MOVES:
        return after
    way, power = way_without_velocity(e, p, grid, after)
    return state_with(state, state.mode, way, power, housing)


@jit_inline
def resume(e, p, grid, at, home, y, housing):
    """Return the state of a mass without velocity at an `Instant` or state, with a `Housing` or None."""
    turn = phase_at(grid, at)
    since = turns_at(grid, at)
    if housing is None:
        mode = mode_without_velocity(e, p, grid, home, y, turn)
        return State(at.period, at.step, at.theta, home, y, 0.0, mode, since, housing)
    state = State(at.period, at.step, at.theta, home, y, 0.0, FLIGHT, since, housing)
    return resume_with(e, p, grid, state, turn, housing)


@jit
def resume_with(e, p, grid, state, turn, housing):
    """Return a state without velocity of the mass in the mode in which it goes on with a housing.

    Where the housing has no velocity either, both go on as each must if the other does.
    """
    home, y = state.home, state.y
    if housing.way != STANDS and housing.power == MOVES:
        mode = mode_without_velocity(e, p, grid, home, y, turn, housing)
        return state_with(state, mode, housing.way, MOVES, housing)
    for way in (1, -1, STANDS):
        trial = Housing(way, MOVES, housing.momentum, housing.displacement)
        mode = mode_without_velocity(e, p, grid, home, y, turn, trial)
        moving = state_with(state, mode, way, MOVES, housing)
        goes, power = way_without_velocity(e, p, grid, moving)
        if goes == way:
            return state_with(state, mode, way, power, housing)
    return moving


@jit
def piece_state(e, p, grid, at, home, y, w, housing):
    """Return the state at (y, w) in the frame of `home`, at any side of a soft support, with a `Housing` or None."""
    if w == 0.0:
        return resume(e, p, grid, at, home, y, housing)
    mode = FLIGHT
    if home > 0 and y == 0.0:
        mode = LEAVES_BY_VELOCITY if w > 0.0 else IMPACTS_AT_START
    elif home > 0 and y < 0.0:
        mode = mode_beyond(e, p, home, y, w)
    state = State(at.period, at.step, at.theta, home, y, w, mode, 0.0, housing)
    return with_housing(e, p, grid, state, housing)


@jit
def initial_piece_state(e, p, grid, at, x, v, housing):
    """Return the state of a motion that starts at (x, v): on or beyond a support its home is there."""
    home = 1 if x >= support_position(p, 1) else 2 if x <= support_position(p, 2) else 0
    if home == 0:
        return piece_state(e, p, grid, at, home, x, v, housing)
    sigma = -1.0 if home == 1 else 1.0
    y = sigma * (x - support_position(p, home))
    if not is_soft(e, p, home):
        y = 0.0
    return piece_state(e, p, grid, at, home, y, sigma * v, housing)


@jit_inline
def start_state(pieces, e, p, grid, turns, x, v, housing_velocity):
    """Return `state.initial_state`, or that of a motion by pieces; pieces : `log.pieces`.

    housing_velocity : of a housing that may slide; its displacement is 0.
    """
    housing = start_of_housing(e.housing, p, v, housing_velocity)
    if pieces is not None:
        return initial_piece_state(e, p, grid, grid_time(turns, grid.steps), x, v, housing)
    return initial_state(e, p, grid, turns, x, v, housing)
