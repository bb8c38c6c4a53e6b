"""One steady state as what is drawn of it: one period of its motion, or a sweep of one row."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from vibropipe.figures.text import clock, frequency
from vibropipe.physics.exciter import ParameterError

UNSAMPLED = "must hold the trajectory of its steady state: ask for the output motion, or draw what simulate returns"
WITHOUT_ORBIT = (
    "must hold a periodic motion, of which one period is drawn: draw what simulate returns"
)


def is_steady_state(data: xr.Dataset) -> bool:
    """Return whether a dataset is one steady state, or one row of a sweep."""
    is_row = "regime" in data and not data["regime"].dims and "displacement_end" not in data
    return is_row and clock(data) not in data.dims and frequency(data) in data.coords


def as_row(data: xr.Dataset) -> xr.Dataset:
    """Return one steady state as a sweep of one row."""
    return data.drop_vars(_lists(data)).expand_dims(frequency(data))


def as_motion(data: xr.Dataset) -> xr.Dataset:
    """Return one period of one steady state as a motion, or raise a ParameterError where its trajectory is not held."""
    if "phase" not in data.dims:
        raise ParameterError("dataset", data, must=UNSAMPLED, got="")
    if not int(data["period_multiple"]) or not np.isfinite(data["displacement"].values).all():
        raise ParameterError("dataset", data, must=WITHOUT_ORBIT, got="")
    time, span = clock(data), 2.0 * math.pi / float(data["base_frequency"])
    units = {"units": "s" if time == "time" else "1"}
    data = data.isel(phase=[*range(data.sizes["phase"]), 0]).assign_attrs(kind="motion")
    samples = (time, span * np.append(data["phase"].values[:-1], 1.0), units)
    data = data.drop_vars("phase").rename(phase=time).assign_coords({time: samples})
    if "row_size" in data or "impact_phase" not in data:
        return data.drop_vars(_lists(data))  # which may be those of all rows of a sweep
    multiple, support = int(data["period_multiple"]), data["impact_support"]
    at = span / multiple * (data["impact_period"] + data["impact_phase"])
    after = -xr.where(support == 1, data["R1"], data["R2"]) * data["impact_velocity"]
    after = data.get("impact_velocity_after", after)
    impacts = {f"impact_{time}": at.assign_attrs(units), "impact_velocity_after": after}
    return data.assign(impacts).sortby(at)


def _lists(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.variables if "impact" in data[name].dims]
