"""Outputs of the points of a branch: each orbit is known by its impacts, so nothing is marched.

An orbit by linear pieces is known by its law: it is marched once, from its section.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import GRAZINGS, IMPACTS, RESTS, TAILS
from vibropipe.march.loop import OK
from vibropipe.march.state import FLIGHT, State
from vibropipe.orbits.branches.sequence import eigenvalues, fill_equations, return_derivative
from vibropipe.orbits.closed_form import solve_linear, write_forces_of_flight
from vibropipe.orbits.housing import STROBE, strobe_of
from vibropipe.orbits.housing_jacobian import coupling_of
from vibropipe.orbits.law.marching import march_orbit
from vibropipe.orbits.return_map import (
    gap_difference,
    momentum_change,
    multipliers_of,
    return_map_jacobian,
)
from vibropipe.orbits.room import new_work
from vibropipe.orbits.row import FIRST, UNRESOLVED, row_parameters, write_closing, write_orbit
from vibropipe.orbits.settling import NO_CHAOS, SteadyState
from vibropipe.orbits.shooting import motion_norm
from vibropipe.orbits.verdict import PERIODIC
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.forced_flow import fly_freely


@jit
def log_impacts(p, m, supports, u, log) -> None:
    """Fill an empty log with the impacts of an orbit, in order of time and at positions in [0, m).

    supports : (n,) int8, struck in turn over the whole orbit
    u : (2n,) or longer, times in forcing periods, which increase, and velocities
    """
    n, first = supports.size, 0
    for kind in (IMPACTS, RESTS, GRAZINGS, TAILS):
        log.counts[kind] = 0
    for i in range(n):
        # The impact after the wrap comes first.
        if i > 0 and math.floor(u[i] / m) > math.floor(u[i - 1] / m):
            first = i
    for k in range(n):
        i = (first + k) % n
        log.position[k] = u[i] - m * math.floor(u[i] / m)
        log.velocity[k] = u[n + i]
        log.impulse[k] = -(1.0 + restitution_at(p, supports[i])) * u[n + i]
        log.support[k] = supports[i]
    log.counts[IMPACTS] = n


@jit
def orbit_multipliers(p, m, supports, u):
    """Return the Floquet multipliers; infinite and 0 where an impact has no speed."""
    trace, determinant = return_derivative(p, float(m), 0, supports, u)
    if not abs(trace) < math.inf:
        return complex(math.inf, 0.0), complex(0.0, 0.0)
    return eigenvalues(trace, determinant)


@jit
def closing_residual(p, m, supports, u, residual, none):
    """Return the largest residual of the equations of an orbit, relative to its largest speed or displacement."""
    n, size = supports.size, p.l
    fill_equations(p, float(m), 0, supports, u, residual, none)
    largest = 0.0
    for k in range(n):
        size = max(size, abs(u[n + k]))
        largest = max(largest, abs(residual[2 * k]) + abs(residual[2 * k + 1]))
    return largest / size


@jit_allocating
def write_points(e, parameters, m, supports, unknowns, log, c, residual, out) -> None:
    """Write the orbits of the points of one branch as rows.

    parameters : (points, parameters)
    supports : (n,) int8, struck in turn over the whole orbit; without impacts the motion is that in closed form
    unknowns : (points, 2n + 1), times in forcing periods, velocities, and the parameter
    log, c : work space, as for `march`
    residual : (2n,) or longer, work space
    out : RowResults, a row for each point; outputs without entries are not computed
    """
    n, none, work = supports.size, np.empty((0, 0)), new_work(out)
    for row in range(parameters.shape[0]):
        p, u = row_parameters(parameters, row), unknowns[row]
        if n == 0:
            x, v = solve_linear(p, out, row)
            write_forces_of_flight(e, p, x, v, out, row, c)
            out.section[row, 0], out.section[row, 1] = x, v
            continue
        log_impacts(p, m, supports, u, log)
        last = n - 1
        x = support_position(p, log.support[last])
        v = -restitution_at(p, log.support[last]) * log.velocity[last]
        x, v, _e11, _e12, _e21, _e22 = fly_freely(p, log.position[last] - m, 0.0, x, v)
        state = State(0, 0, 0.0, 0, x, v, FLIGHT, 0.0, None)
        first, second = orbit_multipliers(p, m, supports, u)
        closing = closing_residual(p, m, supports, u, residual, none)
        steady = SteadyState(
            PERIODIC, OK, m, state, state, closing, 0, first, second, NO_CHAOS, complex(0.0, 0.0)
        )  # fmt: skip
        residual[0], residual[1] = 0.0, 0.0
        write_orbit(e, p, steady, log, c, work, residual, out, row, row * n)
        write_closing(steady, residual, out, row)
        out.section[row, 0], out.section[row, 1] = x, v


@jit
def write_piece_point(e, p, section, m, march_room, work, largest, out, row, first) -> None:
    """Write the orbit from a section as a row, its impacts from index `first` on; arguments as `write_piece_points`."""
    log, c, _grid_room = march_room
    x, v, velocity = section[0], section[1], 0.0
    if e.housing is not None and p.mass_ratio > 0.0:
        velocity = section[2]
    out.section[row, 0], out.section[row, 1] = x, v
    state, end, status = march_orbit(e, p, 0.0, x, v, velocity, m, march_room)
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
    largest[0], largest[1] = 0.0, 0.0
    write_orbit(e, p, steady, log, c, work, largest, out, row, first)
    write_closing(steady, largest, out, row)
    if out.housing.size > 0:
        out.housing[row, STROBE] = strobe_of(p, state.housing, v)


@jit_allocating
def write_piece_points(e, parameters, m, sections, march_room, out) -> None:
    """Write the orbits of the points of one branch as rows.

    parameters : (points, parameters)
    sections : (points, 2 or 3), states at the section, as `march_pieces`, counted from the equilibrium
    march_room : as for `march_orbit`
    out : RowResults, a row for each point; outputs without entries are not computed
    """
    work, largest, first = new_work(out), np.zeros(2), FIRST
    for row in range(parameters.shape[0]):
        p, section = row_parameters(parameters, row), sections[row]
        write_piece_point(e, p, section, m, march_room, work, largest, out, row, first)
        first += out.impact_count[row]
