"""Jumps of the first harmonic between neighbouring rows of a sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

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
    regime, values = line["regime"].values, line[axis].values
    amplitude = np.where(regime < NO_ORBIT, amplitude, np.nan)
    return [
        Jump(*(float(v) for v in (values[n], values[n + 1], amplitude[n], amplitude[n + 1])))
        for n in jump_steps(values, amplitude, regime)
    ]


def jump_steps(
    x: NDArray[np.float64], values: NDArray[np.float64], regime: NDArray[np.int8]
) -> NDArray[np.intp]:
    """Return the rows after which a quantity over `x` jumps; values that are not finite belong to no orbit."""
    known = np.isfinite(values)
    if known.sum() < 2:
        return np.empty(0, np.intp)
    pairs = known[:-1] & known[1:]
    steps = np.where(pairs, np.abs(np.diff(np.where(known, values, 0.0))), np.inf)
    slopes = steps / np.abs(np.diff(x))
    padded = np.concatenate([[np.inf], slopes, [np.inf]])
    beside = np.maximum(padded[:-2], padded[2:])
    struck = regime != Regime.NO_IMPACT
    is_jump = (steps > JUMP_SHARE * np.abs(values[known]).max()) & (slopes > JUMP_FACTOR * beside)
    return np.flatnonzero(is_jump & pairs & (struck[:-1] | struck[1:]))
