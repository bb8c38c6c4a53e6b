"""Derivatives of Floquet multipliers of an orbit of linear pieces: of trace and determinant of its return map.

The return map is the product of the transfers between events, -at^-1 before of the blocks of its law. The blocks are
smooth along the orbits beside it, also where a transfer is not; their derivatives are central differences of fourth
order along the known derivatives of the events, without another orbit.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.piece_log import FORM, HELD, RESTING
from vibropipe.orbits.housing_jacobian import eigenvalues_of_cubic
from vibropipe.orbits.law.determinants import less_inverse_times, return_map_of_three, transfer
from vibropipe.orbits.law.equations import fill_blocks, new_blocks
from vibropipe.orbits.law.flights import flight_of
from vibropipe.orbits.return_map import floquet_multipliers
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.law_orbit import ends_of_piece
from vibropipe.orbits.sensitivity.multipliers import DOUBLE
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED, H1, H2, K1, K2, MASS_RATIO, NU, H
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.load import forcing_period
from vibropipe.physics.quotient import divide
from vibropipe.physics.saltation import product
from vibropipe.physics.stiffness import piece_rate

# Index in `Parameters` of each parameter of the derivatives.
INDICES = np.array([Parameters._fields.index(name) for name in ALL_DIFFERENTIATED])
# Step of the differences: largest relative change of a parameter, and of a phase of a piece in radians. The error of
# fourth order and rounding are both some 1e-13.
STEP = 1e-3


@jit
def difference_step(e, p, orbit, j, size):
    """Return the step of a parameter along which column j of the derivatives is a difference; size : its scale."""
    fastest, turns_phases = 1.0 / size, orbit.columns[j] in (NU, H, K1, K2, H1, H2, MASS_RATIO)
    for i in range(orbit.u.shape[0]):
        if orbit.law.codes[i, FORM] in (HELD, RESTING):
            continue
        start, _end, turns = ends_of_piece(e, p, orbit, i)
        flight = flight_of(e, p, orbit.law, i, start.t, turns)
        rate = max(piece_rate(flight.stiffness, flight.damping), 2.0 * p.nu)
        if turns_phases:
            fastest = max(fastest, rate * flight.t / size)
        for event in (i, (i + 1) % orbit.u.shape[0]):
            moved = abs(orbit.du[event, 0, j]) if start.timed > 0.0 else 0.0
            fastest = max(fastest, rate * forcing_period(p) * moved)
    return STEP / fastest


@jit
def weight_of(factor):
    """Return the weight of f(factor step) in step f'(0): (f(-2) - 8 f(-1) + 8 f(1) - f(2)) / 12."""
    return (8.0 if abs(factor) == 1 else -2.0) / (12.0 * factor)


@jit
def fill_moved(e, values, orbit, j, moved, none, u, beside) -> None:
    """Fill the blocks of the orbit whose parameter of column j is larger by `moved`; none : (0,) int64.

    values : (1, parameters) float, changed and restored; u : (n, width) float, work space
    """
    index, (n, width) = INDICES[orbit.columns[j]], orbit.u.shape
    own = values[0, index]
    values[0, index] = own + moved
    for i in range(n):
        for part in range(width):
            u[i, part] = orbit.u[i, part] + moved * orbit.du[i, part, j]
    fill_blocks(e, row_parameters(values, 0), orbit.law, u, none, beside)
    values[0, index] = own


@jit
def step_of(e, values, orbit, j):
    """Return the step of the differences by column j."""
    p = row_parameters(values, 0)
    size = max(abs(values[0, INDICES[orbit.columns[j]]]), 0.1 * min(1.0, p.l))
    return difference_step(e, p, orbit, j, size)


@jit
def fill_slopes(e, values, orbit, j, none, beside, slopes) -> None:
    """Fill the derivatives of the blocks by column j, in `slopes`; arguments as for `fill_moved`."""
    step = step_of(e, values, orbit, j)
    slopes.before[:] = 0.0
    slopes.at[:] = 0.0
    for factor in range(-2, 3):
        if factor == 0:
            continue
        fill_moved(e, values, orbit, j, factor * step, none, slopes.rest, beside)
        weight = weight_of(factor) / step
        for i in range(orbit.u.shape[0]):
            for row in range(2):
                for c in range(2):
                    slopes.before[i, row, c] += weight * beside.before[i, row, c]
                    slopes.at[i, row, c] += weight * beside.at[i, row, c]


@jit
def slopes_of_invariants(e, values, orbit, j, none, beside, u):
    """Return the derivatives by column j of trace, principal minors and determinant of three rows."""
    step = step_of(e, values, orbit, j)
    by_trace, by_minors, by_last = 0.0, 0.0, 0.0
    for factor in range(-2, 3):
        if factor == 0:
            continue
        fill_moved(e, values, orbit, j, factor * step, none, u, beside)
        matrix, minors, determinant = return_map_of_three(beside.before, beside.at)
        weight = weight_of(factor) / step
        by_trace += weight * (matrix[0, 0] + matrix[1, 1] + matrix[2, 2])
        by_minors += weight * minors
        by_last += weight * determinant
    return by_trace, by_minors, by_last


