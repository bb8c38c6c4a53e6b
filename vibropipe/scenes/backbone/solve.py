"""A backbone scene: curves in closed form, with simulated motions set on them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.conservative import amplitude_frequency, backbone
from vibropipe.solve.motion import simulate

if TYPE_CHECKING:
    from vibropipe.scenes.backbone.keys import BackboneScene
    from vibropipe.scenes.kind import Progress


def solve(scene: BackboneScene, progress: Progress | None = None) -> xr.Dataset:
    """Compute a backbone: over amplitude, or along eq. (10) with simulated points on its curves."""
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
    """Set simulated conservative motions on the curves of eq. (10), evenly over their drawn parts.

    Adds `simulated_tau_bar` and `simulated_velocity_over_l` over (delta_over_l, point), nan where a
    curve has no drawn part.
    """
    offsets = curves["delta_over_l"].values
    found = np.full((2, len(offsets), points), np.nan)
    for row, offset in enumerate(offsets):
        curve = curves["velocity_over_l"].isel(delta_over_l=row).values
        drawn = np.flatnonzero(np.isfinite(curve))
        if drawn.size == 0:
            continue
        chosen = drawn[np.linspace(0, drawn.size - 1, points + 2).round().astype(int)[1:-1]]
        for point, place in enumerate(chosen):
            period = float(curves["tau_bar"][place])
            found[:, row, point] = free_motion(float(offset), float(curve[place]), period)
    dims = ("delta_over_l", "point")
    return curves.assign(
        simulated_tau_bar=(dims, found[0]), simulated_velocity_over_l=(dims, found[1])
    )


def free_motion(offset: float, velocity: float, about: float) -> tuple[float, float]:
    """Simulate the conservative motion that leaves support 1 with `velocity`; l = 1.

    Returns its period, twice the time from support 2 to support 1, and its velocity at support 1;
    nan if it does not strike both within three periods of `about`.
    """
    exciter = Exciter(l=1.0, delta=offset)
    motion = simulate(
        exciter, tau_end=3 * about, x0=1.0 + offset, v0=-velocity, samples_per_period=0
    )
    supports = motion["impact_support"].values
    times, speeds = motion["impact_tau"].values, motion["impact_velocity"].values
    for first in range(len(supports) - 1):
        if supports[first] == 2 and supports[first + 1] == 1:
            return 2 * float(times[first + 1] - times[first]), float(speeds[first + 1])
    return math.nan, math.nan
