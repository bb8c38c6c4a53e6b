"""A housing along linear pieces: what ends its sliding or holding, its samples and its largest speed."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import phase_at
from vibropipe.march.log import SAMPLES, sample_place
from vibropipe.march.piece_crossing import crossing, largest_value
from vibropipe.march.piece_log import PIECES, extend_housing
from vibropipe.march.roots import CROSSING, GRAZING, NONE, STRIDE_LIMIT, gap
from vibropipe.march.state import advance_time, is_before
from vibropipe.physics.contact import to_displacement
from vibropipe.physics.housing import (
    BY_ACCELERATION,
    BY_JERK,
    MOVES,
    STANDS,
    UNWATCHED,
    momentum_rate,
    momentum_share,
    total_load,
)
from vibropipe.physics.load import NEVER, force_at, force_value

# What ends a step, beside the events of the mass (`piece_events`): a held housing slips either way, a sliding one has
# no velocity; the force on a held one touches the friction, which only divides the step.
SLIP_UP, SLIP_DOWN, STOP, TOUCHES = 6, 7, 8, 9
# Degree of the polynomial of Newmark's method.
NEWMARK_DEGREE = 2
# Share of a step within which such a touch is the one that the step begins with.
SAME_TOUCH = 2.0**-40


@jit
def fill_speed(p, sigma, housing, c, dt, work) -> None:
    """Fill work, (c.size,), with the polynomial of the velocity of a sliding housing on the piece of c."""
    share, last = momentum_share(p), c.size - 1
    for n in range(last):
        work[n] = -share * sigma * (n + 1) * c[n + 1] / dt
    work[last] = 0.0
    work[0] += housing.momentum
    work[1] += momentum_rate(p, housing.way) * dt
    # The derivatives that are known to be zero are set to zero, without rounding; Newmark's step has no jerk.
    if housing.power >= BY_ACCELERATION:
        work[0] = 0.0
    if housing.power == BY_JERK and last > NEWMARK_DEGREE:
        work[1] = 0.0


@jit
def fill_acceleration(e, p, grid, frame, piece, state, span, dt, c, work) -> None:
    """Fill work, (c.size,), with the polynomial of x'' on the piece of c, by the forces on the mass.

    span : length of Newmark's step, in dt, over which its force is linear.
    """
    share, last = 1.0 / (dt * dt), c.size - 1
    if grid.exact is not None:
        for n in range(last - 1):
            work[n] = frame.sigma * share * (n + 2) * (n + 1) * c[n + 2]
        work[last - 1], work[last] = 0.0, 0.0
        return
    first, end, second = 0.0, 0.0, e.second_harmonic
    if e.forcing is not None:
        first = force_value(force_at(p, frame.sigma, phase_at(grid, state), second), second)
        turn = (state.step + state.theta + span) / grid.steps
        end = force_value(force_at(p, frame.sigma, turn, second), second)
    stiffness, damping = piece.stiffness, piece.damping / dt
    work[0] = frame.sigma * (first + piece.load - stiffness * c[0] - damping * c[1])
    work[1] = frame.sigma * ((end - first) / span - stiffness * c[1] - 2.0 * damping * c[2])
    work[2] = -frame.sigma * stiffness * c[2]


@jit
def slip_offset(p, is_up) -> float:
    """Return the force that a held housing stands more until it slips up or down, where x'' = 0."""
    load = total_load(p)
    return p.housing_friction_1 - load if is_up else p.housing_friction_2 + load


@jit_inline
def first_housing_event(e, p, grid, state, step, c, log):
    """Locate the first event of the housing, if there is one, as `piece_events.first_event` does."""
    span, dt, counts = step.span, step.dt, log.counts
    if log.pieces.housing is None:
        return span, 0, NONE
    housing, work = state.housing, log.pieces.housing.work
    power = housing.power
    if housing.way != STANDS:
        fill_speed(p, step.frame.sigma, housing, c, dt, work)
        if grid.exact is None:
            power = min(power, BY_ACCELERATION)
        theta, kind = crossing(work, power, float(housing.way), 0.0, 0.0, span, counts)
        return theta, 0 if kind == NONE else STOP, kind
    theta, event, kind = span, 0, NONE
    if power == UNWATCHED or p.mass_ratio == 0.0:
        return theta, event, kind
    fill_acceleration(e, p, grid, step.frame, step.piece, state, span, dt, c, work)
    for way in (SLIP_UP, SLIP_DOWN):
        is_up = way == SLIP_UP
        sign, offset = 1.0 if is_up else -1.0, slip_offset(p, is_up)
        other, other_kind = crossing(work, power, sign, offset, 0.0, span, counts)
        if other_kind == STRIDE_LIMIT:
            return other, way, other_kind
        if other_kind == GRAZING and other <= SAME_TOUCH:
            other_kind = NONE
        if other_kind != NONE and (kind == NONE or other < theta):
            theta, kind = other, other_kind
            event = way if kind == CROSSING else TOUCHES
    return theta, event, kind


@jit
def housing_margin(e, p, grid, state, step, event, length, c, log):
    """Return what falls to zero at an event of the housing, with its slope, at the end of a step of Newmark's method.

    length : of the step, which c is the polynomial of, in step.dt. Without a housing the margin is 0.
    """
    if log.pieces.housing is None:
        return 0.0, 0.0
    work, dt = log.pieces.housing.work, step.dt
    sign, offset = float(state.housing.way), 0.0
    if event == STOP:
        fill_speed(p, step.frame.sigma, state.housing, c, dt, work)
    else:
        fill_acceleration(e, p, grid, step.frame, step.piece, state, length, dt, c, work)
        sign, offset = 1.0 if event == SLIP_UP else -1.0, slip_offset(p, event == SLIP_UP)
    value, slope, _curvature, _third = gap(work, 0, sign, offset, length)
    return value, slope


@jit_inline
def largest_housing_speed(log, p, sigma, housing, c, dt, theta) -> float:
    """Return the largest speed of a housing on a piece from 0 to theta; log : `HousingLog`, or None without one."""
    if log is None:
        return 0.0
    if housing.way == STANDS:
        return 0.0
    work = log.work
    fill_speed(p, sigma, housing, c, dt, work)
    return largest_value(work, float(housing.way), theta)


@jit
def stop_wait(p, housing) -> float:
    """Return the time after which a housing stops whose mass lies still in it; NEVER without one or if it does not.

    The last flights of a chatter may push it by less than their rounding, so that it has stopped before: 0.
    """
    if housing is None:
        return NEVER
    rate = momentum_rate(p, housing.way)
    if housing.way == STANDS or not housing.way * rate < 0.0:
        return NEVER
    return max(0.0, -housing.momentum / rate)


@jit_inline
def until_stop(effect, p, grid, state, end):
    """Return the `Instant` at which the housing of a mass that lies still in it stops, or `end` if that is earlier.

    effect : that of a housing; None has `end`.
    """
    if effect is None:
        return end
    wait = stop_wait(p, state.housing)
    if wait < NEVER:
        at = advance_time(grid, state, wait / (grid.steps * grid.dt))
        if is_before(at, end):
            return at
    return end


@jit_inline
def is_about_to_move(housing) -> bool:
    """Return whether a housing leaves zero velocity; not without one."""
    if housing is None:
        return False
    return housing.way != STANDS and housing.power != MOVES


@jit_inline
def is_held_a_step(housing) -> bool:
    """Return whether a housing is held within a step of the grid, whatever the force; not without one."""
    if housing is None:
        return False
    return housing.power == UNWATCHED


@jit_inline
def keep_housing(log, samples, first, p, grid, state, housing, speed) -> None:
    """Log a housing at the end of a part of the last piece, which began in a state, and its samples from `first` on.

    Before the piece is extended. speed : the largest in that part.
    """
    record_housing(samples, log.counts, first, p, grid, state)
    extend_housing(log.pieces.housing, log.pieces.counts[PIECES] - 1, housing, speed)


@jit
def keep_still_housing(log, samples, first, p, grid, state, housing) -> None:
    """Log a housing as `keep_housing` does, while the mass lies still in it."""
    speed = max(still_speed(state.housing), still_speed(housing))
    keep_housing(log, samples, first, p, grid, state, housing, speed)


@jit
def still_speed(housing) -> float:
    """Return the speed of a housing in which the mass lies still; 0 without one."""
    if housing is None:
        return 0.0
    return 0.0 if housing.way == STANDS else abs(housing.momentum)


@jit_inline
def record_housing(samples, counts, first, p, grid, state) -> None:
    """Write velocity and displacement of the housing beside the samples from `first` on, on the piece of a state.

    Nothing without samples, or without a housing.
    """
    if samples is not None:
        fill_samples(samples.housing, samples, counts, first, p, grid, state)


@jit
def fill_samples(columns, samples, counts, first, p, grid, state) -> None:
    """Write what `record_housing` does into columns, (n, 2) or None."""
    if columns is None:
        return
    x = to_displacement(p, state.home, state.y)
    housing, share = state.housing, momentum_share(p)
    rate = momentum_rate(p, housing.way)
    for i in range(first, counts[SAMPLES]):
        step, left = sample_place(samples, grid.steps, i)
        theta = samples.start_theta + left / samples.per_period
        waited = samples.start_step + step - (state.period * grid.steps + state.step)
        after = (waited + (theta - state.theta)) * grid.dt
        if housing.way == STANDS:
            columns[i, 0], columns[i, 1] = 0.0, housing.displacement
            continue
        momentum = housing.momentum + rate * after
        columns[i, 0] = momentum - share * samples.velocity[i]
        drift = (housing.momentum + 0.5 * rate * after) * after
        columns[i, 1] = housing.displacement + drift - share * (samples.displacement[i] - x)
