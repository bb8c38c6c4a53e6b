"""Cyclic systems of 2 x 2 blocks with borders, solved by orthogonal elimination in a time proportional to their number.

Row i is before[i] x[i - 1] + at[i] x[i] + by[i] q = rest[i]; before[0], times a factor, acts on the last x. Borders are
further equations for the k further unknowns q. Products of transfers would lose all digits of what grows along an
orbit, and a block is singular where an impact has no velocity: the system is not.

References
----------
S. J. Wright, "Stable parallel algorithms for two-point boundary value problems", SIAM Journal on Scientific and
Statistical Computing 13 (1992) 742-764 (structured orthogonal elimination).
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating


@jit
def _reflect(panel, column) -> None:
    """Reflect the rows of a panel from `column` on so that those below it are zero in this column."""
    rows, columns = panel.shape
    norm = 0.0
    for i in range(column, rows):
        norm += panel[i, column] * panel[i, column]
    if norm == 0.0:
        return
    head = panel[column, column]
    length = -math.copysign(math.sqrt(norm), head)
    first = head - length
    scale = first * length
    if scale == 0.0:
        return
    for j in range(column + 1, columns):
        total = first * panel[column, j]
        for i in range(column + 1, rows):
            total += panel[i, column] * panel[i, j]
        total /= scale
        panel[column, j] += total * first
        for i in range(column + 1, rows):
            panel[i, j] += total * panel[i, column]
    panel[column, column] = length
    for i in range(column + 1, rows):
        panel[i, column] = 0.0


@jit
def _solve_dense(matrix, rhs):
    """Solve a small system in place by elimination with row pivoting; return sign and logarithm of its determinant."""
    size, sign, log = rhs.size, 1.0, 0.0
    for j in range(size):
        pivot = j
        for i in range(j + 1, size):
            if abs(matrix[i, j]) > abs(matrix[pivot, j]):
                pivot = i
        if matrix[pivot, j] == 0.0:
            return 0.0, -math.inf
        if pivot != j:
            sign = -sign
            for c in range(size):
                matrix[j, c], matrix[pivot, c] = matrix[pivot, c], matrix[j, c]
            rhs[j], rhs[pivot] = rhs[pivot], rhs[j]
        sign *= math.copysign(1.0, matrix[j, j])
        log += math.log(abs(matrix[j, j]))
        for i in range(j + 1, size):
            factor = matrix[i, j] / matrix[j, j]
            for c in range(j, size):
                matrix[i, c] -= factor * matrix[j, c]
            rhs[i] -= factor * rhs[j]
    for j in range(size - 1, -1, -1):
        for c in range(j + 1, size):
            rhs[j] -= matrix[j, c] * rhs[c]
        rhs[j] /= matrix[j, j]
    return sign, log


@jit_allocating
def solve_cyclic(before, at, by, rest, wrap, borders, corner, target, x, q):
    """Solve a bordered cyclic system.

    Parameters
    ----------
    before, at : (n, 2, 2) float
    by : (n, 2, k) float
    rest : (n, 2) float
        Right-hand side.
    wrap : float
        Factor of before[0].
    borders : (k, n, 2) float
        Rows of the borders: the sum of borders[j] x + corner[j] q = target[j].
    corner : (k, k) float
    target : (k,) float
    x : (n, 2) float
        Filled with the solution.
    q : (k,) float
        Filled with the further unknowns.

    Returns
    -------
    sign, log : float
        Of the determinant; (0, -inf) where the system is singular.
    """
    n, k = at.shape[0], q.size
    next_, top, further = 2, 4, 6
    kept = np.zeros((n, 2, further + k + 1))
    panel = np.zeros((4, further + k + 1))
    border, ends = borders.copy(), np.zeros((k, 2))
    q_rows, values = corner.copy(), target.copy()
    sign, log = 1.0, 0.0
    panel[:2, top:further] = wrap * before[0]
    panel[:2, :2] = at[0]
    panel[:2, further : further + k] = by[0]
    panel[:2, further + k] = rest[0]
    for i in range(n - 1):
        panel[2:] = 0.0
        panel[:2, next_:top] = 0.0
        panel[2:, :2] = before[i + 1]
        panel[2:, next_:top] = at[i + 1]
        panel[2:, further : further + k] = by[i + 1]
        panel[2:, further + k] = rest[i + 1]
        _reflect(panel, 0)
        _reflect(panel, 1)
        kept[i] = panel[:2]
        one, two = panel[0, 0], panel[1, 1]
        if one == 0.0 or two == 0.0:
            return 0.0, -math.inf
        # A reflection changes the sign of the determinant, twice that of nothing.
        sign *= math.copysign(1.0, one) * math.copysign(1.0, two)
        log += math.log(abs(one)) + math.log(abs(two))
        for j in range(k):
            a = border[j, i, 0] / one
            b = (border[j, i, 1] - a * panel[0, 1]) / two
            for c in range(2):
                border[j, i + 1, c] -= a * panel[0, next_ + c] + b * panel[1, next_ + c]
                ends[j, c] -= a * panel[0, top + c] + b * panel[1, top + c]
            for c in range(k):
                q_rows[j, c] -= a * panel[0, further + c] + b * panel[1, further + c]
            values[j] -= a * panel[0, further + k] + b * panel[1, further + k]
        panel[:2, :2] = panel[2:, next_:top]
        panel[:2, top:] = panel[2:, top:]
    matrix, rhs = np.zeros((2 + k, 2 + k)), np.zeros(2 + k)
    matrix[:2, :2] = panel[:2, :2] + panel[:2, top:further]
    matrix[:2, 2:] = panel[:2, further : further + k]
    rhs[:2] = panel[:2, further + k]
    matrix[2:, :2] = border[:, n - 1] + ends
    matrix[2:, 2:] = q_rows
    rhs[2:] = values
    last_sign, last_log = _solve_dense(matrix, rhs)
    x[n - 1], q[:] = rhs[:2], rhs[2:]
    for i in range(n - 2, -1, -1):
        for row in range(1, -1, -1):
            total = kept[i, row, further + k]
            for c in range(2):
                total -= kept[i, row, next_ + c] * x[i + 1, c] + kept[i, row, top + c] * x[n - 1, c]
            for c in range(k):
                total -= kept[i, row, further + c] * q[c]
            if row == 0:
                total -= kept[i, 0, 1] * x[i, 1]
            x[i, row] = total / kept[i, row, row]
    return sign * last_sign, log + last_log
