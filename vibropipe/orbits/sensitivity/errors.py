"""Errors of an orbit: rounding of each flight and the residual, carried through the inverse that closes the orbit.

Every flight rounds the phase and the speed of the impact that ends it. Independent samples of these roundings, with
random signs, follow the transfers of the flights (`orbits.sensitivity.flights`) and close by (I - M)^-1, as the
derivatives by the parameters do; the error is the root mean square of the samples. They need no variations of the
flights, only the free flow.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline, jit_nogil
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.flow import free_flow
from vibropipe.physics.linear import linear_amplitude, second_linear_amplitude
from vibropipe.physics.load import (
    constant_load,
    force_at,
    force_value,
    forcing_period,
    has_second,
    largest_force,
)
from vibropipe.physics.saltation import product
from vibropipe.physics.turns import TWO_PI

SAMPLES = 4
# Relative distance of neighbouring floats: what an operation, or a parameter, is uncertain by.
ULP = 2.0**-52
# Columns of the records of flights: transfer, rounding of phase and speed.
TRANSFER, ROUNDING = 0, 4
RECORD = 6
# Columns of `RowResults.e_row`: section, sums of impulses and their phases, trace of the return map's derivative, and
# the largest of impact velocities on each support and of impact phases.
X, V, IMPULSES, PHASES, TRACE, SPEED_1, SPEED_2, TURN = range(8)
COLUMNS = 8


@jit_inline
def random_sign(n):
    """Return 1 or -1 for a number, without pattern."""
    bits = (n * 2654435761 + 1013904223) & 0xFFFFFFFF
    bits = ((bits ^ (bits >> 15)) * 2246822519) & 0xFFFFFFFF
    return 1.0 if (bits >> 13) & 1 == 1 else -1.0


class Impacts(NamedTuple):
    """The impacts (n,) of an orbit of m forcing periods; second : the effect `second_harmonic`."""

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray
    m: np.int64
    second: int | None


@jit_inline
def fill_record(p, impacts, j, record) -> None:
    """Fill the transfer of the flight that impact j of an orbit ends, and what it rounds."""
    position, velocity, support, m, second = impacts
    n = position.size
    i = j - 1 if j > 0 else n - 1
    home, start, end = support[i], position[i] - (0 if j > 0 else m), position[j]
    period, r = forcing_period(p), restitution_at(p, support[i])
    t, w0, u1 = (end - start) * period, r * abs(velocity[i]), abs(velocity[j])
    sigma, lands_home = -1.0 if home == 1 else 1.0, support[j] == home
    sign = -1.0 if lands_home else 1.0
    w1, load = sign * u1, constant_load(sigma, support_position(p, home))
    a0 = force_value(force_at(p, sigma, start, second), second) + load - p.h * w0
    far = 0.0 if lands_home else 2.0 * p.l
    a1 = force_value(force_at(p, sigma, end, second), second) + load - p.h * w1 - far
    e11, e12, e21, e22 = free_flow(p.h, t)
    b11 = (e11 * w0 + e12 * a0) / w1
    b12 = -r * e12 / (w1 * period)
    record[0], record[1] = b11, b12
    record[2] = sign * (a1 * b11 - e21 * w0 - e22 * a0) * period
    record[3] = sign * (r * e22 + a1 * period * b12)
    short = min(1.0, t)
    push = abs(load) + largest_force(p) + far
    height = far + t * (w0 + u1) + short * short * push
    record[4] = ULP * (1.0 + abs(start) + abs(end)) + ULP * height / (u1 * period)
    record[5] = ULP * (w0 + u1 + short * push) + ULP * height * abs(a1) / u1


@jit
def follow_samples(records, n, phases, speeds) -> None:
    """Follow samples (SAMPLES,) of the errors of the last impact along n flights."""
    for c in range(SAMPLES):
        turn, speed = phases[n - 1, c], speeds[n - 1, c]
        for j in range(n):
            record, k = records[j], 2 * (SAMPLES * j + c)
            turn, speed = (
                record[0] * turn + record[1] * speed + random_sign(k) * record[4],
                record[2] * turn + record[3] * speed + random_sign(k + 1) * record[5],
            )
            phases[j, c], speeds[j, c] = turn, speed


@jit
def close_samples(p, impacts, closing, has_rest, records, phases, speeds):
    """Fill samples of the errors of all impacts of an orbit, (n, SAMPLES) each.

    impacts : Impacts
    closing : distance by which the orbit fails to close
    has_rest : whether a rest erases what was before it
    records : (n, RECORD), work space
    phases, speeds : (n, SAMPLES)

    Returns the modulus of the product of all transfers, |M11| + |M22| + ...
    """
    n, velocity = impacts.position.size, impacts.velocity
    m11, m12, m21, m22, size = 1.0, 0.0, 0.0, 1.0, 0.0
    for j in range(n):
        fill_record(p, impacts, j, records[j])
        t = records[j]
        m11, m12, m21, m22 = product(t[0], t[1], t[2], t[3], m11, m12, m21, m22)
        size = max(size, abs(m11) + abs(m22) + math.sqrt(abs(m12 * m21)))
    last = n - 1
    for c in range(SAMPLES):
        phases[last, c] = speeds[last, c] = 0.0
    follow_samples(records, n, phases, speeds)
    if not has_rest:
        determinant = (1.0 - m11) * (1.0 - m22) - m12 * m21
        speed = abs(velocity[last])
        for c in range(SAMPLES):
            turn = phases[last, c] + random_sign(7919 + c) * closing / (speed * forcing_period(p))
            change = speeds[last, c] + random_sign(104729 + c) * closing
            phases[last, c] = ((1.0 - m22) * turn + m12 * change) / determinant
            speeds[last, c] = (m21 * turn + (1.0 - m11) * change) / determinant
    follow_samples(records, n, phases, speeds)
    return size


@jit
def largest_speed(velocity) -> float:
    """Return the largest modulus of velocities (n,)."""
    largest = 0.0
    for v in velocity:
        largest = max(largest, abs(v))
    return largest


@jit
def rms(samples) -> float:
    """Return the root mean square of samples (SAMPLES,)."""
    total = 0.0
    for c in range(SAMPLES):
        total += samples[c] * samples[c]
    return math.sqrt(total / SAMPLES)


@jit_inline
def write_orbit_errors(p, impacts, closing, size, phases, speeds, out, row, first) -> None:
    """Write the errors of an orbit from the samples of its impacts.

    p, impacts, closing, phases, speeds : as for `close_samples`
    size : its result
    out : RowResults, `e_row` and `e_impacts`
    row, first : the row, and its first impact
    """
    position, velocity, support, m, second = impacts
    n, period = position.size, forcing_period(p)
    # The flight to the start of the orbit, from the last impact.
    last = n - 1
    r, u = restitution_at(p, support[last]), abs(velocity[last])
    t, w0 = (m - position[last]) * period, r * u
    sigma, b = -1.0 if support[last] == 1 else 1.0, support_position(p, support[last])
    force = force_value(force_at(p, sigma, position[last], second), second)
    a0 = force - sigma * b - p.h * w0
    e11, e12, e21, e22 = free_flow(p.h, t)
    x2, v2 = 0.0, 0.0
    for c in range(SAMPLES):
        dt, dw = phases[last, c] * period, r * speeds[last, c]
        x2 += (e12 * dw - (e11 * w0 + e12 * a0) * dt) ** 2
        v2 += (e22 * dw - (e21 * w0 + e22 * a0) * dt) ** 2
    floor = ULP * (abs(b) + largest_force(p) + (1.0 + t) * w0) + closing
    out.e_row[row, X] = math.sqrt(x2 / SAMPLES) + floor
    out.e_row[row, V] = math.sqrt(v2 / SAMPLES) + floor
    impulses, turned, relative = 0.0, 0.0, ULP
    for j in range(n):
        phase, speed = rms(phases[j]), rms(speeds[j])
        out.e_impacts[first + j, 0], out.e_impacts[first + j, 1] = phase, speed
        share = (1.0 + restitution_at(p, support[j])) / (m * period)
        impulses += (share * (speed + ULP * abs(velocity[j]))) ** 2
        turned += (share * abs(velocity[j]) * TWO_PI * (phase + ULP)) ** 2
        relative += speed / abs(velocity[j]) + phase * period + ULP
        note_impact(out, row, support[j], phase, speed)
    out.e_row[row, IMPULSES] = math.sqrt(impulses) + ULP * largest_force(p)
    out.e_row[row, PHASES] = math.sqrt(turned)
    out.e_row[row, TRACE] = relative * size


@jit_inline
def note_impact(out, row, support, phase, speed) -> None:
    """Update the largest errors of impact phases and velocities of a row."""
    column = SPEED_1 if support == 1 else SPEED_2
    out.e_row[row, column] = max(out.e_row[row, column], speed)
    out.e_row[row, TURN] = max(out.e_row[row, TURN], phase)


@jit_inline
def cancellation(p, w):
    """Return how many times larger than the dynamic stiffness at the frequency w its terms are."""
    return (1.0 + w * w + p.h * w) / abs(complex((1.0 - w) * (1.0 + w), p.h * w))


@jit_inline
def write_closed_errors(p, x, v, out, row, first, last) -> None:
    """Write the errors of a row in closed form, or without impacts, from its section (|x|, |v|): rounding alone."""
    amplitude = abs(linear_amplitude(p))
    scale = ULP * (x + v + abs(p.l) + abs(p.delta))
    if first == last:
        lost = cancellation(p, p.nu)
        scale = ULP * (x + v + 2.0 * amplitude * (1.0 + lost)) if amplitude > 0.0 else ULP * (x + v)
        if has_second(p):
            lost = cancellation(p, 2.0 * p.nu)
            scale += ULP * 2.0 * abs(second_linear_amplitude(p)) * (1.0 + lost)
    out.e_row[row, X] = scale
    out.e_row[row, V] = scale * max(1.0, p.nu)
    out.e_row[row, IMPULSES], out.e_row[row, PHASES] = scale, 0.0
    out.e_row[row, TRACE] = ULP * (1.0 + forcing_period(p))
    for i in range(first, last):
        out.e_impacts[i, 0] = 4.0 * ULP + scale / abs(out.impact_velocity[i])
        out.e_impacts[i, 1] = scale + scale / abs(out.impact_velocity[i])
        note_impact(out, row, out.impact_support[i], out.e_impacts[i, 0], out.e_impacts[i, 1])


def with_errors(
    rows: RowResults, parameters: np.ndarray, impacts: int, second: int | None
) -> RowResults:
    """Return compacted results, whose impacts are listed, with the errors of all orbits.

    parameters : (rows, parameters)
    impacts : capacity for the impacts of an orbit
    second : the effect `second_harmonic`
    """
    n = rows.impact_position.size
    room = rows._replace(
        e_row=np.full((len(parameters), COLUMNS), np.nan), e_impacts=np.full((n, 2), np.nan)
    )
    estimate_rows(parameters, room, impacts, second)
    return room


@jit_inline
def estimate_row(p, out, row, first, last, records, phases, speeds, second) -> None:
    """Write the errors of a row whose impacts are first to last; arguments as for `close_samples`."""
    m, x, v = np.int64(out.period_multiple[row]), out.section[row, 0], out.section[row, 1]
    if m == 0:
        return
    for column in range(SPEED_1, COLUMNS):
        out.e_row[row, column] = 0.0
    if last == first or is_conservative(p, x, v):
        write_closed_errors(p, abs(x), abs(v), out, row, first, last)
        return
    has_rest = out.rests[row, 0] + out.rests[row, 1] > 0.0
    velocity, support = out.impact_velocity[first:last], out.impact_support[first:last]
    impacts = Impacts(out.impact_position[first:last], velocity, support, m, second)
    closing = out.residual[row] * (abs(x) + abs(v) + largest_speed(velocity))
    size = close_samples(p, impacts, closing, has_rest, records, phases, speeds)
    write_orbit_errors(p, impacts, closing, size, phases, speeds, out, row, first)
    if has_rest:
        out.e_row[row, TRACE] = 0.0


@jit_nogil
def estimate_rows(parameters, out, impacts, second) -> None:
    """Write the errors of solved rows: `e_row` and `e_impacts`, NaN on entry.

    parameters : (rows, parameters)
    out : RowResults, compacted results with their impacts
    impacts : capacity for the impacts of an orbit
    second : the effect `second_harmonic`
    """
    records = np.empty((impacts, RECORD))
    phases, speeds = np.empty((impacts, SAMPLES)), np.empty((impacts, SAMPLES))
    first = 0
    for row in range(parameters.shape[0]):
        last = first + out.impact_count[row]
        p = row_parameters(parameters, row)
        estimate_row(p, out, row, first, last, records, phases, speeds, second)
        first = last
