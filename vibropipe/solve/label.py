"""Results of rows as labelled quantities: dimension `row`, names and words from the vocabulary."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.orbits.outputs import RowResults
from vibropipe.solve.rows import PHASES
from vibropipe.solve.unsolved import is_solved

if TYPE_CHECKING:
    import xarray as xr

Variables = dict[str, tuple[tuple[str, ...], np.ndarray]]


def label_rows(rows: RowResults, parameters: np.ndarray) -> Variables:
    """Variables over `row` (and `support`, `harmonic`, `multiplier`, `phase`) of compacted results of parameters
    (rows, 7)."""
    # A motion without an orbit is measured at multiples of the forcing frequency.
    base = np.where(rows.period_multiple > 0, rows.frequency, parameters[:, 0])
    # Of a row that is not solved the section is what it began with.
    section = np.where(is_solved(rows.status)[:, None], rows.section, np.nan)
    variables: Variables = {
        "regime": (("row",), rows.regime),
        "status": (("row",), rows.status),
        "period_multiple": (("row",), rows.period_multiple),
        "impacts_per_orbit": (("row", "support"), rows.impacts),
        "rests_per_orbit": (("row", "support"), rows.rests),
        "base_frequency": (("row",), base),
        "residual": (("row",), rows.residual),
        "periods_to_settle": (("row",), rows.settled_after),
        "displacement_strobe": (("row",), section[:, 0]),
        "velocity_strobe": (("row",), section[:, 1]),
        "window_periods": (("row",), rows.window_periods),
    }
    if rows.amplitudes.size > 0:
        variables |= _harmonics(rows.amplitudes, base)
    if rows.multipliers.size > 0:
        radius = np.abs(rows.multipliers).max(axis=1)
        variables["floquet_multiplier"] = (("row", "multiplier"), rows.multipliers)
        variables["stable"] = (("row",), (radius < 1).astype(np.int8))
    if rows.impact_count.size > 0:
        variables |= _impacts(rows)
    if rows.energy.size > 0:
        variables |= _energy(rows.energy)
    if rows.motion.size > 0:
        variables["displacement"] = (("row", "phase"), rows.motion[:, 0])
        variables["velocity"] = (("row", "phase"), rows.motion[:, 1])
    return variables


def _harmonics(amplitudes: np.ndarray, base_frequency: np.ndarray) -> Variables:
    """x = mean + sum A_k cos(k w0 tau + phase_k) from X_k; the velocity's are i k w0 X_k, since x is
    continuous through impacts."""
    orders = np.arange(amplitudes.shape[1])
    rates = 1j * orders[None, :] * base_frequency[:, None] * amplitudes
    variables: Variables = {}
    for name, values in (("displacement", amplitudes), ("velocity", rates)):
        variables[f"{name}_mean"] = (("row",), values[:, 0].real)
        variables[f"{name}_amplitude"] = (("row", "harmonic"), 2 * np.abs(values[:, 1:]))
        variables[f"{name}_phase"] = (("row", "harmonic"), np.angle(values[:, 1:]))
    return variables


def _impacts(rows: RowResults) -> Variables:
    position = rows.impact_position
    whole = np.floor(position)
    return {
        "row_size": (("row",), rows.impact_count),
        "impact_phase": (("impact",), position - whole),
        "impact_period": (("impact",), whole.astype(np.int32)),
        "impact_support": (("impact",), rows.impact_support),
        "impact_velocity": (("impact",), rows.impact_velocity),
        "impact_velocity_max": (("row", "support"), rows.impact_velocity_max),
    }


def _energy(energy: np.ndarray) -> Variables:
    lost = energy[:, 1] + energy[:, 2] + energy[:, 3]
    return {
        "energy_input": (("row",), energy[:, 0]),
        "energy_damping": (("row",), energy[:, 1]),
        "energy_impact": (("row", "support"), energy[:, 2:]),
        "energy_residual": (("row",), energy[:, 0] - lost),
    }


def coordinates(variables: Variables, harmonics: int) -> xr.Coordinates:
    """Coordinates of the dimensions that `variables` use beside the rows."""
    return _coordinates(
        frozenset(dim for dims, _values in variables.values() for dim in dims), harmonics
    )


@functools.cache
def _coordinates(dims: frozenset[str], harmonics: int) -> xr.Coordinates:
    """Those of some dimensions, with their indexes, which take long to make."""
    import xarray as xr

    known = {
        "support": np.array([1, 2], np.int8),
        "harmonic": np.arange(1, harmonics + 1),
        "multiplier": np.array([1, 2]),
        "phase": np.arange(PHASES) / PHASES,
    }
    return xr.Coordinates({name: (name, known[name]) for name in known if name in dims})


def concatenate(parts: list[Variables]) -> Variables:
    """The variables of all parts, which are emptied: one variable at a time is in memory twice."""
    return {
        name: (dims, np.concatenate([part.pop(name)[1] for part in parts]))
        for name, (dims, _values) in list(parts[0].items())
    }


def ragged_places(row_size: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Places, in a flat array of row_size entries a row, of the entries of `rows` in that order."""
    ends = np.cumsum(row_size)
    sizes = row_size[rows]
    shift = np.repeat(ends[rows] - sizes - (np.cumsum(sizes) - sizes), sizes)
    return np.arange(sizes.sum()) + shift


def take_rows(variables: Variables, rows: np.ndarray) -> Variables:
    """The variables with their rows in another order, ragged entries moving with their rows."""
    if np.array_equal(rows, np.arange(len(rows))):
        return variables
    selected = {}
    for name, (dims, values) in variables.items():
        if dims[0] == "row":
            selected[name] = (dims, values[rows])
        else:
            selected[name] = (dims, values[ragged_places(variables["row_size"][1], rows)])
    return selected
