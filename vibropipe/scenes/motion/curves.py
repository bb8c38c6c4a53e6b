"""Curves of a sampled motion, with corners and jumps at the times of the impacts."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.phase_plane import certain_jumps, walls_of, with_breaks
from vibropipe.figures.text import clock, frequency, times_of
from vibropipe.solve.shown_units import in_si, shown_unit
from vibropipe.words.parameters import PARAMETERS

Floats = NDArray[np.float64]


def acceleration_bound(dataset: xr.Dataset) -> float:
    """Return a bound of |x''| between impacts, by the equation of motion; infinite in physical units, or if soft."""
    if "nu" not in dataset.variables or {"k1", "k2"} & {*dataset.variables}:
        return np.inf
    given = {name: abs(float(dataset[name])) for name in PARAMETERS if name in dataset.variables}
    p = {**dict.fromkeys(PARAMETERS, 0.0), **given}
    speed = float(np.abs(dataset["velocity"].values).max())
    forces = p["f"] + p["f2"] + p["shaker"] * p["nu"] ** 2 + p["load"] + p["friction"]
    of_mass = forces + p["h"] * speed + p["l"] + p["delta"]
    ground = p["housing_friction_1"] + p["housing_friction_2"] + p["housing_load"]
    return of_mass + p["mass_ratio"] * (of_mass + ground)


def forcing_period(dataset: xr.Dataset) -> float:
    """Return the forcing period in the units of the times of a motion, which are ms where a short one is shown."""
    return shown_unit(dataset, "s")[1] * 2.0 * math.pi / float(in_si(dataset[frequency(dataset)]))


def velocities_at_impacts(dataset: xr.Dataset) -> tuple[Floats, Floats]:
    """Return the velocities before and after each impact; a soft support is entered without a jump."""
    before, after = dataset["impact_velocity"].values, dataset["impact_velocity_after"].values
    if "contact_duration" not in dataset:
        return before, after
    is_soft = np.isfinite(dataset["contact_duration"].values) | np.isnan(after)
    return before, np.where(is_soft, before, after)


def curve(dataset: xr.Dataset, name: str) -> tuple[Floats, Floats]:
    """Return a sampled quantity with impacts inserted: corners of x, jumps of x'.

    Where impacts are not stored, the curve of x' has a break at each step too large for a motion between impacts.
    """
    tau, values = dataset[clock(dataset)].values, dataset[name].values
    if "impact_support" not in dataset:
        if name != "velocity" or tau.size < 2:
            return tau, values
        at = certain_jumps(tau, values, acceleration_bound(dataset))
        return np.insert(tau, at, np.nan), np.insert(values, at, np.nan)
    at = times_of(dataset, "impact").values
    inside = (at >= tau[0]) & (at <= tau[-1])
    at = at[inside]
    if name == "velocity":
        before, after = velocities_at_impacts(dataset)
        return with_breaks(tau, values, at, before[inside], after[inside])
    where = walls_of(dataset)
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
