"""Derivatives of what an orbit shows of its housing: velocity at the section, mean velocity, share of sliding, work."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.piece_log import HOME
from vibropipe.orbits.housing import GROUND, LOADS
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.momentum import momentum_rate
from vibropipe.orbits.law.sliding import friction_by, pull_by, way_of
from vibropipe.orbits.law.states import Momentum, momentum_after, sign_of
from vibropipe.orbits.sensitivity.law_orbit import (
    PLACE,
    RATE,
    TIME,
    ends_of_piece,
    fill_arrival,
    fill_departure,
)
from vibropipe.physics.derivatives import (
    HOUSING_LOAD,
    LOAD,
    MASS_RATIO,
    NU,
)
from vibropipe.physics.housing import ground_friction, momentum_share, total_load
from vibropipe.physics.load import forcing_period

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
def write_housing_derivatives(e, p, orbit, m, out, energy) -> None:
    """Write the derivatives of a housing of an orbit of m periods into out, (3, parameters).

    And those of the energies of the ground and of the loads into energy, (N_ENERGIES - 1, parameters) or empty. It
    drifts by (q_0 + q_1)/2 c t - c (x_1 - x_0) along a piece of the time t on which it slides, and not on others.
    """
    law, n, columns = orbit.law, orbit.u.shape[0], orbit.columns
    begin, end = np.empty((3, columns.size)), np.empty((3, columns.size))
    c, period = momentum_share(p), forcing_period(p)
    for k in columns:
        for row in range(3):
            out[row, k] = 0.0
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
