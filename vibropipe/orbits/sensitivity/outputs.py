"""The output `sensitivity`: the derivatives of the quantities of a closed orbit by the parameters."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating, jit_inline
from vibropipe.orbits.sensitivity.flights import Flights, first_flights, new_flights, vary_orbit
from vibropipe.orbits.sensitivity.harmonics import (
    add_support_derivatives,
    divide_derivatives,
    replace_resonant_derivatives,
)
from vibropipe.orbits.sensitivity.multipliers import fill_multipliers
from vibropipe.physics.contact import restitution_at
from vibropipe.physics.derivatives import (
    NU,
    F,
    is_of_second,
    n_parameters,
    restitution_derivative,
    support_derivative,
)
from vibropipe.physics.load import forcing_period
from vibropipe.physics.load_harmonics import (
    second_amplitude_derivative,
    work_at_second,
    work_by_amplitude,
    work_of_second,
    work_over_periods,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import sincos_turns
from vibropipe.physics.variation import BY_W, BY_Y, by_parameter, n_variations, vary_flight

# Relative difference of two velocities below which they are one, and of their derivatives above which they part; share
# of the velocity below which a difference of its derivatives is rounding.
TIE, PARTED, ROUNDED = 1e-11, 1e-6, 1e-12


class Differentiation(NamedTuple):
    """Work arrays of the derivatives of orbits.

    ends : (2, variations)
    changes : (3, parameters)
    values : (2,) complex
    derivatives : (3, parameters) complex
    sums : (2, variations) complex
    totals : (n,) complex, n the largest number of amplitudes
    d_totals : (n, 2, parameters)
    """

    ends: np.ndarray
    flights: Flights
    changes: np.ndarray
    values: np.ndarray
    derivatives: np.ndarray
    sums: np.ndarray
    totals: np.ndarray
    d_totals: np.ndarray


@jit_allocating
def new_differentiation(out, impacts, second):
    """Return work arrays for the derivatives in `out`, of orbits of so many impacts."""
    by = n_parameters(second)
    totals = max(3, max(out.d_amplitudes.shape[1], out.d_subharmonics.shape[1]))
    return Differentiation(
        np.empty((2, n_variations(second))), new_flights(impacts, second), np.empty((3, by)),
        np.empty(2, np.complex128), np.empty((3, by), np.complex128),
        np.empty((2, n_variations(second)), np.complex128), np.empty(totals, np.complex128),
        np.empty((totals, 2, by)),
    )  # fmt: skip


@jit_inline
def write_section(p, flights, ends, section, second) -> None:
    """Write the derivatives of the state at the start of the orbit into (2, parameters)."""
    home, start, w0 = flights.home[0], flights.start[0], flights.departure[0]
    released = flights.released[0] == 1
    sigma, i = -1.0 if home == 1 else 1.0, flights.speed.size - 1
    is_held = released and start > 0.0
    if not is_held:
        sine, cosine = sincos_turns(start)
        vary_flight(p, home, sine, cosine, -start, w0, ends, second)
    a0, period = flights.at_start[0, 0], forcing_period(p)
    for k in range(n_parameters(second)):
        section[0, k], section[1, k] = support_derivative(home, k), 0.0
        if is_held:
            continue
        dw0 = restitution_at(p, home) * flights.d_speed[i, k]
        dw0 += restitution_derivative(home, k) * flights.speed[i]
        for part in range(2):
            change = by_parameter(home, ends, part, k)
            if not released:
                by_time = (ends[part, BY_Y] * w0 + ends[part, BY_W] * a0) * period
                change += ends[part, BY_W] * dw0 - by_time * flights.d_start[0, k]
            section[part, k] += sigma * change


@jit_inline
def write_amplitude_derivatives(p, m, flights, room, denominator, d_amplitudes, second):
    """Write the derivatives of the amplitudes X(k nu/denominator) into (harmonics + 1, parameters) complex.

    `room.totals` receives the amplitudes.
    """
    n = d_amplitudes.shape[0]
    total, d_total = room.totals[:n], room.d_totals[:n]
    total[:] = 0.0
    d_total[:] = 0.0
    add_support_derivatives(p, m, flights, denominator, room.changes, total, d_total, second)
    divide_derivatives(p, denominator, m, total, d_total, d_amplitudes, second)
    replace_resonant_derivatives(
        p, denominator, m, flights, room.ends, room.sums, total, d_amplitudes, second
    )


@jit_inline
def write_energy_derivatives(p, m, flights, amplitudes, d_amplitudes, energy, second) -> None:
    """Write the derivatives of work of the force and losses by damping and supports into (4, parameters).

    `amplitudes` (3 or more,) and d_amplitudes (3 or more, parameters) as of `write_amplitude_derivatives`; without a
    second harmonic 2 suffice.
    """
    for k in range(n_parameters(second)):
        energy[0, k] = work_over_periods(p, m, d_amplitudes[1, k])
        if second is not None:
            # It is linear in X(2 nu), and nu cancels.
            energy[0, k] += m * work_of_second(p, d_amplitudes[2, k])
            if is_of_second(k):
                by_force = second_amplitude_derivative(p, k)
                energy[0, k] += m * work_at_second(p, by_force, amplitudes[2])
        energy[2, k] = energy[3, k] = 0.0
    energy[0, F] += work_by_amplitude(m, amplitudes[1])
    for j in range(flights.speed.size):
        support, speed = flights.support[j], flights.speed[j]
        r, i, home = restitution_at(p, support), j - 1, flights.home[j]
        if j == 0:
            i = flights.speed.size - 1
        for k in range(n_parameters(second)):
            dr, change = restitution_derivative(support, k), flights.d_speed[j, k]
            lost = (1.0 - r) * (1.0 + r) * speed * change - r * dr * speed * speed
            energy[1 + support, k] += lost
            if flights.released[j] == 1:
                # The chatter before the rest loses what is left after its first impact.
                w = restitution_at(p, home) * flights.speed[i]
                dw = restitution_at(p, home) * flights.d_speed[i, k]
                energy[1 + home, k] += w * (dw + restitution_derivative(home, k) * flights.speed[i])
    for k in range(n_parameters(second)):
        energy[1, k] = energy[0, k] - energy[2, k] - energy[3, k]


@jit_inline
def write_stability_derivatives(p, m, flights, room, out, row, second) -> None:
    """Write the derivatives of multipliers and Lyapunov exponent of an orbit."""
    fill_multipliers(p, m, flights, room.changes[0], room.values, room.derivatives, second)
    length = m * forcing_period(p)
    for k in range(n_parameters(second)):
        if out.d_multipliers.size > 0:
            out.d_multipliers[row, 0, k] = room.derivatives[0, k]
            out.d_multipliers[row, 1, k] = room.derivatives[1, k]
        if out.d_exponent.size > 0:
            out.d_exponent[row, k] = divide(room.derivatives[0, k], room.values[0]).real / length
            if k == NU:
                out.d_exponent[row, k] += math.log(abs(room.values[0])) / (length * p.nu)


@jit_inline
def clear_ties(flights, fastest, derivatives) -> None:
    """Clear the derivatives (parameters,) of a largest velocity that two impacts have and do not keep in common.

    Under a second harmonic alone each forcing period is twice the same, until a first harmonic parts its halves.
    """
    largest = flights.speed[fastest]
    for j in range(flights.speed.size):
        is_tie = flights.speed[j] >= (1.0 - TIE) * largest
        if j == fastest or flights.support[j] != flights.support[fastest] or not is_tie:
            continue
        for k in range(derivatives.size):
            one, other = flights.d_speed[fastest, k], flights.d_speed[j, k]
            if abs(one - other) > PARTED * (abs(one) + abs(other)) + ROUNDED * largest:
                derivatives[k] = math.nan


@jit_inline
def write_impact_derivatives(flights, out, row, first, second) -> None:
    """Write the derivatives of phases and velocities of the impacts, and of the largest velocity on each support."""
    for j in range(flights.speed.size):
        sign = 1.0 if flights.support[j] == 1 else -1.0
        for k in range(n_parameters(second)):
            out.d_impacts[first + j, 0, k] = flights.d_end[j, k]
            out.d_impacts[first + j, 1, k] = sign * flights.d_speed[j, k]
    for side in range(2):
        fastest = -1
        for j in range(flights.speed.size):
            if flights.support[j] == side + 1 and (
                fastest < 0 or flights.speed[j] > flights.speed[fastest]
            ):
                fastest = j
        if fastest >= 0:
            for k in range(n_parameters(second)):
                out.d_velocity_max[row, side, k] = flights.d_speed[fastest, k]
            if second is not None:
                clear_ties(flights, fastest, out.d_velocity_max[row, side])


@jit_inline
def write_sensitivity(p, contacts, m, room, out, row, first, second) -> None:
    """Write the derivatives of an orbit with impacts by the parameters; what is undefined stays NaN.

    contacts : of the orbit
    room : Differentiation
    out : RowResults, arrays `d_*`, NaN on entry; those without entries are not computed
    first : index of the first impact of the row
    second : the effect `second_harmonic`
    """
    flights = first_flights(room.flights, contacts.position.size)
    if not vary_orbit(p, contacts, m, flights, second):
        return
    write_section(p, flights, room.ends, out.d_section[row], second)
    if out.d_impacts.size > 0:
        write_impact_derivatives(flights, out, row, first, second)
    if out.d_multipliers.size + out.d_exponent.size > 0:
        write_stability_derivatives(p, m, flights, room, out, row, second)
    if out.d_amplitudes.size > 0:
        write_amplitude_derivatives(p, m, flights, room, 1, out.d_amplitudes[row], second)
    if out.d_energy.size > 0:
        # The force works on its own harmonics, which may be more than are requested.
        n = 2 if second is None else 3
        is_known = out.d_amplitudes.size > 0 and out.d_amplitudes.shape[1] >= n
        d_amplitudes = out.d_amplitudes[row] if is_known else room.derivatives[:n]
        if not is_known:
            write_amplitude_derivatives(p, m, flights, room, 1, d_amplitudes, second)
        energy = out.d_energy[row]
        write_energy_derivatives(p, m, flights, room.totals, d_amplitudes, energy, second)
    if out.d_subharmonics.size > 0 and m > 1:
        write_amplitude_derivatives(p, m, flights, room, m, out.d_subharmonics[row], second)
