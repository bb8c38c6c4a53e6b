"""Points of a branch of orbits of one law, by Newton's method, and their test functions: compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.continuation.curve import FOLD, OWN_TESTS
from vibropipe.continuation.newton import DONE, FAILED, GOES_ON, MAX_CORRECTIONS, verdict
from vibropipe.march.piece_log import CAUSE, FORM, RELEASE, RESTING
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.determinants import (
    pair_share,
    return_map,
    return_map_of_three,
    unit_and_doubling,
)
from vibropipe.orbits.law.elimination import Border, solve_cyclic
from vibropipe.orbits.law.equations import Blocks, fill_blocks, new_blocks
from vibropipe.orbits.law.law import Law, width_of
from vibropipe.orbits.law.margins import fill_margins
from vibropipe.orbits.row import fill_acted, row_parameters
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.words.parameters import ACTED

# Test functions of a point beside FOLD (where the orbit of a branch folds) and CROSSING, which no law needs. DOUBLING:
# det(D + 1) of the return map's derivative D, bounded (a flip; of a mirrored law a pitchfork). UNIT: det(D - 1) alike.
# GAP: least distance from a support at a turning point, or another margin, as a pure number. SPEED: least impact
# velocity towards its support, weighted. What follows says where.
DOUBLING, UNIT, GAP, SPEED, TRACE, DETERMINANT, GAP_TIME, GAP_SIDE, GAP_FLIGHT = range(
    OWN_TESTS, OWN_TESTS + 9
)
# Numbers of a point beside its tests: the kind of its least margin but that of speeds, and the slowest event. Beside a
# housing PAIR is 0 where a pair of multipliers is on the unit circle; MINORS are those of the return map's derivative.
MARGIN, SLOW_EVENT, PAIR, MINORS, N_TESTS = range(GAP_FLIGHT + 1, GAP_FLIGHT + 6)
# Step of central differences of parameters that others act on, relative. It affects the speed of convergence and the
# tangent.
DIFFERENCE = 1e-5


class Through(NamedTuple):
    """Work arrays for the parameters that others act on; without rows where none does.

    columns, places : (t,) int, these parameters in `ALL_DIFFERENTIATED` and in an exciter
    blocks : of the derivatives by them
    ends : (2, t)
    """

    columns: np.ndarray
    places: np.ndarray
    blocks: Blocks
    ends: np.ndarray


def new_through(n: int, is_acted: bool, housing: int | None) -> Through:
    """Return work arrays for n events, without rows if nothing is acted on."""
    columns = np.array([ALL_DIFFERENTIATED.index(name) for name in ACTED], np.int64)
    places = np.array([Parameters._fields.index(name) for name in ACTED], np.int64)
    blocks = new_blocks(n if is_acted else 0, len(ACTED), housing)
    return Through(columns, places, blocks, np.zeros((2, len(ACTED))))


class System(NamedTuple):
    """The equations of a law over its unknowns: times of n events, what is free of the state before each, k parameters.

    These are w n + k numbers, w = 2 or, with a housing, 3.

    values : (1, parameters), of the exciter; those that vary are set
    along, columns : (k,) int, parameters that vary, by their place in an exciter and in `ALL_DIFFERENTIATED`
    least, most : (k,), between them equations are filled
    events : (n, w), the unknowns of events
    margins : (KINDS + 1, 4)
    size, speed : scales of displacement and velocity
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
    through: Through


@jit
def add_through(system, p) -> None:
    """Add the derivatives by the parameters that others act on, once the blocks and `values` are filled."""
    columns, places, blocks, ends = system.through
    fill_blocks(system.e, p, system.law, system.events, columns, blocks)
    by, values = system.blocks.by, system.values
    for j in range(system.along.size):
        place = system.along[j]
        held = values[0, place]
        step = DIFFERENCE * max(abs(held), 0.1 * (system.most[j] - system.least[j]))
        for side in range(2):
            values[0, place] = held + (step if side == 0 else -step)
            fill_acted(values[0], ends[side])
        values[0, place] = held
        for t in range(columns.size):
            slope = (ends[0, t] - ends[1, t]) / (2.0 * step)
            if system.along[j] == places[t]:
                slope -= 1.0  # its own column is there
            for i in range(by.shape[0]):
                for row in range(by.shape[1]):
                    by[i, row, j] += slope * blocks.by[i, row, t]


