"""The return map of a law, and the determinants of its cyclic system, whose zeros are folds and doublings."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.orbits.law.elimination import no_border, solve_cyclic
from vibropipe.orbits.law.equations import fill_blocks
from vibropipe.orbits.law.law import set_unknowns, width_of
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.saltation import product


@jit
def less_inverse_times(a, b11, b12, b21, b22):
    """Return -a^-1 b of 2 x 2 matrices as its elements by rows; b by its elements."""
    share = -1.0 / (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0])
    return (
        share * (a[1, 1] * b11 - a[0, 1] * b21),
        share * (a[1, 1] * b12 - a[0, 1] * b22),
        share * (a[0, 0] * b21 - a[1, 0] * b11),
        share * (a[0, 0] * b22 - a[1, 0] * b12),
    )


@jit
def transfer(blocks, i):
    """Return the derivative of the unknowns of event i by those of the event before, as its elements by rows."""
    before = blocks.before[i]
    return less_inverse_times(blocks.at[i], before[0, 0], before[0, 1], before[1, 0], before[1, 1])


@jit
def return_map(blocks):
    """Return the derivative of the return map of the first event, as its elements by rows, and its determinant.

    The determinant is a product: that of the elements would cancel next to a grazing.
    """
    m11, m12, m21, m22, determinant = 1.0, 0.0, 0.0, 1.0, 1.0
    for j in range(blocks.at.shape[0]):
        i = (j + 1) % blocks.at.shape[0]
        t11, t12, t21, t22 = transfer(blocks, i)
        m11, m12, m21, m22 = product(t11, t12, t21, t22, m11, m12, m21, m22)
        a, b = blocks.at[i], blocks.before[i]
        determinant *= b[0, 0] * b[1, 1] - b[0, 1] * b[1, 0]
        determinant /= a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    return (m11, m12, m21, m22), determinant


@jit_inline
def determinant_of(a, housing):
    """Return the determinant of a block."""
    least = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    if housing is None:
        return least
    total = a[2, 2] * least
    total += a[0, 2] * (a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0])
    return total - a[1, 2] * (a[0, 0] * a[2, 1] - a[0, 1] * a[2, 0])


@jit
def fill_cofactors(a, out) -> None:
    """Fill out with the cofactors of a matrix; both (3, 3)."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for m in range(3):
            r, s = (m + 1) % 3, (m + 2) % 3
            out[i, m] = a[j, r] * a[k, s] - a[j, s] * a[k, r]


@jit
def multiply(left, right, transposed, factor, out) -> None:
    """Fill out with left right, or with left transposed, times a factor; all (3, 3)."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += (left[k, i] if transposed else left[i, k]) * right[k, j]
            out[i, j] = factor * total


@jit_allocating
def return_map_of_three(before, at):
    """Return the derivative M of the return map of the first event beside a housing, its principal minors, and det M.

    M is (3, 3), with rows and columns of zeros for unknowns that an event has not. The sum of the minors is the trace
    of a product of cofactors, as the determinant is a product: those of M would cancel next to a grazing.
    """
    matrix, cofactors, determinant = np.eye(3), np.eye(3), 1.0
    own, one, two = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    n = at.shape[0]
    for step in range(n):
        i = (step + 1) % n
        scale = 1.0 / determinant_of(at[i], 1)
        determinant *= -determinant_of(before[i], 1) * scale
        multiply(before[i], matrix, False, -scale, one)
        fill_cofactors(at[i], own)
        multiply(own, one, True, 1.0, matrix)
        fill_cofactors(before[i], own)
        multiply(own, cofactors, False, scale, two)
        multiply(at[i], two, True, 1.0, cofactors)
    minors = cofactors[0, 0] + cofactors[1, 1] + cofactors[2, 2]
    return matrix, minors, determinant


@jit
def pair_share(trace, minors, determinant):
    """Return the product of 1 - a b over all pairs of three eigenvalues, bounded: 0 where a pair is on the unit circle.

    It is 0, too, where a and 1/a are eigenvalues.
    """
    value = 1.0 - minors + trace * determinant - determinant * determinant
    size = 1.0 + abs(minors) + abs(trace * determinant) + determinant * determinant
    return value / size if size < math.inf else 1.0


@jit_allocating
def cyclic_determinant(before, at, rest, wrap, housing):
    """Return sign and logarithm of the determinant of a cyclic system without borders, as `solve_cyclic`."""
    n, width = at.shape[0], width_of(housing)
    x, q = np.zeros((n, width)), np.zeros(0)
    return solve_cyclic(before, at, rest, wrap, no_border(n, width), x, q, housing)


@jit_allocating
def unit_and_doubling(before, at, rest, housing=None):
    """Return the shares of both determinants: zero at a fold, and where an orbit doubles or loses its symmetry.

    The sum of both is the determinant of the blocks times 2 (1 + det M), whose sign is taken from the blocks: next to
    a grazing both determinants cancel. With a housing, an int or None, it is that times 2 (1 + the principal minors).
    """
    signs, logs, flips = np.empty(2), np.empty(2), 1.0
    for k in range(2):
        signs[k], logs[k] = cyclic_determinant(before, at, rest, 2.0 * k - 1.0, housing)
    for i in range(at.shape[0]):
        flips = math.copysign(flips, flips * determinant_of(at[i], housing))
    top = max(logs[0], logs[1])
    if not top > -math.inf:
        return 0.0, 0.0
    doubling, unit = math.exp(logs[0] - top), math.exp(logs[1] - top)
    total = flips * (doubling + unit)
    return signs[1] * unit / total, signs[0] * doubling / total


@jit_allocating
def condition(blocks, wrap, slow, housing=None):
    """Return det(1 - wrap M) of the return map M times the determinant of the block of one event; none where slow < 0.

    M grows without bounds where an impact loses its speed, as 1 over the determinant of its block: times this the
    condition of a boundary, and its derivatives, are finite there and have no other zero.
    """
    sign, log = cyclic_determinant(blocks.before, blocks.at, blocks.rest, wrap, housing)
    for i in range(blocks.at.shape[0]):
        if i != slow:
            own = determinant_of(blocks.at[i], housing)
            sign = math.copysign(sign, sign * own)
            log -= math.log(abs(own))
    return sign * math.exp(log)


@jit_allocating
def fill_slopes(e, values, along, law, u, blocks, steps, wrap, slow, slope) -> None:
    """Fill the derivatives of a `condition` by all unknowns, as central differences.

    values : (1, parameters), of the exciter; those at `along` (k,) are set
    along : (k,) int
    u : (w n + k,), times, what is free of the states, and parameters
    blocks : without parameters; overwritten
    steps, slope : (w n + k,)
    """
    n, columns = law.codes.shape[0], np.zeros(0, np.int64)
    events = np.empty((n, width_of(e.housing)))
    for k in range(u.size):
        ends = 0.0
        for sign in (1.0, -1.0):
            set_unknowns(values, along, u, events, k, sign * steps[k])
            fill_blocks(e, row_parameters(values, 0), law, events, columns, blocks)
            ends += sign * condition(blocks, wrap, slow, e.housing)
        slope[k] = ends / (2.0 * steps[k])
