"""Outputs of the points of a branch: each orbit is known by its impacts, so nothing is marched."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import GRAZINGS, IMPACTS, RESTS, TAILS
from vibropipe.march.loop import OK
from vibropipe.march.state import FLIGHT, State
from vibropipe.orbits.branches.sequence import (
    eigenvalues,
    fill_equations,
    restitution_at,
    return_derivative,
)
from vibropipe.orbits.closed_form import solve_linear, write_forces_of_flight
from vibropipe.orbits.outputs import (
    count_contacts,
    regime_of,
    write_energy,
    write_harmonics,
    write_impacts,
    write_largest,
    write_multipliers,
)
from vibropipe.orbits.room import new_work
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.settling import NO_CHAOS, SteadyState
from vibropipe.orbits.verdict import PERIODIC
from vibropipe.physics.contact import support_position
from vibropipe.physics.forced_flow import fly_freely


@jit
def log_impacts(p, m, supports, u, log) -> None:
    """Fill an empty log with the impacts of an orbit, in order of time and at positions in [0, m).

    Parameters
    ----------
    p : Parameters
    m : int
        Period multiple.
    supports : (n,) int8
        Supports struck in turn over the whole orbit.
    u : (2n,) float or longer
        Times in forcing periods, which increase, and velocities.
    log : Log
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
    fill_equations(p, float(m), 0, supports, u, 1.0, residual, none)
    largest = 0.0
    for k in range(n):
        size = max(size, abs(u[n + k]))
        largest = max(largest, abs(residual[2 * k]) + abs(residual[2 * k + 1]))
    return largest / size


@jit_allocating
def write_points(e, parameters, m, supports, unknowns, log, c, residual, out) -> None:
    """Write the orbits of the points of one branch as rows.

    Parameters
    ----------
    e : Effects
    parameters : (points, parameters) float
    m : int
        Period multiple.
    supports : (n,) int8
        Supports struck in turn over the whole orbit; without impacts the motion is that in closed form.
    unknowns : (points, 2n + 1) float
        Times in forcing periods, velocities, and the parameter.
    log, c
        Work space, as for `march`.
    residual : (2n,) float or longer
        Work space.
    out : RowResults
        Results, a row for each point; outputs without entries are not computed.
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
        first_multiplier, second = orbit_multipliers(p, m, supports, u)
        closing = closing_residual(p, m, supports, u, residual, none)
        steady = SteadyState(
            PERIODIC, OK, m, state, state, closing, 0, first_multiplier, second, NO_CHAOS,
            second,
        )  # fmt: skip
        impacts, rests = out.impacts[row], out.rests[row]
        residual[0], residual[1] = 0.0, 0.0
        count_contacts(log, state, impacts, rests, residual)
        write_largest(residual, impacts, out.impact_velocity_max, row)
        out.residual[row] = closing
        out.regime[row] = regime_of(impacts, rests)
        out.period_multiple[row] = m
        out.frequency[row] = p.nu / m
        write_multipliers(first_multiplier, second, out.multipliers, row)
        write_harmonics(e, p, steady, log, c, work, out.amplitudes, out.subharmonics, row)
        write_energy(e, p, steady, log, c, work, out, row)
        write_impacts(
            log, m, out.impact_count, out.impact_position, out.impact_velocity, out.impact_support,
            row, row * n,
        )  # fmt: skip
        out.section[row, 0], out.section[row, 1] = x, v
