"""One error for each row of a sweep: the largest of its orbit's errors, relative to the scales of the row.

Each error (`orbit_errors`) counts as the larger of absolute and relative to the scale of its kind in that row:
displacements, velocities, and numbers without unit. A row without an orbit, or not solved, has an infinite error: means
over a chaotic motion differ as much as the length of their window allows.
"""

from __future__ import annotations

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import support_positions
from vibropipe.solve.rows.label import Variables
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import ERROR_SUFFIX, STEADY

# What the errors of a quantity of rows are relative to, by its dimension.
KINDS = {"length": "displacement", "velocity": "velocity", "": "number"}
# Quantities whose errors count, those of impacts and phases apart; velocities of harmonics follow from displacements.
COUNTED = {
    name: KINDS[entry.dimension]
    for name, entry in STEADY.items()
    if entry.has_error and entry.dimension in KINDS and "impact" not in entry.dims
    if entry.units != "rad"
}


def row_errors(parameters: np.ndarray, variables: Variables) -> np.ndarray:
    """Return the error of each row (rows,).

    Parameters
    ----------
    parameters : (rows, parameters) array
    variables : Variables
        Quantities of the rows, with their errors.
    """
    scales = row_scales(parameters, variables)
    error = np.zeros(len(parameters))
    for name, kind in COUNTED.items():
        if name + ERROR_SUFFIX not in variables:
            continue
        scale = np.minimum(1.0, scales.get(kind, np.ones(len(error))))
        values = variables[name + ERROR_SUFFIX][1].astype(float)
        largest = np.nan_to_num(values, nan=0.0, posinf=np.inf).reshape(len(error), -1).max(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.maximum(error, np.where(largest > 0, largest / scale, 0.0))
    has_orbit = np.isfinite(variables["displacement_strobe" + ERROR_SUFFIX][1])
    return np.where(has_orbit, error, np.inf)


def row_scales(parameters: np.ndarray, variables: Variables) -> dict[str, np.ndarray]:
    """Return the scales of displacement and velocity of each row, from the variables present."""
    p = Parameters(*parameters.T)
    is_struck = variables["impacts_per_orbit"][1] > 0
    supports = np.abs(np.stack(support_positions(p.l, p.delta), axis=1))
    scales = {
        "displacement": np.max(np.where(is_struck, supports, 0.0), axis=1),
        "velocity": np.zeros(len(parameters)),
    }
    for kind, scale in scales.items():
        scale[:] = np.maximum(scale, np.abs(variables[f"{kind}_strobe"][1]))
        if f"{kind}_amplitude" in variables:
            scale[:] = np.maximum(scale, variables[f"{kind}_amplitude"][1].max(axis=1))
    if "impact_velocity_max" in variables:
        fastest = np.nan_to_num(variables["impact_velocity_max"][1]).max(axis=1)
        scales["velocity"] = np.maximum(scales["velocity"], fastest)
    return scales


def with_error(variables: Variables, error: np.ndarray, accuracy: float) -> Variables:
    """Return the variables with `error`, and status `inaccurate` in rows that miss the accuracy."""
    status = variables["status"][1].copy()
    status[(error > accuracy) & (status == Status.OK)] = Status.INACCURATE
    return {**variables, "status": (("row",), status), "error": (("row",), error)}
