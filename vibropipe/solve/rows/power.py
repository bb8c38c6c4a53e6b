"""The outputs `power` and `frame`: energies, forces and impulses of rows per unit of time, and what impacts wear.

The drive acts between mass and frame, the load on the mass alone. Spring, damper, friction, supports and the reaction
of the drive then press on the frame with load - x'', whatever they are (docs/theory.md). A housing is the frame: where
it slides, x'' + X'' stands for x''.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from vibropipe.orbits.forces import ACCELERATION, FORCE_MAX, IMPULSE, POWER_MAX, SQUARE
from vibropipe.orbits.results import RowResults
from vibropipe.solve.rows.row_results import acting_rows, columns_of
from vibropipe.words.vocabulary import POWERS

Values = dict[str, np.ndarray]
TWO_PI = 2.0 * np.pi
# Phases at which the force of two harmonics is looked at before Newton's method, and steps of that.
PHASES, NEWTON_STEPS = 64, 6


def label_power(
    values: Mapping[str, np.ndarray], rows: RowResults, nu: np.ndarray, parameters: np.ndarray
) -> Values:
    """Return the powers of rows.

    values : labelled quantities of the rows: energies and impacts, and those of a housing
    rows : with `forces`
    nu : (rows,), 2 pi over the time to which energies and impacts per period belong
    parameters : (rows, parameters)
    """
    p = columns_of(acting_rows(parameters))
    powers = {
        name: per_time(values[energy], nu) for name, energy in POWERS.items() if energy in values
    }
    struck = mean_over_impacts(rows, lambda speed, row: 0.5 * inertia_of(p)[row] * speed**2)
    powers |= {
        "power_struck": per_time(values["impacts_per_period"] * struck, nu),
        "power_input_max": rows.forces[:, POWER_MAX],
        "drive_force_max": largest_drive_force(p),
    }
    if "power_housing_load" in powers:
        powers |= _creeping(powers, values["housing_velocity_mean"])
    return powers


def inertia_of(p: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the share (rows,) of the mass that an impact turns round: both bodies move, 1/(1 + kappa)."""
    inertia: np.ndarray = 1.0 / (1.0 + p["mass_ratio"])
    return inertia


def _creeping(powers: Mapping[str, np.ndarray], speed: np.ndarray) -> Values:
    """Return what a housing that creeps costs; NaN where it does not creep, or works against no load.

    speed : (rows,), mean velocity of the housing
    """
    work = powers["power_input"]
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = -powers["power_housing_load"] / work
        per_distance = work / np.abs(speed)
    is_useful = (powers["power_housing_load"] < 0.0) & (work > 0.0)
    return {
        "efficiency": np.where(is_useful, efficiency, np.nan),
        "work_per_distance": np.where(speed != 0.0, per_distance, np.nan),
    }


def label_frame(
    values: Mapping[str, np.ndarray], rows: RowResults, nu: np.ndarray, parameters: np.ndarray
) -> Values:
    """Return the forces and impulses that reach the frame, and the wear of the supports.

    Arguments are as for `label_power`; `values` with the harmonics of displacement.
    """
    p = columns_of(parameters)
    periods = np.maximum(
        np.where(rows.period_multiple > 0, rows.period_multiple, rows.window_periods), 1
    )
    span, load, forces = periods * TWO_PI / nu, p["load"], rows.forces
    acceleration, square = forces[:, ACCELERATION] / span, forces[:, SQUARE] / span
    mean_square = load**2 - 2.0 * load * acceleration + square
    multiples = np.arange(1, rows.amplitudes.shape[1])
    exponent = p["wear_exponent"]
    wear = mean_over_impacts(rows, lambda speed, row: speed ** exponent[row])
    # A force that does not push off the frame is not known apart from one that does.
    is_known = known_on_frame(parameters)
    amplitude, phase = _harmonics(values, rows, multiples * nu[:, None])
    frame = {
        "frame_force_mean": load - acceleration,
        "frame_force_rms": is_known * np.sqrt(np.maximum(mean_square, 0.0)),
        "frame_force_max": is_known * forces[:, FORCE_MAX],
        "frame_force_amplitude": is_known[:, None] * amplitude,
        "frame_force_phase": is_known[:, None] * phase,
        "impulse_per_period": forces[:, IMPULSE : IMPULSE + 2] / periods[:, None],
        "wear_rate": per_time(values["impacts_per_period"] * wear, nu),
    }
    return frame | {"impact_impulse": _impulses(rows, parameters)}


