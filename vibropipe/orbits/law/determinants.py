"""The return map of a law, and the determinants of its cyclic system, whose zeros are folds and doublings."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.orbits.law.elimination import solve_cyclic
from vibropipe.orbits.law.equations import fill_blocks
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


@jit_allocating
def unit_and_doubling(before, at, rest):
    """Return the shares of both determinants: zero at a fold, and where an orbit doubles or loses its symmetry.

    The sum of both is the determinant of the blocks times 2 (1 + det M), whose sign is taken from the blocks: next to
    a grazing both determinants cancel.
    """
    n, flips = at.shape[0], 1.0
    none, x = np.zeros((n, 2, 0)), np.zeros((n, 2))
    borders, corner, few = np.zeros((0, n, 2)), np.zeros((0, 0)), np.zeros(0)
    signs, logs = np.empty(2), np.empty(2)
    for k in range(2):
        wrap = 2.0 * k - 1.0
        signs[k], logs[k] = solve_cyclic(before, at, none, rest, wrap, borders, corner, few, x, few)
    for i in range(n):
        flips = math.copysign(
            flips, flips * (at[i, 0, 0] * at[i, 1, 1] - at[i, 0, 1] * at[i, 1, 0])
        )
    top = max(logs[0], logs[1])
    if not top > -math.inf:
        return 0.0, 0.0
    doubling, unit = math.exp(logs[0] - top), math.exp(logs[1] - top)
    total = flips * (doubling + unit)
    return signs[1] * unit / total, signs[0] * doubling / total


@jit_allocating
def fill_slopes(e, values, along, law, u, blocks, steps, is_unit, slope) -> None:
    """Fill the derivatives of one of both shares by all unknowns, as central differences.

    Parameters
    ----------
    e : Effects
    values : (1, parameters) float
        Of the exciter; those at `along` (k,) are set.
    along : (k,) int
    law : Law
    u : (2 n + k,) float
        Times, what is free of the states, and parameters.
    blocks : Blocks
        Without parameters; overwritten.
    steps, slope : (2 n + k,) float
    is_unit : bool
    """
    n, columns = law.codes.shape[0], np.zeros(0, np.int64)
    events = np.empty((n, 2))
    for k in range(u.size):
        ends = 0.0
        for sign in (1.0, -1.0):
            for i in range(n):
                for j in range(2):
                    events[i, j] = u[j * n + i]
            for j in range(along.size):
                values[0, along[j]] = u[2 * n + j]
            if k < 2 * n:
                events[k % n, k // n] += sign * steps[k]
            else:
                values[0, along[k - 2 * n]] += sign * steps[k]
            fill_blocks(e, row_parameters(values, 0), law, events, columns, blocks)
            unit, doubling = unit_and_doubling(blocks.before, blocks.at, blocks.rest)
            ends += sign * (unit if is_unit else doubling)
        slope[k] = ends / (2.0 * steps[k])
