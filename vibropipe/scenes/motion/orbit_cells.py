"""Cells of the table of steady states: what a motion strikes, and its multipliers."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import REST, format_number
from vibropipe.report.table import DASH

DIGITS = 4  # significant digits


def struck(dataset: xr.Dataset, support: int) -> list[float]:
    """Return the velocities before the impacts of the orbit on a support, in order; none without an orbit."""
    if "orbit_impact_velocity" not in dataset or not int(dataset["period_multiple"]):
        return []
    at = dataset["orbit_impact_support"].values == support
    return [float(v) for v in dataset["orbit_impact_velocity"].values[at]]


def struck_text(dataset: xr.Dataset, support: int) -> str:
    """Write the velocities before the impacts on a support; of those before a rest, any number, the largest."""
    velocities = struck(dataset, support)
    if "rests_per_orbit" in dataset and float(dataset["rests_per_orbit"].sel(support=support)):
        if not velocities:
            return REST
        return f"{format_number(max(velocities, key=abs), DIGITS)}, {REST}"
    return ", ".join(format_number(v, DIGITS) for v in velocities) or DASH


def multipliers_text(dataset: xr.Dataset) -> str:
    """Write the multipliers: real ones as a list, a conjugate pair once with a double sign; a dash without an orbit."""
    values = np.atleast_1d(dataset["floquet_multiplier"].values)
    if np.isnan(values).any():
        return DASH
    complex_pair = values.size == 2 and abs(values[0].imag) > 1e-12
    if complex_pair:
        return f"{format_number(values[0].real, DIGITS)} ± {format_number(abs(values[0].imag), DIGITS)} i"
    rounding = np.finfo(float).eps * np.abs(values).max(initial=0.0)
    return ", ".join(
        format_number(float(value.real) if abs(value) > rounding else 0.0, DIGITS)
        for value in values
    )
