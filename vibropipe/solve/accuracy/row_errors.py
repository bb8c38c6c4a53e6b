"""Error estimates for the rows of a sweep: one error per row, shared by its quantities.

A row is solved again with parameters perturbed by one unit in the last place. The difference contains rounding, the
residual of Newton's method and the conditioning of the orbit. The error is SAFETY times the largest difference of
its quantities, each the larger of absolute and relative to the scale of its kind in that row. Harmonics are compared
as complex amplitudes: the error of a phase is the error divided by the amplitude. A row that becomes another motion
when perturbed, or is not solved, has an infinite error. Means over a chaotic motion differ as much as the length of
their window allows; its listed impacts and sections and its Lyapunov exponent are not compared. Of an orbit the growth
per unit of tau, exp(exponent), is compared: the error of the exponent is the error divided by the growth.
"""

from __future__ import annotations

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import support_positions
from vibropipe.solve.accuracy.motion_errors import SIGNS, ULP
from vibropipe.solve.label import Variables
from vibropipe.solve.unsolved import is_solved
from vibropipe.words.status import Status

SAFETY = 4.0
# Variables that must agree for two rows to be the same motion.
IDENTITY = ("regime", "period_multiple")


def perturbed_rows(parameters: np.ndarray) -> np.ndarray:
    """Return parameters (rows, parameters), each moved by one unit in the last place.

    Absent effects (0) and restitution 1 are kept, and an equilibrium at a support stays there.
    """
    perturbed = parameters * (1 + ULP * np.array(SIGNS[0][: parameters.shape[1]]))
    for name in ("R1", "R2"):
        column = Parameters._fields.index(name)
        perturbed[:, column] = np.where(
            parameters[:, column] == 1, 1.0, np.minimum(perturbed[:, column], 1)
        )
    delta, half, load = (Parameters._fields.index(name) for name in ("delta", "l", "load"))
    offset = parameters[:, delta] - parameters[:, load]
    tied = np.abs(offset) == parameters[:, half]
    perturbed[tied, delta] = perturbed[tied, load] + np.copysign(
        perturbed[tied, half], offset[tied]
    )
    return perturbed


def row_errors(parameters: np.ndarray, variables: Variables, perturbed: Variables) -> np.ndarray:
    """Return the error of each row (rows,).

    Parameters
    ----------
    parameters : (rows, parameters) array
    variables, perturbed : Variables
        Quantities of the rows, and of the perturbed rows.
    """
    scales = row_scales(parameters, variables)
    floor = 8 * ULP + np.nan_to_num(variables["residual"][1], nan=0.0, posinf=0.0)
    error = np.zeros(len(parameters))
    is_same = np.ones(len(parameters), bool)
    for name in IDENTITY:
        is_same &= variables[name][1] == perturbed[name][1]
    is_orbit = variables["period_multiple"][1] > 0
    if "row_size" in variables:
        is_same &= ~is_orbit | (variables["row_size"][1] == perturbed["row_size"][1])
    for name, distance in differences(variables, perturbed, is_same & is_orbit).items():
        scale = np.minimum(1.0, scales.get(name, np.ones(len(error))))
        with np.errstate(divide="ignore", invalid="ignore"):
            relative_error = np.where(distance > 0, distance / scale, 0.0)
        error = np.maximum(error, relative_error)
    is_same &= is_solved(variables["status"][1]) & is_solved(perturbed["status"][1])
    return np.where(is_same, SAFETY * error + floor, np.inf)


def row_scales(parameters: np.ndarray, variables: Variables) -> dict[str, np.ndarray]:
    """Return the scales of displacement, velocity and energy of each row, from the variables present."""
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
    return {**scales, "energy": scales["velocity"] ** 2}


def differences(
    variables: Variables, perturbed: Variables, is_same_orbit: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the largest difference per row of displacements, velocities, energies, and numbers without unit.

    Impacts and sections are compared only of rows with the same orbit.
    """
    distances: dict[str, list[np.ndarray]] = {
        name: [np.zeros(len(is_same_orbit))]
        for name in ("displacement", "velocity", "energy", "number")
    }

    def compare(kind: str, name: str) -> None:
        if name in variables:
            distances[kind].append(row_distance(variables[name][1], perturbed[name][1]))

    for kind in ("displacement", "velocity"):
        compare(kind, f"{kind}_strobe")
        compare(kind, f"{kind}_mean")
        for name in (kind, f"subharmonic_{kind}"):
            if f"{name}_amplitude" in variables:
                one, two = (complex_amplitudes(source, name) for source in (variables, perturbed))
                distances[kind].append(row_distance(one, two))
        if f"poincare_{kind}" in variables:
            one, two = (source[f"poincare_{kind}"][1] for source in (variables, perturbed))
            distances[kind].append(np.where(is_same_orbit, row_distance(one, two), 0.0))
    compare("displacement", "displacement")
    compare("number", "floquet_multiplier")
    if "lyapunov_exponent" in variables:
        one, two = (np.exp(source["lyapunov_exponent"][1]) for source in (variables, perturbed))
        distances["number"].append(np.where(is_same_orbit, row_distance(one, two), 0.0))
    for name in ("energy_input", "energy_damping", "energy_impact"):
        compare("energy", name)
    if "row_size" in variables:
        velocity, phase = impact_differences(variables, perturbed, is_same_orbit)
        distances["velocity"].append(velocity)
        distances["number"].append(phase)
    return {kind: np.max(values, axis=0) for kind, values in distances.items()}


def complex_amplitudes(variables: Variables, kind: str) -> np.ndarray:
    """Return the complex amplitudes (row, harmonic) of "displacement", "velocity" or "subharmonic_displacement"."""
    values: np.ndarray = variables[f"{kind}_amplitude"][1] * np.exp(
        1j * variables[f"{kind}_phase"][1]
    )
    return values


def row_distance(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return the largest |one - two| of each row; values absent in both rows (NaN) do not count."""
    distance: np.ndarray = np.nan_to_num(np.abs(one - two), nan=0.0, posinf=np.inf)
    return distance if distance.ndim == 1 else distance.max(axis=tuple(range(1, distance.ndim)))


def impact_differences(
    variables: Variables, perturbed: Variables, is_same_orbit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest differences per row of impact velocities, and of times of impact in forcing periods."""
    rows = np.arange(len(is_same_orbit))
    row_of_impact = np.repeat(rows, variables["row_size"][1])
    row_of_perturbed = np.repeat(rows, perturbed["row_size"][1])
    mask, other_mask = is_same_orbit[row_of_impact], is_same_orbit[row_of_perturbed]

    def largest(distance: np.ndarray) -> np.ndarray:
        worst = np.zeros(len(is_same_orbit))
        np.maximum.at(worst, row_of_impact[mask], distance)
        return worst

    def change(name: str) -> np.ndarray:
        distance: np.ndarray = np.abs(variables[name][1][mask] - perturbed[name][1][other_mask])
        return distance

    turns = change("impact_phase")
    return largest(change("impact_velocity")), largest(np.minimum(turns, np.abs(1 - turns)))


def with_error(variables: Variables, error: np.ndarray, accuracy: float) -> Variables:
    """Return the variables with `error`, and status `inaccurate` in rows that miss the accuracy."""
    status = variables["status"][1].copy()
    status[(error > accuracy) & (status == Status.OK)] = Status.INACCURATE
    return {**variables, "status": (("row",), status), "error": (("row",), error)}
