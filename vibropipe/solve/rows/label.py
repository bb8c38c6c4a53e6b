"""Results of rows as labelled variables over the dimension `row`, with names from the vocabulary."""

from __future__ import annotations

import functools
from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.orbits.housing import (
    GROUND,
    LARGEST_SPEED,
    LOADS,
    MEAN,
    N_ENERGIES,
    SLIP_SHARE,
    STROBE,
)
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.window import LISTED_PERIODS
from vibropipe.solve.accuracy.orbit_errors import label_errors
from vibropipe.solve.multipliers import decay
from vibropipe.solve.rows.power import label_frame, label_power
from vibropipe.solve.rows.row_results import PHASES, SUBHARMONICS_PER_HARMONIC, columns_of
from vibropipe.solve.rows.sensitivity import differentiated, label_derivatives
from vibropipe.solve.rows.unsolved import is_solved
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.vocabulary import (
    ERROR_SUFFIX,
    OF_CONTACT,
    PARAMETER,
    STEADY,
    row_dims,
    split_suffix,
)

if TYPE_CHECKING:
    import xarray as xr

# Quantities of a housing, by the columns of `RowResults.housing`.
HOUSING = {
    STROBE: "housing_velocity_strobe",
    MEAN: "housing_velocity_mean",
    LARGEST_SPEED: "housing_velocity_max",
    SLIP_SHARE: "housing_slip_share",
}
Variables = dict[str, tuple[tuple[str, ...], np.ndarray]]


def label_rows(
    rows: RowResults, parameters: np.ndarray, outputs: Collection[str] = OUTPUTS
) -> Variables:
    """Label compacted results.

    Parameters
    ----------
    rows : RowResults
        Compacted results (`solve.row_results`).
    parameters : (rows, parameters) array
        Parameters of the rows.
    outputs : collection of str
        Outputs whose quantities are returned, of those that the rows have.

    Returns
    -------
    Variables
        Dimensions and values by name, over `row` (and `support`, `harmonic`, `multiplier`, `phase`, `subharmonic`,
        `visit`) or `impact`.
    """
    # An orbit of m = 1 is one of the forcing period, or a conservative one of its own.
    nu = np.where(rows.period_multiple == 1, rows.frequency, parameters[:, 0])
    values = _values(rows, nu, parameters, outputs)
    variables: Variables = {name: (row_dims(name), array) for name, array in values.items()}
    if rows.exponent.size > 0:
        variables["lyapunov_exponent_error"] = (("row",), rows.exponent[:, 1])
    if rows.e_row.size > 0:
        variables |= label_errors(rows, nu, parameters)
    if rows.multipliers.size > 0:
        error = variables.get("floquet_multiplier" + ERROR_SUFFIX)
        is_stable = decay(rows.multipliers, error and error[1]) > 0.0
        variables["stable"] = ("row",), is_stable.astype(np.int8)
    if rows.d_section.size > 0:
        variables |= label_derivatives(rows, parameters)
    wanted = {"", *outputs}
    return {
        name: variable
        for name, variable in variables.items()
        if STEADY[split_suffix(name)[0]].output in wanted
    }


