"""Dense linear systems with one border row: factors by partial pivoting, without exceptions."""

from __future__ import annotations

from vibropipe.compiler import jit

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
