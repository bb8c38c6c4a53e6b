"""Derivatives of solved rows: each orbit by its impacts, as they are listed; linear motions, and endless rests."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_inline, jit_nogil
from vibropipe.orbits.housing import N_ENERGIES
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import row_parameters
from vibropipe.orbits.sensitivity.flights import Contacts
from vibropipe.orbits.sensitivity.outputs import new_differentiation, write_sensitivity
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import (
    F2,
    LOAD,
    N_OF_PIECES,
    N_WITH_HOUSING,
    NU,
    F,
    H,
    is_of_second,
    n_parameters,
    support_derivative,
)
from vibropipe.physics.linear import linear_amplitude, linear_multipliers, second_linear_amplitude
from vibropipe.physics.load import forcing_period, has_second
from vibropipe.physics.load_harmonics import (
    force_amplitude_derivative,
    second_amplitude_derivative,
    work_at_second,
    work_by_amplitude,
    work_of_second,
    work_over_periods,
)
from vibropipe.physics.quotient import divide


@jit
def amplitude_derivative(p, amplitude, n, k):
    """Return the derivative by parameter k of the amplitude X(n nu) under a force that does not depend on it."""
    stiffness = complex((1.0 - n * p.nu) * (1.0 + n * p.nu), p.h * (n * p.nu))
    change = complex(0.0, 0.0)
    if k == NU:
        change = complex(-2.0 * n * n * p.nu, n * p.h)
    elif k == H:
        change = complex(0.0, n * p.nu)
    return divide(-amplitude * change, stiffness)


@jit
def linear_amplitude_derivative(p, k):
    """Return the derivative of `linear_amplitude` by parameter k."""
    if k == F:
        return divide(
            force_amplitude_derivative(), complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu)
        )
    return amplitude_derivative(p, linear_amplitude(p), 1.0, k)


@jit
def second_linear_amplitude_derivative(p, k):
    """Return the derivative of `second_linear_amplitude` by parameter k."""
    if is_of_second(k):
        stiffness = complex((1.0 - 2.0 * p.nu) * (1.0 + 2.0 * p.nu), p.h * (2.0 * p.nu))
        return divide(second_amplitude_derivative(p, k), stiffness)
    return amplitude_derivative(p, second_linear_amplitude(p), 2.0, k)


@jit
def linear_roots(p):
    """Return the roots of s^2 + h s + 1 = 0 and their derivatives by h, in the order of `linear_multipliers`."""
    b = 0.5 * p.h
    square = (1.0 - b) * (1.0 + b)
    root = math.sqrt(abs(square))
    if square > 0.0:
        first, second = complex(-b, root), complex(-b, -root)
        slope = complex(0.0, 2.0 * root)
    else:
        first, second = complex(-1.0 / (b + root), 0.0), complex(-(b + root), 0.0)
        slope = complex(2.0 * root, 0.0)
    return first, second, divide(-first, slope), divide(second, slope)


@jit
def write_linear(p, out, row) -> None:
    """Write the derivatives of the steady motion without impacts, for h > 0."""
    period = forcing_period(p)
    first, second, first_h, second_h = linear_roots(p)
    multipliers = linear_multipliers(p)
    amplitude, amplitude_2 = linear_amplitude(p), second_linear_amplitude(p)
    for k in range(out.d_section.shape[2]):
        x, x2 = linear_amplitude_derivative(p, k), second_linear_amplitude_derivative(p, k)
        out.d_section[row, 0, k] = 2.0 * x.real
        out.d_section[row, 1, k] = -2.0 * (p.nu * x.imag + (amplitude.imag if k == NU else 0.0))
        if has_second(p) or k == F2:
            out.d_section[row, 0, k] += 2.0 * x2.real
            out.d_section[row, 1, k] -= 4.0 * p.nu * x2.imag
            out.d_section[row, 1, k] -= 4.0 * amplitude_2.imag if k == NU else 0.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, :, k] = 0.0
            if out.d_amplitudes.shape[1] > 1:
                out.d_amplitudes[row, 1, k] = x
            if out.d_amplitudes.shape[1] > 2:
                out.d_amplitudes[row, 2, k] = x2
        if out.d_multipliers.size > 0:
            by_first, by_second = complex(0.0, 0.0), complex(0.0, 0.0)
            if k == NU:
                by_first, by_second = -first * (period / p.nu), -second * (period / p.nu)
            elif k == H:
                by_first, by_second = first_h * period, second_h * period
            out.d_multipliers[row, 0, k] = multipliers[0] * by_first
            out.d_multipliers[row, 1, k] = multipliers[1] * by_second
        if out.d_exponent.size > 0:
            out.d_exponent[row, k] = first_h.real if k == H else 0.0
        if out.d_energy.size > 0:
            work = work_over_periods(p, 1, x)
            if k == F:
                work += work_by_amplitude(1, amplitude)
            if has_second(p):
                work += work_of_second(p, x2)
            if is_of_second(k):
                work += work_at_second(p, second_amplitude_derivative(p, k), amplitude_2)
            out.d_energy[row, 0, k] = out.d_energy[row, 1, k] = work
            out.d_energy[row, 2, k] = out.d_energy[row, 3, k] = 0.0


@jit
def write_held(support, out, row) -> None:
    """Write the derivatives of a mass that rests on a support for ever."""
    for k in range(out.d_section.shape[2]):
        out.d_section[row, 0, k], out.d_section[row, 1, k] = support_derivative(support, k), 0.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, :, k] = 0.0
            out.d_amplitudes[row, 0, k] = support_derivative(support, k)
        if out.d_multipliers.size > 0:
            out.d_multipliers[row, :, k] = 0.0
        if out.d_energy.size > 0:
            out.d_energy[row, :, k] = 0.0


def new_derivatives(
    n: int,
    harmonics: int,
    subharmonics: int,
    outputs: tuple[str, ...],
    pieces: bool,
    second: int | None,
    housing: int | None = None,
) -> dict[str, np.ndarray]:
    """Return the arrays of `RowResults` for derivatives: NaN, or without entries unless `sensitivity` is requested.

    A quantity has derivatives if its own output is requested as well. Those of impacts begin without entries.

    n : number of rows
    harmonics, subharmonics : numbers of harmonics and subharmonics
    outputs : requested outputs
    pieces : whether motions have soft supports or friction: derivatives by more parameters, and of one more energy
    second : the effect `second_harmonic`
    housing : the effect, with which there are two more energies and one more multiplier
    """
    parameters = N_OF_PIECES if pieces else n_parameters(second)
    if housing is not None:
        parameters = N_WITH_HOUSING

    def unknown(when: str, *shape: int, dtype: type = float) -> np.ndarray:
        wanted = "sensitivity" in outputs and (when == "" or when in outputs)
        return np.full((n if wanted else 0, *shape, parameters), np.nan, dtype)

    return {
        "releases": np.full((n if "sensitivity" in outputs else 0, 2), np.nan),
        "grazes": np.zeros(n if "sensitivity" in outputs else 0, np.int8),
        "d_section": unknown("", 2),
        "d_amplitudes": unknown("harmonics", harmonics + 1, dtype=complex),
        "d_subharmonics": unknown("subharmonics", subharmonics + 1, dtype=complex),
        "d_multipliers": unknown("stability", 2 if housing is None else 3, dtype=complex),
        "d_exponent": unknown("lyapunov"),
        "d_energy": unknown("energy", (5 if pieces else 4) if housing is None else N_ENERGIES - 1),
        "d_housing": unknown("", 3 if housing is not None else 0),
        "d_housing_harmonics": unknown(
            "frame", harmonics + 1 if housing is not None else 0, dtype=complex
        ),
        "d_velocity_max": unknown("impacts", 2),
        "d_impacts": np.empty((0, 2, parameters)),
    }


def with_impact_derivatives(rows: RowResults) -> RowResults:
    """Return compacted results with room for the derivatives of their impacts, NaN, if impacts are requested."""
    if rows.d_velocity_max.size == 0:
        return rows
    shape = (rows.impact_position.size, *rows.d_impacts.shape[1:])
    return rows._replace(d_impacts=np.full(shape, np.nan))


@jit_inline
def differentiate_row(p, out, row, first, room, second) -> None:
    """Write the derivatives of a row, whose impacts begin at `first`; arguments as for `differentiate_rows`."""
    m, x, v = np.int64(out.period_multiple[row]), out.section[row, 0], out.section[row, 1]
    n, last = int(out.impacts[row, 0] + out.impacts[row, 1]), first + out.impact_count[row]
    if m == 0:
        return
    if n == 0 and out.rests[row, 0] + out.rests[row, 1] > 0.0:
        write_held(1 if x == support_position(p, 1) else 2, out, row)
    elif n == 0 and p.h > 0.0:
        write_linear(p, out, row)
    elif n > 0 and n == last - first and out.grazes[row] == 0 and not is_conservative(p, x, v):
        contacts = Contacts(
            out.impact_position[first:last],
            out.impact_velocity[first:last],
            out.impact_support[first:last],
            out.releases[row],
        )
        write_sensitivity(p, contacts, m, room, out, row, first, second)


@jit_nogil
def differentiate_rows(parameters, out, impacts, second) -> None:
    """Write the derivatives of solved rows.

    parameters : (rows, parameters)
    out : RowResults, compacted results of the rows, with their impacts
    impacts : capacity for the impacts of an orbit
    second : the effect `second_harmonic`
    """
    room, first = new_differentiation(out, impacts, second), 0
    for row in range(parameters.shape[0]):
        differentiate_row(row_parameters(parameters, row), out, row, first, room, second)
        # Kernels count displacements from the equilibrium, which the load moves.
        out.d_section[row, 0, LOAD] += 1.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, 0, LOAD] += 1.0
        first += out.impact_count[row]
