"""One row of a sweep: its steady state, and of it only the outputs that have somewhere to go."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.jit import jit, jit_allocating
from vibropipe.kernels.grid import exact_grid
from vibropipe.kernels.harmonics import RESONANT, add_contacts, admittance, close
from vibropipe.kernels.march import OK, REST, begin, march
from vibropipe.kernels.orbit import LOG_FULL, at_period_zero, clear, periods, section
from vibropipe.kernels.quadrature import along_orbit, mend_resonance
from vibropipe.kernels.record import IMPACTS, RESTS, SAMPLES, Samples
from vibropipe.kernels.steady import EVENTS_PER_PERIOD, ONE, PERIODIC, UNBOUNDED, settle_motion
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.forcing import TWO_PI
from vibropipe.status import Status
from vibropipe.vocabulary import Regime

NO_IMPACT, ONE_SIDED_1, ONE_SIDED_2 = int(Regime.NO_IMPACT), int(Regime.ONE_SIDED_1), int(Regime.ONE_SIDED_2)
TWO_SIDED, WITH_REST, UNRESOLVED = int(Regime.TWO_SIDED), int(Regime.WITH_REST), int(Regime.UNRESOLVED)
APERIODIC_REGIME, UNBOUNDED_REGIME = int(Regime.APERIODIC), int(Regime.UNBOUNDED)
MAX_PERIODS = int(Status.MAX_PERIODS)
WINDOW = 256


class Rows(NamedTuple):
    """Arrays of results, first dimension the row; an output that nobody asked for is None."""

    regime: np.ndarray
    status: np.ndarray
    period_multiple: np.ndarray
    settled_after: np.ndarray
    window: np.ndarray
    residual: np.ndarray
    section: np.ndarray
    impacts: np.ndarray
    rests: np.ndarray
    amplitudes: np.ndarray | None
    multipliers: np.ndarray | None
    impact_count: np.ndarray | None
    impact_position: np.ndarray | None
    impact_velocity: np.ndarray | None
    impact_support: np.ndarray | None
    largest: np.ndarray | None
    energy: np.ndarray | None
    motion: np.ndarray | None


@jit
def count_contacts(log, end, impacts, rests, largest) -> None:
    """Add a log's impacts and rests on each support, and keep the largest impact velocities."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        side = log.support[i] - 1
        if side >= 0:
            impacts[side] += 1.0
            largest[side] = max(largest[side], abs(log.velocity[i]))
    for i in range(min(log.counts[RESTS], log.rest_start.size)):
        rests[log.rest_support[i] - 1] += 1.0
    if end.order == REST and end.rest_start <= 0.0:
        # A rest over the whole orbit has no end in the log.
        rests[end.home - 1] += 1.0


@jit
def _regime(impacts, rests) -> int:
    if rests[0] + rests[1] > 0.0:
        return WITH_REST
    if impacts[0] > 0.0 and impacts[1] > 0.0:
        return TWO_SIDED
    if impacts[0] > 0.0:
        return ONE_SIDED_1
    return ONE_SIDED_2 if impacts[1] > 0.0 else NO_IMPACT


# numba prunes a branch on `argument is None` before it types the code, but only for plain arguments: so each
# output has a function of its own, with its array as an argument.


@jit_allocating
def _write_harmonics(p, settled, log, c, amplitudes, row) -> None:
    """Amplitudes X(k nu/m), k = 0, 1, ..., of a closed orbit whose contacts are in the log."""
    if amplitudes is not None:
        m, end = settled.m, settled.end
        resting = end.home if end.order == REST else 0
        add_contacts(p, log, resting, end.rest_start, m, float(m), amplitudes[row])
        if not close(p, m, float(m), amplitudes[row]):
            x, v = section(p, settled.state)
            mend_resonance(p, x, v, end, log, m, amplitudes[row], np.zeros(2), c)


@jit
def _write_multipliers(first, second, multipliers, row) -> None:
    if multipliers is not None:
        multipliers[row, 0] = first
        multipliers[row, 1] = second


@jit_allocating
def _write_energy(p, settled, log, c, energy, row) -> None:
    """Work of the force, loss by damping, loss at support 1 and at support 2, over a closed orbit."""
    if energy is not None:
        x, v = section(p, settled.state)
        none = np.zeros(0, np.complex128)
        along_orbit(p, x, v, settled.end, log, settled.m, none, energy[row], c)
        for i in range(min(log.counts[IMPACTS], log.position.size)):
            before, impulse = log.velocity[i], log.impulse[i]
            side = abs(log.support[i]) - 1
            if log.support[i] > 0:
                energy[row, 2 + side] -= impulse * (before + 0.5 * impulse)
            else:
                energy[row, 2 + side] += tail_loss(p, impulse, side)


@jit
def tail_loss(p, impulse, side):
    """Energy lost in the completed tail of a chatter that carries `impulse`: all of its departure speed."""
    restitution = p.R1 if side == 0 else p.R2
    speed = abs(impulse) * (1.0 - restitution) / (1.0 + restitution) if restitution < 1.0 else abs(impulse)
    return 0.5 * speed * speed


