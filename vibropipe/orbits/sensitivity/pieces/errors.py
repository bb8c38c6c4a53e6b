"""Errors of an orbit of linear pieces, from its samples of rounding."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    AT,
    CAUSE,
    CONTACT,
    FORM,
    HOME,
    IMPACT,
    PIECES,
    STICK,
    TURN,
    W_END,
    Y_END,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.orbits.pieces import end_of_piece
from vibropipe.orbits.sensitivity.errors import COLUMNS as ERRORS
from vibropipe.orbits.sensitivity.errors import (
    IMPULSES,
    PHASES,
    SPEED_1,
    TRACE,
    ULP,
    V,
    X,
    note_impact,
    rms,
)
from vibropipe.orbits.sensitivity.pieces.columns import BY_V, BY_X, PARAMETER, SAMPLE, add_starts
from vibropipe.orbits.sensitivity.pieces.events import acceleration_of_piece
from vibropipe.physics.load import largest_force
from vibropipe.physics.stiffness import piece_rate


@jit
def relative_error(e, p, pieces, i, state):
    """Return by how much the event that begins piece i changes the derivative of the return map, relative to its size.

    state : (2, PARAMETER) float
        Closed samples of the end of the piece before.
    """
    x, v, w = rms(state[0, SAMPLE:]), rms(state[1, SAMPLE:]), abs(pieces.values[i - 1, W_END])
    cause, rate, force = pieces.codes[i, CAUSE], 1.0, 1.0 + largest_force(p)
    for j in range(i - 1, i + 1):
        stiffness, damping = coefficients(
            e, p, pieces.codes[j, HOME], pieces.codes[j, FORM] == CONTACT
        )
        rate = max(rate, piece_rate(stiffness, damping))
    if cause in (TURN, STICK):
        y1, turn = pieces.values[i - 1, Y_END], pieces.values[i, AT]
        a = abs(acceleration_of_piece(e, p, pieces, i - 1, turn, y1, 0.0))
        return v / a * (rate + p.nu * force / a)
    if not w > 0.0:
        return 0.0
    late = x / w
    struck = (v + (force + rate * w) * late) / w if cause == IMPACT else 0.0
    return late * rate + struck


@jit
def write_errors(e, p, pieces, m, closing, starts, room, out, row, first) -> None:
    """Write the errors of an orbit from its samples.

    Parameters
    ----------
    e, p, pieces, m
        As for `vary_pieces`.
    closing : float
        Distance by which the orbit fails to close.
    starts : (2, COLUMNS) float
        Of `close_variations`.
    room : PieceVariations
        Filled by `vary_pieces`; its contacts are closed.
    out : RowResults
        `e_row` and `e_impacts`.
    row, first : int
        The row, and its first impact.
    """
    floor = closing + ULP * (abs(out.section[row, 0]) + abs(out.section[row, 1]) + largest_force(p))
    out.e_row[row, X] = rms(starts[0, SAMPLE:PARAMETER]) + floor
    out.e_row[row, V] = rms(starts[1, SAMPLE:PARAMETER]) + floor
    mean, square, size = floor, 0.0, 1.0
    for i in range(pieces.counts[PIECES]):
        add_starts(PARAMETER, room.states[i], starts)
        share = (end_of_piece(p, pieces, i) - pieces.values[i, AT]) / m
        mean += share * rms(room.states[i, 0, SAMPLE:])
        if i > 0:
            square += relative_error(e, p, pieces, i, room.states[i - 1]) ** 2
    for part in range(2):
        size = max(size, abs(room.ends[part, BY_X]) + abs(room.ends[part, BY_V]))
    out.e_row[row, IMPULSES], out.e_row[row, PHASES] = mean, 0.0
    relative = math.sqrt(square) + ULP * (1.0 + pieces.counts[PIECES])
    out.e_row[row, TRACE] = relative * size
    n = room.counts[0]
    is_listed = out.impact_count[row] == n
    for column in range(SPEED_1, ERRORS):
        out.e_row[row, column] = 0.0 if is_listed else math.nan
    for j in range(n if is_listed else 0):
        phase = rms(room.contacts[j, 0, SAMPLE:PARAMETER]) + ULP * (1.0 + m)
        speed = rms(room.contacts[j, 1, SAMPLE:PARAMETER])
        speed += ULP * abs(out.impact_velocity[first + j])
        out.e_impacts[first + j, 0], out.e_impacts[first + j, 1] = phase, speed
        note_impact(out, row, out.impact_support[first + j], phase, speed)
