"""Derivatives of Floquet multipliers of an orbit of linear pieces.

The derivative along the orbit is known in closed form, its own derivative is a central difference: the orbits beside it
follow from the derivative of the section.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import CAUSE, HOME, PIECES
from vibropipe.orbits.pieces import jacobian_of_pieces
from vibropipe.orbits.return_map import floquet_multipliers
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.multipliers import DOUBLE
from vibropipe.orbits.sensitivity.pieces.derivatives import is_by
from vibropipe.orbits.sensitivity.pieces.orbit import march_orbit
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED, N_OF_PIECES, NU
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.load import forcing_period
from vibropipe.physics.quotient import divide

# Index in `Parameters` of each parameter of the derivatives.
INDICES = np.array([Parameters._fields.index(name) for name in ALL_DIFFERENTIATED])
# Step of the central differences of trace and determinant over the size of a parameter: both are known to some 1e-13,
# and where the motion nearly grazes they bend within a thousandth.
STEP = 1e-4


@jit
def law_of(pieces):
    """Return a number for the sequence of logged pieces: what begins each, and its frame."""
    law = 0
    for i in range(pieces.counts[PIECES]):
        law += (i + 1) * (10 * pieces.codes[i, CAUSE] + pieces.codes[i, HOME] + 1)
    return law


@jit
def trace_of_orbit(e, p, x, v, m, march_room):
    """Return trace and determinant of the derivative along the motion from (x, v), and the law of its pieces.

    The law is -1 where the motion cannot be differentiated.
    """
    if not march_orbit(e, p, 0.0, x, v, m, march_room):
        return 0.0, 0.0, -1
    pieces = march_room[0].pieces
    j11, j12, j21, j22 = jacobian_of_pieces(e, p, pieces)
    return j11 + j22, j11 * j22 - j12 * j21, law_of(pieces)


@jit
def trace_slopes(e, values, k, x, v, m, law, march_room, out, row):
    """Return the derivatives of trace and determinant by parameter k, and whether the pieces stay those of `law`.

    Central differences of fourth order along the derivative of the section; arguments as for
    `write_multiplier_derivatives`.
    """
    size, p = values[0, INDICES[k]], row_parameters(values, 0)
    step = STEP * max(abs(size), 0.1 * min(1.0, p.l))
    trace, determinant, is_smooth = 0.0, 0.0, True
    for n in range(-2, 3):
        if n == 0:
            continue
        moved = n * step
        values[0, INDICES[k]] = size + moved
        x1, v1 = x + moved * out.d_section[row, 0, k], v + moved * out.d_section[row, 1, k]
        other = trace_of_orbit(e, row_parameters(values, 0), x1, v1, m, march_room)
        # (f(-2) - 8 f(-1) + 8 f(1) - f(2)) / 12
        weight = (8.0 / n if abs(n) == 1 else -2.0 / n) / (12.0 * step)
        trace, determinant = trace + weight * other[0], determinant + weight * other[1]
        is_smooth = is_smooth and other[2] == law
    values[0, INDICES[k]] = size
    return trace, determinant, is_smooth


@jit
def write_multiplier_derivatives(e, values, m, march_room, out, row) -> None:
    """Write the derivatives of multipliers and Lyapunov exponent, by those of trace and determinant of their matrix.

    The log has the orbit on entry, and neighbours of it on return.

    Parameters
    ----------
    e, m, march_room
        As for `march_orbit`.
    values : (1, parameters) float
        Parameters of the row; changed and restored.
    out : RowResults
        `d_section` of the row is written.
    row : int
    """
    p, x, v = row_parameters(values, 0), out.section[row, 0], out.section[row, 1]
    pieces = march_room[0].pieces
    law, jacobian = law_of(pieces), jacobian_of_pieces(e, p, pieces)
    first, second = floquet_multipliers(*jacobian)
    # A rest erases all perturbations.
    is_erased, difference = first == 0.0, first - second
    length = m * forcing_period(p)
    for k in range(N_OF_PIECES):
        if not is_by(p, k):
            continue
        by_trace, slope, is_smooth = trace_slopes(e, values, k, x, v, m, law, march_room, out, row)
        if not is_smooth:
            continue
        if is_erased:
            d_first, d_second = complex(0.0, 0.0), complex(0.0, 0.0)
        elif not abs(difference) > DOUBLE * abs(first):
            continue
        else:
            d_first = divide(first * by_trace - slope, difference)
            d_second = divide(slope - second * by_trace, difference)
        if out.d_multipliers.size > 0:
            out.d_multipliers[row, 0, k], out.d_multipliers[row, 1, k] = d_first, d_second
        if out.d_exponent.size > 0 and not is_erased:
            out.d_exponent[row, k] = divide(d_first, first).real / length
            if k == NU:
                out.d_exponent[row, k] += math.log(abs(first)) / (length * p.nu)
