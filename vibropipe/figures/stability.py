"""Stability in words and pictures: stable, unstable, or neutral."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

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


def is_unstable(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where perturbations of orbits grow, in the shape of `stable`; a motion without an orbit has none."""
    unstable: NDArray[np.bool_] = (dataset["stable"].values == 0) & ~is_neutral(dataset)
    return unstable & has_orbit(dataset)


def has_orbit(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where there is an orbit whose stability is known, in the shape of `stable`."""
    known = np.ones(dataset["stable"].shape, bool)
    if "period_multiple" in dataset:
        known &= dataset["period_multiple"].transpose(*dataset["stable"].dims).values > 0
    if "floquet_multiplier" in dataset:
        multipliers = dataset["floquet_multiplier"].transpose(*dataset["stable"].dims, "multiplier")
        known &= ~np.isnan(multipliers.values).any(axis=-1)
    return known


def stability_text(dataset: xr.Dataset) -> str:
    """Return the stability of one orbit in a word; empty without an orbit."""
    if not has_orbit(dataset):
        return ""
    if int(dataset["stable"]):
        return "stable"
    return "neutral" if is_neutral(dataset) else "unstable"
