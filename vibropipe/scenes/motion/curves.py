"""A sampled motion as a curve to draw: corners and jumps stand at the impacts themselves."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.physics.start import support_positions

Floats = NDArray[np.float64]

SAME_INSTANT = 1e-9  # relative


def supports(dataset: xr.Dataset) -> dict[int, float]:
    """Return where the supports lie, eq. (1)."""
    upper, lower = support_positions(float(dataset["l"]), float(dataset["delta"]))
    return {1: upper, 2: lower}


def with_breaks(
    tau: Floats, values: Floats, at: Floats, before: Floats, after: Floats
) -> tuple[Floats, Floats]:
    """Insert (at, before), a gap, (at, after) into a sampled curve so that jumps are not sloped.

    Samples at the instant of an impact are dropped: they hold one side of the jump or the other.
    """
    apart = away_from(tau, at)
    tau, values = tau[apart], values[apart]
    places = np.repeat(np.searchsorted(tau, at, side="left"), 3)
    new_tau = np.repeat(at, 3)
    new_values = np.stack([before, np.full_like(before, np.nan), after], axis=1).ravel()
    return np.insert(tau, places, new_tau), np.insert(values, places, new_values)


def away_from(tau: Floats, at: Floats) -> NDArray[np.bool_]:
    """Return which samples are at no instant of ``at`` (ascending), to within rounding."""
    if at.size == 0:
        return np.ones(tau.shape, dtype=np.bool_)
    right = np.searchsorted(at, tau)
    nearest = np.minimum(
        np.abs(tau - at[np.clip(right, 0, at.size - 1)]),
        np.abs(tau - at[np.clip(right - 1, 0, at.size - 1)]),
    )
    return nearest > SAME_INSTANT * (1.0 + np.abs(tau))


def curve(dataset: xr.Dataset, name: str) -> tuple[Floats, Floats]:
    """Return the sampled ``name`` with its impacts put in: corners of x, jumps of x'."""
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
    places = np.searchsorted(tau, at, side="left")
    return np.insert(tau, places, at), np.insert(values, places, corner)


def jumps(tau: Floats, velocity: Floats, near: Floats) -> NDArray[np.intp]:
    """Return the samples that start a new piece: the steepest step around each instant of ``near``.

    The exact motion strikes a little earlier or later than the one drawn over it.
    """
    if tau.size < 2:
        return np.empty(0, np.intp)
    steps = np.abs(np.diff(velocity))
    around = np.searchsorted(tau, near)[:, None] + np.arange(-3, 3)
    around = np.clip(around, 0, steps.size - 1)
    steepest = np.argmax(steps[around], axis=1)
    return np.unique(around[np.arange(near.size), steepest] + 1)
