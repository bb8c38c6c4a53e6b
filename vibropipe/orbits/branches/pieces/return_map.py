"""The return map of a motion by linear pieces, and its derivatives by the section and by a parameter."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import AT, BEGIN, CAUSE, HOME, PIECES, W_END, Y_END
from vibropipe.orbits.branches.sequence import parameters_at
from vibropipe.orbits.pieces import end_of_piece
from vibropipe.orbits.sensitivity.pieces.columns import BY_V, BY_X, PARAMETER
from vibropipe.orbits.sensitivity.pieces.orbit import march_orbit, vary_pieces
from vibropipe.physics.contact import to_displacement, to_velocity

# What `differentiate` finds: (x, x') after the orbit; the derivative by the section, and by the parameter; a number for
# what begins the pieces; how far, in forcing periods, the section is from the next event, and where it would be
# farthest, and how far.
X, V, BY_SECTION, BY_PARAMETER, LAW, MARGIN, BEST, BEST_MARGIN = (
    0, 1, slice(2, 6), slice(6, 8), 8, 9, 10, 11,
)  # fmt: skip
N_RESULTS = 12
# Frames of a piece: of the equilibrium and of each support.
FRAMES = 3
# Roots are counted in parts of this size.
LAW_UNIT = 2.0**20
# 1 for derivatives by parameters (`vary_pieces`).
BY = 1


@jit
def law_of_orbit(pieces):
    """Return a number for what begins the logged pieces, in whatever order: a section may cut an orbit anywhere.

    Sums of different roots, rounded to integers, are equal by a rare chance only.
    """
    law = 0.0
    for i in range(pieces.counts[PIECES]):
        if pieces.codes[i, CAUSE] != BEGIN:
            root = math.sqrt(2.0 + FRAMES * pieces.codes[i, CAUSE] + pieces.codes[i, HOME])
            law += math.floor(LAW_UNIT * root)
    return law


@jit
def returned(e, p, section, x, v, m, march_room):
    """Return (x, x') after m periods, and whether the motion could be marched and grazes no rigid support."""
    if not march_orbit(e, p, section, x, v, m, march_room):
        return x, v, False
    pieces = march_room[0].pieces
    last = pieces.counts[PIECES] - 1
    home = pieces.codes[last, HOME]
    x1 = to_displacement(p, home, pieces.values[last, Y_END])
    return x1, to_velocity(home, pieces.values[last, W_END]), True


@jit
def fill_margins(p, pieces, m, result) -> None:
    """Fill MARGIN, BEST and BEST_MARGIN; the section cuts a piece into the first and the last."""
    last = pieces.counts[PIECES] - 1
    begin, end = pieces.values[0, AT], end_of_piece(p, pieces, 0)
    start = pieces.values[last, AT] - m
    result[9], result[10], result[11] = min(end - begin, begin - start), 0.5 * (start + end), 0.0
    result[11] = 0.5 * (end - start)
    for i in range(1, last):
        here, there = pieces.values[i, AT], end_of_piece(p, pieces, i)
        if 0.5 * (there - here) > result[11]:
            result[10], result[11] = 0.5 * (here + there), 0.5 * (there - here)
    if last == 0:
        result[9] = result[11]


@jit
def differentiate(e, values, along, column, u, m, section, march_room, room, result) -> bool:
    """Fill result (N_RESULTS,) with the return map and its derivatives.

    Parameters
    ----------
    e : Effects
    values : (1, parameters) float
        Parameters; the one at `along` is set.
    along, column : int
        Index of the parameter that varies, and among those of derivatives.
    u : (3,) float
        Displacement and velocity at the section, counted from the equilibrium, and the parameter.
    m : int
        Period multiple.
    section : float
        Phase of the section, in turns.
    march_room
        As for `march_orbit`; its log is left with the orbit.
    room : PieceVariations
    result : (N_RESULTS,) float

    Returns
    -------
    bool
        Whether the map exists and is smooth there.
    """
    p = parameters_at(values, along, u[2])
    result[0], result[1], is_marched = returned(e, p, section, u[0], u[1], m, march_room)
    pieces = march_room[0].pieces
    if not is_marched or not vary_pieces(e, p, pieces, m, BY, room):
        return False
    for part in range(2):
        result[2 + 2 * part] = room.ends[part, BY_X]
        result[3 + 2 * part] = room.ends[part, BY_V]
        result[6 + part] = room.ends[part, PARAMETER + column]
    result[8] = law_of_orbit(pieces)
    fill_margins(p, pieces, m, result)
    return True


def fixed_point_jacobian(result: np.ndarray) -> np.ndarray:
    """Return the derivative (2, 2) of the return map minus identity, from what `differentiate` fills."""
    jacobian: np.ndarray = result[BY_SECTION].reshape(2, 2) - np.eye(2)
    return jacobian
