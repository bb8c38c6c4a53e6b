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

# Columns of a panel: of x[i], x[i + 1], the last x, and the further unknowns, with the right-hand side behind them; and
# its rows of one block and of the next. They are numpy integers because numba compiles another copy of a kernel for
# each literal constant.
OWN, NEXT, TOP, FURTHER = map(np.int64, (0, 2, 4, 6))
FIRST, SECOND = map(np.int64, (0, 2))


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


@jit
def _load(panel, row, at, by, rest, i, column) -> None:
    """Fill two rows of a panel with block row i, its own block from a column on."""
    k = by.shape[2]
    for r in range(2):
        for c in range(2):
            panel[row + r, column + c] = at[i, r, c]
        for c in range(k):
            panel[row + r, FURTHER + c] = by[i, r, c]
        panel[row + r, FURTHER + k] = rest[i, r]


@jit
def _begin(panel, before, at, by, rest, wrap) -> None:
    """Fill the first two rows of a panel with the first block row, whose block `before` acts on the last x."""
    _load(panel, FIRST, at, by, rest, FIRST, OWN)
    for row in range(2):
        for c in range(2):
            panel[row, TOP + c] = wrap * before[0, row, c]


@jit
def _reduce(panel, before, at, by, rest, i) -> None:
    """Join block row i + 1 to what is left of the rows before it, and eliminate x[i] from it."""
    _load(panel, SECOND, at, by, rest, i + 1, NEXT)
    for row in range(2):
        for c in range(2):
            panel[row, NEXT + c], panel[2 + row, TOP + c] = 0.0, 0.0
            panel[2 + row, OWN + c] = before[i + 1, row, c]
    for column in range(2):
        _reflect(panel, column)


@jit
def _carry(panel, kept, i) -> None:
    """Keep the two rows that give x[i], and carry the others on as those of x[i + 1]."""
    for row in range(2):
        for c in range(panel.shape[1]):
            kept[i, row, c] = panel[row, c]
            if c >= TOP:
                panel[row, c] = panel[2 + row, c]
        for c in range(2):
            panel[row, OWN + c] = panel[2 + row, NEXT + c]


@jit
def _reduce_borders(panel, border, ends, matrix, rhs, i) -> None:
    """Eliminate x[i] from the borders by the first two rows of a panel."""
    k = border.shape[0]
    for j in range(k):
        a = border[j, i, 0] / panel[0, 0]
        b = (border[j, i, 1] - a * panel[0, 1]) / panel[1, 1]
        for c in range(2):
            border[j, i + 1, c] -= a * panel[0, NEXT + c] + b * panel[1, NEXT + c]
            ends[j, c] -= a * panel[0, TOP + c] + b * panel[1, TOP + c]
        for c in range(k):
            matrix[2 + j, 2 + c] -= a * panel[0, FURTHER + c] + b * panel[1, FURTHER + c]
        rhs[2 + j] -= a * panel[0, FURTHER + k] + b * panel[1, FURTHER + k]


@jit
def _substitute_back(kept, x, q) -> None:
    """Fill x from its last block and q."""
    n, k = x.shape[0], q.size
    for i in range(n - 2, -1, -1):
        for row in range(1, -1, -1):
            total = kept[i, row, FURTHER + k]
            for c in range(2):
                total -= kept[i, row, NEXT + c] * x[i + 1, c] + kept[i, row, TOP + c] * x[n - 1, c]
            for c in range(k):
                total -= kept[i, row, FURTHER + c] * q[c]
            if row == 0:
                total -= kept[i, 0, 1] * x[i, 1]
            x[i, row] = total / kept[i, row, row]


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
    kept, panel = np.zeros((n, 2, FURTHER + k + 1)), np.zeros((4, FURTHER + k + 1))
    border, ends = np.zeros((k, n, 2)), np.zeros((k, 2))
    matrix, rhs = np.zeros((2 + k, 2 + k)), np.zeros(2 + k)
    for j in range(k):
        rhs[2 + j] = target[j]
        for c in range(k):
            matrix[2 + j, 2 + c] = corner[j, c]
        for i in range(n):
            for c in range(2):
                border[j, i, c] = borders[j, i, c]
    _begin(panel, before, at, by, rest, wrap)
    sign, log = 1.0, 0.0
    for i in range(n - 1):
        _reduce(panel, before, at, by, rest, i)
        one, two = panel[0, 0], panel[1, 1]
        if one == 0.0 or two == 0.0:
            return 0.0, -math.inf
        # Two reflections keep the sign of the determinant.
        sign *= math.copysign(1.0, one) * math.copysign(1.0, two)
        log += math.log(abs(one)) + math.log(abs(two))
        _reduce_borders(panel, border, ends, matrix, rhs, i)
        _carry(panel, kept, i)
    for row in range(2):
        rhs[row] = panel[row, FURTHER + k]
        for c in range(2):
            matrix[row, c] = panel[row, OWN + c] + panel[row, TOP + c]
        for c in range(k):
            matrix[row, 2 + c] = panel[row, FURTHER + c]
    for j in range(k):
        for c in range(2):
            matrix[2 + j, c] = border[j, n - 1, c] + ends[j, c]
    last_sign, last_log = _solve_dense(matrix, rhs)
    for c in range(2):
        x[n - 1, c] = rhs[c]
    for c in range(k):
        q[c] = rhs[2 + c]
    _substitute_back(kept, x, q)
    return sign * last_sign, log + last_log


@jit_allocating
def solve_columns(before, at, rest, x) -> None:
    """Solve a cyclic system without borders for some right-hand sides; NaN or inf where it is singular.

    Parameters
    ----------
    before, at : (n, 2, 2) float
    rest : (n, 2, sides) float
        Right-hand sides.
    x : (n, 2, sides) float
        Filled with the solutions.
    """
    n, sides = rest.shape[0], rest.shape[2]
    none, matrix, rhs = np.zeros((n, 2)), np.zeros((2, 2)), np.zeros(2)
    kept, panel = np.zeros((n, 2, FURTHER + sides + 1)), np.zeros((4, FURTHER + sides + 1))
    _begin(panel, before, at, rest, none, 1.0)
    for i in range(n - 1):
        _reduce(panel, before, at, rest, none, i)
        _carry(panel, kept, i)
    for side in range(sides):
        for row in range(2):
            rhs[row] = panel[row, FURTHER + side]
            for c in range(2):
                matrix[row, c] = panel[row, OWN + c] + panel[row, TOP + c]
        _solve_dense(matrix, rhs)
        x[n - 1, 0, side], x[n - 1, 1, side] = rhs[0], rhs[1]
        for i in range(n - 2, -1, -1):
            for row in range(1, -1, -1):
                own = kept[i, row]
                total = own[FURTHER + side]
                for c in range(2):
                    total -= own[NEXT + c] * x[i + 1, c, side] + own[TOP + c] * x[n - 1, c, side]
                if row == 0:
                    total -= own[1] * x[i, 1, side]
                x[i, row, side] = total / own[row]
