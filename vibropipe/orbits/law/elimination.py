"""Cyclic systems of small blocks with borders, solved by orthogonal elimination in a time proportional to their number.

Row i is before[i] x[i - 1] + at[i] x[i] + by[i] q = rest[i]; before[0], times a factor, acts on the last x. Borders are
further equations for the k further unknowns q. Blocks are w x w: 2 x 2 or, with a housing, 3 x 3 (`width_of`). Products
of transfers would lose all digits of what grows along an orbit, and a block is singular where an impact has no
velocity: the system is not.

References
----------
S. J. Wright, "Stable parallel algorithms for two-point boundary value problems", SIAM Journal on Scientific and
Statistical Computing 13 (1992) 742-764 (structured orthogonal elimination).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.orbits.law.law import width_of

# A panel has the rows of one block and of the next, and w columns each of x[i], x[i + 1] and the last x, then those of
# the further unknowns and the right-hand side. Its first row and column; a numpy integer because numba compiles another
# copy of a kernel for each literal constant.
FIRST = np.int64(0)


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
def _load(panel, row, at, by, rest, i, column, housing) -> None:
    """Fill the rows of a panel from one on with block row i, its own block from a column on."""
    k, width = by.shape[2], width_of(housing)
    further = 3 * width
    for r in range(width):
        for c in range(width):
            panel[row + r, column + c] = at[i, r, c]
        for c in range(k):
            panel[row + r, further + c] = by[i, r, c]
        panel[row + r, further + k] = rest[i, r]


@jit
def _begin(panel, before, at, by, rest, wrap, housing) -> None:
    """Fill the first rows of a panel with the first block row, whose block `before` acts on the last x."""
    _load(panel, FIRST, at, by, rest, FIRST, FIRST, housing)
    width = width_of(housing)
    for row in range(width):
        for c in range(width):
            panel[row, 2 * width + c] = wrap * before[0, row, c]


@jit
def _reduce(panel, before, at, by, rest, i, housing) -> None:
    """Join block row i + 1 to what is left of the rows before it, and eliminate x[i] from it."""
    width = width_of(housing)
    _load(panel, width, at, by, rest, i + 1, width, housing)
    for row in range(width):
        for c in range(width):
            panel[row, width + c], panel[width + row, 2 * width + c] = 0.0, 0.0
            panel[width + row, c] = before[i + 1, row, c]
    for column in range(width):
        _reflect(panel, column)


@jit
def _carry(panel, kept, i, housing) -> None:
    """Keep the rows that give x[i], and carry the others on as those of x[i + 1]."""
    width = width_of(housing)
    for row in range(width):
        for c in range(panel.shape[1]):
            kept[i, row, c] = panel[row, c]
            if c >= 2 * width:
                panel[row, c] = panel[width + row, c]
        for c in range(width):
            panel[row, c] = panel[width + row, width + c]


@jit
def _reduce_borders(panel, border, ends, matrix, rhs, i, housing) -> None:
    """Eliminate x[i] from the borders by the first rows of a panel."""
    k, width = border.shape[0], width_of(housing)
    top, further = 2 * width, 3 * width
    for j in range(k):
        a = border[j, i, 0] / panel[0, 0]
        b, d = (border[j, i, 1] - a * panel[0, 1]) / panel[1, 1], 0.0
        if housing is not None:
            d = (border[j, i, 2] - a * panel[0, 2] - b * panel[1, 2]) / panel[2, 2]
        for c in range(width):
            border[j, i + 1, c] -= _share(panel, a, b, d, width + c, housing)
            ends[j, c] -= _share(panel, a, b, d, top + c, housing)
        for c in range(k):
            matrix[width + j, width + c] -= _share(panel, a, b, d, further + c, housing)
        rhs[width + j] -= _share(panel, a, b, d, further + k, housing)


@jit_inline
def _share(panel, a, b, d, column, housing):
    """Return the sum of the first rows of a panel times factors, in a column."""
    total = a * panel[0, column] + b * panel[1, column]
    if housing is not None:
        total += d * panel[2, column]
    return total


@jit_inline
def _solve_row(own, row, after, last, q, x, housing):
    """Return the unknown of a row of what `_carry` keeps, (w, columns), from those after it, the last ones and q."""
    k, width = q.size, width_of(housing)
    total = own[row, 3 * width + k]
    for c in range(width):
        total -= own[row, width + c] * after[c] + own[row, 2 * width + c] * last[c]
    for c in range(k):
        total -= own[row, 3 * width + c] * q[c]
    for c in range(row + 1, width):
        total -= own[row, c] * x[c]
    return total / own[row, row]


@jit
def _substitute_back(kept, x, q, housing) -> None:
    """Fill x from its last block and q."""
    n = x.shape[0]
    for i in range(n - 2, -1, -1):
        for row in range(width_of(housing) - 1, -1, -1):
            x[i, row] = _solve_row(kept[i], row, x[i + 1], x[n - 1], q, x[i], housing)


class Border(NamedTuple):
    """The further unknowns q of a cyclic system and their equations: the sum of rows[j] x + corner[j] q = target[j].

    by : (n, w, k), what q does to the blocks
    rows : (k, n, w)
    corner : (k, k)
    target : (k,)
    """

    by: np.ndarray
    rows: np.ndarray
    corner: np.ndarray
    target: np.ndarray


@jit_allocating
def no_border(n, width):
    """Return the `Border` without further unknowns of n blocks."""
    few = np.zeros(0)
    return Border(np.zeros((n, width, 0)), np.zeros((0, n, width)), np.zeros((0, 0)), few)


@jit_allocating
def solve_cyclic(before, at, rest, wrap, further, x, q, housing=None):
    """Solve a bordered cyclic system.

    before, at : (n, w, w)
    rest : (n, w), right-hand side
    wrap : factor of before[0]
    further : Border
    x : (n, w), filled with the solution
    q : (k,), filled with the further unknowns
    housing : the effect, with which w = 3; else 2

    Returns (sign, log) of the determinant; (0, -inf) where the system is singular.
    """
    n, k, width = at.shape[0], q.size, width_of(housing)
    by, borders, corner, target = further
    top, free = 2 * width, 3 * width
    kept, panel = np.zeros((n, width, free + k + 1)), np.zeros((top, free + k + 1))
    border, ends = np.zeros((k, n, width)), np.zeros((k, width))
    matrix, rhs = np.zeros((width + k, width + k)), np.zeros(width + k)
    for j in range(k):
        rhs[width + j] = target[j]
        for c in range(k):
            matrix[width + j, width + c] = corner[j, c]
        for i in range(n):
            for c in range(width):
                border[j, i, c] = borders[j, i, c]
    _begin(panel, before, at, by, rest, wrap, housing)
    sign, log = 1.0, 0.0
    for i in range(n - 1):
        _reduce(panel, before, at, by, rest, i, housing)
        size = 0.0
        for column in range(width):
            pivot = panel[column, column]
            if pivot == 0.0:
                return 0.0, -math.inf
            sign *= math.copysign(1.0, pivot)
            size += math.log(abs(pivot))
        log += size
        if housing is not None:
            sign = -sign  # each of three reflections changes it
        _reduce_borders(panel, border, ends, matrix, rhs, i, housing)
        _carry(panel, kept, i, housing)
    for row in range(width):
        rhs[row] = panel[row, free + k]
        for c in range(width):
            matrix[row, c] = panel[row, c] + panel[row, top + c]
        for c in range(k):
            matrix[row, width + c] = panel[row, free + c]
    for j in range(k):
        for c in range(width):
            matrix[width + j, c] = border[j, n - 1, c] + ends[j, c]
    last_sign, last_log = _solve_dense(matrix, rhs)
    for c in range(width):
        x[n - 1, c] = rhs[c]
    for c in range(k):
        q[c] = rhs[width + c]
    _substitute_back(kept, x, q, housing)
    return sign * last_sign, log + last_log


@jit_allocating
def solve_columns(before, at, rest, x, housing=None) -> None:
    """Solve a cyclic system without borders for some right-hand sides; NaN or inf where it is singular.

    before, at : (n, w, w)
    rest : (n, w, sides), right-hand sides
    x : (n, w, sides), filled with the solutions
    housing : as for `solve_cyclic`
    """
    n, sides, width = rest.shape[0], rest.shape[2], width_of(housing)
    none, matrix, rhs = np.zeros((n, width)), np.zeros((width, width)), np.zeros(width)
    further = 3 * width
    kept, panel = (
        np.zeros((n, width, further + sides + 1)),
        np.zeros((2 * width, further + sides + 1)),
    )
    _begin(panel, before, at, rest, none, 1.0, housing)
    for i in range(n - 1):
        _reduce(panel, before, at, rest, none, i, housing)
        _carry(panel, kept, i, housing)
    for side in range(sides):
        for row in range(width):
            rhs[row] = panel[row, further + side]
            for c in range(width):
                matrix[row, c] = panel[row, c] + panel[row, 2 * width + c]
        _solve_dense(matrix, rhs)
        for row in range(width):
            x[n - 1, row, side] = rhs[row]
        for i in range(n - 2, -1, -1):
            for row in range(width - 1, -1, -1):
                own = kept[i, row]
                total = own[further + side]
                for c in range(width):
                    after, last = x[i + 1, c, side], x[n - 1, c, side]
                    total -= own[width + c] * after + own[2 * width + c] * last
                for c in range(row + 1, width):
                    total -= own[c] * x[i, c, side]
                x[i, row, side] = total / own[row]
