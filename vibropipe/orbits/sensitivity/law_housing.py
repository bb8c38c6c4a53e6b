"""Derivatives of what an orbit shows of its housing: velocities, share of sliding, work, and its acceleration."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.piece_log import FORM, HELD, HOME, RESTING
from vibropipe.orbits.housing import GROUND, LOADS
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.momentum import momentum_rate
from vibropipe.orbits.law.sliding import friction_by, pull_by, way_of
from vibropipe.orbits.law.states import Momentum, momentum_after, sign_of
from vibropipe.orbits.sensitivity.law_integrals import add_moving, add_still, reference_derivative
from vibropipe.orbits.sensitivity.law_orbit import (
    PLACE,
    RATE,
    TIME,
    ends_of_piece,
    fill_arrival,
    fill_departure,
)
from vibropipe.physics.derivatives import HOUSING_LOAD, LOAD, MASS_RATIO, NU
from vibropipe.physics.housing import ground_friction, momentum_share, total_load
from vibropipe.physics.load import forcing_period
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral

# Rows of the derivatives.
AT_SECTION, MEAN, SHARE = range(3)


@jit
def share_by(p, k) -> float:
    """Return the derivative of c by parameter k."""
    return 1.0 / ((1.0 + p.mass_ratio) * (1.0 + p.mass_ratio)) if k == MASS_RATIO else 0.0


@jit
def change_of(momentum: Momentum, du, j) -> float:
    """Return the derivative of a momentum by column j, from those of the unknowns of its event."""
    return momentum.q_1 * du[1, j] + momentum.q_2 * du[2, j]


@jit_allocating
def write_housing_derivatives(e, p, orbit, m, rows, row, energy) -> None:
    """Write the derivatives of a housing of an orbit of m periods into a row of `RowResults`.

    And those of the energies of the ground and of the loads into energy, (N_ENERGIES - 1, parameters) or empty. It
    drifts by (q_0 + q_1)/2 c t - c (x_1 - x_0) along a piece of the time t on which it slides, and not on others.
    """
    law, n, columns, out = orbit.law, orbit.u.shape[0], orbit.columns, rows.d_housing[row]
    begin, end = np.empty((3, columns.size)), np.empty((3, columns.size))
    c, period = momentum_share(p), forcing_period(p)
    for k in columns:
        for quantity in range(3):
            out[quantity, k] = 0.0
        if energy.size > 0:
            energy[GROUND, k], energy[LOADS, k] = 0.0, 0.0
    drift = 0.0
    for i in range(n):
        if law.codes[i, WAY] == 0:
            continue
        start, stop, turns = ends_of_piece(e, p, orbit, i)
        fill_departure(e, p, orbit, i, begin)
        fill_arrival(e, p, orbit, (i + 1) % n, end)
        momentum, sigma, way = (
            momentum_after(e, p, law, i, orbit.u),
            sign_of(law.codes[i, HOME]),
            way_of(law, i),
        )
        rate, t = momentum_rate(p, law, i), turns * period
        own = momentum.q * t + 0.5 * rate * t * t - (stop.y - start.y)
        drift += sigma * c * own
        for j in range(columns.size):
            k = columns[j]
            dq = change_of(momentum, orbit.du[i], j)
            dt = period * (end[TIME, j] - begin[TIME, j])
            if k == NU:
                dt -= t / p.nu
            by = t * dq + (momentum.q + rate * t) * dt
            by += 0.5 * t * t * sigma * pull_by(way, k) - (end[PLACE, j] - begin[PLACE, j])
            moved, gone = sigma * (c * by + share_by(p, k) * own), sigma * c * own
            out[MEAN, k] += moved
            if energy.size > 0:
                energy[GROUND, k] += ground_friction(p, way) * moved + friction_by(way, k) * gone
                energy[LOADS, k] += total_load(p) * moved
                if k in (LOAD, HOUSING_LOAD):
                    energy[LOADS, k] += gone
            out[SHARE, k] += (end[TIME, j] - begin[TIME, j]) / m
            if i == 0:
                slow = momentum.q - start.w
                out[AT_SECTION, k] = sigma * (c * (dq - begin[RATE, j]) + share_by(p, k) * slow)
    for k in columns:
        out[MEAN, k] /= m * period
        if k == NU:
            out[MEAN, k] += drift / (m * period * p.nu)
    if rows.d_housing_harmonics.size > 0:
        by = rows.d_housing_harmonics[row]
        write_derivatives_of_harmonics(e, p, orbit, m, rows.housing_harmonics[row], by)


@jit
def slope_integral(cycles, start, end) -> complex:
    """Return the integral of (t - start) exp(-2 pi i cycles t) over t from start to end; cycles > 0."""
    whole = phase_integral(cycles, start, end) - (end - start) * phase_factor(cycles * end)
    return whole * complex(0.0, -1.0 / (TWO_PI * cycles))


@jit_allocating
def add_velocity_derivatives(e, p, orbit, i, m, changes, waves, out):
    """Add the derivatives of the integrals of X' exp(-2 pi i k t) over piece i, on which the housing slides.

    By parts x' needs its ends and the derivatives of the integral of x at a fixed phase. What the rates by nu and c of
    whole integrals give is left out.

    changes : tuple of two (3, parameters) arrays, derivatives of the state at start and end
    waves : (n, parameters) complex, work array
    out : (n, parameters) complex

    Returns the momentum at the start of the piece, and its rate, times c, along x.
    """
    law, columns, period = orbit.law, orbit.columns, forcing_period(p)
    start, _stop, turns = ends_of_piece(e, p, orbit, i)
    (begin, end), home, way, u = changes, law.codes[i, HOME], way_of(law, i), orbit.u
    momentum, sigma, c = momentum_after(e, p, law, i, u), sign_of(home), momentum_share(p)
    rate, last = momentum_rate(p, law, i), start.t + turns
    node, nothing = np.zeros((2, columns.size)), np.zeros((0, columns.size))
    waves[:] = 0.0
    sums = waves, waves[:0], nothing
    if law.codes[i, FORM] in (HELD, RESTING):
        add_still(e, p, orbit, i, m, begin, sums)
    else:
        add_moving(e, p, orbit, i, m, begin, node, sums)
    for k in range(1, out.shape[0]):
        first, late = phase_factor(k * start.t), phase_factor(k * last)
        whole, slope = phase_integral(k, start.t, last), slope_integral(k, start.t, last)
        for j in range(columns.size):
            by, origin = columns[j], reference_derivative(home, columns[j])
            dq, faster = change_of(momentum, orbit.du[i], j), sigma * pull_by(way, by)
            if by == NU:
                faster -= rate / p.nu
            gained = (dq - rate * period * begin[TIME, j]) * whole + faster * period * slope
            gained += (momentum.q + rate * turns * period) * late * end[TIME, j]
            gained -= momentum.q * first * begin[TIME, j]
            ahead, behind = origin + sigma * end[PLACE, j], origin + sigma * begin[PLACE, j]
            moved = ahead * late - behind * first + complex(0.0, TWO_PI * k) * m * waves[k, j]
            out[k, by] += c * (sigma * gained - moved * (1.0 / period))
    return sigma * c * momentum.q, sigma * c * rate


@jit_allocating
def write_derivatives_of_harmonics(e, p, orbit, m, harmonics, out) -> None:
    """Write the derivatives of the harmonics of X'', impacts included, which are i k nu times those of X'.

    orbit : VariedOrbit
    harmonics : (n,) complex, of X'', in multiples of nu
    out : (n, parameters) complex
    """
    n, law, period, c = harmonics.size, orbit.law, forcing_period(p), momentum_share(p)
    begin, end = np.empty((3, orbit.columns.size)), np.empty((3, orbit.columns.size))
    waves, momenta = np.empty((n, orbit.columns.size), np.complex128), np.zeros(n, np.complex128)
    for by in orbit.columns:
        for k in range(n):
            out[k, by] = 0.0
    for i in range(orbit.u.shape[0]):
        if law.codes[i, WAY] == 0:
            continue
        fill_departure(e, p, orbit, i, begin)
        fill_arrival(e, p, orbit, (i + 1) % orbit.u.shape[0], end)
        q, rate = add_velocity_derivatives(e, p, orbit, i, m, (begin, end), waves, out)
        start, _stop, turns = ends_of_piece(e, p, orbit, i)
        for k in range(1, n):
            last = start.t + turns
            momenta[k] += q * phase_integral(k, start.t, last)
            momenta[k] += rate * period * slope_integral(k, start.t, last)
    for k in range(1, n):
        factor = complex(0.0, k * p.nu)
        velocity = harmonics[k] * complex(0.0, -1.0 / (k * p.nu))
        for by in orbit.columns:
            change = out[k, by] * (1.0 / m)
            if by == NU:
                # x' is a derivative by phase times nu, and so is X''.
                change += (velocity - momenta[k] * (1.0 / m) + velocity) * (1.0 / p.nu)
            elif c > 0.0:
                change += share_by(p, by) / c * velocity
            out[k, by] = factor * change
