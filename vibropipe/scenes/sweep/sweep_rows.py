"""The rows of a sweep: its dimensions, kinds of rows, and single rows with their impacts."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.motion_words import is_unstable
from vibropipe.figures.phase_plane import Impacts
from vibropipe.report.findings import point_text
from vibropipe.scenes.keys.parts import MAX_LINES
from vibropipe.solve.in_si import stated_start
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime

OF_LINES = (
    "regime",
    "period_multiple",
    "displacement_amplitude",
    "impacts_per_orbit",
    "impacts_per_period",
)


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the swept dimensions, in the order of the dataset, without the direction of following."""
    return [str(name) for name in dataset["regime"].dims if name != DIRECTION]


def directions(dataset: xr.Dataset) -> list[str]:
    """Return the directions in which the rows were followed: up, down, both, or none."""
    if DIRECTION in dataset["regime"].dims:
        return [str(value) for value in dataset[DIRECTION].values]
    follow = str(dataset.attrs.get("follow", ""))
    return [follow.split()[-1]] if follow.endswith((" up", " down")) else []


def is_from_rest(dataset: xr.Dataset) -> bool:
    """Return whether each row starts from the equilibrium without velocity."""
    is_at_origin = stated_start(str(dataset.attrs.get("start", ""))) == (0.0, 0.0)
    return is_at_origin and "load" not in dataset and not directions(dataset)


def axis_of(dataset: xr.Dataset) -> str:
    """Return the swept parameter along which the lines are: that with the finest grid."""
    return max(swept(dataset), key=lambda name: dataset.sizes[name])


def axis_and_others(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the parameter of the abscissa and the other swept parameters."""
    along = axis_of(dataset)
    return along, [name for name in swept(dataset) if name != along]


def n_lines(dataset: xr.Dataset) -> int:
    """Return the number of lines of a sweep."""
    return int(dataset["regime"].size // dataset.sizes[axis_of(dataset)])


def lines_of(dataset: xr.Dataset, *names: str) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield (point of the other parameters, its rows along the axis with increasing parameter, with some variables)."""
    axis = axis_of(dataset)
    others = [str(name) for name in dataset["regime"].dims if name != axis]
    ordered = dataset[[n for n in (*OF_LINES, *names) if n in dataset]].sortby(axis)
    for at in combinations(ordered, others):
        line = ordered.isel(at)
        yield point_text(line["regime"], others), line


def is_map(dataset: xr.Dataset) -> bool:
    """Return whether a sweep has more lines than can be distinguished."""
    _, others = axis_and_others(dataset)
    return any(dataset.sizes[name] > MAX_LINES for name in others)


def strikes(dataset: xr.Dataset) -> xr.DataArray:
    """Return where the mass strikes a support: in no row without a result, nor where it lies on one for good."""
    regime = dataset["regime"]
    struck = (regime != Regime.NO_IMPACT) & (regime < Regime.UNBOUNDED)
    if "impacts_per_orbit" not in dataset:
        return struck
    return struck & (
        (regime != Regime.WITH_REST) | (dataset["impacts_per_orbit"].sum("support") > 0)
    )


def with_impacts_per_period(dataset: xr.Dataset) -> xr.Dataset:
    """Return a sweep with `impacts_per_period`, which older datasets have per orbit alone.

    It has no number where a mass comes to rest: before that a chatter has infinitely many impacts.
    """
    if "impacts_per_period" in dataset and "rests_per_orbit" in dataset:
        rate = dataset["impacts_per_period"]
        moves = dataset["rests_per_orbit"] == 0
        return dataset.assign(impacts_per_period=rate.where(moves).assign_attrs(rate.attrs))
    if "impacts_per_period" in dataset or "impacts_per_orbit" not in dataset:
        return dataset
    multiple = dataset.get("period_multiple", xr.ones_like(dataset["regime"]))
    rate = dataset["impacts_per_orbit"] / multiple.where(multiple > 0, 1)
    solved = ~dataset["regime"].isin([Regime.UNRESOLVED, Regime.UNBOUNDED])
    attrs = {"long_name": "impacts per forcing period", "symbol": "$p_s/m$", "units": "1"}
    return dataset.assign(impacts_per_period=rate.where(solved).assign_attrs(attrs))


def row_kinds(row: xr.Dataset) -> dict[str, NDArray[np.bool_]]:
    """Return a mask of the points by kind of mark; each point is in exactly one mask."""
    orbit = row["regime"].values < Regime.APERIODIC
    stable = ~is_unstable(row) if "stable" in row else np.ones_like(orbit)
    multiple = np.zeros_like(orbit)
    if "period_multiple" in row:
        multiple = row["period_multiple"].values > 1
    return {
        "line": orbit & stable & ~multiple,
        "multiple": orbit & stable & multiple,
        "unstable": orbit & ~stable,
        "no_orbit": ~orbit,
    }


def combinations(dataset: xr.Dataset, dims: list[str]) -> list[dict[str, int]]:
    """Return the indices of all combinations of values of some dimensions; one empty mapping without any."""
    indices = itertools.product(*(range(dataset.sizes[dim]) for dim in dims))
    return [dict(zip(dims, at, strict=True)) for at in indices]


def evenly(items: list[dict[str, int]], most: int) -> list[dict[str, int]]:
    """Return at most `most` items, evenly spaced with both ends."""
    if len(items) <= most:
        return items
    return [items[n] for n in np.unique(np.linspace(0, len(items) - 1, most).round().astype(int))]


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
    after = -np.where(support == 1, float(row["R1"]), float(row["R2"])) * before
    if "contact_duration" in row:  # a soft support is entered without a jump
        after = np.where(np.isfinite(row["contact_duration"].values), before, after)
    periods = max(1, int(row.get("period_multiple", xr.DataArray(1))))
    time = (row["impact_period"].values + row["impact_phase"].values) / periods
    order = np.argsort(time, kind="stable")
    return Impacts(time[order], support[order], before[order], after[order])
