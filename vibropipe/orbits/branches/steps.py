"""Pseudo-arclength continuation of an impact sequence: one step, and the test functions of a point.

Unknowns are the impact times, the impact velocities and the parameter. A step predicts along the tangent and corrects
by Newton's method in the plane across it, which is regular at a fold. Its linear systems have one border row.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.orbits.branches.clearance import clearance
from vibropipe.orbits.branches.sequence import fill_equations, parameters_at, return_derivative

# Stands in for a pivot that is zero: the solution is then large along the null vector, which is what is sought there.
MIN_PIVOT = 1e-300


@jit
def factorise(a, pivots) -> None:
    """Replace a (size, size) by its factors L U with partial pivoting; pivots (size,) int receives the rows.

    References
    ----------
    G. H. Golub, C. F. Van Loan, "Matrix Computations", 4th ed., Johns Hopkins (2013), sec. 3.4.
    """
    size = pivots.size
    for k in range(size):
        pivot = k
        for row in range(k + 1, size):
            if abs(a[row, k]) > abs(a[pivot, k]):
                pivot = row
        pivots[k] = pivot
        if pivot != k:
            for column in range(size):
                a[k, column], a[pivot, column] = a[pivot, column], a[k, column]
        if a[k, k] == 0.0:
            a[k, k] = MIN_PIVOT
        for row in range(k + 1, size):
            factor = a[row, k] / a[k, k]
            a[row, k] = factor
            if factor != 0.0:
                for column in range(k + 1, size):
                    a[row, column] -= factor * a[k, column]


@jit
def solve_factorised(a, pivots, b) -> None:
    """Replace b (size,) by the solution of the system with the factors of `factorise`."""
    size = pivots.size
    for k in range(size):
        pivot = pivots[k]
        if pivot != k:
            b[k], b[pivot] = b[pivot], b[k]
    for k in range(size):
        for row in range(k + 1, size):
            b[row] -= a[row, k] * b[k]
    for k in range(size - 1, -1, -1):
        for column in range(k + 1, size):
            b[k] -= a[k, column] * b[column]
        b[k] /= a[k, k]


# Newton iterations of a corrector; the step is too long if they do not suffice.
MAX_CORRECTIONS = 10
# Change of the weighted unknowns at which they are converged: the next would be below rounding. One that is small but
# decreases no more is rounding itself.
CONVERGED, STALLED = 1e-12, 1e-8
# Largest first change of a corrector, relative to the weighted unknowns: beyond it Newton's method leaves the branch.
MAX_CHANGE = 0.5
# Step of the central difference by the parameter. It affects the speed of convergence and the tangent, not the orbit.
DIFFERENCE = 1e-5
# Test functions of a point. FOLD: component of the tangent along the parameter. DOUBLING: det(D + 1) of the return
# map's derivative D, bounded (a flip; of a mirrored sequence a pitchfork). GAP: least distance from a support at a
# turning point, as a share of l. SPEED: least impact velocity towards its support, weighted. What follows says where.
# CROSSING: determinant of the equations bordered by the tangent, zero where branches cross; an impact sequence does not
# need it.
FOLD, DOUBLING, GAP, SPEED, TRACE, DETERMINANT, GAP_TIME, GAP_SIDE, GAP_FLIGHT, SLOWEST = range(10)
CROSSING, TESTS = 10, 11


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
    """

    values: np.ndarray
    along: int
    span: float
    mirrored: int
    supports: np.ndarray


class Work(NamedTuple):
    """Work arrays for sequences of n impacts, size 2n + 1."""

    matrix: np.ndarray
    pivots: np.ndarray
    rhs: np.ndarray
    above: np.ndarray
    below: np.ndarray
    border: np.ndarray
    none: np.ndarray
    c: np.ndarray


@jit
def _fill_system(sought, u, weights, work) -> None:
    """Fill the rows of the equations of work.matrix, and work.rhs with their values, at u."""
    values, along, span, mirrored, supports = sought
    size = work.pivots.size
    value, reach = u[size - 1], 1.0 / weights[size - 1]
    step = DIFFERENCE * max(min(reach, abs(value)), 0.01 * reach)
    p = parameters_at(values, along, value + step)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.above, work.none)
    p = parameters_at(values, along, value - step)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.below, work.none)
    p = parameters_at(values, along, value)
    fill_equations(p, span, mirrored, supports, u, 1.0, work.rhs, work.matrix)
    for row in range(size - 1):
        work.matrix[row, size - 1] = (work.above[row] - work.below[row]) / (2.0 * step)


@jit
def correct_once(u, target, weights, work):
    """Take one Newton step of u, in place, for the equations in work.matrix and work.rhs within the plane of `correct`.

    Returns the largest weighted change; u is kept unless it is less than MAX_CHANGE.
    """
    size, across, change = u.size, -target, 0.0
    for column in range(size):
        work.matrix[size - 1, column] = work.border[column]
        across += work.border[column] * u[column]
    work.rhs[size - 1] = across
    factorise(work.matrix, work.pivots)
    solve_factorised(work.matrix, work.pivots, work.rhs)
    for k in range(size):
        change = max(change, abs(work.rhs[k] * weights[k]))
    if change < MAX_CHANGE:
        for k in range(size):
            u[k] -= work.rhs[k]
    return change


