"""The period of a pendulum: 4 K(sin(a / 2)) / sqrt(g), by the arithmetic-geometric mean."""

import numpy as np
import xarray as xr


def solve(scene, progress=None):
    amplitude = scene.over_arrays()["amplitude"]
    a, b = np.ones_like(amplitude), np.cos(amplitude / 2)
    for _ in range(8):
        a, b = (a + b) / 2, np.sqrt(a * b)
    period = 2 * np.pi / (a * np.sqrt(scene.gravity))
    if progress is not None:
        progress(amplitude.size, amplitude.size)
    return xr.Dataset(
        {"period": ("amplitude", period, {"units": "s", "long_name": "period"})},
        {"amplitude": ("amplitude", amplitude, {"units": "rad", "long_name": "amplitude"})},
    )
