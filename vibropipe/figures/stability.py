"""Stability in words and pictures: stable, unstable, or neutral."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.store.stability import is_neutral


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
