"""Which attractor a motion settles on: it is marched until it enters a region from which no motion leaves.

The attractors are known beforehand. Around each section point of a stable orbit there is an ellipse that the return
map takes into itself (`solve.neighbourhood`): a motion is assigned to the orbit when its section enters one. An
attractor without an orbit is known by the cells of the section plane that it visits: a motion is assigned to it after
RUN sections in a row in its cells, since the motion through a single one may still lead elsewhere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import IMPACTS, RESTS, TAILS, allow_work, clear_log, is_spent, work_of
from vibropipe.march.loop import OK
from vibropipe.march.piece_log import BEGIN, CAUSE, DIRECTION, HOME, PIECES, STICK
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    march_periods,
    return_map_jacobian,
    state_xv,
)
from vibropipe.orbits.settling import MAX_CROWDED
from vibropipe.orbits.shooting import EVENTS_PER_PERIOD
from vibropipe.physics.limits import MAX_ROW_WORK

# What a start gets that is assigned to no attractor: the motion was not assigned within the periods allowed, or its
# march failed.
UNDECIDED, FAILED = -1, -2
# Sections in a row in cells of an attractor without an orbit after which a motion is assigned to it.
RUN = 32
# Work after which a start has failed: less than that of a row, since there are thousands. With soft supports it is
# enough for tau = 50,000.
MAX_START_WORK = MAX_ROW_WORK // 5
# Bound of the columns and lines of cells.
LINES = 2**31


class Ellipses(NamedTuple):
    """Ellipses (x - x0, v - v0) S (x - x0, v - v0)^T <= 1 around section points of stable orbits.

    center : (n, 2), section points (x0, v0)
    shape : (n, 3), S, as (s11, s12, s22)
    owner : (n,) int64, number of the attractor
    """

    center: np.ndarray
    shape: np.ndarray
    owner: np.ndarray


class Cells(NamedTuple):
    """Cells of the section plane that attractors without an orbit visit.

    visited : (n_cells,) int64, cells of the attractors one after the other, those of each in increasing order: column *
        LINES + line, counted by x and by v
    first : (n + 1,) int64, index of the first cell of each attractor in `visited`
    corner, scale : (n, 2), least x and v of the cells, and cells per unit of x and of v
    owner : (n,) int64, number of the attractor
    """

    visited: np.ndarray
    first: np.ndarray
    corner: np.ndarray
    scale: np.ndarray
    owner: np.ndarray


@jit
def ellipse_owner(ellipses, x, v) -> int:
    """Return the number of the attractor whose ellipse contains a state, or UNDECIDED."""
    for i in range(ellipses.owner.size):
        dx, dv = x - ellipses.center[i, 0], v - ellipses.center[i, 1]
        size = (ellipses.shape[i, 0] * dx + 2.0 * ellipses.shape[i, 1] * dv) * dx
        if size + ellipses.shape[i, 2] * dv * dv <= 1.0:
            return ellipses.owner[i]
    return UNDECIDED


@jit
def cell_owner(cells, runs, x, v) -> int:
    """Count the sections in a row in the cells of each attractor.

    runs : (n,) int64, sections in a row so far, updated in place
    x, v : the next section

    Returns the number of the attractor whose count has reached RUN, or UNDECIDED.
    """
    for i in range(cells.owner.size):
        column = (x - cells.corner[i, 0]) * cells.scale[i, 0]
        line = (v - cells.corner[i, 1]) * cells.scale[i, 1]
        low, high = cells.first[i], cells.first[i + 1]
        is_inside = column >= 0.0 and column < LINES and line >= 0.0 and line < LINES
        cell = int(column) * LINES + int(line) if is_inside else -1
        while low < high:
            middle = (low + high) // 2
            if cells.visited[middle] < cell:
                low = middle + 1
            else:
                high = middle
        if low < cells.first[i + 1] and cells.visited[low] == cell:
            runs[i] += 1
            if runs[i] >= RUN:
                return cells.owner[i]
        else:
            runs[i] = 0
    return UNDECIDED


@jit
def next_section(e, p, grid, state, log, c):
    """March to the next section, the end of the forcing period of a state.

    e, p, grid, state, log, c : as for `march`. The log is emptied first

    Returns the state, and a `Status`; LOG_FULL if the log holds only the last contacts.
    """
    clear_log(log)
    return march_periods(e, p, grid, at_period_zero(state), ONE_PERIOD, log, c, EVENTS_PER_PERIOD)


@jit
def settled_attractor(e, p, grid, state, ellipses, cells, runs, max_periods, log, c):
    """March from a state until the motion is assigned to an attractor.

    e, p, grid, log, c : as for `march`
    state : start, at any phase of the force
    runs : (n,) int64, work space, for each attractor of `cells`
    max_periods : largest number of forcing periods marched

    Returns the number of the attractor, UNDECIDED, also where the log limits its work further, or FAILED; and the
    forcing periods marched.
    """
    crowded, before = 0, work_of(log)
    runs[:] = 0
    allow_work(log, MAX_START_WORK)
    if state.step == 0 and state.theta == 0.0:
        x, v = state_xv(p, state)
        attractor = ellipse_owner(ellipses, x, v)
        if attractor >= 0:
            return attractor, 0
    for k in range(1, max_periods + 1):
        state, status = next_section(e, p, grid, state, log, c)
        crowded += status == LOG_FULL
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            is_cut = is_spent(log) and work_of(log) - before <= MAX_START_WORK
            return (UNDECIDED if is_cut else FAILED), k
        x, v = state_xv(p, state)
        attractor = ellipse_owner(ellipses, x, v)
        if attractor < 0 and cells.owner.size > 0:
            attractor = cell_owner(cells, runs, x, v)
        if attractor >= 0:
            return attractor, k
    return UNDECIDED, max_periods


@jit_allocating
def assign_starts(e, p, grid, starts, phase, regions, max_periods, log, c, assigned) -> None:
    """Assign starts to attractors (`settled_attractor`).

    e, p, grid, max_periods, log, c : as for `settled_attractor`
    starts : (n, 2), x and v
    phase : phase of the force at the start, in turns
    regions : tuple, the ellipses and cells of `settled_attractor`
    assigned : tuple of (n,) int64, output: attractor of each start, and forcing periods marched
    """
    (ellipses, cells), (owner, periods) = regions, assigned
    runs = np.zeros(cells.owner.size, np.int64)
    for i in range(starts.shape[0]):
        state = start_state(log.pieces, e, p, grid, phase, starts[i, 0], starts[i, 1], 0.0)
        owner[i], periods[i] = settled_attractor(
            e, p, grid, state, ellipses, cells, runs, max_periods, log, c
        )


@jit_allocating
def record_sections(e, p, grid, x, v, phase, log, c, sections) -> int:
    """March a motion and write its sections.

    e, p, grid, log, c : as for `march`
    x, v : start
    phase : phase of the force at the start, in turns
    sections : (n, 2), output: the next n sections (x, x')

    Returns how many were written; fewer than n if the march failed.
    """
    state = start_state(log.pieces, e, p, grid, phase, x, v, 0.0)
    allow_work(log, MAX_ROW_WORK)
    for k in range(sections.shape[0]):
        state, status = next_section(e, p, grid, state, log, c)
        if status != OK and status != LOG_FULL:
            return k
        sections[k, 0], sections[k, 1] = state_xv(p, state)
    return sections.shape[0]


@jit
def _contact_sequence(log, key):
    """Return a number that tells sequences of contacts apart; `key` is that of the contacts before.

    Of a forcing period with a rest only the rests count: the mass leaves its support in the same state however it
    came to rest. Of a stick only the slip counts: a mass that friction holds at the section began to stick before,
    but near motions may do so after.
    """
    rests = min(log.counts[RESTS], log.rest_support.size)
    if rests > 0 or log.counts[TAILS] > 0:
        for i in range(rests):
            key = key * 1_000_003 + 4 + log.rest_support[i]
        return key * 1_000_003 + 3
    if log.pieces is not None:
        pieces = log.pieces
        for i in range(pieces.counts[PIECES]):
            cause = pieces.codes[i, CAUSE]
            if cause != BEGIN and cause != STICK:
                key = (key * 1_000_003 + cause) * 7 + pieces.codes[i, HOME]
                key = key * 5 + pieces.codes[i, DIRECTION]
        return key * 1_000_003
    for i in range(min(log.counts[IMPACTS], log.support.size)):
        key = key * 1_000_003 + log.support[i]
    return key * 1_000_003


@jit_allocating
def map_states(e, p, grid, states, m, log, c, images, sequence) -> None:
    """Apply the m-period return map to states at the section.

    e, p, grid, log, c : as for `march`
    states : (n, 2)
    m : number of forcing periods
    images : (n, 2), output: the states m periods later; NaN where the march failed, as beyond the work of a row for all
    sequence : (n,) int64, output: equal for states whose motions have the same contacts in the same forcing periods
    """
    allow_work(log, MAX_ROW_WORK)
    for i in range(states.shape[0]):
        state = start_state(log.pieces, e, p, grid, 0.0, states[i, 0], states[i, 1], 0.0)
        key, status = 1, OK
        for _ in range(m):
            state, status = next_section(e, p, grid, state, log, c)
            if status != OK:
                break
            key = _contact_sequence(log, key)
        images[i, 0], images[i, 1] = state_xv(p, state)
        sequence[i] = key
        if status != OK:
            images[i, 0] = images[i, 1] = np.nan


@jit
def section_jacobian(e, p, grid, x, v, m, log, c):
    """Return the Jacobian (j11, j12, j21, j22) of the m-period return map at a state (x, v) of the section."""
    start = start_state(log.pieces, e, p, grid, 0.0, x, v, 0.0)
    clear_log(log)
    allow_work(log, MAX_ROW_WORK)
    end, _status = march_periods(e, p, grid, start, m, log, c, EVENTS_PER_PERIOD * m)
    return return_map_jacobian(e, p, log, start, end, m)
