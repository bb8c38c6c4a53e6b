"""The log of pieces: between two events a motion is one linear piece, and orbits are sums and products over pieces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.effects import Effects
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.load import COLUMNS, COLUMNS_OF_SECOND

# What begins a piece: the march; entering and leaving a soft support; an impact on a rigid one or the tail of a
# chatter; a zero of the velocity, after which it goes on, or is held; the end of that; a rest and its release; a touch
# without velocity.
# Of a housing: it is no longer held, or its velocity has a zero, after which it is held or slides on. Of a support that
# only pushes: its force falls to zero, and rises from it again. They are numpy integers because numba compiles another
# copy of a kernel for each literal constant.
BEGIN, ENTER, LEAVE, IMPACT, TURN, STICK, SLIP, REST_BEGINS, RELEASE, TOUCH = map(
    np.int64, range(10)
)
HOUSING_SLIP, HOUSING_STOP, UNLOAD, RELOAD = map(np.int64, range(10, 14))
# What a piece is: free flight, contact with a soft support, held by friction, at rest on a support, and free flight
# beyond a support that only pushes.
FREE, CONTACT, HELD, RESTING, BEYOND = range(5)
# Columns of `values` and of `codes`.
AT, SPAN, Y, W, Y_END, W_END = range(6)
CAUSE, FORM, HOME, DIRECTION = range(4)
# Entries of `counts`, and of `contact`: how long the contact under way has lasted, its largest force and depth, and
# whether there is one: 1, or UNSEEN if its beginning was not.
PIECES, LEAVES = 0, 1
ELAPSED, FORCE, DEPTH, IS_OPEN = range(4)
UNSEEN = 2.0
# Forms of `flows`: a free piece, a contact with support 1 or 2, and the same beside a housing that slides. Its rows: a
# basis, and two of the numbers of a step.
FORMS, ROWS = 6, COLUMNS + COLUMNS_OF_SECOND + 2
# Columns of `HousingLog.values`.
P_START, X_START, P_END, X_END, LARGEST = range(5)


class HousingLog(NamedTuple):
    """How a housing that may slide takes part in the pieces.

    way : (n,) int8, of each piece, the direction in which the housing slides; 0 where it is held
    values : (n, 5), momentum of both bodies and displacement of the housing, at start and end, and its largest speed
    work : (degree + 1,), work array for polynomials
    product, factor, room : (3, 3), work arrays for derivatives
    """

    way: np.ndarray
    values: np.ndarray
    work: np.ndarray
    product: np.ndarray
    factor: np.ndarray
    room: np.ndarray


class PieceLog(NamedTuple):
    """Pieces in order of time, and ends of contacts with soft supports.

    values : (n, 6), start in forcing periods, duration in tau, and (y, w) at start and end, in the frame of HOME
    codes : (n, 4) int8, what began it, what it is, the frame, and the direction of sliding (0 without friction)
    leaves : (n, 4), of each contact that has ended: velocity of x, duration in tau, largest force, largest depth
    contact : (4,), the contact under way
    work, polynomial : (degree + 1,), work arrays for the polynomials of a velocity or a force, and of the displacement
    energy : (5,), where integrals go that are not wanted
    counts : (2,) int64, numbers of pieces and of leaves
    flows : (FORMS, ROWS, degree + 1), of each form of a piece, the unit motions on it and what else its steps take
        (`march.piece_path`)
    housing : of a housing that may slide
    """

    values: np.ndarray
    codes: np.ndarray
    leaves: np.ndarray
    contact: np.ndarray
    work: np.ndarray
    polynomial: np.ndarray
    energy: np.ndarray
    counts: np.ndarray
    flows: np.ndarray
    housing: HousingLog | None


def new_piece_log(n: int, degree: int, has_housing: bool) -> PieceLog:
    """Return an empty log for n pieces of motions that are polynomials of a degree."""
    housing = None
    if has_housing:
        square = (np.empty((3, 3)) for _ in range(3))
        housing = HousingLog(np.empty(n, np.int8), np.empty((n, 5)), np.empty(degree + 1), *square)
    return PieceLog(
        np.empty((n, 6)),
        np.empty((n, 4), np.int8),
        np.empty((n, 4)),
        np.zeros(4),
        np.empty(degree + 1),
        np.empty(degree + 1),
        np.zeros(5),
        np.zeros(2, np.int64),
        np.zeros((FORMS, ROWS, degree + 1)),
        housing,
    )


@jit
def clear_pieces(pieces) -> None:
    """Empty the log, if there is one; the contact under way is kept."""
    if pieces is not None:
        pieces.counts[PIECES] = 0
        pieces.counts[LEAVES] = 0


@jit_inline
def is_full_of_pieces(pieces) -> bool:
    """Return whether the pieces of one more event might exceed the capacity."""
    return pieces.counts[PIECES] + 2 >= pieces.values.shape[0]


@jit_inline
def begin_piece(pieces, position, cause, form, home, direction, y, w) -> None:
    """Append a piece, `position` in forcing periods."""
    n = pieces.counts[PIECES]
    values, codes = pieces.values, pieces.codes
    values[n, AT], values[n, SPAN], values[n, Y], values[n, W] = position, 0.0, y, w
    values[n, Y_END], values[n, W_END] = y, w
    codes[n, CAUSE], codes[n, FORM], codes[n, HOME], codes[n, DIRECTION] = (
        cause,
        form,
        home,
        direction,
    )
    pieces.counts[PIECES] = n + 1


@jit_inline
def begin_housing(log, n, housing) -> None:
    """Begin piece n in the log of a housing, if there is one."""
    if log is None:
        return
    log.way[n] = housing.way
    values = log.values
    values[n, P_START], values[n, X_START] = housing.momentum, housing.displacement
    values[n, P_END], values[n, X_END], values[n, LARGEST] = (
        housing.momentum,
        housing.displacement,
        0.0,
    )


@jit_inline
def extend_housing(log, n, housing, speed) -> None:
    """Let the housing of piece n end in a state, after a part with a largest speed; nothing without a housing."""
    if log is None:
        return
    log.values[n, P_END], log.values[n, X_END] = housing.momentum, housing.displacement
    log.values[n, LARGEST] = max(log.values[n, LARGEST], speed)


@jit_inline
def extend_piece(pieces, span, y, w) -> None:
    """Add a span of tau to the last piece, which then ends in (y, w)."""
    n = pieces.counts[PIECES] - 1
    pieces.values[n, SPAN] += span
    pieces.values[n, Y_END], pieces.values[n, W_END] = y, w


@jit_inline
def begin_contact(pieces, force) -> None:
    """Start the record of a contact; force : of the support at once, by its damping."""
    contact = pieces.contact
    contact[ELAPSED], contact[FORCE], contact[DEPTH], contact[IS_OPEN] = 0.0, force, 0.0, 1.0


@jit_inline
def end_contact(pieces, velocity) -> None:
    """Append the end of the contact under way, if its beginning was logged; velocity : of x."""
    n, was_seen = pieces.counts[LEAVES], pieces.contact[IS_OPEN] != UNSEEN
    pieces.contact[IS_OPEN] = 0.0
    if not was_seen:
        return
    pieces.leaves[n, 0] = velocity
    for i in range(3):
        pieces.leaves[n, 1 + i] = pieces.contact[i]
    pieces.counts[LEAVES] = n + 1


def piece_log_of(
    effects: Effects, n: int, degree: int = DEGREE
) -> tuple[PieceLog, None] | tuple[None, int]:
    """Return `pieces` and `plain` of a `Log`: an empty log for n pieces, if motions are marched by pieces."""
    if not effects.has_pieces:
        return None, 1
    return new_piece_log(n, degree, effects.housing is not None), None