def _harmonics(
    values: Mapping[str, np.ndarray], rows: RowResults, w: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes and phases of the force on the frame; w : angular frequencies (rows, harmonics)."""
    amplitude, phase = w**2 * values["displacement_amplitude"], values["displacement_phase"]
    if rows.housing_harmonics.size == 0:
        return amplitude, phase
    acceleration = rows.housing_harmonics[:, 1:]
    slides = acceleration != 0.0
    force = w**2 * rows.amplitudes[:, 1:] - acceleration
    return np.where(slides, 2.0 * np.abs(force), amplitude), np.where(
        slides, np.angle(force), phase
    )


def known_on_frame(parameters: np.ndarray) -> np.ndarray:
    """Return 1 for each row (rows,) whose force on the frame is known, NaN under a shaker."""
    return np.where(columns_of(parameters)["shaker"] != 0.0, np.nan, 1.0)


def per_time(values: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return what (rows, ...) is per period as per unit of time; nu : (rows,)."""
    return values * (nu / TWO_PI).reshape(-1, *(1,) * (values.ndim - 1))


def mean_over_impacts(
    rows: RowResults, of: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Return the means (rows, 2) over the listed impacts on each support; 0 without one.

    of : takes the speeds before impact and the indices of their rows, (impacts,), and returns what is averaged
    """
    n = rows.impact_count.size
    owner = np.repeat(np.arange(n), rows.impact_count)
    place = 2 * owner + rows.impact_support - 1
    sums = np.bincount(place, of(np.abs(rows.impact_velocity), owner), 2 * n)
    counts = np.bincount(place, minlength=2 * n)
    return (sums / np.maximum(counts, 1)).reshape(n, 2)


def _impulses(rows: RowResults, parameters: np.ndarray) -> np.ndarray:
    """Return the impulse that the support takes of each impact; NaN where a soft contact is not known."""
    if rows.contacts.shape[1] > 0:
        return rows.contacts[:, -1]
    owner = np.repeat(np.arange(rows.impact_count.size), rows.impact_count)
    p = columns_of(acting_rows(parameters))
    is_first = rows.impact_support == 1
    restitution = np.where(is_first, p["R1"][owner], p["R2"][owner])
    # Contacts with soft supports are not known of a housing that slides.
    is_soft = np.where(is_first, p["k1"][owner], p["k2"][owner]) > 0.0
    impulses = inertia_of(p)[owner] * (1.0 + restitution) * np.abs(rows.impact_velocity)
    return np.where(is_soft, np.nan, impulses)


def largest_drive_force(p: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the largest size (rows,) of f sin(u) + f2 sin(2 u + phi2), from parameters (rows,) by name."""
    largest: np.ndarray = np.abs(p["f"])
    has_second = p["f2"] != 0.0
    if has_second.any():
        two = (p[name][has_second][:, None] for name in ("f", "f2", "phi2"))
        largest[has_second] = _largest_of_two(*two)
    return largest


def _largest_of_two(f: np.ndarray, f2: np.ndarray, phi2: np.ndarray) -> np.ndarray:
    """Return the largest force (rows,) of two harmonics (rows, 1), from phases all round and Newton's method."""
    u = np.broadcast_to(TWO_PI * np.arange(PHASES) / PHASES, (len(f), PHASES))

    def force(u: np.ndarray, order: int) -> np.ndarray:
        turn = order * np.pi / 2.0
        return f * np.sin(u + turn) + 2.0**order * f2 * np.sin(2.0 * u + phi2 + turn)

    largest = np.abs(force(u, 0)).max(axis=1)
    for _ in range(NEWTON_STEPS):
        slope, curvature = force(u, 1), force(u, 2)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.where(curvature == 0.0, u, u - np.clip(slope / curvature, -0.1, 0.1))
    return np.fmax(largest, np.abs(force(u, 0)).max(axis=1))