def _values(
    rows: RowResults, nu: np.ndarray, parameters: np.ndarray, outputs: Collection[str]
) -> dict[str, np.ndarray]:
    """Return the quantities of rows by their names, without errors and derivatives; nu : (rows,), of harmonics."""
    m, solved = rows.period_multiple, is_solved(rows.status)[:, None]
    # The section of an unsolved row is its start, not a result.
    section = np.where(solved, rows.section, np.nan)
    values = {
        "regime": rows.regime,
        "status": rows.status,
        "period_multiple": m,
        "impacts_per_period": np.where(solved, rows.impacts / np.maximum(m, 1)[:, None], np.nan),
        "impacts_per_orbit": rows.impacts,
        "rests_per_orbit": rows.rests,
        "grazings_per_orbit": rows.grazings,
        "base_frequency": np.where(m > 0, rows.frequency, nu),
        "residual": rows.residual,
        "periods_to_settle": rows.settled_after,
        "displacement_strobe": section[:, 0],
        "velocity_strobe": section[:, 1],
        "window_periods": rows.window_periods,
        "chaos": rows.chaos,
    }
    if rows.amplitudes.size > 0:
        values |= _harmonics(rows.amplitudes, nu)
    if rows.multipliers.size > 0:
        values["floquet_multiplier"] = rows.multipliers
    if rows.impact_count.size > 0:
        values |= _impacts(rows)
    if rows.energy.size > 0:
        values |= _energy(rows.energy, np.maximum(np.where(m > 0, m, rows.window_periods), 1))
    if rows.motion.size > 0:
        values |= {"displacement": rows.motion[:, 0], "velocity": rows.motion[:, 1]}
    if rows.subharmonics.size > 0:
        values["subharmonic_displacement_amplitude"] = 2 * np.abs(rows.subharmonics[:, 1:])
        values["subharmonic_displacement_phase"] = np.angle(rows.subharmonics[:, 1:])
    if rows.poincare.size > 0:
        values["poincare_displacement"] = rows.poincare[:, 0]
        values["poincare_velocity"] = rows.poincare[:, 1]
    if rows.exponent.size > 0:
        values["lyapunov_exponent"] = rows.exponent[:, 0]
    if rows.housing.size > 0:
        values |= {name: rows.housing[:, column] for column, name in HOUSING.items()}
    if rows.forces.size > 0:
        values |= _forces(values, rows, nu, parameters, outputs)
    held = {STEADY[name].output for name in values}
    for name, entry in STEADY.items():
        if entry.function is not None and entry.output in held:
            values[name] = entry.function(values, columns_of(parameters))
    return values


def _forces(
    values: dict[str, np.ndarray],
    rows: RowResults,
    nu: np.ndarray,
    parameters: np.ndarray,
    outputs: Collection[str],
) -> dict[str, np.ndarray]:
    """Return the quantities of the outputs `power` and `frame`."""
    found: dict[str, np.ndarray] = {}
    if "power" in outputs:
        found |= label_power(values, rows, nu, parameters)
    if "frame" in outputs:
        found |= label_frame(values, rows, nu, parameters)
        if "impacts" not in outputs:
            del found["impact_impulse"]
    return found


def _harmonics(amplitudes: np.ndarray, nu: np.ndarray) -> dict[str, np.ndarray]:
    """Return amplitudes and phases of x = mean + sum A_k cos(k nu tau + phase_k) from X_k.

    Those of x' come from i k nu X_k, since x is continuous through impacts.
    """
    multiples = np.arange(amplitudes.shape[1])
    rates = 1j * multiples[None, :] * nu[:, None] * amplitudes
    values = {}
    for name, of in (("displacement", amplitudes), ("velocity", rates)):
        values[f"{name}_mean"] = of[:, 0].real
        values[f"{name}_amplitude"] = 2 * np.abs(of[:, 1:])
        values[f"{name}_phase"] = np.angle(of[:, 1:])
    return values


def _impacts(rows: RowResults) -> dict[str, np.ndarray]:
    """Return the quantities of impacts: positions are split into the forcing period and the phase in it."""
    position = rows.impact_position
    whole = np.floor(position)
    values = {
        "row_size": rows.impact_count,
        "impact_phase": position - whole,
        "impact_period": whole.astype(np.int32),
        "impact_support": rows.impact_support,
        "impact_velocity": rows.impact_velocity,
        "impact_velocity_max": rows.impact_velocity_max,
    }
    return values | _contacts(rows) if rows.contacts.shape[1] > 0 else values


