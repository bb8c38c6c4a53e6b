"""How hard soft supports are loaded: each contact of a solved row, marched by itself from the impact that begins it.

Its impact, listed to rounding, determines a contact: one that lasts over the end of an orbit, or beyond the list of a
motion without an orbit, needs no special case.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import Instant, exact_steps, grid_in_room, grid_time
from vibropipe.march.log import clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_log import LEAVES
from vibropipe.march.piece_state import piece_state
from vibropipe.march.pieces import next_instant
from vibropipe.march.state import restitution_of
from vibropipe.physics.stiffness import is_soft

# Columns of a contact, those of `PieceLog.leaves`: velocity after it, duration, largest force, largest depth.
CONTACT_COLUMNS = 4
# Forcing periods after which a contact counts as endless.
MAX_CONTACT_PERIODS = 256


@jit
def march_contact(e, p, grid, position, home, velocity, march_room, contact) -> None:
    """March a contact with a soft support step by step until the mass leaves, and write its columns.

    Parameters
    ----------
    e, p, grid : Effects, Parameters, StepGrid
    position : float
        Of the impact that begins it, in forcing periods.
    home : int
        The support.
    velocity : float
        x' on entering.
    march_room
        As for `march_orbit`.
    contact : (4,) float
        Columns of the contact; not written where it does not end.
    """
    log, c, _grid_room = march_room
    state = piece_state(e, p, grid, grid_time(position, grid.steps), home, 0.0, -abs(velocity))
    last = state.period + MAX_CONTACT_PERIODS
    while state.period < last:
        clear_log(log)
        period, step, theta = next_instant(grid, state, 1.0)
        end = Instant(period, step, theta)
        state, status = march(e, p, grid, state, end, log, None, c, 10_000_000)
        if status != OK:
            return
        if log.pieces.counts[LEAVES] > 0:
            for k in range(CONTACT_COLUMNS):
                contact[k] = log.pieces.leaves[0, k]
            return


@jit
def write_contacts(e, p, march_room, out, row, first) -> None:
    """Write the contacts of a solved row into `out.contacts`: of an impact on a rigid support, the velocity after it.

    Parameters
    ----------
    e, p, march_room
        As for `march_orbit`.
    out : RowResults
        Compacted results, with their impacts; `contacts` NaN on entry.
    row : int
        Index of the row.
    first : int
        Index of its first impact.
    """
    if out.impact_count[row] == 0:
        return
    grid = grid_in_room(e, p, exact_steps(e, p), march_room[2])
    for i in range(first, first + out.impact_count[row]):
        home, velocity = np.int64(out.impact_support[i]), out.impact_velocity[i]
        if is_soft(e, p, home):
            # Only the phase matters: a time of few digits before the point keeps more behind it.
            position = out.impact_position[i] - math.floor(out.impact_position[i])
            march_contact(e, p, grid, position, home, velocity, march_room, out.contacts[i])
        else:
            out.contacts[i, 0] = -restitution_of(e, p, home) * velocity
