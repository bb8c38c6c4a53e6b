"""The equations of an orbit over its law: each piece ends in the state just before the next event.

Unknowns of an event are its time, in forcing periods, and what neither the piece before nor the condition of the event
fixes of the state just before it: the velocity at a support, the displacement of a turn or stick from the reference of
its frame, nothing of a slip or a release; a section has both, and no time. Beside a housing an event has a third one:
the momentum q of `sliding` while that slides; where it stops displacement and velocity. Mirror images have the opposite
numbers. Row i is a piece from event i - 1 to event i: before[i] du[i - 1] + at[i] du[i] + by[i] dp = -rest[i]. A number
that is no unknown is 0 by an equation of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.piece_log import (
    CAUSE,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    HOUSING_STOP,
    RELEASE,
    RESTING,
)
from vibropipe.orbits.law.flights import flight_of, flown_by
from vibropipe.orbits.law.law import is_contact, trivial_order, width_of
from vibropipe.orbits.law.momentum import fill_momentum, momentum_rest
from vibropipe.orbits.law.quotients import divided, divided_stop, power_of
from vibropipe.orbits.law.states import (
    arrival,
    arrival_by,
    departure,
    departure_by,
    hold_force,
    press_by,
)
from vibropipe.physics.derivatives import NU
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.friction import hold_of
from vibropipe.physics.load import forcing_period
from vibropipe.physics.piece import acceleration_of, by_phase, flown, force_at_end
from vibropipe.physics.turns import TWO_PI

# Span that stands for 0 where a row is divided by a power of it, in forcing periods.
TINY = 1e-30
# Time below which derivatives over its square are those of this time.
SHORTEST = 1e-4


class Blocks(NamedTuple):
    """The blocks of the equations of n events by k parameters.

    before, at : (n, w, w), derivatives by the unknowns of the event before, and of the event; w = 2 or, with a housing,
        3
    by : (n, w, k), derivatives by the parameters
    rest : (n, w), residuals
    polynomial : (DEGREE + 1,), work array
    """

    before: np.ndarray
    at: np.ndarray
    by: np.ndarray
    rest: np.ndarray
    polynomial: np.ndarray


@jit_allocating
def new_blocks(n, k, housing=None):
    """Return `Blocks` for n events and k parameters; housing : int or None, the effect."""
    w = width_of(housing)
    before, at = np.zeros((n, w, w)), np.zeros((n, w, w))
    return Blocks(before, at, np.zeros((n, w, k)), np.zeros((n, w)), np.empty(DEGREE + 1))


@jit
def fill_held(e, p, law, i, u, ends, sign, columns, blocks) -> None:
    """Fill row i of the blocks after a piece that is held or rests; its momentum apart.

    ends : where the piece begins, and where the event is; sign : -1 where the latter is mirrored, else 1
    """
    before, at, by, rest, _c = blocks
    (start, end), last = ends, (i - 1) % law.codes.shape[0]
    # A rest is at the support, whatever came before.
    kept = 1.0 if law.codes[last, FORM] == HELD else 0.0
    rest[i, 0], rest[i, 1] = kept * start.y - sign * end.y, 0.0
    before[i, 0, 0], before[i, 0, 1] = kept * start.y_0, kept * start.y_1
    at[i, 0, 0], at[i, 0, 1] = -sign * end.y_0, -sign * end.y_1
    before[i, 1, 0], before[i, 1, 1], at[i, 1, 0], at[i, 1, 1] = 0.0, 0.0, 0.0, 1.0
    for j in range(columns.size):
        y, _w = departure_by(e, p, law, last, u, columns[j])
        by[i, 0, j], by[i, 1, j] = (kept * y - sign * arrival_by(e, p, law, i, u, columns[j]), 0.0)
    if e.housing is not None:
        for row in range(2):
            before[i, row, 2], at[i, row, 2] = 0.0, 0.0
        if law.codes[i, CAUSE] == HOUSING_STOP:
            at[i, 1, 1], at[i, 1, 2] = 0.0, 1.0


@jit
def fill_row(e, p, law, i, u, columns, blocks) -> float:
    """Fill row i of the blocks; return the span of its piece in forcing periods."""
    rest, last = blocks.rest, (i - 1) % law.codes.shape[0]
    start, end = departure(e, p, law, last, u), arrival(e, p, law, i, u)
    # The mirror image of a state in a frame of a support has the same numbers.
    sign, later = 1.0, 0.0
    if i == 0:
        later = law.span
        if law.mirrored == 1 and law.codes[last, HOME] == 0:
            sign = -1.0
    turns = end.t + later - start.t
    if e.rest is not None and law.codes[i, CAUSE] == RELEASE:
        # No support presses the mass any more, whatever came before.
        fill_release(e.rest, e, p, law, i, end.t, columns, blocks)
        if e.housing is not None:
            fill_carried(e, p, law, i, u, (start, end), sign, turns, columns, blocks)
        return turns
    may_stay = e.friction is not None or e.rest is not None
    if may_stay and law.codes[last, FORM] in (HELD, RESTING):
        fill_held(e, p, law, i, u, (start, end), sign, columns, blocks)
        if e.housing is not None:
            fill_carried(e, p, law, i, u, (start, end), sign, turns, columns, blocks)
        return turns
    order, row = trivial_order(e, p, law, i), guard_row(law.codes[i, CAUSE])
    if order > 0 and abs(turns) < TINY:
        turns = TINY
    flight = flight_of(e, p, law, last, start.t, turns)
    y, w = flown(flight, start.y, start.w)
    pulls = acceleration_of(flight, force_at_end(flight), y, w)
    rest[i, 0], rest[i, 1] = y - sign * end.y, w - sign * end.w
    slopes, third = (w, pulls), 0.0
    if e.housing is not None:
        rest[i, 2], third = momentum_rest(e, p, law, i, u, flight.t, sign, w, pulls)
    if order > 0:
        if row == 2:
            rest[i, 2], third = divided_stop(
                e, p, law, i, flight, start, order, rest[i, 2], third, blocks.polynomial
            )
        else:
            rest[i, row], slope = divided(e, flight, start, row, order, blocks.polynomial)
            slopes = (slope, pulls) if row == 0 else (w, slope)
        if order > 1 and abs(flight.t) < SHORTEST:
            # Derivatives over the square of a time would cancel: those of a longer time are close to them.
            longer = math.copysign(SHORTEST, turns) / forcing_period(p)
            flight = flight_of(e, p, law, last, start.t, longer)
    fill_derivatives(e, p, law, i, u, flight, (start, end), sign, columns, blocks)
    if e.housing is not None:
        fill_momentum(e, p, law, i, u, flight.t, sign, columns, blocks)
    if order > 0:
        divide_row(i, row, power_of(flight.t, order), columns, blocks)
    fill_times(i, p, (start, end), slopes, turns, columns, blocks)
    if e.housing is not None:
        add_rate(i, 2, third, p, (start, end), turns, columns, blocks)
    return turns


@jit
def guard_row(kind) -> int:
    """Return which equation of a row the condition of its event gives."""
    if is_contact(kind):
        return 0
    return 2 if kind == HOUSING_STOP else 1


@jit
def fill_release(rest_effect, e, p, law, i, t, columns, blocks) -> None:
    """Fill the row of a release, which fixes its time alone; compiled only with the effect."""
    if rest_effect is None:
        return
    before, at, by, rest, _c = blocks
    value, _stiffness, rate = hold_force(e, p, law, i, t)
    rest[i, 0], rest[i, 1] = value - law.codes[i, DIRECTION] * hold_of(e, p), 0.0
    for row in range(2):
        for j in range(before.shape[2]):
            before[i, row, j], at[i, row, j] = 0.0, 0.0
        for j in range(columns.size):
            by[i, row, j] = press_by(e, p, law, i, t, columns[j]) if row == 0 else 0.0
    at[i, 0, 0], at[i, 1, 1] = rate, 1.0


@jit
def fill_carried(e, p, law, i, u, ends, sign, turns, columns, blocks) -> None:
    """Fill the third equation of row i, whose piece a mass stays on in its housing."""
    time = turns * forcing_period(p)
    fill_momentum(e, p, law, i, u, time, sign, columns, blocks)
    blocks.rest[i, 2], slope = momentum_rest(e, p, law, i, u, time, sign, 0.0, 0.0)
    add_rate(i, 2, slope, p, ends, turns, columns, blocks)


@jit
def fill_derivatives(e, p, law, i, u, flight, ends, sign, columns, blocks) -> None:
    """Fill the derivatives of row i at a fixed time of flight; ends : states at the start and at the end."""
    before, at, by, _rest, _c = blocks
    last = (i - 1) % law.codes.shape[0]
    start, end = ends
    # A later start is a later phase of the force.
    late, faster = by_phase(flight)
    free, k = flight.free, flight.stiffness
    before[i, 0, 0] = start.timed * TWO_PI * late + free.c * start.y_0
    before[i, 1, 0] = start.timed * TWO_PI * faster - k * free.s * start.y_0
    before[i, 0, 1] = free.c * start.y_1 + free.s * start.w_1
    before[i, 1, 1] = free.ds * start.w_1 - k * free.s * start.y_1
    at[i, 0, 0], at[i, 1, 0] = -sign * end.y_0, 0.0
    at[i, 0, 1], at[i, 1, 1] = -sign * end.y_1, -sign * end.w_1
    if e.housing is not None:
        before[i, 0, 2], before[i, 1, 2] = free.s * start.w_2, free.ds * start.w_2
        at[i, 0, 2], at[i, 1, 2] = 0.0, -sign * end.w_2
    for j in range(columns.size):
        dy, dw = departure_by(e, p, law, last, u, columns[j])
        to_y, to_w = flown_by(e, p, law, last, flight, (start.y, start.w), start.t, columns[j])
        by[i, 0, j] = (
            to_y + free.c * dy + free.s * dw - sign * arrival_by(e, p, law, i, u, columns[j])
        )
        by[i, 1, j] = to_w + free.ds * dw - k * free.s * dy


@jit
def row_power(e, p, law, i, t):
    """Return what both equations of row i are divided by, of a piece of the length t in tau."""
    order = trivial_order(e, p, law, i)
    if order > 1 and abs(t) < SHORTEST:
        t = math.copysign(SHORTEST, t)
    power, row = power_of(t, order), guard_row(law.codes[i, CAUSE])
    return power if row == 0 else 1.0, power if row == 1 else 1.0


@jit
def divide_row(i, row, power, columns, blocks) -> None:
    """Divide the derivatives of a row."""
    before, at, by, _rest, _c = blocks
    for j in range(before.shape[2]):
        before[i, row, j] /= power
        at[i, row, j] /= power
    for j in range(columns.size):
        by[i, row, j] /= power


@jit
def fill_times(i, p, ends, slopes, turns, columns, blocks) -> None:
    """Add the derivatives by the time of flight, which shrinks as the forcing period does."""
    for row in range(2):
        add_rate(i, row, slopes[0] if row == 0 else slopes[1], p, ends, turns, columns, blocks)


@jit
def add_rate(i, row, slope, p, ends, turns, columns, blocks) -> None:
    """Add the derivatives of an equation by the time of flight, from its slope by it in tau."""
    before, at, by, _rest, _c = blocks
    start, end = ends
    rate = forcing_period(p) * slope
    before[i, row, 0] -= start.timed * rate
    at[i, row, 0] += end.timed * rate
    for j in range(columns.size):
        if columns[j] == NU:
            by[i, row, j] -= turns / p.nu * rate


@jit
def fill_blocks(e, p, law, u, columns, blocks) -> float:
    """Fill the blocks of all rows; return the least span of a piece, in forcing periods.

    u : (n, 2), unknowns
    columns : (k,) int64, parameters of the derivatives, by their place in `ALL_DIFFERENTIATED`
    """
    least = np.inf
    for i in range(law.codes.shape[0]):
        least = min(least, fill_row(e, p, law, i, u, columns, blocks))
    return least
