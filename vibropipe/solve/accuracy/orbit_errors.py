"""Errors of labelled quantities of orbits, from those of their sections, impacts and return maps.

They estimate rounding and the residual, carried through the inverse that closes the orbit
(`orbits.sensitivity.errors`); NaN without an orbit. Their two digits need no more than single precision.

The one error of a row of a sweep is the largest of its orbit's errors. Each counts as the larger of absolute and
relative to the scale of its kind in that row: displacements, velocities, and numbers without unit. A row without an
orbit, or not solved, has an infinite error: means over a chaotic motion differ as much as the length of their window
allows.
"""

from __future__ import annotations

import numpy as np

from vibropipe.orbits.harmonics import RESONANT
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.sensitivity.errors import IMPULSES, PHASES, SPEED_1, TRACE, TURN, ULP, V, X
from vibropipe.physics.derivatives import H
from vibropipe.physics.effects import CALL_FOR_PIECES
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import support_positions
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import ERROR_SUFFIX, STEADY, row_dims

Variables = dict[str, tuple[tuple[str, ...], np.ndarray]]
# Factor of the root mean square of four samples, which may happen to be small.
SAFETY = 1.5
# Columns of the parameters with which a motion is marched by linear pieces.
PIECES = [Parameters._fields.index(name) for name in CALL_FOR_PIECES]
# Rounding of the determinant of a return map's derivative, in ulps of the square of the larger multiplier.
DETERMINANT = 4.0
# What the errors of a quantity of rows are relative to, by its dimension.
KINDS = {"length": "displacement", "velocity": "velocity", "": "number"}
# Quantities whose errors count, those of impacts and phases apart; velocities of harmonics follow from displacements.
COUNTED = {
    name: KINDS[entry.dimension]
    for name, entry in STEADY.items()
    if entry.has_error and entry.dimension in KINDS and "impact" not in entry.dims
    if entry.units != "rad"
}


def label_errors(rows: RowResults, nu: np.ndarray, parameters: np.ndarray) -> Variables:
    """Label the errors of compacted results: `<name>_error` over the dimensions of `<name>`, float32.

    rows : with `e_row` and `e_impacts`
    nu : (rows,), frequency of the first harmonic
    parameters : (rows, parameters)
    """
    e, has_pieces = SAFETY * rows.e_row, np.any(parameters[:, PIECES] != 0.0, axis=1)
    errors_of = {"displacement_strobe": e[:, X], "velocity_strobe": e[:, V]}
    if rows.amplitudes.size > 0:
        errors = _harmonics(rows, e, nu, parameters[:, H], has_pieces)
        size = np.abs(rows.amplitudes[:, 1:])
        errors_of["displacement_mean"] = errors[:, 0]
        errors_of["displacement_amplitude"] = 2.0 * errors[:, 1:]
        with np.errstate(divide="ignore", invalid="ignore"):
            turned = np.where(errors[:, 1:] > 0.0, errors[:, 1:] / size, 0.0)
        # A phase of nothing is any.
        errors_of["displacement_phase"] = np.minimum(turned, np.pi)
    if rows.multipliers.size > 0:
        errors = _multipliers(rows, e[:, TRACE])
        # The determinant along pieces is a difference of products that a stick makes equal.
        errors += np.where(has_pieces, e[:, TRACE], 0.0)[:, None]
        # A mass that rests forgets where it came from: both are exactly 0.
        forgets = (rows.rests.sum(axis=1) > 0) & (rows.multipliers == 0.0).all(axis=1)
        errors[forgets] = 0.0
        errors_of["floquet_multiplier"] = errors
    if rows.impact_count.size > 0:
        errors_of["impact_phase"] = SAFETY * rows.e_impacts[:, 0]
        errors_of["impact_velocity"] = SAFETY * rows.e_impacts[:, 1]
        speeds = e[:, SPEED_1:TURN]
        is_struck = ~np.isnan(rows.impact_velocity_max)
        errors_of["impact_velocity_max"] = np.where(is_struck, speeds, np.nan)
    # An error beyond float32, of an orbit of enormous multipliers, is infinite.
    with np.errstate(over="ignore"):
        return {
            name + ERROR_SUFFIX: (row_dims(name), values.astype(np.float32))
            for name, values in errors_of.items()
        }


def _harmonics(
    rows: RowResults, e: np.ndarray, nu: np.ndarray, h: np.ndarray, has_pieces: np.ndarray
) -> np.ndarray:
    """Return the errors of the complex amplitudes (rows, harmonics + 1); has_pieces (rows,) bool."""
    k = np.arange(rows.amplitudes.shape[1])
    w = k * nu[:, None]
    stiffness = np.hypot((1.0 - w) * (1.0 + w), h[:, None] * w)
    size = np.abs(rows.amplitudes)
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = (e[:, IMPULSES, None] + k * e[:, PHASES, None] + ULP * size) / stiffness
    # Near resonance amplitudes are integrals of the motion.
    along = e[:, X, None] + e[:, V, None] / np.minimum(1.0, nu)[:, None]
    errors = np.where(stiffness < RESONANT, along + 8.0 * ULP * size, errors)
    # Those of linear pieces are integrals of the motion, too, of which each is divided by its stiffness.
    rounded = ULP * size.sum(axis=1, keepdims=True) * (1.0 + w * w)
    pieces = e[:, IMPULSES, None] + 4.0 * rounded / np.maximum(stiffness, RESONANT)
    errors = np.where(has_pieces[:, None], pieces, errors)
    is_struck = (rows.impacts.sum(axis=1) > 0)[:, None]
    still = np.where(size > 0.0, e[:, IMPULSES, None], 0.0)
    exact = np.where(np.isnan(e[:, IMPULSES, None]), np.nan, still)
    return np.asarray(np.where(is_struck, errors, exact))


def _multipliers(rows: RowResults, trace: np.ndarray) -> np.ndarray:
    """Return the errors of both multipliers (rows, 2) from that of the trace."""
    size = np.abs(rows.multipliers)
    distance = np.abs(rows.multipliers[:, 0] - rows.multipliers[:, 1])[:, None]
    # Next to a grazing of several impacts at once the products may overflow: the error is then infinite.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        split = size * trace[:, None] / distance
        # Where both are equal the root of the error of the trace counts.
        limit = np.sqrt(trace[:, None] * (size + trace[:, None]))
    # The small one follows from a determinant, a difference of products of the size of the large one.
    rounding = DETERMINANT * ULP * size.max(axis=1, keepdims=True)
    return np.where(np.isnan(trace)[:, None], np.nan, np.fmin(split, limit) + rounding)


def row_errors(parameters: np.ndarray, variables: Variables) -> np.ndarray:
    """Return the error of each row (rows,), from parameters (rows, parameters) and quantities with their errors."""
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
