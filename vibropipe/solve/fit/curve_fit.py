"""A wanted or measured motion as a curve of displacement over the phase, and its distance from an orbit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import support_positions
from vibropipe.solve.rows.label import Variables, ragged_indices
from vibropipe.solve.rows.row_results import PHASES, acting_rows
from vibropipe.words.regimes import Regime

OUTPUTS = ("impacts", "motion")


def displacement_at(variables: Variables, parameters: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return displacements (rows, n) of orbits at phases (n,), in forcing periods; NaN without an orbit."""
    m = variables["period_multiple"][1]
    displacement = np.full((len(m), phase.size), np.nan)
    for row in np.flatnonzero(m > 0).tolist():
        displacement[row] = orbit_curve(variables, parameters[row], row).at(phase)[0]
    return displacement


class OrbitCurve(NamedTuple):
    """Displacement and velocity of an orbit over the phase, in forcing periods.

    Cubic Hermite interpolation between the samples and the impacts of an orbit: its error is that of the fourth power
    of a sample's width, also where the velocity jumps; the error of the velocity is that of the third power.

    parameters : as kernels see them
    m : forcing periods of the orbit
    rigid_impacts : (i,), phases of impacts on rigid supports
    begin, width : (n,), phases where stretches between samples and impacts begin, and their lengths, > 0
    x, v : (n, 2), displacement and velocity at both ends of each
    """

    parameters: Parameters
    m: int
    rigid_impacts: np.ndarray
    begin: np.ndarray
    width: np.ndarray
    x: np.ndarray
    v: np.ndarray

    def at(self, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return displacements and velocities (n,) at phases (n,)."""
        place = phase % self.m
        index = np.maximum(np.searchsorted(self.begin, place, side="right") - 1, 0)
        width, period = self.width[index], 2 * np.pi / self.parameters.nu
        s = (place - self.begin[index]) / width
        (x0, x1), (v0, v1) = self.x[index].T, self.v[index].T
        step, slope0, slope1 = x1 - x0, v0 * width * period, v1 * width * period
        # Powers of s beyond the straight line at the beginning.
        square, cube = 3 * step - 2 * slope0 - slope1, slope0 + slope1 - 2 * step
        x = x0 + s * (slope0 + s * (square + s * cube))
        return x, (slope0 + s * (2 * square + 3 * s * cube)) / (width * period)


def orbit_curve(variables: Variables, parameters: np.ndarray, row: int) -> OrbitCurve:
    """Return the curve of an orbit.

    variables : with the outputs `impacts` and `motion`
    parameters : (p,), of the row
    row : one with an orbit
    """
    p = Parameters(*acting_rows(parameters[None])[0])
    m = int(variables["period_multiple"][1][row])
    x, v = (variables[name][1][row] for name in ("displacement", "velocity"))
    grid = np.arange(PHASES + 1) / PHASES * m
    position, support, velocity = _impacts(variables, row)
    if int(variables["regime"][1][row]) == Regime.WITH_REST:
        # Impacts accumulate: velocities between them are those of the samples.
        position = position[:0]
    # A soft support takes the mass over with the velocity that it has.
    is_rigid = np.where(support == 1, p.k1 == 0.0, p.k2 == 0.0)
    restitution = np.where(support == 1, p.R1, p.R2)
    after = np.where(is_rigid, -restitution * velocity, velocity)
    at = dict(zip((1, 2), support_positions(p.l, p.delta), strict=True))
    wall = np.where(support == 1, at[1], at[2])
    # Samples, and impacts after those at the same phase.
    place = np.concatenate([grid, position])
    order = np.argsort(place, kind="stable")
    n = len(position)
    displacement = np.concatenate([x, x[:1], wall[:n]])[order]
    before = np.concatenate([v, v[:1], velocity[:n]])[order]
    beyond = np.concatenate([v, v[:1], after[:n]])[order]
    width = np.diff(place[order])
    kept = width > 0
    return OrbitCurve(
        p, m, position[is_rigid[:n]], place[order][:-1][kept], width[kept],
        np.column_stack([displacement[:-1], displacement[1:]])[kept],
        np.column_stack([beyond[:-1], before[1:]])[kept],
    )  # fmt: skip


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