@jit
def transfer_slope(blocks, slopes, i, t):
    """Return the derivative of a transfer t = -at^-1 before, -at^-1 (before' + at' t), from those of its blocks."""
    a, da, db = blocks.at[i], slopes.at[i], slopes.before[i]
    t11, t12, t21, t22 = t
    b11 = db[0, 0] + da[0, 0] * t11 + da[0, 1] * t21
    b12 = db[0, 1] + da[0, 0] * t12 + da[0, 1] * t22
    b21 = db[1, 0] + da[1, 0] * t11 + da[1, 1] * t21
    b22 = db[1, 1] + da[1, 0] * t12 + da[1, 1] * t22
    return less_inverse_times(a, b11, b12, b21, b22)


@jit
def trace_and_determinant_slopes(blocks, slopes):
    """Return the derivatives of trace and determinant of the return map."""
    (m11, m12, m21, m22), dm = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 0.0)
    determinant, slope = 1.0, 0.0
    for j in range(blocks.at.shape[0]):
        i = (j + 1) % blocks.at.shape[0]
        t11, t12, t21, t22 = transfer(blocks, i)
        d11, d12, d21, d22 = transfer_slope(blocks, slopes, i, (t11, t12, t21, t22))
        one = product(d11, d12, d21, d22, m11, m12, m21, m22)
        two = product(t11, t12, t21, t22, dm[0], dm[1], dm[2], dm[3])
        dm = (one[0] + two[0], one[1] + two[1], one[2] + two[2], one[3] + two[3])
        m11, m12, m21, m22 = product(t11, t12, t21, t22, m11, m12, m21, m22)
        by_piece = d11 * t22 + t11 * d22 - d12 * t21 - t12 * d21
        slope = slope * (t11 * t22 - t12 * t21) + determinant * by_piece
        determinant *= t11 * t22 - t12 * t21
    return dm[0] + dm[3], slope


@jit_allocating
def write_multiplier_derivatives(e, values, orbit, m, out, row) -> None:
    """Write the derivatives of multipliers and Lyapunov exponent, by those of trace and determinant of the return map.

    values : (1, parameters), parameters of the row; changed and restored
    orbit : VariedOrbit
    """
    n, none = orbit.u.shape[0], np.zeros(0, np.int64)
    beside = new_blocks(n, 0, e.housing)
    if e.housing is not None:
        write_three(e, values, orbit, m, out, row, none, beside)
        return
    slopes = new_blocks(n, 0, e.housing)
    first, second = floquet_multipliers(*orbit.return_map)
    # A rest erases all perturbations.
    is_erased, difference = first == 0.0, first - second
    length, nu = m * forcing_period(row_parameters(values, 0)), values[0, INDICES[NU]]
    for j in range(orbit.columns.size):
        k = orbit.columns[j]
        d_first, d_second = complex(0.0, 0.0), complex(0.0, 0.0)
        if not is_erased:
            if not abs(difference) > DOUBLE * abs(first):
                continue
            fill_slopes(e, values, orbit, j, none, beside, slopes)
            by_trace, slope = trace_and_determinant_slopes(orbit.blocks, slopes)
            d_first = divide(first * by_trace - slope, difference)
            d_second = divide(slope - second * by_trace, difference)
        if out.d_multipliers.size > 0:
            out.d_multipliers[row, 0, k], out.d_multipliers[row, 1, k] = d_first, d_second
        if out.d_exponent.size > 0 and not is_erased:
            out.d_exponent[row, k] = divide(d_first, first).real / length
            if k == NU:
                out.d_exponent[row, k] += math.log(abs(first)) / (length * nu)


@jit_allocating
def write_three(e, values, orbit, m, out, row, none, beside) -> None:
    """Write the derivatives of three multipliers, roots of a cubic; arguments as for `write_multiplier_derivatives`."""
    trace, minors, determinant = orbit.invariants
    roots, u = eigenvalues_of_cubic(trace, minors, determinant), np.empty(orbit.u.shape)
    length, nu = m * forcing_period(row_parameters(values, 0)), values[0, INDICES[NU]]
    rests = (orbit.law.codes[:, FORM] == RESTING).any()
    for j in range(orbit.columns.size):
        k = orbit.columns[j]
        by_trace, by_minors, by_last = slopes_of_invariants(e, values, orbit, j, none, beside, u)
        for which in range(3):
            root = roots[0] if which == 0 else roots[1] if which == 1 else roots[2]
            slope = (3.0 * root - 2.0 * trace) * root + minors
            if rests and root == 0.0 and slope == 0.0 and out.d_multipliers.size > 0:
                # A rest erases all perturbations but that of the momentum.
                out.d_multipliers[row, which, k] = 0.0
            if not abs(slope) > DOUBLE * abs(roots[0]) * abs(roots[0]):
                continue  # of a double root
            change = divide((root * by_trace - by_minors) * root + by_last, slope)
            if out.d_multipliers.size > 0:
                out.d_multipliers[row, which, k] = change
            if which == 0 and out.d_exponent.size > 0 and root != 0.0:
                out.d_exponent[row, k] = divide(change, root).real / length
                if k == NU:
                    out.d_exponent[row, k] += math.log(abs(root)) / (length * nu)
