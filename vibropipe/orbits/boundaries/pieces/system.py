"""The equations of a boundary of orbits with soft supports or friction, by the replay of their events.

Unknowns are phase and velocity of the first contact (without contacts, phase and displacement of the first turn), at a
grazing the phase at which a flight touches a support, and two parameters. The conditions are those of
`vibropipe.orbits.boundaries.system`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.continuation.curve import FOLD
from vibropipe.continuation.newton import DONE, FAILED, MAX_CORRECTIONS, fill_tangent, newton_step
from vibropipe.march.piece_log import PieceLog
from vibropipe.orbits.boundaries.pieces.replay import (
    derivative_of_replay,
    replay,
    slowest_contact,
    touch_at,
)
from vibropipe.orbits.boundaries.system import FOLDS, GRAZINGS, parameters_of_point
from vibropipe.orbits.branches.steps import DETERMINANT, DOUBLING, GAP, SPEED, TRACE, UNIT

# Step of the central differences, weighted. It affects the speed of convergence alone.
DIFFERENCE = 1e-7


class Sought(NamedTuple):
    """What is solved for: see `replay` and `touch_at`.

    Attributes
    ----------
    effects : Effects
    values : (1, parameters) float
        Parameters of the exciter; those at `along` (2,) are set.
    along : (2,) int
    kind, mirrored, flight, side : int
        Kind of the boundary, and of a grazing the piece that touches a support.
    span, size, speed : float
        Length of the sequence in forcing periods, and scales of displacement and velocity.
    pieces : PieceLog
    guess : (n + 1,) float
        Spans of the pieces, near those sought.
    """

    effects: Any
    values: np.ndarray
    along: np.ndarray
    kind: int
    mirrored: int
    flight: int
    side: int
    span: float
    size: float
    speed: float
    pieces: PieceLog
    guess: np.ndarray


@jit
def fill_residuals(sought, u, residuals) -> bool:
    """Fill the residuals of closing and of the condition at u; return whether the orbit could be replayed."""
    e, pieces = sought.effects, sought.pieces
    p = parameters_of_point(sought.values, sought.along, u)
    for i in range(sought.guess.size):
        pieces.values[i, 1] = sought.guess[i]
    late, missed, is_replayed = replay(e, p, pieces, sought.mirrored, u[0], u[1], sought.span)
    if not is_replayed:
        return False
    residuals[0], residuals[1] = late, missed
    if sought.kind == GRAZINGS:
        gap, rate = touch_at(e, p, pieces, sought.flight, sought.side, u[2])
        residuals[2], residuals[3] = gap / sought.size, rate / sought.speed
        return True
    trace, determinant, scale = derivative_of_replay(e, p, pieces, sought.mirrored, sought.speed)
    residuals[2] = scale * (1.0 + determinant + (-trace if sought.kind == FOLDS else trace))
    return True


@jit
def _fill_system(sought, u, weights, work) -> bool:
    """Fill the rows of the equations of work.matrix, and work.rhs with their values, at u.

    Derivatives are central differences, which affect the speed of convergence alone.
    """
    size = u.size
    for k in range(size):
        held, reach = u[k], 1.0 / weights[k]
        step = DIFFERENCE * reach
        if k >= size - 2:
            step = DIFFERENCE * max(min(reach, abs(held)), 0.01 * reach)
        u[k] = held + step
        is_replayed = fill_residuals(sought, u, work.above)
        u[k] = held - step
        is_replayed = is_replayed and fill_residuals(sought, u, work.below)
        u[k] = held
        if not is_replayed:
            return False
        for row in range(size - 1):
            work.matrix[row, k] = (work.above[row] - work.below[row]) / (2.0 * step)
    return fill_residuals(sought, u, work.rhs)


@jit
def _finish(sought, u, weights, work, tangent, tests) -> bool:
    """Fill the tangent of a corrected point and its test functions; GAP, which a march tells, is 1."""
    fill_tangent(weights, work, tangent)
    if not fill_residuals(sought, u, work.rhs):
        return False
    e, pieces = sought.effects, sought.pieces
    p = parameters_of_point(sought.values, sought.along, u)
    for i in range(sought.guess.size):
        sought.guess[i] = pieces.values[i, 1]
    trace, determinant, _scale = derivative_of_replay(e, p, pieces, sought.mirrored, sought.speed)
    tests[:] = 0.0
    tests[TRACE], tests[DETERMINANT], tests[GAP] = trace, determinant, 1.0
    tests[SPEED] = slowest_contact(pieces) / sought.speed
    tests[UNIT], tests[DOUBLING] = 1.0, 1.0
    tests[FOLD] = tangent[u.size - 1] * weights[u.size - 1]
    if sought.kind == GRAZINGS:
        size = 1.0 + abs(determinant) + abs(trace)
        tests[UNIT] = (1.0 + determinant - trace) / size
        tests[DOUBLING] = (1.0 + determinant + trace) / size
    return True


@jit
def solve(sought, u, target, weights, work, tangent, tests) -> bool:
    """Correct u, in place, to the boundary in the plane work.border . u = target; return whether there is one.

    Tangent (size,) and test functions (TESTS,) are filled.
    """
    work.last[0] = math.inf
    for _ in range(MAX_CORRECTIONS):
        if not _fill_system(sought, u, weights, work):
            return False
        said = newton_step(u, target, weights, work)
        if said == FAILED:
            return False
        for i in range(sought.guess.size):
            sought.guess[i] = sought.pieces.values[i, 1]
        if said == DONE:
            return _finish(sought, u, weights, work, tangent, tests)
    return False
