"""Outputs of the points of a branch of orbits by linear pieces: each is marched once, from its section."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.grid import exact_steps, grid_in_room, grid_time
from vibropipe.march.log import allow_work, clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.housing import STROBE, strobe_of, write_housing
from vibropipe.orbits.housing_jacobian import coupling_of
from vibropipe.orbits.outputs import (
    count_contacts,
    regime_of,
    write_energy,
    write_harmonics,
    write_impacts,
    write_largest,
    write_multipliers,
    write_smoothness,
)
from vibropipe.orbits.return_map import (
    gap_difference,
    momentum_change,
    multipliers_of,
    return_map_jacobian,
)
from vibropipe.orbits.room import new_work
from vibropipe.orbits.row import FIRST, UNRESOLVED, row_parameters
from vibropipe.orbits.settling import NO_CHAOS, SteadyState
from vibropipe.orbits.shooting import motion_norm
from vibropipe.orbits.verdict import PERIODIC
from vibropipe.physics.limits import MAX_ROW_WORK


@jit
def write_piece_point(e, p, section, m, march_room, work, largest, out, row, first) -> None:
    """Write the orbit from a section as a row, its impacts from index `first` on; arguments as `write_piece_points`."""
    log, c, grid_room = march_room
    x, v, velocity = section[0], section[1], 0.0
    if e.housing is not None and p.mass_ratio > 0.0:
        velocity = section[2]
    out.section[row, 0], out.section[row, 1] = x, v
    grid = grid_in_room(e, p, exact_steps(e, p), grid_room)
    clear_log(log)
    state = start_state(log.pieces, e, p, grid, 0.0, x, v, velocity)
    allow_work(log, MAX_ROW_WORK)
    end, status = march(
        e, p, grid, state, grid_time(float(m), grid.steps), log, None, c, 10_000_000
    )
    out.status[row] = status
    if status != OK:
        out.regime[row] = UNRESOLVED
        return
    dy, dw = gap_difference(e, p, end, state)
    norm = motion_norm(p, state, log)
    change = abs(dy) + abs(dw)
    if e.housing is not None:
        change += abs(momentum_change(e, p, end, state))
    closing = change / norm if norm > 0.0 else 0.0
    derivative = return_map_jacobian(e, p, log, state, end, m)
    one, two, three = multipliers_of(derivative, coupling_of(log.pieces))
    steady = SteadyState(PERIODIC, OK, m, state, end, closing, 0, one, two, NO_CHAOS, three)
    impacts, rests = out.impacts[row], out.rests[row]
    largest[0], largest[1] = 0.0, 0.0
    count_contacts(log, end, impacts, rests, largest)
    out.residual[row] = closing
    out.regime[row] = regime_of(impacts, rests)
    out.period_multiple[row] = m
    out.frequency[row] = p.nu / m
    write_multipliers(one, two, out.multipliers, row, three)
    if out.housing.size > 0:
        write_housing(log.pieces, p, steady, out.housing, row)
        out.housing[row, STROBE] = strobe_of(p, state.housing, v)
    write_largest(largest, impacts, out.impact_velocity_max, row)
    write_harmonics(e, p, steady, log, c, work, out.amplitudes, out.subharmonics, row)
    write_energy(e, p, steady, log, c, work, out, row)
    write_smoothness(log, out.grazes, out.releases, row)
    write_impacts(
        log, m, out.impact_count, out.impact_position, out.impact_velocity, out.impact_support,
        row, first,
    )  # fmt: skip


@jit_allocating
def write_piece_points(e, parameters, m, sections, march_room, out) -> None:
    """Write the orbits of the points of one branch as rows.

    Parameters
    ----------
    e : Effects
    parameters : (points, parameters) float
    m : int
        Period multiple.
    sections : (points, 2 or 3) float
        States at the section, as `march_pieces`, counted from the equilibrium.
    march_room
        As for `march_orbit`.
    out : RowResults
        Results, a row for each point; outputs without entries are not computed.
    """
    work, largest, first = new_work(out), np.zeros(2), FIRST
    for row in range(parameters.shape[0]):
        p, section = row_parameters(parameters, row), sections[row]
        write_piece_point(e, p, section, m, march_room, work, largest, out, row, first)
        first += out.impact_count[row]
