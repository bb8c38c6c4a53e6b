"""One row of a sweep: its steady state, and of its outputs those that are requested."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numba.extending import overload

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import exact_steps, grid_in_room
from vibropipe.march.loop import OK
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.closed_form import solve_conservative, solve_linear, write_forces_of_flight
from vibropipe.orbits.housing import (
    STROBE,
    continue_housing,
    strobe_of,
    write_housing,
    write_housing_harmonics,
)
from vibropipe.orbits.outputs import (
    count_contacts,
    count_grazings,
    orbit_exponent,
    regime_of,
    write_energy,
    write_harmonics,
    write_impacts,
    write_largest,
    write_multipliers,
    write_orbit_exponent,
    write_smoothness,
)
from vibropipe.orbits.return_map import state_xv
from vibropipe.orbits.settling import find_steady_state
from vibropipe.orbits.undamped import repeats_without_impact, solve_without_contact
from vibropipe.orbits.verdict import DRIFTING, PERIODIC, UNBOUNDED, UNDAMPED
from vibropipe.orbits.window import clear_window, window_of
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import support_position
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import REACH, fastest_rate
from vibropipe.physics.friction import friction_of
from vibropipe.physics.linear import settles_without_impact
from vibropipe.physics.load import fastest_of_row, forcing_period
from vibropipe.physics.stiffness import is_soft
from vibropipe.words.parameters import ACTED
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

APERIODIC_REGIME, UNBOUNDED_REGIME = int(Regime.APERIODIC), int(Regime.UNBOUNDED)
LOAD = Parameters._fields.index("load")
# Index of the first row and of its first impact: a numpy integer, because numba compiles another copy of the closed
# forms for a literal constant.
FIRST = np.int64(0)
UNRESOLVED, MAX_PERIODS = int(Regime.UNRESOLVED), int(Status.MAX_PERIODS)
# Steps of a forcing period above which a row is not marched: a period takes a tenth of what a row may.
MAX_STEPS_PER_PERIOD, MAX_STEPS = 5e6, int(Status.MAX_STEPS)


@jit
def aperiodic_regime(kind):
    """Return the code of `regime` for a motion without an orbit, from its kind (`settling`)."""
    if kind == UNBOUNDED:
        return UNBOUNDED_REGIME
    return UNRESOLVED if kind == DRIFTING else APERIODIC_REGIME


@jit_inline
def write_orbit(e, p, steady, log, c, work, largest, out, row, first) -> None:
    """Write what a closed orbit shows that its log and its states determine; arguments as for `march_row`.

    work : `room.new_work`; largest : (2,), updated with the largest impact velocities.
    """
    impacts, rests = out.impacts[row], out.rests[row]
    count_contacts(log, steady.end, impacts, rests, largest)
    out.regime[row] = regime_of(impacts, rests)
    out.period_multiple[row] = steady.m
    out.frequency[row] = p.nu / steady.m
    write_harmonics(e, p, steady, log, c, work, out.amplitudes, out.subharmonics, row)
    write_energy(e, p, steady, log, c, work, out, row)
    write_smoothness(log, out.grazes, out.releases, row)
    write_housing(log.pieces, p, steady, out.housing, row)
    write_housing_harmonics(log.pieces, e, p, steady.m, work[0], out.housing_harmonics, row)
    write_impacts(
        log, steady.m, out.impact_count, out.impact_position, out.impact_velocity,
        out.impact_support, row, first,
    )  # fmt: skip


@jit_inline
def write_closing(steady, largest, out, row) -> None:
    """Write how well a steady state closes, its multipliers, and its `largest` impact velocities, (2,)."""
    out.residual[row] = steady.residual
    write_multipliers(steady.first, steady.second, out.multipliers, row, steady.third)
    write_largest(largest, out.impacts[row], out.impact_velocity_max, row)


@jit
def march_row(e, p, x, v, limits, room, out, row, first):
    """Solve a row by marching.

    x, v : start of the motion
    limits : with max_periods and patience of `find_steady_state`, in forcing periods
    room : RowRoom
    out : RowResults; outputs without entries are not computed
    first : index of the first impact of the row

    Returns the stroboscopic section (x, v); the start if the row is not solved. In that case its regime is unresolved
    and its status gives the reason.
    """
    log, c = room.log, room.c
    out.section[row, 0], out.section[row, 1] = x, v
    fastest = fastest_rate(fastest_of_row(p), p.h)
    if not forcing_period(p) * fastest / REACH < MAX_STEPS_PER_PERIOD:
        out.regime[row], out.status[row] = UNRESOLVED, MAX_STEPS
        return x, v
    grid = grid_in_room(e, p, exact_steps(e, p), room.grid)
    velocity = 0.0
    if out.housing.size > 0 and p.mass_ratio > 0.0:
        velocity = out.housing[row, STROBE]
    state = start_state(log.pieces, e, p, grid, 0.0, x, v, velocity)
    window = window_of(p, out, row, first, room.sums, room.work)
    steady = find_steady_state(
        e, p, grid, state, log, c, limits.max_periods, limits.patience, window, room.sections
    )
    status, largest = steady.status, window.largest
    if status != MAX_PERIODS:
        clear_window(window)
    out.status[row] = status
    out.settled_after[row] = steady.periods_marched
    out.chaos[row] = steady.chaos
    if status != OK and status != MAX_PERIODS:
        out.regime[row] = UNRESOLVED
        return x, v
    if steady.kind == UNDAMPED:
        x, v = state_xv(p, steady.state)
        solve_without_contact(e, p, x, v, out, row, first, c)
    elif steady.kind == PERIODIC:
        write_orbit(e, p, steady, log, c, room.work, largest, out, row, first)
        count_grazings(log, steady.m, out.grazings[row])
        if out.exponent.size > 0:
            write_orbit_exponent(orbit_exponent(p, steady, out.impacts[row]), out.exponent, row)
    else:
        out.regime[row] = aperiodic_regime(steady.kind)
        out.window_periods[row] = int(window.start[2])
    if steady.kind != UNDAMPED:
        write_closing(steady, largest, out, row)
    x, v = state_xv(p, steady.state)
    out.section[row, 0], out.section[row, 1] = x, v
    if out.housing.size > 0:
        out.housing[row, STROBE] = strobe_of(p, steady.state.housing, v)
    return x, v


def _columns(values):
    """Return the parameters of a row as a tuple."""
    return tuple(values)


@overload(_columns)
def _compiled_columns(values):
    # The length of a compiled tuple is that of its expression, here of the records.
    columns = ", ".join(ACTED.get(name, name) for name in Parameters._fields)
    return eval(f"lambda values: ({_in_columns(columns)})")


def _in_columns(expression):
    """Return an expression of parameters as one of the columns of `values`."""
    column = {name: f"values[{index}]" for index, name in enumerate(Parameters._fields)}
    return re.sub(r"[A-Za-z_]\w*", lambda found: column[found[0]], expression)


def _fill_acted(values, acted):
    """Do as `fill_acted`, which is compiled."""


@overload(_fill_acted)
def _compiled_fill_acted(values, acted):
    lines = [f"acted[{n}] = {_in_columns(text)}" for n, text in enumerate(ACTED.values())]
    made: dict[str, Any] = {}
    exec("\n    ".join(["def fill(values, acted):", *lines]), made)
    return made["fill"]


@jit
def fill_acted(values, acted) -> None:
    """Fill the parameters of a row that others act on, in the order of `ACTED`, as kernels see them."""
    _fill_acted(values, acted)


@jit
def row_parameters(parameters, row):
    """Return row `row` of an array (rows, parameters) as `Parameters`, with what acts through others."""
    return Parameters(*_columns(parameters[row]))


@jit_inline
def next_impact(out, row, first):
    """Return the index of the first impact after those of a row, which begin at `first`."""
    return first + out.impact_count[row] if out.impact_count.size > 0 else first


@jit
def solve_closed_form_rows(e, parameters, starts, chain_length, row, x, v, out, first, c):
    """Solve rows in closed form up to the first that has to be marched.

    This loop is a function of its own because within the loop of marches a row in closed form takes four times as long.

    parameters : (rows, parameters)
    starts : (rows, 2), start (x, v) of the first row of each chain
    chain_length : rows per chain
    row : first row
    x, v : section of the row before, the start of this one within a chain
    first : index of the first impact of the first row
    c : work space, as for `march`

    Returns the first row that has to be marched, or the number of rows, its start (x, v), and the index of its first
    impact.
    """
    while row < parameters.shape[0]:
        p = row_parameters(parameters, row)
        if row % chain_length == 0:
            x, v = starts[row, 0], starts[row, 1]
        elif parameters[row, LOAD] != parameters[row - 1, LOAD]:
            # The same state, counted from another equilibrium.
            x += parameters[row - 1, LOAD] - parameters[row, LOAD]
        # The section of the row before may lie beyond a soft support.
        x = x if is_soft(e, p, 2) else max(x, support_position(p, 2))
        x = x if is_soft(e, p, 1) else min(x, support_position(p, 1))
        if friction_of(e, p) > 0.0 or (e.housing is not None and p.mass_ratio > 0.0):
            break
        is_rigid = not (is_soft(e, p, 1) or is_soft(e, p, 2))
        if settles_without_impact(p, x, v):
            x, v = solve_linear(p, out, row)
            write_forces_of_flight(e, p, x, v, out, row, c)
        elif e.watched is None and is_rigid and is_conservative(p, x, v):
            x, v = solve_conservative(p, x, v, out, row, first, c)
        elif repeats_without_impact(p, x, v):
            solve_without_contact(e, p, x, v, out, row, first, c)
        else:
            break
        out.section[row, 0], out.section[row, 1] = x, v
        first = next_impact(out, row, first)
        row += 1
    return row, x, v, first


@jit
def solve_row_chains(e, parameters, starts, chain_length, limits, room, out) -> None:
    """Solve rows in chains: each row starts from the section of the row before, the first from `starts`.

    parameters : (rows, parameters)
    starts : (rows, 2), start (x, v) of the first row of each chain
    chain_length : rows per chain
    limits, room : as for `march_row`
    """
    row, x, v, first = FIRST, 0.0, 0.0, FIRST
    while True:
        row, x, v, first = solve_closed_form_rows(
            e, parameters, starts, chain_length, row, x, v, out, first, room.c
        )
        if row == parameters.shape[0]:
            break
        p = row_parameters(parameters, row)
        continue_housing(out.housing, row, chain_length)
        x, v = march_row(e, p, x, v, limits, room, out, row, first)
        first = next_impact(out, row, first)
        row += 1
