"""Points of a branch of orbits of one law, by Newton's method, and their test functions: compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.continuation.curve import FOLD, OWN_TESTS
from vibropipe.continuation.newton import DONE, FAILED, GOES_ON, MAX_CORRECTIONS, verdict
from vibropipe.orbits.law import margins as of
from vibropipe.orbits.law.determinants import return_map, unit_and_doubling
from vibropipe.orbits.law.elimination import solve_cyclic
from vibropipe.orbits.law.equations import Blocks, fill_blocks
from vibropipe.orbits.law.law import Law
from vibropipe.orbits.law.margins import fill_margins
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.effects import Effects

# Test functions of a point beside FOLD (where the orbit of a branch folds) and CROSSING, which no law needs. DOUBLING:
# det(D + 1) of the return map's derivative D, bounded (a flip; of a mirrored law a pitchfork). UNIT: det(D - 1) alike.
# GAP: least distance from a support at a turning point, or another margin, as a pure number. SPEED: least impact
# velocity towards its support, weighted. What follows says where.
DOUBLING, UNIT, GAP, SPEED, TRACE, DETERMINANT, GAP_TIME, GAP_SIDE, GAP_FLIGHT, SLOWEST, TESTS = (
    range(OWN_TESTS, OWN_TESTS + 11)
)
# Numbers of a point beside its tests: the kind of its least margin but that of speeds, and the slowest event.
MARGIN, SLOW_EVENT = TESTS, TESTS + 1
N_TESTS = TESTS + 2


class System(NamedTuple):
    """The equations of a law over its unknowns: times of n events, what is free of the state before each, k parameters.

    Attributes
    ----------
    e : Effects
    law : Law
    values : (1, parameters) float
        Of the exciter; those that vary are set.
    along, columns : (k,) int
        Parameters that vary, by their place in an exciter and in `ALL_DIFFERENTIATED`.
    least, most : (k,) float
        Between them equations are filled.
    events : (n, 2) float
        The unknowns of events.
    blocks : Blocks
    margins : (KINDS + 1, 4) float
    size, speed : float
        Scales of displacement and velocity.
    """

    e: Effects
    law: Law
    values: np.ndarray
    along: np.ndarray
    columns: np.ndarray
    least: np.ndarray
    most: np.ndarray
    events: np.ndarray
    blocks: Blocks
    margins: np.ndarray
    size: float
    speed: float


@jit
def fill_at(system, u) -> bool:
    """Fill the blocks at the unknowns u (2 n + k,), and `events` and `values`; return whether they are finite."""
    law, events = system.law, system.events
    n = law.codes.shape[0]
    for i in range(n):
        events[i, 0], events[i, 1] = u[i], u[n + i]
    for j in range(system.along.size):
        value = u[2 * n + j]
        if not system.least[j] < value < system.most[j]:
            return False
        system.values[0, system.along[j]] = value
    p = row_parameters(system.values, 0)
    fill_blocks(system.e, p, law, events, system.columns, system.blocks)
    total = 0.0
    for i in range(n):
        total += abs(system.blocks.rest[i, 0]) + abs(system.blocks.rest[i, 1])
    return total < math.inf


@jit_allocating
def fill_tests(system, c, tests) -> None:
    """Fill the test functions (N_TESTS,) of the orbit of `events`, whose blocks are filled, but FOLD.

    c : (DEGREE + 1,) float, a work array.
    """
    blocks, margins = system.blocks, system.margins
    tests[UNIT], tests[DOUBLING] = unit_and_doubling(blocks.before, blocks.at, blocks.rest)
    (m11, _m12, _m21, m22), tests[DETERMINANT] = return_map(blocks)
    tests[TRACE] = m11 + m22
    p = row_parameters(system.values, 0)
    fill_margins(system.e, p, system.law, system.events, c, margins)
    tests[SPEED] = min(margins[of.SPEED, of.VALUE] / system.speed, 1.0)
    tests[SLOW_EVENT] = margins[of.SPEED, of.AT]
    least = np.inf
    for kind in range(1, of.KINDS):
        scale = 1.0
        if kind == of.HOLD:
            scale = max(p.friction, 1e-100)
        elif kind == of.GAP:
            scale = system.size
        elif kind == of.SLIDE:
            scale = system.speed
        value = margins[kind, of.VALUE] / scale
        if kind == 1 or value < least or value != value:
            least, tests[MARGIN] = value, kind
            tests[GAP_FLIGHT], tests[GAP_SIDE] = margins[kind, of.AT], margins[kind, of.SIDE]
            tests[GAP_TIME] = margins[kind, of.TIME]
    tests[GAP] = min(least, 1.0)


@jit_allocating
def solve(system, u, target, weights, border, tangent, tests) -> int:
    """Correct u, in place, to the orbit in the plane border . u = target, of one parameter.

    Parameters
    ----------
    system : System
    u : (2 n + 1,) float
    target : float
    weights : (2 n + 1,) float
        Of the unknowns in norms.
    border : (2 n + 1,) float
    tangent : (2 n + 1,) float
        Filled with the unit tangent there, along the border.
    tests : (N_TESTS,) float
        Filled with its test functions.

    Returns
    -------
    int
        How often the equations were filled; its negative where there is no orbit.
    """
    n, blocks = system.law.codes.shape[0], system.blocks
    borders, corner, goal = np.empty((1, n, 2)), np.empty((1, 1)), np.empty(1)
    x, q, zeros = np.empty((n, 2)), np.empty(1), np.zeros((n, 2))
    for i in range(n):
        borders[0, i, 0], borders[0, i, 1] = border[i], border[n + i]
    corner[0, 0] = border[2 * n]
    rest, previous, said = blocks.rest, math.inf, GOES_ON
    fills = 0
    while fills <= MAX_CORRECTIONS:
        fills += 1
        if not fill_at(system, u):
            return -fills
        goal[0] = -target
        for k in range(u.size):
            goal[0] += border[k] * u[k]
        if said == DONE:
            rest, goal[0] = zeros, 1.0  # for the tangent
        sign, _log = solve_cyclic(
            blocks.before, blocks.at, blocks.by, rest, 1.0, borders, corner, goal, x, q
        )
        if sign == 0.0:
            return -fills
        if said == DONE:
            break
        change = abs(q[0]) * weights[2 * n]
        for i in range(n):
            change = max(change, abs(x[i, 0]) * weights[i], abs(x[i, 1]) * weights[n + i])
        said, previous = verdict(change, previous), change
        if said == FAILED:
            return -fills
        for i in range(n):
            u[i] -= x[i, 0]
            u[n + i] -= x[i, 1]
        u[2 * n] -= q[0]
    else:
        return -fills
    square = (q[0] * weights[2 * n]) ** 2
    for i in range(n):
        tangent[i], tangent[n + i] = x[i, 0], x[i, 1]
        square += (x[i, 0] * weights[i]) ** 2 + (x[i, 1] * weights[n + i]) ** 2
    tangent[2 * n] = q[0]
    if not 0.0 < square < math.inf:
        return -fills
    norm = math.sqrt(square)
    for k in range(u.size):
        tangent[k] /= norm
    tests[:] = 0.0
    tests[FOLD] = tangent[2 * n] * weights[2 * n]
    fill_tests(system, blocks.polynomial, tests)
    return fills