def _contacts(rows: RowResults) -> dict[str, np.ndarray]:
    """Return the quantities of contacts with soft supports, and the largest of each row and support.

    One is NaN where the support is rigid or not struck, and where a contact of the row is not known.
    """
    values = {"impact_velocity_after": rows.contacts[:, 0]}
    largest = np.full((rows.impact_count.size, 2, len(OF_CONTACT)), -np.inf)
    owner = np.repeat(np.arange(rows.impact_count.size), rows.impact_count)
    with np.errstate(invalid="ignore"):
        columns = rows.contacts[:, 1 : 1 + len(OF_CONTACT)]
        np.maximum.at(largest, (owner, rows.impact_support - 1), columns)
    largest[np.isneginf(largest)] = np.nan
    for column, (name, name_of_largest) in enumerate(OF_CONTACT.items()):
        values[name] = rows.contacts[:, 1 + column]
        values[name_of_largest] = largest[:, :, column]
    return values


def _energy(sums: np.ndarray, periods: np.ndarray) -> dict[str, np.ndarray]:
    """Return the energies per forcing period, from their sums (`RowResults`) over the periods (rows,)."""
    energy = sums / periods[:, None]
    losses = energy[:, 1] + energy[:, 2] + energy[:, 3]
    further = {}
    if energy.shape[1] > 5:
        losses = losses + energy[:, 4]
        further["energy_friction"] = energy[:, 4]
    if energy.shape[1] == N_ENERGIES:
        losses = losses + energy[:, GROUND] - energy[:, LOADS]
        further["energy_housing_friction"] = energy[:, GROUND]
        further["energy_housing_load"] = energy[:, LOADS]
    return {
        "energy_input": energy[:, 0],
        "energy_damping": energy[:, 1],
        "energy_impact": energy[:, 2:4],
        **further,
        "energy_change": energy[:, -1],
        "energy_residual": energy[:, 0] - losses - energy[:, -1],
    }


def coordinates(variables: Variables, harmonics: int) -> xr.Coordinates:
    """Return the coordinates of the dimensions of `variables` other than `row`."""
    dims = frozenset(dim for dims, _values in variables.values() for dim in dims)
    multipliers = variables.get("floquet_multiplier", ((), np.empty((0, 2))))[1].shape[-1]
    return _coordinates(dims, harmonics, differentiated(variables), multipliers)


@functools.cache
def _coordinates(
    dims: frozenset[str], harmonics: int, parameters: tuple[str, ...], multipliers: int
) -> xr.Coordinates:
    """Return the coordinates of some dimensions; cached, since their indexes take long to build."""
    import xarray as xr

    values = {
        "support": np.array([1, 2], np.int8),
        "harmonic": np.arange(1, harmonics + 1),
        "multiplier": np.arange(1, multipliers + 1),
        "phase": np.arange(PHASES) / PHASES,
        "subharmonic": np.arange(1, SUBHARMONICS_PER_HARMONIC * harmonics + 1),
        "visit": np.arange(LISTED_PERIODS),
        PARAMETER: np.array(parameters),
    }
    return xr.Coordinates({name: (name, values[name]) for name in values if name in dims})


def concatenate(parts: list[Variables]) -> Variables:
    """Join the variables of all parts, which are emptied: only one variable at a time is in memory twice."""
    return {
        name: (dims, np.concatenate([part.pop(name)[1] for part in parts]))
        for name, (dims, _values) in list(parts[0].items())
    }


def ragged_indices(row_size: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the indices of the entries of `rows`, in that order, in a flat array of row_size entries per row."""
    ends = np.cumsum(row_size)
    sizes = row_size[rows]
    shift = np.repeat(ends[rows] - sizes - (np.cumsum(sizes) - sizes), sizes)
    return np.arange(sizes.sum()) + shift


def take_rows(variables: Variables, rows: np.ndarray) -> Variables:
    """Return the variables with their rows in the order `rows`; ragged entries move with their rows."""
    if np.array_equal(rows, np.arange(len(rows))):
        return variables
    selected = {}
    for name, (dims, values) in variables.items():
        if dims[0] == "row":
            selected[name] = (dims, values[rows])
        else:
            selected[name] = (dims, values[ragged_indices(variables["row_size"][1], rows)])
    return selected
