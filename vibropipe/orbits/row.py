"""One row of a sweep: its steady state, and of it only the outputs that have somewhere to go."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.grid import exact_grid, grid_time
from vibropipe.march.log import SAMPLES, Samples
from vibropipe.march.loop import OK, march
from vibropipe.march.state import initial_state
from vibropipe.orbits.closed_form import solve_conservative, solve_linear
from vibropipe.orbits.outputs import (
    count_contacts,
    regime_of,
    write_energy,
    write_harmonics,
    write_impacts,
    write_largest,
    write_multipliers,
)
from vibropipe.orbits.return_map import clear_log, state_xv
from vibropipe.orbits.settling import DRIFTING, PERIODIC, UNBOUNDED, find_steady_state
from vibropipe.orbits.window import clear_window, new_window
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import support_position
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import REACH, fastest_rate
from vibropipe.physics.linear import settles_without_impact
from vibropipe.physics.load import forcing_period
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

APERIODIC_REGIME, UNBOUNDED_REGIME = int(Regime.APERIODIC), int(Regime.UNBOUNDED)
UNRESOLVED, MAX_PERIODS = int(Regime.UNRESOLVED), int(Status.MAX_PERIODS)
# Steps of a forcing period beyond which a row is not marched: half a second, and some minutes for the row.
MAX_STEPS_PER_PERIOD, MAX_STEPS = 1e8, int(Status.MAX_STEPS)


@jit
def aperiodic_regime(kind):
    """The code of `regime` of a motion that found no orbit within its bound on periods."""
    if kind == UNBOUNDED:
        return UNBOUNDED_REGIME
    return UNRESOLVED if kind == DRIFTING else APERIODIC_REGIME


@jit_allocating
def march_row(e, p, x, v, max_periods, patience, log, c, out, row):
    """A row that has to be marched; returns the (x, v) at its section.

    Where it is not solved its regime is unresolved, its status says why, and (x, v) are those it began with.
    """
    out.section[row, 0], out.section[row, 1] = x, v
    if not forcing_period(p) * fastest_rate(p.nu, p.h) / REACH < MAX_STEPS_PER_PERIOD:
        out.regime[row], out.status[row] = UNRESOLVED, MAX_STEPS
        return x, v
    grid = exact_grid(e, p)
    state = initial_state(e, p, grid, 0.0, x, v)
    impacts, rests = out.impacts[row], out.rests[row]
    window = new_window(p, out.amplitudes, row, impacts, rests)
    settled = find_steady_state(e, p, grid, state, log, c, max_periods, patience, window)
    status, largest = settled.status, window.largest
    if status != MAX_PERIODS:
        clear_window(window)
    out.status[row] = status
    out.settled_after[row] = settled.periods_marched
    if status != OK and status != MAX_PERIODS:
        out.regime[row] = UNRESOLVED
        return x, v
    if settled.kind == PERIODIC:
        count_contacts(log, settled.end, impacts, rests, largest)
        out.regime[row] = regime_of(impacts, rests)
        out.period_multiple[row] = settled.m
        out.frequency[row] = p.nu / settled.m
        write_harmonics(e, p, settled, log, c, out.amplitudes, row)
        write_energy(e, p, settled, log, c, out.energy, row)
        write_impacts(
            log,
            settled.m,
            out.impact_count,
            out.impact_position,
            out.impact_velocity,
            out.impact_support,
            row,
        )
    else:
        out.regime[row] = aperiodic_regime(settled.kind)
        out.window_periods[row] = int(window.start[2])
    out.residual[row] = settled.residual
    write_multipliers(settled.first, settled.second, out.multipliers, row)
    write_largest(largest, impacts, out.impact_velocity_max, row)
    x, v = state_xv(p, settled.state)
    out.section[row, 0], out.section[row, 1] = x, v
    return x, v


@jit
def row_parameters(parameters, row):
    """(nu, f, h, l, delta, R1, R2) of a row of numbers (rows, 7), by name."""
    return Parameters(
        parameters[row, 0],
        parameters[row, 1],
        parameters[row, 2],
        parameters[row, 3],
        parameters[row, 4],
        parameters[row, 5],
        parameters[row, 6],
    )


@jit_allocating
def solve_closed_form_rows(e, parameters, starts, chain_length, row, x, v, out):
    """Solve rows from `row` on in closed form, up to the first that has to be marched: (that row, its start).

    A function of its own: amid a march a row in closed form takes four times as long. x, v: the section of the
    row before, which seeds this one within a chain.
    """
    while row < parameters.shape[0]:
        p = row_parameters(parameters, row)
        if row % chain_length == 0:
            x, v = starts[row, 0], starts[row, 1]
        x = min(max(x, support_position(p, 2)), support_position(p, 1))
        if settles_without_impact(p, x, v):
            x, v = solve_linear(p, out, row)
        elif e.watched is None and is_conservative(p, x, v):
            x, v = solve_conservative(p, x, v, out, row)
        else:
            break
        out.section[row, 0], out.section[row, 1] = x, v
        row += 1
    return row, x, v


@jit_allocating
def solve_row_chains(
    e, parameters, starts, chain_length, max_periods, patience, log, c, out
) -> None:
    """Solve rows (rows, 7) into `out` in chains of chain_length, each row of a chain seeded by the one before it
    and the first by starts (rows, 2).

    max_periods, patience: as for `find_steady_state`.
    """
    row, x, v = 0, 0.0, 0.0
    while True:
        row, x, v = solve_closed_form_rows(e, parameters, starts, chain_length, row, x, v, out)
        if row == parameters.shape[0]:
            break
        p = row_parameters(parameters, row)
        x, v = march_row(e, p, x, v, max_periods, patience, log, c, out, row)
        row += 1


@jit_allocating
def sample_row(e, p, x, v, m, log, c, motion, row) -> None:
    """Samples of a closed orbit of multiple m from its section (x, v), at equal fractions of it, into
    motion[row] (2, samples); nan where that march comes to no end."""
    grid = exact_grid(e, p)
    samples = Samples(motion[row, 0], motion[row, 1], m, motion.shape[2], 0, 0.0)
    clear_log(log)
    log.counts[SAMPLES] = 0
    state = initial_state(e, p, grid, 0.0, x, v)
    _end, status = march(
        e, p, grid, state, grid_time(float(m), grid.steps), log, samples, c, 10_000_000
    )
    if status != OK:
        motion[row] = math.nan
