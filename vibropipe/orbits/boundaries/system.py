"""The equations of a boundary: an orbit by its impacts, and the condition that makes it a bifurcation.

Unknowns are the times and velocities of the impacts of a sequence, at a grazing the time at which a flight touches a
support, and two parameters. A boundary is a curve of zeros of one equation less.

Conditions: fold det(D - 1) = 0, flip and pitchfork det(D + 1) = 0 with the derivative D of the return map (of a
symmetric orbit, of the map to its mirror image), each multiplied by all impact velocities, which makes them smooth
where an impact loses its speed; grazing: gap and velocity of the flight are zero at the time of touch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.continuation.curve import CROSSING, FOLD
from vibropipe.continuation.newton import DONE, GOES_ON, MAX_CORRECTIONS, fill_tangent, newton_step
from vibropipe.orbits.branches.clearance import clearance, flight_clearance
from vibropipe.orbits.branches.sequence import fill_equations, next_impact
from vibropipe.orbits.law.steps import (
    DETERMINANT,
    DOUBLING,
    GAP,
    GAP_FLIGHT,
    GAP_SIDE,
    GAP_TIME,
    SLOWEST,
    SPEED,
    TRACE,
    UNIT,
)
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.contact import restitution_at, support_offset, support_position
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.forced_flow import acceleration, fly_freely
from vibropipe.physics.linear import steady_at
from vibropipe.physics.load import forcing_period, has_second
from vibropipe.physics.saltation import product

# Kinds of boundaries, as `Bifurcation` numbers them, and curves on which a quantity has a value.
FOLDS, FLIPS, PITCHFORKS, GRAZINGS, LEVELS = range(5)
KINDS = {"fold": FOLDS, "flip": FLIPS, "pitchfork": PITCHFORKS, "grazing": GRAZINGS}
# Step of the central differences by both parameters, relative. It affects the speed of convergence and the tangent.
DIFFERENCE = 1e-5
# Step of the central differences of a condition, weighted. It affects the speed of convergence alone.
CONDITION_DIFFERENCE = 1e-6
# A touching flight is looked at up to this time before its touch, in forcing periods.
BEFORE_TOUCH = 1e-7


class Room(NamedTuple):
    """Work arrays: a Jacobian without rows, and the coefficients of a flight."""

    none: np.ndarray
    c: np.ndarray


def new_room() -> Room:
    """Return work arrays of an orbit."""
    return Room(np.zeros((0, 0)), np.zeros(DEGREE + 1))


class Sought(NamedTuple):
    """What is solved for.

    values : (1, parameters), parameters of the exciter; those at `along` (2,) are set
    along : (2,) int
    kind : kind of the boundary
    span, mirrored, supports : as in `Sequence`; without impacts, the linear motion
    flight, side : of a grazing: the flight that touches, and the support
    """

    values: np.ndarray
    along: np.ndarray
    kind: int
    span: float
    mirrored: int
    supports: np.ndarray
    flight: int
    side: int
    room: Room


@jit
def parameters_of_point(values, along, u):
    """Return the `Parameters` of values (1, n) with both that vary set to the last unknowns, which are stored."""
    values[0, along[0]] = u[u.size - 2]
    values[0, along[1]] = u[u.size - 1]
    return row_parameters(values, 0)


@jit
def scaled_derivative(p, sought, u, speed):
    """Return trace, determinant and scale of the return map's derivative over a sequence.

    Returns (trace, determinant, scale): the trace times `scale`, which is finite where an impact has no speed; `scale`
    is the product of the impact speeds over `speed`.
    """
    span, mirrored, supports = sought.span, sought.mirrored, sought.supports
    n, j11, j12, j21, j22 = supports.size, 1.0, 0.0, 0.0, 1.0
    determinant, scale = math.exp(-p.h * span * forcing_period(p)), 1.0
    for i in range(n):
        _j, end, _velocity, _support, _sign = next_impact(span, mirrored, supports, u, i)
        x, restitution, before = (
            support_position(p, supports[i]), restitution_at(p, supports[i]), u[n + i],
        )  # fmt: skip
        towards = 1.0 if supports[i] == 1 else -1.0
        size = towards * before / speed
        after = -restitution * before
        # The saltation matrix times the speed.
        shear = acceleration(p, x, after, u[i]) + restitution * acceleration(p, x, before, u[i])
        diagonal = -restitution * size
        j11, j12, j21, j22 = product(
            diagonal, 0.0, towards * shear / speed, diagonal, j11, j12, j21, j22
        )
        _x, _v, e11, e12, e21, e22 = fly_freely(p, u[i], end, x, after)
        j11, j12, j21, j22 = product(e11, e12, e21, e22, j11, j12, j21, j22)
        determinant *= restitution * restitution
        scale *= size
    trace = j11 + j22
    return (-trace if mirrored == 1 else trace), determinant, scale


@jit
def condition(p, sought, u, speed):
    """Return the condition of a boundary: two numbers, of which only a grazing has the second.

    u : (size,), unknowns
    speed : scale of velocities
    """
    n = sought.supports.size
    if sought.kind == GRAZINGS:
        flight, time = sought.flight, u[2 * n]
        if n == 0:
            x, v = steady_at(p, time)
        else:
            support = sought.supports[flight]
            x, v = support_position(p, support), -restitution_at(p, support) * u[n + flight]
            x, v, _e11, _e12, _e21, _e22 = fly_freely(p, u[flight], time, x, v)
        return (x - support_position(p, sought.side)) / p.l, v / speed
    trace, determinant, scale = scaled_derivative(p, sought, u, speed)
    return scale * (1.0 + determinant) + (-trace if sought.kind == FOLDS else trace), 0.0


@jit
def _fill_system(sought, u, weights, work) -> None:
    """Fill the rows of the equations of work.matrix, and work.rhs with their values, at u."""
    span, mirrored, supports = sought.span, sought.mirrored, sought.supports
    size, n = u.size, supports.size
    speed = 1.0 if n == 0 else 1.0 / weights[n]
    p = parameters_of_point(sought.values, sought.along, u)
    fill_equations(p, span, mirrored, supports, u, work.rhs, work.matrix)
    first, second = condition(p, sought, u, speed)
    work.rhs[2 * n] = first
    if sought.kind == GRAZINGS:
        work.rhs[2 * n + 1] = second
    for k in range(size):
        held, reach = u[k], 1.0 / weights[k]
        is_parameter = k >= size - 2
        share = DIFFERENCE if is_parameter else CONDITION_DIFFERENCE
        step = share * (max(min(reach, abs(held)), 0.01 * reach) if is_parameter else reach)
        u[k] = held + step
        p = parameters_of_point(sought.values, sought.along, u)
        above, above_second = condition(p, sought, u, speed)
        if is_parameter:
            fill_equations(p, span, mirrored, supports, u, work.above, sought.room.none)
        u[k] = held - step
        p = parameters_of_point(sought.values, sought.along, u)
        below, below_second = condition(p, sought, u, speed)
        if is_parameter:
            fill_equations(p, span, mirrored, supports, u, work.below, sought.room.none)
        u[k] = held
        work.matrix[2 * n, k] = (above - below) / (2.0 * step)
        if sought.kind == GRAZINGS:
            work.matrix[2 * n + 1, k] = (above_second - below_second) / (2.0 * step)
        if k >= 2 * n:
            for row in range(2 * n):
                change = work.above[row] - work.below[row] if is_parameter else 0.0
                work.matrix[row, k] = change / (2.0 * step)


@jit
def _touching_clearance(p, sought, u, c):
    """Return the clearance of an orbit that touches a support, but for that touch; as `clearance`."""
    span, mirrored, supports, side = sought.span, sought.mirrored, sought.supports, sought.side
    n, touch = supports.size, u[2 * supports.size]
    if n == 0 and has_second(p):
        # From one touch to the next.
        until = touch + 1.0 - BEFORE_TOUCH
        gap, time, support = flight_clearance(p, touch, until, side, 0.0, c)
        return gap, time, support, -1
    if n == 0:
        sign = 1.0 if side == 1 else -1.0
        # Without an offset the linear motion touches both supports at once.
        offset = support_offset(p)
        other = 2.0 * p.l if offset == 0.0 else -2.0 * sign * offset
        return min(other, sign * support_position(p, side)), 0.0, 3 - side, -1
    gap, time, support, at = 2.0 * p.l, 0.0, 0, -1
    for i in range(n):
        _j, end, _velocity, _support, _sign = next_impact(span, mirrored, supports, u, i)
        v, leaves = -restitution_at(p, supports[i]) * u[n + i], int(supports[i])
        if i == sought.flight:
            start, until = u[i], touch - BEFORE_TOUCH
            if until > start:
                here, when, which = flight_clearance(p, start, until, leaves, v, c)
                if here < gap:
                    gap, time, support, at = here, when, which, i
            here, when, which = flight_clearance(p, touch, end, side, 0.0, c)
        else:
            here, when, which = flight_clearance(p, u[i], end, leaves, v, c)
        if here < gap:
            gap, time, support, at = here, when, which, i
    return gap, time, support, at


@jit
def _finish(sought, u, weights, work, tangent, tests) -> None:
    """Fill the tangent of a corrected point, and its test functions (TESTS,), named as those of a branch.

    UNIT and DOUBLING, det(D - 1) and det(D + 1), are those of the orbit that grazes; on other boundaries they are 1.
    GAP leaves out the touch of a grazing.
    """
    fill_tangent(weights, work, tangent)
    p = parameters_of_point(sought.values, sought.along, u)
    supports, grazes = sought.supports, sought.kind == GRAZINGS
    n = supports.size
    if grazes:
        gap, time, support, at = _touching_clearance(p, sought, u, sought.room.c)
    else:
        gap, time, support, at = clearance(
            p, sought.span, sought.mirrored, supports, u, sought.room.c
        )
    tests[GAP], tests[GAP_TIME], tests[GAP_SIDE], tests[GAP_FLIGHT] = gap / p.l, time, support, at
    tests[FOLD], tests[CROSSING] = tangent[u.size - 1] * weights[u.size - 1], 0.0
    tests[UNIT], tests[DOUBLING], tests[TRACE], tests[DETERMINANT] = 1.0, 1.0, 0.0, 0.0
    tests[SPEED], tests[SLOWEST] = 1.0, -1.0
    if n > 0:
        trace, determinant, scale = scaled_derivative(p, sought, u, 1.0 / weights[n])
        if grazes:
            size = abs(scale) * (1.0 + determinant) + abs(trace)
            tests[UNIT] = (scale * (1.0 + determinant) - trace) / size
            tests[DOUBLING] = (scale * (1.0 + determinant) + trace) / size
        tests[TRACE] = trace / scale if scale != 0.0 else math.inf
        tests[DETERMINANT] = determinant
    for i in range(n):
        speed = (u[n + i] if supports[i] == 1 else -u[n + i]) * weights[n + i]
        if i == 0 or speed < tests[SPEED]:
            tests[SPEED], tests[SLOWEST] = speed, i


@jit
def solve(sought, u, target, weights, work, tangent, tests) -> bool:
    """Correct u, in place, to the boundary in the plane work.border . u = target; return whether there is one.

    Tangent (size,) and test functions (TESTS,) are filled; arguments as of `vibropipe.orbits.law.steps.solve`.
    """
    work.last[0] = math.inf
    for _ in range(MAX_CORRECTIONS):
        _fill_system(sought, u, weights, work)
        said = newton_step(u, target, weights, work)
        if said == DONE:
            _finish(sought, u, weights, work, tangent, tests)
        if said != GOES_ON:
            return said == DONE
    return False
