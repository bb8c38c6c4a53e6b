"""Contacts with soft supports of solved rows, each marched from the impact that begins it."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import Instant, exact_steps, grid_in_room, grid_time
from vibropipe.march.log import clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_log import (
    AT,
    BEYOND,
    CAUSE,
    FORM,
    HELD,
    HOME,
    LEAVE,
    LEAVES,
    PIECES,
    SPAN,
    W_END,
    Y_END,
    W,
    Y,
)
from vibropipe.march.piece_state import coefficients, piece_state
from vibropipe.march.piece_still import next_instant
from vibropipe.march.state import restitution_of
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.piece_terms import load_of_piece
from vibropipe.orbits.pieces import end_of_piece
from vibropipe.physics.load import forcing_period
from vibropipe.physics.load_harmonics import reaction_integral
from vibropipe.physics.stiffness import damping_of, is_soft, stiffness_of

# Columns of a contact, those of `PieceLog.leaves`: velocity after it, duration, largest force, largest depth. One more,
# if there is room for it, has the impulse that the support takes.
CONTACT_COLUMNS = 4
# Forcing periods after which a contact counts as endless.
MAX_CONTACT_PERIODS = 256


@jit
def impulse_of_contact(e, p, pieces):
    """Return the impulse that a soft support takes over the logged pieces of a contact, up to its end if it is logged.

    The damper takes none over a whole contact, which ends at the depth at which it began, unless the support lets go
    before.
    """
    impulse = 0.0
    for i in range(pieces.counts[PIECES]):
        home, values = pieces.codes[i, HOME], pieces.values
        if pieces.codes[i, CAUSE] == LEAVE:
            break
        if pieces.codes[i, FORM] == BEYOND:
            continue
        if pieces.codes[i, FORM] == HELD:
            impulse -= stiffness_of(p, home) * values[i, Y] * values[i, SPAN]
            continue
        stiffness, damping = coefficients(e, p, home, True)
        sigma, load = load_of_piece(e, p, pieces, i)
        # The integral of the equation of motion over the piece.
        total = values[i, W_END] - values[i, W] + damping * (values[i, Y_END] - values[i, Y])
        total -= load * values[i, SPAN]
        if e.forcing is not None:
            end = end_of_piece(p, pieces, i)
            reaction = reaction_integral(p, 0, ONE_PERIOD, values[i, AT], end).real
            total += sigma * reaction * forcing_period(p)
        impulse += stiffness_of(p, home) * total / stiffness
        if e.no_pull is not None:
            impulse -= damping_of(p, home) * (values[i, Y_END] - values[i, Y])
    return impulse


@jit
def march_contact(e, p, grid, position, home, velocity, march_room, contact) -> None:
    """March a contact with a soft support, which its impact determines, until the mass leaves, and write its columns.

    position : of the impact that begins it, in forcing periods
    velocity : x' on entering
    march_room : as for `march_orbit`
    contact : (4,) or (5,), columns of the contact; not written where it does not end
    """
    log, c, _grid_room = march_room
    state = piece_state(
        e, p, grid, grid_time(position, grid.steps), home, 0.0, -abs(velocity), None
    )
    last, impulse = state.period + MAX_CONTACT_PERIODS, 0.0
    while state.period < last:
        clear_log(log)
        period, step, theta = next_instant(grid, state, 1.0)
        end = Instant(period, step, theta)
        state, status = march(e, p, grid, state, end, log, None, c, 10_000_000)
        if status != OK:
            return
        if contact.size > CONTACT_COLUMNS:
            impulse += impulse_of_contact(e, p, log.pieces)
            contact[CONTACT_COLUMNS] = math.nan
        if log.pieces.counts[LEAVES] > 0:
            if contact.size > CONTACT_COLUMNS:
                contact[CONTACT_COLUMNS] = impulse
            for k in range(CONTACT_COLUMNS):
                contact[k] = log.pieces.leaves[0, k]
            return


@jit
def write_contacts(contacts, e, p, march_room, out, row, first) -> None:
    """Write the contacts of a solved row: of an impact on a rigid support, the velocity after it.

    And its impulse, if there is room for it.

    contacts : (n, columns) or None, NaN on entry; nothing is written, or compiled, without it or its columns
    e, p, march_room : as for `march_orbit`
    out : RowResults, compacted results, with their impacts
    first : index of the first impact of the row
    """
    if contacts is None:
        return
    if contacts.shape[1] == 0 or out.impact_count[row] == 0:
        return
    grid = grid_in_room(e, p, exact_steps(e, p), march_room[2])
    for i in range(first, first + out.impact_count[row]):
        home, velocity = np.int64(out.impact_support[i]), out.impact_velocity[i]
        if is_soft(e, p, home):
            # Only the phase matters: a time of few digits before the point keeps more behind it.
            position = out.impact_position[i] - math.floor(out.impact_position[i])
            march_contact(e, p, grid, position, home, velocity, march_room, contacts[i])
        else:
            contacts[i, 0] = -restitution_of(e, p, home) * velocity
            if contacts.shape[1] > CONTACT_COLUMNS:
                contacts[i, CONTACT_COLUMNS] = abs(contacts[i, 0] - velocity)
