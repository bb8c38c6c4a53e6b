"""Orbits that are neutral, which `stable` does not tell from unstable ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

# Largest distance of the largest modulus of a neutral orbit's multipliers from 1: their rounding.
NEUTRAL_TOLERANCE = 1e-9


def is_neutral(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where perturbations of orbits neither grow nor decay, in the shape of `stable`.

    Such is a motion without losses, and a mass that friction holds: `stable` is 0, since it means asymptotically
    stable, but nothing is unstable.
    """
    stable = dataset["stable"].values
    if "floquet_multiplier" not in dataset:
        return np.zeros(stable.shape, bool)
    moduli = np.abs(dataset["floquet_multiplier"].transpose(..., "multiplier").values)
    neutral: NDArray[np.bool_] = np.abs(moduli.max(axis=-1) - 1.0) <= NEUTRAL_TOLERANCE
    return neutral & (stable == 0)
