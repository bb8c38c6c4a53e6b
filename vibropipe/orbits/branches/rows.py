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
from vibropipe.physics.contact import restitution_at, to_displacement, to_velocity
from vibropipe.physics.load import forcing_period
from vibropipe.physics.piece import flown
from vibropipe.physics.saltation import eigenvalues_of
from vibropipe.physics.turns import sincos_turns
from vibropipe.physics.variation import flight_from


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
def flown_from(e, p, log, i, until):
    """Return (y, w) at a time, in forcing periods, of the mass that left impact i of a log, in the frame of that."""
    home, start = log.support[i], log.position[i]
    flight = flight_from(p, home, *sincos_turns(start), until - start, e.second_harmonic)
    return flown(flight, 0.0, -restitution_at(p, home) * to_velocity(home, log.velocity[i]))


@jit
def closing_residual(e, p, m, log):
    """Return how far flights miss the next of n logged impacts, relative to the largest speed or displacement."""
    n, size, largest = log.counts[IMPACTS], p.l, 0.0
    for i in range(n):
        # The last flight leads to the first impact, m periods later.
        j, until = (i + 1, log.position[i + 1]) if i + 1 < n else (0, log.position[0] + m)
        y, w = flown_from(e, p, log, i, until)
        home = log.support[i]
        far = 0.0 if log.support[j] == home else 2.0 * p.l
        size = max(size, abs(log.velocity[j]))
        largest = max(largest, abs(y - far) + abs(w - to_velocity(home, log.velocity[j])))
    return largest / size


@jit
def orbit_multipliers(e, p, m, log, start):
    """Return the Floquet multipliers from logged impacts; infinite and 0 where an impact has no speed."""
    j11, _j12, _j21, j22 = return_map_jacobian(e, p, log, start, start, m)
    if not abs(j11 + j22) < math.inf:
        return complex(math.inf, 0.0), complex(0.0, 0.0)
    determinant = math.exp(-p.h * m * forcing_period(p))
    for i in range(log.counts[IMPACTS]):
        determinant *= restitution_at(p, log.support[i]) ** 2
    return eigenvalues_of(j11 + j22, determinant)


@jit_allocating
def write_points(e, parameters, m, supports, unknowns, log, c, largest, out) -> None:
    """Write the orbits of the points of one branch as rows.

    parameters : (points, parameters)
    supports : (n,) int8, struck in turn over the whole orbit; without impacts the motion is that in closed form
    unknowns : (points, 2n + 1), times in forcing periods, velocities, and the parameter
    log, c : work space, as for `march`
    largest : (2,), work space
    out : RowResults, a row for each point; outputs without entries are not computed
    """
    n, work = supports.size, new_work(out)
    for row in range(parameters.shape[0]):
        p, u = row_parameters(parameters, row), unknowns[row]
        if n == 0:
            x, v = solve_linear(p, out, row)
            write_forces_of_flight(e, p, x, v, out, row, c)
            out.section[row, 0], out.section[row, 1] = x, v
            continue
        log_impacts(p, m, supports, u, log)
        y, w = flown_from(e, p, log, n - 1, float(m))
        home = log.support[n - 1]
        x, v = to_displacement(p, home, y), to_velocity(home, w)
        state = State(0, 0, 0.0, 0, x, v, FLIGHT, 0.0, None)
        first, second = orbit_multipliers(e, p, m, log, state)
        closing = closing_residual(e, p, m, log)
        steady = SteadyState(
            PERIODIC, OK, m, state, state, closing, 0, first, second, NO_CHAOS, complex(0.0, 0.0)
        )  # fmt: skip
        largest[0], largest[1] = 0.0, 0.0
        write_orbit(e, p, steady, log, c, work, largest, out, row, row * n)
        write_closing(steady, largest, out, row)
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
