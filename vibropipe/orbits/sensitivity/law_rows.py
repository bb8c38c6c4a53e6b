"""Errors and derivatives of solved rows with soft supports or friction, by the laws of their orbits."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_nogil
from vibropipe.march.grid import new_grid_room
from vibropipe.march.log import GRAZINGS, new_log
from vibropipe.march.loop import OK
from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HOME,
    IMPACT,
    LEAVE,
    RELEASE,
    SLIP,
    STICK,
    TURN,
    PieceLog,
)
from vibropipe.march.piece_state import coefficients
from vibropipe.orbits.contacts import write_contacts
from vibropipe.orbits.housing import STROBE
from vibropipe.orbits.law.law import is_contact
from vibropipe.orbits.law.marching import march_orbit
from vibropipe.orbits.law.states import arrival, hold_force
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.errors import COLUMNS as ERRORS
from vibropipe.orbits.sensitivity.errors import (
    IMPULSES,
    PHASES,
    SPEED_1,
    TRACE,
    ULP,
    V,
    X,
    note_impact,
    rms,
)
from vibropipe.orbits.sensitivity.law_housing import write_housing_derivatives
from vibropipe.orbits.sensitivity.law_integrals import add_integrals, reference_derivative
from vibropipe.orbits.sensitivity.law_multipliers import write_multiplier_derivatives
from vibropipe.orbits.sensitivity.law_orbit import columns_of, ends_of_piece, vary_orbit
from vibropipe.orbits.sensitivity.rows import with_impact_derivatives
from vibropipe.physics.derivatives import F2, LOAD, PHI2
from vibropipe.physics.effects import Effects, shared_effects
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.friction import jumps_at_slip
from vibropipe.physics.limits import INTEGRAL_STEPS
from vibropipe.physics.load import forcing_period, largest_force
from vibropipe.physics.stiffness import piece_rate


@jit
def relative_error(e, p, orbit, i, late, speed):
    """Return by how much event i changes the derivative of the return map, relative to its size.

    late, speed : errors of its time, in tau, and of its velocity
    """
    law, n = orbit.law, orbit.u.shape[0]
    cause, rate, force = law.codes[i, CAUSE], 1.0, 1.0 + largest_force(p)
    state, before = arrival(e, p, law, i, orbit.u), (i - 1) % n
    for j in (before, i):
        in_contact = law.codes[j, FORM] == CONTACT
        rate = max(rate, piece_rate(*coefficients(e, p, law.codes[j, HOME], in_contact)))
    if cause in (TURN, STICK):
        value, stiffness, _rate = hold_force(e, p, law, before, state.t)
        a = abs(value - stiffness * state.y - law.codes[before, DIRECTION] * p.friction)
        return late * (rate + p.nu * force / a)
    if cause in (SLIP, RELEASE) and jumps_at_slip(e, p):
        _value, _stiffness, grows = hold_force(e, p, law, before, state.t)
        return late * (rate + p.nu * force / abs(p.nu * grows))
    if not is_contact(cause):
        return 0.0
    w = abs(state.w)
    struck = (speed + (force + rate * w) * late) / w if cause == IMPACT else 0.0
    return late * rate + struck


@jit_allocating
def write_errors(e, p, orbit, m, closing, out, row, first) -> None:
    """Write the errors of an orbit from its samples.

    orbit : VariedOrbit
    closing : distance by which the orbit fails to close
    out : RowResults, `e_row` and `e_impacts`
    row, first : the row, and its first impact
    """
    n, k = orbit.u.shape[0], orbit.columns.size
    samples, period, law = orbit.du[:, :, k:], forcing_period(p), orbit.law
    floor = closing + ULP * (abs(out.section[row, 0]) + abs(out.section[row, 1]) + largest_force(p))
    out.e_row[row, X] = rms(samples[0, 0]) + floor
    out.e_row[row, V] = rms(samples[0, 1]) + floor
    mean, square, moved = floor, 0.0, np.zeros(samples.shape[2])
    for i in range(n):
        after = (i + 1) % n
        _start, end, turns = ends_of_piece(e, p, orbit, i)
        late = 0.0 if end.timed == 0.0 else period * rms(samples[after, 0])
        for s in range(moved.size):
            # At a fixed phase.
            by_time = end.y_0 - period * end.w * end.timed
            moved[s] = by_time * samples[after, 0, s] + end.y_1 * samples[after, 1, s]
        mean += turns / m * rms(moved)
        if after > 0:
            square += relative_error(e, p, orbit, after, late, rms(samples[after, 1])) ** 2
    m11, m12, m21, m22 = orbit.return_map
    size = max(1.0, abs(m11) + abs(m12), abs(m21) + abs(m22))
    out.e_row[row, IMPULSES], out.e_row[row, PHASES] = mean, 0.0
    out.e_row[row, TRACE] = (math.sqrt(square) + ULP * (1.0 + n)) * size
    is_listed = out.impact_count[row] == contacts_of(law)
    for column in range(SPEED_1, ERRORS):
        out.e_row[row, column] = 0.0 if is_listed else math.nan
    j = first
    for i in range(n if is_listed else 0):
        if not begins_contact(law, i):
            continue
        phase = rms(samples[i, 0]) + ULP * (1.0 + m)
        speed = rms(samples[i, 1]) + ULP * abs(out.impact_velocity[j])
        out.e_impacts[j, 0], out.e_impacts[j, 1] = phase, speed
        note_impact(out, row, out.impact_support[j], phase, speed)
        j += 1


@jit
def begins_contact(law, i) -> bool:
    """Return whether event i is listed as an impact."""
    return is_contact(law.codes[i, CAUSE]) and law.codes[i, CAUSE] != LEAVE


@jit
def contacts_of(law) -> int:
    """Return the number of events that are listed as impacts."""
    total = 0
    for i in range(law.codes.shape[0]):
        total += 1 if begins_contact(law, i) else 0
    return total


@jit
def write_contact_derivatives(orbit, out, row, first) -> None:
    """Write the derivatives of phases and velocities of contacts, and of the largest velocity on each support."""
    if out.impact_count[row] != contacts_of(orbit.law):
        return
    listed = first
    for i in range(orbit.u.shape[0]):
        if not begins_contact(orbit.law, i):
            continue
        for part in range(2):
            for j in range(orbit.columns.size):
                out.d_impacts[listed, part, orbit.columns[j]] = orbit.du[i, part, j]
        listed += 1
    for side in range(2):
        fastest, speed = -1, -1.0
        for impact in range(first, listed):
            if out.impact_support[impact] == side + 1 and abs(out.impact_velocity[impact]) > speed:
                fastest, speed = impact, abs(out.impact_velocity[impact])
        if fastest >= 0:
            sign = 1.0 if out.impact_velocity[fastest] > 0.0 else -1.0
            for k in orbit.columns:
                out.d_velocity_max[row, side, k] = sign * out.d_impacts[fastest, 1, k]


@jit_allocating
def write_derivatives(e, p, orbit, m, out, row, first):
    """Write the derivatives of a row but those of its multipliers; returns the steps of their integrals."""
    home, by = orbit.law.codes[0, HOME], orbit.columns.size
    n = out.d_amplitudes.shape[1] if out.d_amplitudes.size > 0 else 0
    more = out.d_subharmonics.shape[1] if out.d_subharmonics.size > 0 and m > 1 else 0
    energies = out.d_energy.shape[1] if out.d_energy.size > 0 else 0
    amplitudes, energy = np.zeros((n, by), np.complex128), np.zeros((energies, by))
    subharmonics = np.zeros((more, by), np.complex128)
    steps = 0.0
    if n + more + energies > 0:
        steps = add_integrals(e, p, orbit, m, (amplitudes, subharmonics, energy))
    for j in range(by):
        k = orbit.columns[j]
        out.d_section[row, 0, k] = orbit.du[0, 0, j] + reference_derivative(home, k)
        out.d_section[row, 1, k] = orbit.du[0, 1, j]
        for q in range(n):
            out.d_amplitudes[row, q, k] = amplitudes[q, j]
        for q in range(more):
            out.d_subharmonics[row, q, k] = subharmonics[q, j]
        for q in range(energies):
            out.d_energy[row, q, k] = energy[q, j]
    if out.d_impacts.size > 0:
        write_contact_derivatives(orbit, out, row, first)
    return steps


@jit_allocating
def write_row(e, values, march_room, out, row, first, derivatives):
    """Write errors and, if they are wanted, derivatives of a row; arguments as for `write_rows`.

    values : (1, parameters), of the row. Returns the steps of its integrals.
    """
    p, m, speed = row_parameters(values, 0), np.int64(out.period_multiple[row]), 0.0
    x, v = out.section[row, 0], out.section[row, 1]
    velocity = 0.0
    if e.housing is not None and p.mass_ratio > 0.0:
        velocity = out.housing[row, STROBE]
    _begun, _end, status = march_orbit(e, p, 0.0, x, v, velocity, m, march_room)
    if status != OK or march_room[0].counts[GRAZINGS] > 0:
        return 0.0
    for j in range(first, first + out.impact_count[row]):
        speed = max(speed, abs(out.impact_velocity[j]))
    closing = out.residual[row] * (abs(x) + abs(v) + speed)
    columns = np.zeros(0, np.int64) if derivatives is None else columns_of(e, p)
    orbit, is_isolated = vary_orbit(e, p, march_room[0].pieces, m, closing, columns)
    steps = 0.0
    if not is_isolated:
        return steps
    if e.housing is None:
        write_errors(e, p, orbit, m, closing, out, row, first)
    if derivatives is not None:
        steps = write_derivatives(e, p, orbit, m, out, row, first)
        if e.housing is not None:
            energy = out.d_energy[row] if out.d_energy.size > 0 else out.d_housing[row, :0]
            write_housing_derivatives(e, p, orbit, m, out, row, energy)
        if out.d_multipliers.size + out.d_exponent.size > 0:
            write_multiplier_derivatives(e, values, orbit, m, out, row)
    return steps


@jit_nogil
def write_rows(
    e: Effects,
    parameters: np.ndarray,
    out: RowResults,
    pieces: PieceLog,
    contacts: np.ndarray | None,
    derivatives: int | None,
) -> float:
    """Write the errors of solved rows, their derivatives, and the contacts with soft supports.

    parameters : (rows, parameters)
    out : compacted results of the rows, with their impacts; errors, derivatives and contacts are NaN on entry.
        Derivatives without entries are not computed
    pieces : its capacity is that for contacts and rests of an orbit, too
    contacts : (n, columns) or None, those of `out`, if they are wanted: with soft supports and without a housing
    derivatives : whether those of `out` are wanted: 1 or None, so that their code is compiled for calls that ask for
        them

    Returns the steps of all integrals.
    """
    capacity = pieces.values.shape[0]
    log, c = new_log(capacity, capacity, pieces, None), np.empty(DEGREE + 1)
    march_room = log, c, new_grid_room(e)
    values, first, steps = np.empty((1, parameters.shape[1])), 0, 0.0
    for row in range(parameters.shape[0]):
        values[0] = parameters[row]
        if out.period_multiple[row] > 0:
            steps += write_row(e, values, march_room, out, row, first, derivatives)
        write_contacts(contacts, e, row_parameters(values, 0), march_room, out, row, first)
        if derivatives is not None:
            # Kernels count displacements from the equilibrium, which the load moves.
            out.d_section[row, 0, LOAD] += 1.0
            if out.d_amplitudes.size > 0:
                out.d_amplitudes[row, 0, LOAD] += 1.0
        first += out.impact_count[row]
    return steps


def with_errors_of_pieces(
    rows: RowResults,
    parameters: np.ndarray,
    effects: Effects,
    pieces: PieceLog,
    contacts: int = 0,
    spent: list[int] | None = None,
) -> RowResults:
    """Return compacted results, whose impacts are listed, with errors and, if requested, derivatives of all orbits.

    Errors are not known beside a housing that slides: there rows gain derivatives alone.

    parameters : (rows, parameters)
    effects : with soft supports or friction
    contacts : columns of the contacts with soft supports, 0 if they are not wanted
    spent : receives the work, in steps of a march
    """
    n, has_derivatives = rows.impact_position.size, rows.d_section.size > 0
    if effects.housing is not None and not has_derivatives:
        return rows
    room = rows
    if effects.housing is None:
        room = rows._replace(
            e_row=np.full((len(parameters), ERRORS), np.nan), e_impacts=np.full((n, 2), np.nan)
        )
    if contacts:
        room = room._replace(contacts=np.full((n, contacts), np.nan))
    if has_derivatives:
        room = with_impact_derivatives(room)
    has_contacts = effects.soft is not None and effects.housing is None
    steps = write_rows(
        shared_effects(effects), parameters, room, pieces,
        room.contacts if has_contacts else None, 1 if has_derivatives else None,
    )  # fmt: skip
    if spent is not None:
        spent.append(int(steps * INTEGRAL_STEPS))
    if not has_derivatives or effects.second_harmonic is not None:
        return room
    return without_second(room)


def without_second(rows: RowResults) -> RowResults:
    """Return results without the derivatives by the parameters of a second harmonic, which all are computed with."""
    kept = [k for k in range(rows.d_section.shape[-1]) if k not in (F2, PHI2)]
    return rows._replace(
        **{
            name: values[..., kept]
            for name, values in rows._asdict().items()
            if name.startswith("d_")
        }
    )
