"""Points of the branch of an impact sequence, by Newton's method, and their test functions.

Unknowns are the impact times, the impact velocities and the parameter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.continuation.curve import CROSSING, FOLD, OWN_TESTS
from vibropipe.continuation.newton import (
    DONE,
    GOES_ON,
    MAX_CORRECTIONS,
    factorise,
    fill_tangent,
    newton_step,
    solve_factorised,
)
from vibropipe.orbits.branches.clearance import clearance
from vibropipe.orbits.branches.sequence import fill_equations, parameters_at, return_derivative
from vibropipe.physics.flow import DEGREE

# Step of the central difference by the parameter. It affects the speed of convergence and the tangent, not the orbit.
DIFFERENCE = 1e-5
# Test functions of a point beside FOLD (where the orbit of a branch folds) and CROSSING, which no impact sequence
# needs. DOUBLING: det(D + 1) of the return map's derivative D, bounded (a flip; of a mirrored sequence a pitchfork).
# UNIT: det(D - 1) alike, of boundaries. GAP: least distance from a support at a turning point, as a share of l. SPEED:
# least impact velocity towards its support, weighted. What follows says where.
DOUBLING, UNIT, GAP, SPEED, TRACE, DETERMINANT, GAP_TIME, GAP_SIDE, GAP_FLIGHT, SLOWEST, TESTS = (
    range(OWN_TESTS, OWN_TESTS + 11)
)


class Room(NamedTuple):
    """Work arrays: a Jacobian without rows, and the coefficients of a flight."""

    none: np.ndarray
    c: np.ndarray


def new_room() -> Room:
    """Return work arrays of an orbit."""
    return Room(np.zeros((0, 0)), np.zeros(DEGREE + 1))


class Sought(NamedTuple):
    """What is solved for.

    Attributes
    ----------
    values : (1, parameters) float
        Parameters of the exciter; the one at `along` is set.
    along : int
        Index of the parameter that varies.
    span, mirrored, supports
        As in `Sequence`.
    room : Room
    """

    values: np.ndarray
    along: int
    span: float
    mirrored: int
    supports: np.ndarray
    room: Room


@jit
def _fill_system(sought, u, weights, work) -> None:
    """Fill the rows of the equations of work.matrix, and work.rhs with their values, at u."""
    values, along, span, mirrored, supports, room = sought
    size = work.pivots.size
    value, reach = u[size - 1], 1.0 / weights[size - 1]
    step = DIFFERENCE * max(min(reach, abs(value)), 0.01 * reach)
    p = parameters_at(values, along, value + step)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.above, room.none)
    p = parameters_at(values, along, value - step)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.below, room.none)
    p = parameters_at(values, along, value)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.rhs, work.matrix)
    for row in range(size - 1):
        work.matrix[row, size - 1] = (work.above[row] - work.below[row]) / (2.0 * step)


@jit
def _finish(sought, u, weights, work, tangent, tests) -> None:
    """Fill the tangent of a corrected point, and its test functions (TESTS,)."""
    fill_tangent(weights, work, tangent)
    values, along, span, mirrored, supports, room = sought
    n, last = supports.size, u.size - 1
    p = parameters_at(values, along, u[last])
    trace, determinant = return_derivative(p, span, mirrored, supports, u)
    gap, time, side, flight = clearance(p, span, mirrored, supports, u, room.c)
    tests[FOLD] = tangent[last] * weights[last]
    tests[DOUBLING] = (1.0 + trace + determinant) / (1.0 + abs(trace) + determinant)
    tests[GAP] = gap / p.l
    tests[TRACE], tests[DETERMINANT] = trace, determinant
    tests[GAP_TIME], tests[GAP_SIDE], tests[GAP_FLIGHT] = time, side, flight
    tests[UNIT], tests[SPEED], tests[CROSSING] = 1.0, math.inf, 0.0
    for i in range(n):
        speed = (u[n + i] if supports[i] == 1 else -u[n + i]) * weights[n + i]
        if speed < tests[SPEED]:
            tests[SPEED], tests[SLOWEST] = speed, i


@jit
def solve(sought, u, target, weights, work, tangent, tests) -> bool:
    """Correct u, in place, to the orbit in the plane work.border . u = target; return whether there is one.

    Parameters
    ----------
    sought : Sought
    u : (2n + 1,) float
        Times, velocities and the parameter.
    target : float
    weights : (2n + 1,) float
        Of the unknowns in norms.
    work : Work
    tangent : (2n + 1,) float
        Filled with the unit tangent there, along the border.
    tests : (TESTS,) float
        Filled with its test functions.
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


@jit
def doubling_vector(sought, u, work, vector) -> None:
    """Fill vector (2n + 1,) with the perturbation that changes sign after `span`, where DOUBLING is zero.

    It is the null vector of the equations with that closure, by inverse iteration; its last entry is 0.
    """
    values, along, span, mirrored, supports, _room = sought
    size = u.size
    p = parameters_at(values, along, u[size - 1])
    fill_equations(p, span, mirrored, supports, u, -1.0, work.rhs, work.matrix)
    for k in range(size):
        work.matrix[k, size - 1] = 0.0
        work.matrix[size - 1, k] = 0.0
        vector[k] = 1.0 / (2.0 + k)
    work.matrix[size - 1, size - 1] = 1.0
    factorise(work.matrix, work.pivots)
    for _ in range(3):
        vector[size - 1] = 0.0
        solve_factorised(work.matrix, work.pivots, vector)
        largest = 0.0
        for k in range(size):
            largest = max(largest, abs(vector[k]))
        for k in range(size):
            vector[k] /= largest
