"""Jumps of the first harmonic between neighbouring rows of a sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibropipe.words.regimes import Regime

# A jump is a step of the amplitude by this share of its maximum on the line, and by this factor steeper than the
# steps on either side: a resonance curve is steep over several rows, a jump is not. A step without another one on
# either side, at an end of a line or beside a row without an orbit, cannot be told from steepness; motions without
# impacts do not jump.
JUMP_SHARE, JUMP_FACTOR = 0.1, 5.0
NO_ORBIT = Regime.APERIODIC  # regimes from here on have no orbit


@dataclass(frozen=True)
class Jump:
    """A jump between neighbouring rows of a line: the values of the parameter and the amplitudes on either side."""

    before: float
    after: float
    amplitude_before: float
    amplitude_after: float


def jumps_of(line: xr.Dataset, axis: str) -> list[Jump]:
    """Return the jumps of the first harmonic of displacement between neighbouring rows that have an orbit."""
    if "displacement_amplitude" not in line:
        return []
    amplitude = line["displacement_amplitude"].isel(harmonic=0).values
    has_orbit = (line["regime"].values < NO_ORBIT) & np.isfinite(amplitude)
    if has_orbit.sum() < 2:
        return []
    pairs = has_orbit[:-1] & has_orbit[1:]
    values = line[axis].values
    steps = np.where(pairs, np.abs(np.diff(np.where(has_orbit, amplitude, 0.0))), np.inf)
    slopes = steps / np.diff(values)
    padded = np.concatenate([[np.inf], slopes, [np.inf]])
    beside = np.maximum(padded[:-2], padded[2:])
    struck = line["regime"].values != Regime.NO_IMPACT
    is_jump = (steps > JUMP_SHARE * amplitude[has_orbit].max()) & (slopes > JUMP_FACTOR * beside)
    is_jump &= struck[:-1] | struck[1:]
    return [
        Jump(*(float(v) for v in (values[n], values[n + 1], amplitude[n], amplitude[n + 1])))
        for n in np.flatnonzero(is_jump)
    ]
