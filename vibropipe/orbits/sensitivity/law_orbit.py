"""How an orbit of linear pieces changes by parameters and by rounding: the equations of its law, solved once for all.

The section is the first event of the law, and each logged piece ends in one of its rows. A parameter changes the rows
at fixed unknowns, and so does the rounding of a piece: all are right-hand sides of one cyclic system.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    LEAVE,
    P_END,
    P_START,
    PIECES,
    RELEASE,
    RESTING,
    SLIP,
    SPAN,
    STICK,
    TOUCH,
    TURN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.orbits.law.determinants import return_map, return_map_of_three
from vibropipe.orbits.law.elimination import solve_columns
from vibropipe.orbits.law.equations import Blocks, fill_blocks, new_blocks, row_power
from vibropipe.orbits.law.law import WAY, Law, ends_force, is_contact, width_of
from vibropipe.orbits.law.states import (
    arrival,
    arrival_by,
    departure,
    departure_by,
    reference_of,
    sign_of,
)
from vibropipe.orbits.piece_terms import load_of_piece
from vibropipe.orbits.sensitivity.errors import SAMPLES, ULP, random_sign
from vibropipe.orbits.sensitivity.flights import SINGULAR
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.derivatives import (
    F2,
    FRICTION,
    FRICTION_RATIO,
    HOUSING_FRICTION_1,
    HOUSING_FRICTION_2,
    K1,
    N_OF_PIECES,
    N_WITH_HOUSING,
    PHI2,
)
from vibropipe.physics.friction import jumps_at_slip
from vibropipe.physics.housing import momentum_share
from vibropipe.physics.load import forcing_period, largest_force
from vibropipe.physics.stiffness import piece_rate, stiffness_of

# Rows of the changes of a state: of its time in forcing periods, its displacement and its velocity.
TIME, PLACE, RATE = range(3)


class VariedOrbit(NamedTuple):
    """An orbit by its law, and its changes.

    law : its first event is the section
    u : (n, w), unknowns of its equations
    du : (n, w, k + SAMPLES), their derivatives by k parameters, and samples of their errors
    blocks : of the equations
    columns : (k,) int64, the parameters
    return_map : derivative of the return map of the section by displacement and velocity
    invariants : trace, sum of principal minors and determinant of that derivative, with a housing of its three rows
    """

    law: Law
    u: np.ndarray
    du: np.ndarray
    blocks: Blocks
    columns: np.ndarray
    return_map: tuple[float, float, float, float]
    invariants: tuple[float, float, float]


@jit_allocating
def columns_of(e, p):
    """Return the parameters by which a motion has derivatives: not by the stiffness of a rigid support.

    By a friction or a static part of it that is absent it has one to one side only.
    """
    columns = np.arange(N_OF_PIECES if e.housing is None else N_WITH_HOUSING)
    is_by = columns >= 0
    if e.housing is not None:
        is_by[HOUSING_FRICTION_1] = p.housing_friction_1 > 0.0
        is_by[HOUSING_FRICTION_2] = p.housing_friction_2 > 0.0
    for support in (1, 2):
        is_by[K1 + support - 1] = stiffness_of(p, support) > 0.0
    is_by[FRICTION] = p.friction > 0.0
    is_by[FRICTION_RATIO] = jumps_at_slip(e, p)
    is_by[F2] = is_by[PHI2] = e.second_harmonic is not None
    return columns[is_by]


@jit_allocating
def law_of_log(e, p, pieces, m):
    """Return the law of the logged pieces of an orbit of m periods, its unknowns, and whether it is smooth there."""
    n, width = pieces.counts[PIECES], width_of(e.housing)
    codes, u = np.zeros((n, 2 + width), np.int8), np.zeros((n, width))
    logged, values = pieces.codes, pieces.values
    for i in range(n):
        for column in range(logged.shape[1]):
            codes[i, column] = logged[i, column]
    is_smooth, home = codes[0, CAUSE] == BEGIN, codes[0, HOME]
    for i in range(1, n):
        if is_contact(codes[i, CAUSE]):
            home = codes[i, HOME]
    for i in range(n):
        cause, there = codes[i, CAUSE], codes[i, HOME]
        if is_contact(cause):
            home = there
            velocity = to_velocity(logged[i - 1, HOME], values[i - 1, W_END])
            approach = -sign_of(home) * velocity
            is_smooth = is_smooth and (-approach if cause == LEAVE else approach) > 0.0
            u[i, 0], u[i, 1] = values[i, AT], velocity
            continue
        if ends_force(cause):
            u[i, 0], u[i, 1] = values[i, AT], to_velocity(there, values[i, W])
            continue
        # Laws count from the support last met.
        codes[i, HOME] = home
        own = sign_of(there) * values[i, Y]
        if there != home:
            own += reference_of(p, there) - reference_of(p, home)
            codes[i, DIRECTION] *= np.int8(sign_of(there) * sign_of(home))
        if i == 0:
            u[0, 0], u[0, 1] = own, to_velocity(there, values[0, W])
        else:
            has_own = cause in (TURN, STICK, HOUSING_STOP)
            u[i, 0], u[i, 1] = values[i, AT], own if has_own else 0.0
        is_smooth = is_smooth and cause != TOUCH
    is_smooth = add_housing(pieces.housing, p, pieces, codes, u) and is_smooth
    return Law(codes, float(m), 0), u, is_smooth


@jit
def add_housing(log, p, pieces, codes, u) -> bool:
    """Add a housing to codes and unknowns of logged pieces; return whether the orbit is smooth there.

    log : `pieces.housing`, None without one
    """
    if log is None:
        return True
    is_smooth, share = True, momentum_share(p)
    for i in range(codes.shape[0]):
        cause, values = codes[i, CAUSE], pieces.values
        codes[i, WAY] = np.int8(sign_of(codes[i, HOME])) * log.way[i]
        velocity = to_velocity(pieces.codes[i, HOME], values[i, W])
        if i == 0:
            u[0, 2] = log.values[0, P_START] / share if log.way[0] != 0 else 0.0
            continue
        if cause == HOUSING_STOP:
            u[i, 2] = velocity
        elif log.way[i - 1] != 0:
            u[i, 2] = log.values[i - 1, P_END] / share
        if cause == HOUSING_SLIP:
            u[i, 1] = velocity
        at_once = cause in (HOUSING_STOP, SLIP, RELEASE) and values[i - 1, SPAN] == 0.0
        is_smooth = is_smooth and not at_once
    return is_smooth


@jit
def add_rounding(e, p, pieces, i, power, by) -> None:
    """Add what piece i, and the event that ends it, round to the samples of its row.

    power : (2,), which its equations are divided by; by : (2, SAMPLES) float
    """
    form, values = pieces.codes[i, FORM], pieces.values
    if form in (HELD, RESTING):
        return
    stiffness, damping = coefficients(e, p, pieces.codes[i, HOME], form == CONTACT)
    _sigma, load = load_of_piece(e, p, pieces, i)
    y, w = abs(values[i, Y]) + abs(values[i, Y_END]), abs(values[i, W]) + abs(values[i, W_END])
    short = min(values[i, SPAN], 1.0 / piece_rate(stiffness, damping))
    push = abs(load) + largest_force(p) + stiffness * y
    # The phase of the end is rounded with the phase itself.
    late = 0.5 * ULP * (0.5 + abs(values[i, AT])) * forcing_period(p)
    last_y, last_w = abs(values[i, Y_END]), abs(values[i, W_END])
    last_push = abs(load) + largest_force(p) + stiffness * last_y + damping * last_w
    by_y = ULP * (y + short * (w + short * push)) + late * last_w
    by_w = ULP * (w + short * push) + late * last_push
    for s in range(SAMPLES):
        k = 2 * (SAMPLES * i + s)
        by[0, s] += random_sign(k) * by_y / power[0]
        by[1, s] += random_sign(k + 1) * by_w / power[1]


@jit_allocating
def vary_orbit(e, p, pieces, m, closing, columns):
    """Return the `VariedOrbit` of the logged pieces of an orbit, and whether it is isolated and smooth.

    closing : distance by which the orbit fails to close; it enters the samples
    columns : (k,) int64, parameters of the derivatives, by their place in `ALL_DIFFERENTIATED`
    """
    law, u, is_smooth = law_of_log(e, p, pieces, m)
    n, k = u.shape[0], columns.size
    blocks = new_blocks(n, k + SAMPLES, e.housing)
    fill_blocks(e, p, law, u, columns, blocks)
    for i in range(n):
        after = (i + 1) % n
        power = row_power(e, p, law, after, pieces.values[i, SPAN])
        add_rounding(e, p, pieces, i, power, blocks.by[after, :, k:])
    for s in range(SAMPLES):
        blocks.by[0, 0, k + s] += random_sign(7921 + s) * closing
        blocks.by[0, 1, k + s] += random_sign(104731 + s) * closing
    du = np.zeros(blocks.by.shape)
    solve_columns(blocks.before, blocks.at, -blocks.by, du, e.housing)
    if e.housing is not None:
        matrix, minors, last = return_map_of_three(blocks.before, blocks.at)
        trace = matrix[0, 0] + matrix[1, 1] + matrix[2, 2]
        determinant = 1.0 - trace + minors - last
        scale = 1.0 + abs(trace) + abs(minors) + abs(last)
        own = matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1]
        varied = VariedOrbit(law, u, du, blocks, columns, own, (trace, minors, last))
        return varied, is_smooth and abs(determinant) > SINGULAR * scale
    (m11, m12, m21, m22), last = return_map(blocks)
    determinant = (1.0 - m11) * (1.0 - m22) - m12 * m21
    scale = 1.0 + abs(m11 + m22) + abs(m11 * m22 - m12 * m21)
    own, invariants = (m11, m12, m21, m22), (m11 + m22, last, 0.0)
    varied = VariedOrbit(law, u, du, blocks, columns, own, invariants)
    return varied, is_smooth and abs(determinant) > SINGULAR * scale


@jit
def fill_arrival(e, p, orbit, i, changes) -> None:
    """Fill the derivatives (3, k) of the state just before event i, in its frame."""
    state = arrival(e, p, orbit.law, i, orbit.u)
    for j in range(orbit.columns.size):
        by = arrival_by(e, p, orbit.law, i, orbit.u, orbit.columns[j])
        _fill_change(e, state, orbit.du[i], j, by, 0.0, changes)


@jit
def fill_departure(e, p, orbit, i, changes) -> None:
    """Fill the derivatives (3, k) of the state just after event i, in the frame of its piece."""
    state = departure(e, p, orbit.law, i, orbit.u)
    for j in range(orbit.columns.size):
        y, w = departure_by(e, p, orbit.law, i, orbit.u, orbit.columns[j])
        _fill_change(e, state, orbit.du[i], j, y, w, changes)


@jit_inline
def _fill_change(e, state, du, j, y, w, changes) -> None:
    """Fill the derivatives of a state by column j, from those of its unknowns and, at fixed ones, y and w."""
    changes[TIME, j] = state.timed * du[0, j]
    changes[PLACE, j] = state.y_0 * du[0, j] + state.y_1 * du[1, j] + y
    changes[RATE, j] = state.w_1 * du[1, j] + w
    if e.housing is not None:
        changes[RATE, j] += state.w_2 * du[2, j]


@jit
def ends_of_piece(e, p, orbit, i):
    """Return the states at the start and at the end of piece i, and its span in forcing periods."""
    law, n = orbit.law, orbit.u.shape[0]
    start, end = departure(e, p, law, i, orbit.u), arrival(e, p, law, (i + 1) % n, orbit.u)
    return start, end, end.t + (law.span if i == n - 1 else 0.0) - start.t
