"""Errors, derivatives and contacts of solved rows with soft supports or friction, along their linear pieces."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_nogil
from vibropipe.march.grid import new_grid_room
from vibropipe.march.log import new_log
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
    PieceLog,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.orbits.contacts import write_contacts
from vibropipe.orbits.pieces import end_of_piece
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import row_parameters
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
from vibropipe.orbits.sensitivity.pieces.columns import (
    BY_V,
    BY_X,
    COLUMNS,
    PARAMETER,
    SAMPLE,
    add_complex_starts,
    add_starts,
    close_variations,
    columns_of,
    new_variations,
)
from vibropipe.orbits.sensitivity.pieces.derivatives import write_derivatives
from vibropipe.orbits.sensitivity.pieces.events import acceleration_of_piece
from vibropipe.orbits.sensitivity.pieces.multipliers import write_multiplier_derivatives
from vibropipe.orbits.sensitivity.pieces.orbit import march_orbit, vary_pieces
from vibropipe.orbits.sensitivity.rows import with_impact_derivatives
from vibropipe.physics.derivatives import F2, LOAD, N_OF_PIECES, PHI2
from vibropipe.physics.effects import Effects
from vibropipe.physics.flow import DEGREE
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


@jit
def write_row(e, values, by, march_room, starts, room, out, row, first) -> None:
    """Write errors and derivatives of a row; arguments as for `write_rows`, values (1, parameters) of the row."""
    p, m = row_parameters(values, 0), out.period_multiple[row]
    x, v = out.section[row, 0], out.section[row, 1]
    if not march_orbit(e, p, 0.0, x, v, m, march_room):
        return
    pieces, speed, columns = march_room[0].pieces, 0.0, columns_of(by)
    if not vary_pieces(e, p, pieces, m, by, room):
        return
    for j in range(first, first + out.impact_count[row]):
        speed = max(speed, abs(out.impact_velocity[j]))
    closing = out.residual[row] * (abs(x) + abs(v) + speed)
    if not close_variations(columns, closing, room.ends, starts):
        return
    for j in range(room.counts[0]):
        add_starts(columns, room.contacts[j], starts)
    write_errors(e, p, pieces, m, closing, starts, room, out, row, first)
    if by is not None:
        add_starts(columns, room.energy, starts)
        add_complex_starts(room.amplitudes, starts)
        add_complex_starts(room.subharmonics, starts)
        write_derivatives(p, starts, room, out, row, first)
        if out.d_multipliers.size + out.d_exponent.size > 0:
            write_multiplier_derivatives(e, values, m, march_room, out, row)


@jit_nogil
def write_rows(
    e: Effects,
    parameters: np.ndarray,
    out: RowResults,
    by: int | None,
    pieces: PieceLog,
) -> None:
    """Write the errors of solved rows, their derivatives, and the contacts with soft supports.

    Parameters
    ----------
    e : Effects
    parameters : (rows, parameters) float
    out : RowResults
        Compacted results of the rows, with their impacts; errors, derivatives and contacts are NaN on entry. Contacts
        without columns are not computed.
    by : int or None
        1 for derivatives, None for errors alone.
    pieces : PieceLog
        Its capacity is that for contacts and rests of an orbit, too.
    """
    capacity = pieces.values.shape[0]
    log, c = new_log(capacity, capacity, pieces, None), np.empty(DEGREE + 1)
    march_room = log, c, new_grid_room(e)
    starts, values, first = np.zeros((2, COLUMNS)), np.empty((1, parameters.shape[1])), 0
    amplitudes = out.d_amplitudes.shape[1] if out.d_amplitudes.size > 0 else 0
    subharmonics = out.d_subharmonics.shape[1] if out.d_subharmonics.size > 0 else 0
    energies = out.d_energy.shape[1] if out.d_energy.size > 0 else 0
    room = new_variations(capacity, amplitudes, subharmonics, energies)
    for row in range(parameters.shape[0]):
        values[0] = parameters[row]
        if out.period_multiple[row] > 0:
            write_row(e, values, by, march_room, starts, room, out, row, first)
        if e.soft is not None and out.contacts.shape[1] > 0:
            write_contacts(e, row_parameters(values, 0), march_room, out, row, first)
        if by is not None:
            # Kernels count displacements from the equilibrium, which the load moves.
            out.d_section[row, 0, LOAD] += 1.0
            if amplitudes > 0:
                out.d_amplitudes[row, 0, LOAD] += 1.0
        first += out.impact_count[row]


def with_errors_of_pieces(
    rows: RowResults,
    parameters: np.ndarray,
    effects: Effects,
    pieces: PieceLog,
    contacts: int = 0,
) -> RowResults:
    """Return compacted results, whose impacts are listed, with errors and, if requested, derivatives of all orbits.

    Parameters
    ----------
    rows : RowResults
    parameters : (rows, parameters) array
    effects : Effects
        With soft supports or friction.
    pieces : PieceLog
    contacts : int
        Columns of the contacts with soft supports, 0 if they are not wanted.
    """
    n = rows.impact_position.size
    room = rows._replace(
        e_row=np.full((len(parameters), ERRORS), np.nan), e_impacts=np.full((n, 2), np.nan)
    )
    if contacts:
        room = room._replace(contacts=np.full((n, contacts), np.nan))
    by = None
    if rows.d_section.size > 0:
        room, by = with_impact_derivatives(room), 1
    write_rows(effects, parameters, room, by, pieces)
    return room if by is None or effects.second_harmonic is not None else without_second(room)


def without_second(rows: RowResults) -> RowResults:
    """Return results without the derivatives by the parameters of a second harmonic, which all are computed with."""
    kept = [k for k in range(N_OF_PIECES) if k not in (F2, PHI2)]
    return rows._replace(
        **{
            name: values[..., kept]
            for name, values in rows._asdict().items()
            if name.startswith("d_")
        }
    )
