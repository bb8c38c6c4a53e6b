"""Solution of backbone scenes: closed-form curves with simulated motions on them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.motion.conservative import amplitude_frequency, backbone
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.backbone.keys import BackboneScene
    from vibropipe.words.progress import Progress


def solve(scene: BackboneScene, progress: Progress | None = None) -> xr.Dataset:
    """Compute a backbone over amplitude, or eq. (10) with simulated motions on its curves."""
    return stored(curves_of(scene), scene.mass_and_stiffness)


def curves_of(scene: BackboneScene) -> xr.Dataset:
    """Return a backbone without units."""
    grids = scene.over_arrays()
    if scene.over_amplitude:
        return amplitude_frequency(
            Exciter(**scene.resolved_exciter()),
            amplitude=grids["amplitude"],
            harmonics=scene.harmonics,
        )
    curves = backbone(grids["delta_over_l"], grids["tau_bar"])
    return simulated_points(curves, scene.check_points)


def simulated_points(curves: xr.Dataset, points: int) -> xr.Dataset:
    """Simulate conservative motions at points evenly spaced along the curves of eq. (10).

    Adds `simulated_tau_bar` and `simulated_velocity_over_l` over (delta_over_l, point); nan for a curve
    without finite values.
    """
    offsets = curves["delta_over_l"].values
    simulated = np.full((2, len(offsets), points), np.nan)
    for row, offset in enumerate(offsets):
        curve = curves["velocity_over_l"].isel(delta_over_l=row).values
        finite = np.flatnonzero(np.isfinite(curve))
        if finite.size == 0:
            continue
        chosen = finite[np.linspace(0, finite.size - 1, points + 2).round().astype(int)[1:-1]]
        for point, index in enumerate(chosen):
            period = float(curves["tau_bar"][index])
            simulated[:, row, point] = free_motion(float(offset), float(curve[index]), period)
    dims = ("delta_over_l", "point")
    return curves.assign(
        simulated_tau_bar=(dims, simulated[0]), simulated_velocity_over_l=(dims, simulated[1])
    )


def free_motion(offset: float, velocity: float, period: float) -> tuple[float, float]:
    """Simulate the conservative motion with l = 1 that leaves support 1 with a given velocity.

    Returns its period (twice the time from support 2 to support 1) and its velocity before the impact
    on support 1; nan if it does not strike both supports within three times the expected period.
    """
    exciter = Exciter(l=1.0, delta=offset)
    motion = simulate(
        exciter, tau_end=3 * period, x0=1.0 + offset, v0=-velocity, samples_per_period=0
    )
    supports = motion["impact_support"].values
    times, speeds = motion["impact_tau"].values, motion["impact_velocity"].values
    for first in range(len(supports) - 1):
        if supports[first] == 2 and supports[first + 1] == 1:
            return 2 * float(times[first + 1] - times[first]), float(speeds[first + 1])
    return math.nan, math.nan