@jit
def correct(sought, u, target, weights, work):
    """Correct u, in place, to the orbit in the plane work.border . u = target.

    Parameters
    ----------
    sought : Sought
    u : (2n + 1,) float
        Times, velocities and the parameter.
    target : float
    weights : (2n + 1,) float
        Of the unknowns in norms.
    work : Work
        Leaves the factors of the last system.

    Returns
    -------
    int
        Newton iterations; -1 if they do not converge.
    """
    previous = math.inf
    for iteration in range(1, MAX_CORRECTIONS + 1):
        _fill_system(sought, u, weights, work)
        change = correct_once(u, target, weights, work)
        if not change < MAX_CHANGE:
            return -1
        if change <= CONVERGED or (change <= STALLED and change >= 0.8 * previous):
            parameters_at(sought.values, sought.along, u[u.size - 1])
            return iteration
        previous = change
    return -1


@jit
def fill_tangent(weights, work, tangent) -> None:
    """Fill the unit tangent of the branch from the factors of the last system; it points along work.border."""
    size, square = tangent.size, 0.0
    for k in range(size):
        tangent[k] = 0.0
    tangent[size - 1] = 1.0
    solve_factorised(work.matrix, work.pivots, tangent)
    for k in range(size):
        square += (tangent[k] * weights[k]) ** 2
    length = math.sqrt(square)
    for k in range(size):
        tangent[k] /= length


@jit
def _finish(sought, u, weights, work, tangent, tests) -> None:
    """Fill the tangent of a corrected point, and its test functions (TESTS,)."""
    fill_tangent(weights, work, tangent)
    values, along, span, mirrored, supports = sought
    n, last = supports.size, u.size - 1
    p = parameters_at(values, along, u[last])
    trace, determinant = return_derivative(p, span, mirrored, supports, u)
    gap, time, side, flight = clearance(p, span, mirrored, supports, u, work.c)
    tests[FOLD] = tangent[last] * weights[last]
    tests[DOUBLING] = (1.0 + trace + determinant) / (1.0 + abs(trace) + determinant)
    tests[GAP] = gap / p.l
    tests[TRACE], tests[DETERMINANT] = trace, determinant
    tests[GAP_TIME], tests[GAP_SIDE], tests[GAP_FLIGHT] = time, side, flight
    tests[SPEED], tests[CROSSING] = math.inf, 0.0
    for i in range(n):
        speed = (u[n + i] if supports[i] == 1 else -u[n + i]) * weights[n + i]
        if speed < tests[SPEED]:
            tests[SPEED], tests[SLOWEST] = speed, i


@jit
def predict(start, tangent, length, weights, work, u):
    """Fill u with the prediction of a step, and work.border; return the target of `correct`: the plane across it."""
    target = length
    for k in range(u.size):
        work.border[k] = tangent[k] * weights[k] * weights[k]
        target += work.border[k] * start[k]
        u[k] = start[k] + length * tangent[k]
    return target


@jit
def hold(fixed, work, u):
    """Fill work.border for a point whose unknown `fixed` (an index) is held; return the target of `correct`."""
    for k in range(u.size):
        work.border[k] = 0.0
    work.border[fixed] = 1.0
    return u[fixed]


@jit
def advance(sought, start, tangent, length, weights, work, u, new, tests):
    """Take one step along a branch.

    Parameters
    ----------
    sought, weights, work
        As for `correct`.
    start, tangent : (2n + 1,) float
        The point, and the unit tangent there.
    length : float
        Weighted length of the step; may be negative.
    u, new : (2n + 1,) float
        Filled with the point reached and its tangent.
    tests : (TESTS,) float
        Filled with its test functions.

    Returns
    -------
    int
        Newton iterations; -1 if the step failed.

    References
    ----------
    H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in: Applications of
    Bifurcation Theory, Academic Press (1977) 359-384.
    """
    target = predict(start, tangent, length, weights, work, u)
    iterations = correct(sought, u, target, weights, work)
    if iterations > 0:
        _finish(sought, u, weights, work, new, tests)
    return iterations


@jit
def settle_at(sought, fixed, weights, work, u, new, tests):
    """Correct u with the unknown `fixed` (an index) held, and fill its tangent, which increases it.

    Returns the Newton iterations; -1 if they do not converge. Other arguments as for `advance`.
    """
    iterations = correct(sought, u, hold(fixed, work, u), weights, work)
    if iterations > 0:
        _finish(sought, u, weights, work, new, tests)
    return iterations


@jit
def doubling_vector(sought, u, work, vector) -> None:
    """Fill vector (2n + 1,) with the perturbation that changes sign after `span`, where DOUBLING is zero.

    It is the null vector of the equations with that closure, by inverse iteration; its last entry is 0.
    """
    values, along, span, mirrored, supports = sought
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
