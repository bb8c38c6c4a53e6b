"""Newton's method on n equations in n + 1 unknowns within a plane, regular at a fold, and the tangent there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit

# Newton iterations of a corrector; the step is too long if they do not suffice.
MAX_CORRECTIONS = 10
# Change of the weighted unknowns at which they are converged: the next would be below rounding. One that is small but
# decreases no more is rounding itself.
CONVERGED, STALLED = 1e-12, 1e-8
# Largest first change of a corrector, relative to the weighted unknowns: beyond it Newton's method leaves the curve.
MAX_CHANGE = 0.5
# What a Newton step says.
FAILED, GOES_ON, DONE = range(-1, 2)
# Stands in for a pivot that is zero: the solution is then large along the null vector, which is what is sought there.
MIN_PIVOT = 1e-300


class Work(NamedTuple):
    """Work arrays for `size` unknowns.

    matrix : (size, size) float, derivatives of the equations; its last row is for the plane. After a step its factors
    pivots : (size,) int
    rhs : (size,) float, values of the equations
    border : (size,) float, normal of the plane
    """

    matrix: np.ndarray
    pivots: np.ndarray
    rhs: np.ndarray
    border: np.ndarray


def new_work(size: int) -> Work:
    """Return work arrays for a number of unknowns."""
    rhs, border = np.zeros((2, size))
    return Work(np.zeros((size, size)), np.zeros(size, np.int64), rhs, border)


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


@jit
def predict(start, tangent, length, weights, border, u):
    """Fill u with the prediction of a step, and border with the normal of the plane across it.

    Returns the target: the plane is border . u = target.
    """
    target = length
    for k in range(u.size):
        border[k] = tangent[k] * weights[k] * weights[k]
        target += border[k] * start[k]
        u[k] = start[k] + length * tangent[k]
    return target


@jit
def verdict(change, previous):
    """Return what the weighted changes of a step and of the one before (infinite before the first) say of them."""
    if not change < MAX_CHANGE:
        return FAILED
    stalls = change <= STALLED and change >= 0.8 * previous
    return DONE if change <= CONVERGED or stalls else GOES_ON


@jit
def fill_tangent(weights, work, tangent) -> None:
    """Fill the unit tangent of the curve from the factors of the last step; it points along work.border."""
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
