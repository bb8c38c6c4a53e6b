"""A wanted or measured motion as a curve of displacement over the phase, and its distance from an orbit."""

from __future__ import annotations

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import support_positions
from vibropipe.solve.rows.label import Variables, ragged_indices
from vibropipe.solve.rows.row_results import PHASES, acting_rows
from vibropipe.words.regimes import Regime

OUTPUTS = ("impacts", "motion")


def displacement_at(variables: Variables, parameters: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return displacements (rows, n) of orbits at phases (n,), in forcing periods; NaN without an orbit.

    Cubic Hermite interpolation between the samples and the impacts of an orbit: its error is that of the fourth
    power of a sample's width, also where the velocity jumps.
    """
    m = variables["period_multiple"][1]
    displacement = np.full((len(m), phase.size), np.nan)
    for row in np.flatnonzero(m > 0).tolist():
        displacement[row] = _row(variables, parameters[row], row, int(m[row]), phase)
    return displacement


def _row(
    variables: Variables, parameters: np.ndarray, row: int, m: int, phase: np.ndarray
) -> np.ndarray:
    from scipy.interpolate import CubicHermiteSpline

    p = Parameters(*acting_rows(parameters[None])[0])
    x, v = (variables[name][1][row] for name in ("displacement", "velocity"))
    grid = np.arange(PHASES + 1) / PHASES * m
    position, support, velocity = _impacts(variables, row)
    if int(variables["regime"][1][row]) == Regime.WITH_REST:
        position = position[
            :0
        ]  # impacts accumulate: velocities between them are those of the samples
    after = [
        -(p.R1 if side == 1 else p.R2) * speed
        for side, speed in zip(support, velocity, strict=True)
    ]
    at = dict(zip((1, 2), support_positions(p.l, p.delta), strict=True))
    # Pieces between impacts, each with its own velocities at both ends.
    ends = np.concatenate([[0.0], position, [float(m)]])
    place = phase % m
    values = np.empty(phase.size)
    for n in range(len(ends) - 1):
        low, high = ends[n], ends[n + 1]
        inner = (grid > low) & (grid < high)
        knots = [grid[inner], np.append(x, x[0])[inner], np.append(v, v[0])[inner]]
        first = (low, at[support[n - 1]], after[n - 1]) if n else (0.0, x[0], v[0])
        is_last = n == len(position)
        last = (high, x[0], v[0]) if is_last else (high, at[support[n]], velocity[n])
        nodes, x_nodes, v_nodes = (
            np.concatenate([[a], knot, [b]]) for a, knot, b in zip(first, knots, last, strict=True)
        )
        chosen = (place >= low) & ((place < high) | is_last)
        distinct = np.concatenate([np.diff(nodes) > 0, [True]])
        if chosen.any():
            slope = v_nodes[distinct] * 2 * np.pi / p.nu
            values[chosen] = CubicHermiteSpline(nodes[distinct], x_nodes[distinct], slope)(
                place[chosen]
            )
    return values


def _impacts(variables: Variables, row: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions in forcing periods, supports and velocities before the impacts of a row, in order."""
    kept = ragged_indices(variables["row_size"][1], np.array([row]))
    position = (variables["impact_period"][1] + variables["impact_phase"][1])[kept]
    order = np.argsort(position, kind="stable")
    return (
        position[order],
        variables["impact_support"][1][kept][order],
        variables["impact_velocity"][1][kept][order],
    )
