"""Breaks of sampled curves at jumps, so that no line is cut slantwise across an impact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TIME_TOLERANCE = 1e-9  # relative: samples this close to an impact count as simultaneous


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


def certain_jumps(tau: Floats, velocity: Floats, acceleration: float) -> NDArray[np.intp]:
    """Return the indices of samples that follow a jump: a step larger than a bound of the acceleration allows."""
    steps = np.abs(np.diff(velocity))
    return np.flatnonzero(steps > 1.05 * acceleration * np.diff(tau)) + 1
