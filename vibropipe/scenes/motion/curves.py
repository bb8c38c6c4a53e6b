"""Curves of a sampled motion, with corners and jumps at the times of the impacts."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.physics.start import support_positions

Floats = NDArray[np.float64]

TIME_TOLERANCE = 1e-9  # relative: samples this close to an impact count as simultaneous


def supports(dataset: xr.Dataset) -> dict[int, float]:
    """Return the positions of the supports, eq. (1)."""
    upper, lower = support_positions(float(dataset["l"]), float(dataset["delta"]))
    return {1: upper, 2: lower}


def with_breaks(
    tau: Floats, values: Floats, at: Floats, before: Floats, after: Floats
) -> tuple[Floats, Floats]:
    """Insert (at, before), a break, (at, after) into a sampled curve, so that jumps are not sloped.

    Samples at the time of an impact are dropped, since they are on one side of the jump or the other.
    """
    is_away = away_from(tau, at)
    tau, values = tau[is_away], values[is_away]
    indices = np.repeat(np.searchsorted(tau, at, side="left"), 3)
    new_tau = np.repeat(at, 3)
    new_values = np.stack([before, np.full_like(before, np.nan), after], axis=1).ravel()
    return np.insert(tau, indices, new_tau), np.insert(values, indices, new_values)


def away_from(tau: Floats, at: Floats) -> NDArray[np.bool_]:
    """Return which samples are at none of the ascending times `at`, within TIME_TOLERANCE."""
    if at.size == 0:
        return np.ones(tau.shape, dtype=np.bool_)
    right = np.searchsorted(at, tau)
    nearest = np.minimum(
        np.abs(tau - at[np.clip(right, 0, at.size - 1)]),
        np.abs(tau - at[np.clip(right - 1, 0, at.size - 1)]),
    )
    return nearest > TIME_TOLERANCE * (1.0 + np.abs(tau))


def curve(dataset: xr.Dataset, name: str) -> tuple[Floats, Floats]:
    """Return a sampled quantity with impacts inserted: corners of x, jumps of x'."""
    tau, values = dataset["tau"].values, dataset[name].values
    if "impact_tau" not in dataset:
        return tau, values
    at = dataset["impact_tau"].values
    inside = (at >= tau[0]) & (at <= tau[-1])
    at = at[inside]
    if name == "velocity":
        before = dataset["impact_velocity"].values[inside]
        after = dataset["impact_velocity_after"].values[inside]
        return with_breaks(tau, values, at, before, after)
    where = supports(dataset)
    struck = dataset["impact_support"].values[inside]
    corner = np.where(struck == 1, where[1], where[2])
    indices = np.searchsorted(tau, at, side="left")
    return np.insert(tau, indices, at), np.insert(values, indices, corner)


def jumps(tau: Floats, velocity: Floats, near: Floats) -> NDArray[np.intp]:
    """Return the indices of samples that follow a jump: the steepest step around each time in `near`.

    Impacts of the exact motion are a little earlier or later than those of the motion drawn over it.
    """
    if tau.size < 2:
        return np.empty(0, np.intp)
    steps = np.abs(np.diff(velocity))
    around = np.searchsorted(tau, near)[:, None] + np.arange(-3, 3)
    around = np.clip(around, 0, steps.size - 1)
    steepest = np.argmax(steps[around], axis=1)
    return np.unique(around[np.arange(near.size), steepest] + 1)
