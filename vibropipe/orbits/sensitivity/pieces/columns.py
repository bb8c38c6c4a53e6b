"""Variations of an orbit with soft supports or friction: what they are by, their work arrays, and how they close.

An orbit is followed once with its start held: by the start, by roundings of each piece, and by the parameters. The
variation of the start for which the orbit closes is (I - M)^-1 of the variation at the end, M the derivative of the
return map.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.orbits.sensitivity.errors import SAMPLES, random_sign
from vibropipe.orbits.sensitivity.flights import SINGULAR
from vibropipe.physics.derivatives import N_OF_PIECES
from vibropipe.physics.flow import DEGREE

# Columns: by displacement and velocity at the start, samples of rounding, by the parameters.
BY_X, BY_V, SAMPLE = 0, 1, 2
PARAMETER = SAMPLE + SAMPLES
COLUMNS = PARAMETER + N_OF_PIECES


class PieceVariations(NamedTuple):
    """Work arrays of the variations along an orbit; each has the columns above last.

    Attributes
    ----------
    ends : (2, COLUMNS) float
        Variations of (y, y') in the frame of the piece, where the orbit has been followed to.
    z : (DEGREE + 1, COLUMNS) float
        Polynomials of the variations.
    node : (2, COLUMNS) float
        Of displacement and velocity at a node of a quadrature, or of an event.
    states : (n, 2, PARAMETER) float
        Of x and x' at the end of each piece.
    contacts : (n, 2, COLUMNS) float
        Of phase, in turns, and velocity before each impact or contact.
    amplitudes, subharmonics : (n, COLUMNS) complex
    energy : (5, COLUMNS) float
        Of work of the force, losses by damping, at support 1 and 2, and by friction.
    counts : (1,) int
        Impacts and contacts so far.
    """

    ends: np.ndarray
    z: np.ndarray
    node: np.ndarray
    states: np.ndarray
    contacts: np.ndarray
    amplitudes: np.ndarray
    subharmonics: np.ndarray
    energy: np.ndarray
    counts: np.ndarray


@jit_allocating
def new_variations(capacity, amplitudes, subharmonics, energies):
    """Return work arrays for so many pieces and contacts each, amplitudes, subharmonics and energies (5 or 0)."""
    return PieceVariations(
        np.empty((2, COLUMNS)),
        np.empty((DEGREE + 1, COLUMNS)),
        np.empty((2, COLUMNS)),
        np.empty((capacity, 2, PARAMETER)),
        np.empty((capacity, 2, COLUMNS)),
        np.empty((amplitudes, COLUMNS), np.complex128),
        np.empty((subharmonics, COLUMNS), np.complex128),
        np.empty((energies, COLUMNS)),
        np.zeros(1, np.int64),
    )


@jit_inline
def columns_of(by):
    """Return the number of columns: all, or those before PARAMETER.

    by : 1, or None where no derivatives are wanted; what they need is then not compiled.
    """
    return PARAMETER if by is None else COLUMNS


@jit
def add_start(columns, values, starts) -> None:
    """Add to variations at a fixed start what that start changes."""
    for v in range(SAMPLE, columns):
        values[v] += values[BY_X] * starts[0, v] + values[BY_V] * starts[1, v]


@jit
def add_starts(columns, values, starts) -> None:
    """Add to each row of variations (n, COLUMNS) at a fixed start what that start changes."""
    for i in range(values.shape[0]):
        add_start(columns, values[i], starts)


@jit
def add_complex_starts(values, starts) -> None:
    """Do the same for complex variations by parameters."""
    for i in range(values.shape[0]):
        for v in range(PARAMETER, COLUMNS):
            values[i, v] += values[i, BY_X] * starts[0, v] + values[i, BY_V] * starts[1, v]


@jit
def close_variations(columns, closing, ends, starts) -> bool:
    """Fill starts (2, COLUMNS) with the variations of the section for which the orbit closes.

    closing : distance by which the orbit fails to close; it enters the samples. Returns False where the orbit is not
    isolated.
    """
    m11, m12, m21, m22 = ends[0, BY_X], ends[0, BY_V], ends[1, BY_X], ends[1, BY_V]
    determinant = (1.0 - m11) * (1.0 - m22) - m12 * m21
    scale = 1.0 + abs(m11 + m22) + abs(m11 * m22 - m12 * m21)
    if not abs(determinant) > SINGULAR * scale:
        return False
    for v in range(SAMPLE, columns):
        x, w = ends[0, v], ends[1, v]
        if v < PARAMETER:
            x, w = x + random_sign(7919 + v) * closing, w + random_sign(104729 + v) * closing
        starts[0, v] = ((1.0 - m22) * x + m12 * w) / determinant
        starts[1, v] = (m21 * x + (1.0 - m11) * w) / determinant
    return True
