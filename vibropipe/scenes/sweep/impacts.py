"""The ragged impacts of a sweep, by row."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.phase_plane import Impacts


def rows_of_impacts(dataset: xr.Dataset) -> NDArray[np.intp]:
    """Return the flat index of the row of each impact, over the dimensions of `regime`."""
    sizes = dataset["row_size"].transpose(*dataset["regime"].dims).values.ravel()
    return np.repeat(np.arange(sizes.size), sizes)


def row_at(dataset: xr.Dataset, index: int) -> xr.Dataset:
    """Return one row by its flat index, with its own impacts alone."""
    dims = dataset["regime"].dims
    at = np.unravel_index(index, dataset["regime"].shape)
    row = dataset.isel(dict(zip(dims, map(int, at), strict=True)))
    if "row_size" not in dataset or "impact" not in dataset.dims:
        return row
    sizes = dataset["row_size"].transpose(*dims).values.ravel()
    first = int(sizes[:index].sum())
    return row.isel(impact=slice(first, first + int(sizes[index])))


def orbit_impacts(row: xr.Dataset) -> Impacts:
    """Return the impacts of one row at fractions of its orbit (of its last forcing periods without one)."""
    if "impact_phase" not in row:
        none = np.empty(0)
        return Impacts(none, np.empty(0, np.int8), none, none)
    before = row["impact_velocity"].values
    support = row["impact_support"].values
    restitution = np.where(support == 1, float(row["R1"]), float(row["R2"]))
    periods = max(1, int(row.get("period_multiple", xr.DataArray(1))))
    time = (row["impact_period"].values + row["impact_phase"].values) / periods
    order = np.argsort(time, kind="stable")
    return Impacts(time[order], support[order], before[order], -(restitution * before)[order])