@jit
def fill_at(system, u) -> bool:
    """Fill the blocks at the unknowns u (w n + k,), and `events` and `values`; return whether they are finite."""
    law, events = system.law, system.events
    n, width = law.codes.shape[0], width_of(system.e.housing)
    for i in range(n):
        for j in range(width):
            events[i, j] = u[j * n + i]
    for j in range(system.along.size):
        value = u[width * n + j]
        if not system.least[j] < value < system.most[j]:
            return False
        system.values[0, system.along[j]] = value
    p = row_parameters(system.values, 0)
    fill_blocks(system.e, p, law, events, system.columns, system.blocks)
    if system.through.blocks.rest.size > 0:
        add_through(system, p)
    total = 0.0
    for i in range(n):
        for j in range(width):
            total += abs(system.blocks.rest[i, j])
    return total < math.inf


@jit_allocating
def fill_tests(system, c, tests) -> None:
    """Fill the test functions (N_TESTS,) of the orbit of `events`, whose blocks are filled, but FOLD.

    c : (DEGREE + 1,) float, a work array.
    """
    blocks, margins = system.blocks, system.margins
    e = system.e
    tests[UNIT], tests[DOUBLING] = unit_and_doubling(
        blocks.before, blocks.at, blocks.rest, e.housing
    )
    if e.housing is not None:
        matrix, minors, determinant = return_map_of_three(blocks.before, blocks.at)
        trace = matrix[0, 0] + matrix[1, 1] + matrix[2, 2]
        tests[TRACE], tests[MINORS], tests[DETERMINANT] = trace, minors, determinant
        tests[PAIR] = pair_share(trace, minors, determinant)
    else:
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
            at = int(margins[kind, of.AT])
            rests = system.law.codes[at, FORM] == RESTING or system.law.codes[at, CAUSE] == RELEASE
            scale = system.size if rests else max(p.friction, 1e-100)
        elif kind == of.HOUSING_HOLD:
            scale = abs(p.f) + abs(p.f2) + p.housing_friction_1 + p.housing_friction_2
        elif kind == of.GAP:
            scale = system.size
        elif kind in (of.SLIDE, of.HOUSING_SLIDE):
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

    u : (w n + 1,)
    weights : (w n + 1,), of the unknowns in norms
    border : (w n + 1,)
    tangent : (w n + 1,), filled with the unit tangent there, along the border
    tests : (N_TESTS,), filled with its test functions

    Returns how often the equations were filled; its negative where there is no orbit.
    """
    n, blocks, width = system.law.codes.shape[0], system.blocks, width_of(system.e.housing)
    borders, corner, goal = np.empty((1, n, width)), np.empty((1, 1)), np.empty(1)
    x, q, zeros = np.empty((n, width)), np.empty(1), np.zeros((n, width))
    for i in range(n):
        for j in range(width):
            borders[0, i, j] = border[j * n + i]
    last = width * n
    corner[0, 0] = border[last]
    further = Border(blocks.by, borders, corner, goal)
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
            blocks.before, blocks.at, rest, 1.0, further, x, q, system.e.housing
        )
        if sign == 0.0:
            return -fills
        if said == DONE:
            break
        change = abs(q[0]) * weights[last]
        for i in range(n):
            for j in range(width):
                change = max(change, abs(x[i, j]) * weights[j * n + i])
        said, previous = verdict(change, previous), change
        if said == FAILED:
            return -fills
        for i in range(n):
            for j in range(width):
                u[j * n + i] -= x[i, j]
        u[last] -= q[0]
    else:
        return -fills
    square = (q[0] * weights[last]) ** 2
    for i in range(n):
        own = 0.0
        for j in range(width):
            tangent[j * n + i] = x[i, j]
            own += (x[i, j] * weights[j * n + i]) ** 2
        square += own
    tangent[last] = q[0]
    if not 0.0 < square < math.inf:
        return -fills
    norm = math.sqrt(square)
    for k in range(u.size):
        tangent[k] /= norm
    tests[:] = 0.0
    tests[FOLD] = tangent[last] * weights[last]
    fill_tests(system, blocks.polynomial, tests)
    return fills
