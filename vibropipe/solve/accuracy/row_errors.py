"""How far the rows of a sweep can be trusted: one error per row, shared by its quantities.

A row is solved again from numbers nudged by one unit in the last place, so that roundings, the rest
of Newton's method and the conditioning of the orbit show together: SAFETY times the largest difference
of its quantities is the error, each absolute or relative to the size of its kind in that row, whichever
is more. Harmonics are compared as complex amplitudes: the error of a phase is that over the amplitude.
A row that becomes another motion when nudged, or is not solved, has the error inf. Means over a chaotic
motion differ as much as their window lets them.
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
# What must be the same for two rows to be the same motion.
IDENTITY = ("regime", "period_multiple", "row_size")


def perturbed_rows(parameters: np.ndarray) -> np.ndarray:
    """Parameters (rows, 7), each moved by one unit in its last place; an effect that is absent, and
    restitution 1, stay so, and an equilibrium at a support stays there."""
    moved = parameters * (1 + ULP * np.array(SIGNS[0][: parameters.shape[1]]))
    for name in ("R1", "R2"):
        column = Parameters._fields.index(name)
        moved[:, column] = np.where(
            parameters[:, column] == 1, 1.0, np.minimum(moved[:, column], 1)
        )
    delta, half = Parameters._fields.index("delta"), Parameters._fields.index("l")
    tied = np.abs(parameters[:, delta]) == parameters[:, half]
    moved[tied, delta] = np.copysign(moved[tied, half], parameters[tied, delta])
    return moved


def row_errors(parameters: np.ndarray, variables: Variables, perturbed: Variables) -> np.ndarray:
    """The error of each row, from its quantities and those of the row solved again."""
    sizes = row_sizes(parameters, variables)
    floor = 8 * ULP + np.nan_to_num(variables["residual"][1], nan=0.0, posinf=0.0)
    error = np.zeros(len(parameters))
    same = np.ones(len(parameters), bool)
    for name in IDENTITY:
        if name in variables:
            same &= variables[name][1] == perturbed[name][1]
    for name, distance in differences(variables, perturbed, same).items():
        scale = np.minimum(1.0, sizes.get(name, np.ones(len(error))))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(distance > 0, distance / scale, 0.0)
        error = np.maximum(error, share)
    same &= is_solved(variables["status"][1]) & is_solved(perturbed["status"][1])
    return np.where(same, SAFETY * error + floor, np.inf)


def row_sizes(parameters: np.ndarray, variables: Variables) -> dict[str, np.ndarray]:
    """Size of displacement, velocity and energy of each row, from what is known of it."""
    p = Parameters(*parameters.T)
    struck = variables["impacts_per_orbit"][1] > 0
    supports = np.abs(np.stack(support_positions(p.l, p.delta), axis=1))
    sizes = {
        "displacement": np.max(np.where(struck, supports, 0.0), axis=1),
        "velocity": np.zeros(len(parameters)),
    }
    for kind, size in sizes.items():
        size[:] = np.maximum(size, np.abs(variables[f"{kind}_strobe"][1]))
        if f"{kind}_amplitude" in variables:
            size[:] = np.maximum(size, variables[f"{kind}_amplitude"][1].max(axis=1))
    if "impact_velocity_max" in variables:
        fastest = np.nan_to_num(variables["impact_velocity_max"][1]).max(axis=1)
        sizes["velocity"] = np.maximum(sizes["velocity"], fastest)
    return {**sizes, "energy": sizes["velocity"] ** 2}


def differences(
    variables: Variables, perturbed: Variables, same: np.ndarray
) -> dict[str, np.ndarray]:
    """Largest difference per row of displacements, velocities, energies, and numbers without unit."""
    distances: dict[str, list[np.ndarray]] = {
        name: [np.zeros(len(same))] for name in ("displacement", "velocity", "energy", "number")
    }

    def compare(kind: str, name: str) -> None:
        if name in variables:
            distances[kind].append(row_distance(variables[name][1], perturbed[name][1]))

    for kind in ("displacement", "velocity"):
        compare(kind, f"{kind}_strobe")
        compare(kind, f"{kind}_mean")
        if f"{kind}_amplitude" in variables:
            one, two = (complex_amplitudes(of, kind) for of in (variables, perturbed))
            distances[kind].append(row_distance(one, two))
    compare("displacement", "displacement")
    compare("number", "floquet_multiplier")
    for name in ("energy_input", "energy_damping", "energy_impact"):
        compare("energy", name)
    if "row_size" in variables:
        velocity, phase = impact_differences(variables, perturbed, same)
        distances["velocity"].append(velocity)
        distances["number"].append(phase)
    return {kind: np.max(values, axis=0) for kind, values in distances.items()}


def complex_amplitudes(variables: Variables, kind: str) -> np.ndarray:
    """Complex amplitudes (row, harmonic)."""
    values: np.ndarray = variables[f"{kind}_amplitude"][1] * np.exp(
        1j * variables[f"{kind}_phase"][1]
    )
    return values


def row_distance(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Largest |one - two| of each row; values that neither row has do not count."""
    distance: np.ndarray = np.nan_to_num(np.abs(one - two), nan=0.0, posinf=np.inf)
    return distance if distance.ndim == 1 else distance.max(axis=tuple(range(1, distance.ndim)))


def impact_differences(
    variables: Variables, perturbed: Variables, same: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Largest difference per row of impact velocities, and of times of impact in forcing periods."""
    rows = np.arange(len(same))
    mine = np.repeat(rows, variables["row_size"][1])
    theirs = np.repeat(rows, perturbed["row_size"][1])
    kept, other = same[mine], same[theirs]

    def largest(distance: np.ndarray) -> np.ndarray:
        worst = np.zeros(len(same))
        np.maximum.at(worst, mine[kept], distance)
        return worst

    def moved(name: str) -> np.ndarray:
        distance: np.ndarray = np.abs(variables[name][1][kept] - perturbed[name][1][other])
        return distance

    turns = moved("impact_phase")
    return largest(moved("impact_velocity")), largest(np.minimum(turns, np.abs(1 - turns)))


def with_error(variables: Variables, error: np.ndarray, accuracy: float) -> Variables:
    """The variables with the error, and rows that miss the accuracy marked in their status."""
    status = variables["status"][1].copy()
    status[(error > accuracy) & (status == Status.OK)] = Status.INACCURATE
    return {**variables, "status": (("row",), status), "error": (("row",), error)}
