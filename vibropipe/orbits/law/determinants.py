"""The determinants of the cyclic system of a law, whose zeros are folds and doublings, and their derivatives."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.orbits.law.elimination import solve_cyclic
from vibropipe.orbits.law.equations import fill_blocks
from vibropipe.orbits.row import row_parameters


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
