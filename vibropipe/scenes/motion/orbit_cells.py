"""Cells of the table of steady states: what a motion strikes, and its largest multiplier."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import REST, format_number, times
from vibropipe.report.table import DASH

DIGITS = 4  # significant digits
MAX_LISTED = 2  # velocities of a cell


def struck(dataset: xr.Dataset, support: int) -> list[float]:
    """Return the velocities before the impacts of the orbit on a support, in order; none without an orbit."""
    if "orbit_impact_velocity" not in dataset or not int(dataset["period_multiple"]):
        return []
    at = dataset["orbit_impact_support"].values == support
    return [float(v) for v in dataset["orbit_impact_velocity"].values[at]]


def is_steady(dataset: xr.Dataset) -> bool:
    """Return whether a motion has a label of its steady state."""
    return "regime" in dataset and not dataset["regime"].ndim


def struck_text(dataset: xr.Dataset, support: int) -> str:
    """Write the velocities before the impacts on a support, of many the largest; of those before a rest, too."""
    velocities = struck(dataset, support)
    largest = format_number(max(velocities, key=abs), DIGITS) if velocities else ""
    if "rests_per_orbit" in dataset and float(dataset["rests_per_orbit"].sel(support=support)):
        return f"{largest}, {REST}" if largest else REST
    if len(velocities) > MAX_LISTED:
        return f"{times(len(velocities))}, largest {largest}"
    return ", ".join(format_number(v, DIGITS) for v in velocities) or DASH


def multiplier_text(dataset: xr.Dataset) -> str:
    """Write the largest modulus of the multipliers; a dash without an orbit."""
    if "floquet_multiplier" not in dataset:
        return DASH
    moduli = np.abs(np.atleast_1d(dataset["floquet_multiplier"].values))
    return DASH if np.isnan(moduli).any() else format_number(float(moduli.max()), 3)
