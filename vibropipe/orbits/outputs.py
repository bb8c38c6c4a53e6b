"""The results of rows, and how each output is written from a closed orbit whose contacts are in the log."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.state import REST
from vibropipe.orbits.harmonics import add_support_forces, divide_by_stiffness
from vibropipe.orbits.quadrature import add_energy, replace_resonant_harmonics
from vibropipe.orbits.return_map import state_xv
from vibropipe.words.regimes import Regime

NO_IMPACT, ONE_SIDED_1, ONE_SIDED_2 = (
    int(Regime.NO_IMPACT),
    int(Regime.ONE_SIDED_1),
    int(Regime.ONE_SIDED_2),
)
TWO_SIDED, WITH_REST = int(Regime.TWO_SIDED), int(Regime.WITH_REST)


class RowResults(NamedTuple):
    """Arrays of results, first dimension the row (of impacts the second); an output that nobody asked for has no
    size."""

    regime: np.ndarray
    frequency: np.ndarray
    status: np.ndarray
    period_multiple: np.ndarray
    settled_after: np.ndarray
    window_periods: np.ndarray
    residual: np.ndarray
    section: np.ndarray
    impacts: np.ndarray
    rests: np.ndarray
    amplitudes: np.ndarray
    multipliers: np.ndarray
    impact_count: np.ndarray
    impact_position: np.ndarray
    impact_velocity: np.ndarray
    impact_support: np.ndarray
    impact_velocity_max: np.ndarray
    energy: np.ndarray
    motion: np.ndarray


@jit_inline
def count_contacts(log, end, impacts, rests, largest) -> None:
    """Add a log's impacts and rests on each support, and keep the largest impact velocities."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        side = log.support[i] - 1
        if side >= 0:
            impacts[side] += 1.0
            largest[side] = max(largest[side], abs(log.velocity[i]))
    for i in range(min(log.counts[RESTS], log.rest_start.size)):
        rests[log.rest_support[i] - 1] += 1.0
    if end.mode == REST and end.rest_start <= 0.0:
        # A rest over the whole orbit has no end in the log.
        rests[end.home - 1] += 1.0


@jit
def regime_of(impacts, rests) -> int:
    """The code of `regime` of an orbit with these impacts and rests on each support."""
    if rests[0] + rests[1] > 0.0:
        return WITH_REST
    if impacts[0] > 0.0 and impacts[1] > 0.0:
        return TWO_SIDED
    if impacts[0] > 0.0:
        return ONE_SIDED_1
    return ONE_SIDED_2 if impacts[1] > 0.0 else NO_IMPACT


# Outputs that nobody asked for are arrays of no size: one compiled driver serves every choice of outputs.


@jit_allocating
def write_harmonics(e, p, settled, log, c, amplitudes, row) -> None:
    """Amplitudes X(k nu/m), k = 0, 1, ..., of a closed orbit whose contacts are in the log."""
    if amplitudes.size > 0:
        m, end = settled.m, settled.end
        resting = end.home if end.mode == REST else 0
        add_support_forces(p, log, resting, end.rest_start, m, float(m), amplitudes[row])
        if not divide_by_stiffness(p, m, float(m), amplitudes[row]):
            x, v = state_xv(p, settled.state)
            replace_resonant_harmonics(e, p, x, v, end, log, m, amplitudes[row], np.zeros(2), c)


@jit
def write_multipliers(first, second, multipliers, row) -> None:
    """Both Floquet multipliers."""
    if multipliers.size > 0:
        multipliers[row, 0] = first
        multipliers[row, 1] = second


@jit_allocating
def write_energy(e, p, settled, log, c, energy, row) -> None:
    """Work of the force, loss by damping, loss at support 1 and at support 2, over a closed orbit."""
    if energy.size > 0:
        x, v = state_xv(p, settled.state)
        stop = float(settled.m)
        add_energy(e, p, x, v, 0.0, stop, settled.end, log, energy[row], c)


@jit
def write_impacts(log, m, count, position, velocity, support, row) -> None:
    """The impacts of an orbit of m periods, in order and at positions in [0, m)."""
    if count.size > 0:
        n = 0
        for at_end in range(1, -1, -1):
            for i in range(min(log.counts[IMPACTS], log.position.size)):
                # An impact at the end of the orbit is the one at its beginning.
                if log.support[i] > 0 and (log.position[i] >= m) == (at_end == 1):
                    position[n, row] = log.position[i] - at_end * m
                    velocity[n, row] = log.velocity[i]
                    support[n, row] = log.support[i]
                    n += 1
        count[row] = n


@jit
def write_largest(largest_seen, impacts, largest, row) -> None:
    """The largest impact velocity on each support; nan where there was none."""
    if largest.size > 0:
        for side in range(2):
            largest[row, side] = largest_seen[side] if impacts[side] > 0.0 else math.nan