@jit
def _write_impacts(log, count, position, velocity, support, row) -> None:
    if count is not None:
        n = 0
        for i in range(min(log.counts[IMPACTS], log.position.size)):
            if log.support[i] > 0 and n < position.shape[1]:
                position[row, n] = log.position[i]
                velocity[row, n] = log.velocity[i]
                support[row, n] = log.support[i]
                n += 1
        count[row] = n


@jit
def _write_largest(largest_seen, impacts, largest, row) -> None:
    if largest is not None:
        for side in range(2):
            largest[row, side] = largest_seen[side] if impacts[side] > 0.0 else math.nan


@jit_allocating
def _write_motion(e, p, grid, settled, log, c, motion, row) -> None:
    """Samples of the closed orbit at equal fractions of it; empties the log."""
    if motion is not None:
        samples = Samples(motion[row, 0], motion[row, 1], settled.m, motion.shape[2], 0, 0.0)
        clear(log)
        log.counts[SAMPLES] = 0
        march(
            e, p, grid, settled.state, settled.m, 0, 0.0, log, samples, c, 10_000_000
        )


@jit
def _add_to_window(p, log, state, amplitudes, row) -> None:
    if amplitudes is not None:
        resting = state.home if state.order == REST else 0
        add_contacts(p, log, resting, state.rest_start, 1, 1.0, amplitudes[row])


@jit
def _close_window(p, dx, dv, amplitudes, row) -> None:
    """Amplitudes at multiples of nu from WINDOW periods over which x and x' changed by dx, dv."""
    if amplitudes is not None:
        for k in range(amplitudes.shape[1]):
            # The ends of the window do not meet: the boundary terms of the partial integration stay.
            amplitudes[row, k] -= (dv + complex(p.h, k * p.nu) * dx) * p.nu / TWO_PI
        close(p, 1, float(WINDOW), amplitudes[row])
        for k in range(amplitudes.shape[1]):
            if abs(admittance(p, k, 1)) < RESONANT:
                amplitudes[row, k] = complex(math.nan, math.nan)


@jit_allocating
def _window(e, p, grid, state, log, c, amplitudes, row, impacts, rests, largest):
    """What a motion without an orbit shows over WINDOW forcing periods: means per period, and amplitudes at
    multiples of nu; returns its last state."""
    x0, v0 = section(p, state)
    for _ in range(WINDOW):
        state = at_period_zero(state)
        clear(log)
        state, status = periods(e, p, grid, state, ONE, log, c, EVENTS_PER_PERIOD)
        if status != OK and status != LOG_FULL:
            break
        count_contacts(log, state, impacts, rests, largest)
        _add_to_window(p, log, state, amplitudes, row)
    for side in range(2):
        impacts[side] /= WINDOW
        rests[side] /= WINDOW
    x, v = section(p, state)
    _close_window(p, x - x0, v - v0, amplitudes, row)
    return state


@jit_allocating
def solve_row(parameters, x, v, max_periods, log, c, out, row):
    """Solve one row into `out`; returns the (x, v) at its section, to seed a neighbour.

    parameters: (nu, f, h, l, delta, R1, R2).
    """
    e = Effects(1, 1, 1, 1, 1, 1)
    p = Parameters(
        parameters[0], parameters[1], parameters[2], parameters[3], parameters[4], parameters[5], parameters[6]
    )  # fmt: skip
    grid = exact_grid(e, p)
    state = begin(e, p, grid, 0.0, x, v)
    settled = settle_motion(e, p, grid, state, log, c, max_periods)
    impacts, rests, largest = out.impacts[row], out.rests[row], np.zeros(2)
    status, last = settled.status, settled.state
    if settled.kind == PERIODIC:
        count_contacts(log, settled.end, impacts, rests, largest)
        out.regime[row] = _regime(impacts, rests)
        out.period_multiple[row] = settled.m
        _write_harmonics(p, settled, log, c, out.amplitudes, row)
        _write_energy(p, settled, log, c, out.energy, row)
        _write_impacts(
            log, out.impact_count, out.impact_position, out.impact_velocity, out.impact_support, row
        )
        _write_motion(e, p, grid, settled, log, c, out.motion, row)
        if status == LOG_FULL:
            out.regime[row] = UNRESOLVED
    elif status == MAX_PERIODS:
        out.regime[row] = UNBOUNDED_REGIME if settled.kind == UNBOUNDED else APERIODIC_REGIME
        out.window[row] = WINDOW
        last = _window(
            e, p, grid, settled.end, log, c, out.amplitudes, row, impacts, rests, largest
        )
    else:
        out.regime[row] = UNRESOLVED
    out.status[row] = status
    out.settled_after[row] = settled.settled_after
    out.residual[row] = settled.residual
    _write_multipliers(settled.first, settled.second, out.multipliers, row)
    _write_largest(largest, impacts, out.largest, row)
    x, v = section(p, last)
    out.section[row, 0], out.section[row, 1] = x, v
    return x, v
