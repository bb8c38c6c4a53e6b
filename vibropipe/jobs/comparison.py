"""Two datasets beside each other: what differs in their studies, rows, laws of motion and quantities."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.physical import is_physical
from vibropipe.store.table import grid_dims
from vibropipe.words.regimes import Regime
from vibropipe.words.units import plain_units
from vibropipe.words.wording import count

if TYPE_CHECKING:
    import xarray as xr

# Values agree within their stated errors and this share of the largest value of the quantity.
SHARE = 1e-9
# The law of motion of a row, and attributes that are told if they differ.
LAW = ("regime", "period_multiple", "impacts_per_orbit")
TOLD = ("title", "method", "effects", "start", "follow", "version", "git_commit", "kernel_hash")
# How a row was computed, which tells nothing of its motion.
WORK = (
    "residual",
    "power_residual",
    "periods_to_settle",
    "window_periods",
    "row_size",
    "base_frequency",
)
ERROR, STUDY = "_error", "study"
# A quantity without an error of its own, and the one that has the same.
SAME_ERROR = {"velocity_phase": "displacement_phase"}


class Setting(NamedTuple):
    """A parameter, or what else a dataset was made with, of both."""

    name: str
    one: str
    two: str


class Change(NamedTuple):
    """A quantity that differs: in how many rows, at most by how much, over its largest value, and where.

    The differences of codes, such as those of `stable`, are NaN: only whether they differ counts.
    """

    name: str
    unit: str
    rows: int
    largest: float
    relative: float
    where: str


class Comparison(NamedTuple):
    """What differs between two datasets.

    study : lines of their studies that differ, each after - or +
    over : dimensions of the rows
    rows, only : rows in both, and in one of them alone
    laws : of each row with another law of motion, where it lies and both laws; None of datasets without laws
    changes : those of the largest relative difference first
    same : number of quantities that agree
    left_out : quantities that one of them lacks, or has in another shape
    """

    settings: list[Setting]
    study: list[str]
    over: list[str]
    rows: int
    only: tuple[int, int]
    laws: list[str] | None
    changes: list[Change]
    same: int
    left_out: list[str]


def compare_datasets(one: xr.Dataset, two: xr.Dataset) -> Comparison:
    """Compare two datasets of a scene: of two versions of a study or of the program.

    Rows are those of equal coordinates, or of equal numbers over dimensions without coordinates.

    Raises ParameterError if they have no row in common, one is in SI and the other without units, or rows that are only
    numbered are not as many.
    """
    first, second, dims = common_rows(one, two)
    sizes = [int(np.prod([data.sizes[name] for name in dims])) for data in (first, one, two)]
    rows, only = sizes[0], (sizes[1] - sizes[0], sizes[2] - sizes[0])
    changes, same, left_out = [], 0, []
    for name in sorted({*map(str, one.data_vars), *map(str, two.data_vars)}):
        if name in (*LAW, *WORK) or name.endswith(ERROR):
            continue
        has_both = name in first.data_vars and name in second.data_vars
        if not has_both or first[name].shape != second[name].shape:
            left_out.append(name)
            continue
        if first[name].dtype.kind not in "iufc":
            continue
        change = change_of(first, second, name, dims)
        changes += [change] if change is not None else []
        same += change is None
    changes.sort(key=lambda change: (math.isnan(change.relative), -change.relative))
    return Comparison(
        [*settings_of(one, two)], study_lines(one, two), dims, rows, only,
        laws_of(first, second), changes, same, left_out,
    )  # fmt: skip


def common_rows(one: xr.Dataset, two: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset, list[str]]:
    """Return the rows that both datasets have, and their dimensions."""
    import xarray as xr

    if is_physical(one) != is_physical(two):
        must = "must have units as the other dataset has, or none as it"
        raise ParameterError("B", "", must=must, got="")
    swept = [", ".join(row_dims(data)) or "nothing" for data in (one, two)]
    if swept[0] != swept[1]:
        must = f"must have rows over {swept[0]}, as A has"
        raise ParameterError("B", "", must=must, got=swept[1])
    dims = row_dims(one)
    for whose, data in (("A", one), ("B", two)):
        if not all(data.sizes[name] for name in dims):
            must = f"must have rows over {', '.join(dims)} to be compared"
            raise ParameterError(whose, "", must=must, got="none")
    indexed = [name for name in one.dims if name in one.indexes and name in two.indexes]
    for name in dims:
        if name not in indexed and one.sizes[name] != two.sizes[name]:
            must = f"must have as many rows over {name} as A, {one.sizes[name]:,}: they have numbers alone"
            raise ParameterError("B", "", must=must, got=f"{two.sizes[name]:,}")
    others = [name for name in {*one.dims, *two.dims} if name not in indexed]
    first, second = xr.align(one, two, join="inner", exclude=others)
    if not all(first.sizes[name] for name in dims):
        must = "must have rows in common with A"
        had = count(int(np.prod([one.sizes[name] for name in dims])), "row")
        raise ParameterError("B", "", must=must, got=f"none of {had}")
    return first, second, dims


def row_dims(dataset: xr.Dataset) -> list[str]:
    """Return the dimensions of the rows of a dataset: those of the regime, or else those of its table."""
    if "regime" in dataset:
        return [str(name) for name in dataset["regime"].dims]
    return list(grid_dims(dataset))


def settings_of(one: xr.Dataset, two: xr.Dataset) -> Iterator[Setting]:
    """Yield scalar parameters and attributes that differ; a dash stands for what one of them has not."""
    names = dict.fromkeys(map(str, [*one.coords, *two.coords]))
    for name in names:
        pair = [data.coords.get(name) for data in (one, two)]
        if any(each is not None and each.ndim for each in pair):
            continue
        texts = ["-" if each is None else value_of(each) for each in pair]
        if texts[0] != texts[1]:
            yield Setting(name, *texts)
    for name in TOLD:
        texts = [str(data.attrs.get(name, "-")) for data in (one, two)]
        if texts[0] != texts[1]:
            yield Setting(name, *texts)


def value_of(array: xr.DataArray) -> str:
    """Write a scalar with its unit."""
    unit = plain_units(array.attrs.get("units", "1"))
    text = f"{array.item():.12g}" if array.dtype.kind in "iuf" else str(array.item())
    return text if unit == "1" else f"{text} {unit}"


def study_lines(one: xr.Dataset, two: xr.Dataset) -> list[str]:
    """Return the lines of both studies that differ."""
    before, after = (str(data.attrs.get(STUDY, "")).splitlines() for data in (one, two))
    lines = difflib.unified_diff(before, after, n=0, lineterm="")
    return [line for line in lines if not line.startswith(("---", "+++", "@@"))]


def change_of(one: xr.Dataset, two: xr.Dataset, name: str, dims: list[str]) -> Change | None:
    """Return how a quantity differs in rows of equal coordinates; None if it agrees within its errors."""
    moved, scale = difference(one, two, name)
    values = [data[name] for data in (one, two)]
    is_other = np.isfinite(values[0]) != np.isfinite(values[1])
    error = SAME_ERROR.get(name, name) + ERROR
    errors = sum(
        data[error].fillna(0.0) for data in (one, two)
        if error in data and set(data[error].dims) <= set(values[0].dims)
    )  # fmt: skip
    differs = is_other | (abs(moved) > errors + SHARE * scale)
    if not bool(differs.any()):
        return None
    own = [str(dim) for dim in differs.dims if dim not in dims and {*dims} & {*differs.dims}]
    size = abs(moved).where(differs).fillna(0.0)
    place = size if bool(size.any()) else is_other
    at = {str(k): int(v) for k, v in place.argmax(...).items()} if place.ndim else {}
    where = place_text(one, {str(dim): at[str(dim)] for dim in differs.dims})
    largest = float(size.max())
    unit = plain_units(values[0].attrs.get("units", "1"))
    if "flag_values" in values[0].attrs:
        largest = scale = math.nan
    return Change(
        name, "" if unit == "1" else unit, int(differs.any(own).sum()), largest,
        largest / scale if scale else 0.0, where,
    )  # fmt: skip


def place_text(dataset: xr.Dataset, at: dict[str, int]) -> str:
    """Write where a value stands: by coordinates, or by its number over dimensions without."""
    return ", ".join(
        f"{name} = {value_of(dataset[name][n])}" if name in dataset.coords else f"{name} {n}"
        for name, n in at.items()
    )


def difference(one: xr.Dataset, two: xr.Dataset, name: str) -> tuple[xr.DataArray, float]:
    """Return B - A of a quantity, of angles the short way round, and its largest size in either."""
    values = [data[name] for data in (one, two)]
    if values[0].dtype.kind in "iu":
        values = [each.astype(float) for each in values]
    moved = values[1] - values[0]
    if values[0].attrs.get("units") == "rad":
        moved = (moved + np.pi) % (2 * np.pi) - np.pi
    sizes = [abs(each).where(np.isfinite(each)) for each in values]
    scale = max(float(each.max()) if bool(each.notnull().any()) else 0.0 for each in sizes)
    return moved, scale


def laws_of(one: xr.Dataset, two: xr.Dataset) -> list[str] | None:
    """Return where a law of motion differs, and both; None of data without laws."""
    changed, found = changed_laws(one, two), []
    if changed is None:
        return None
    for index in np.argwhere(changed.values):
        at = dict(zip(map(str, changed.dims), map(int, index), strict=True))
        place = place_text(one, at)
        before, after = (law_text(data.isel(at)) for data in (one, two))
        found.append(f"{place}: {before} -> {after}" if place else f"{before} -> {after}")
    return found


def changed_laws(one: xr.Dataset, two: xr.Dataset) -> xr.DataArray | None:
    """Return in which rows the laws of motion differ; None of data without laws."""
    kept = [name for name in LAW if name in one and name in two]
    if "regime" not in kept or one["regime"].shape != two["regime"].shape:
        return None
    changed = one["regime"] != two["regime"]
    is_orbit = one["regime"] < Regime.APERIODIC
    for name in kept[1:]:  # which are averages of a motion without an orbit
        other = one[name] != two[name]
        other = other.any([dim for dim in other.dims if dim not in changed.dims])
        changed = changed | (is_orbit & other)
    return changed


def law_text(row: xr.Dataset) -> str:
    """Write a law of motion: `two-sided (2; 1, 1)`."""
    regime = Regime(int(row["regime"])).name.lower().replace("_", " ")
    is_orbit = int(row["regime"]) < Regime.APERIODIC
    if not is_orbit or "period_multiple" not in row or "impacts_per_orbit" not in row:
        return regime
    impacts = ", ".join(f"{float(each):g}" for each in np.ravel(row["impacts_per_orbit"].values))
    return f"{regime} ({int(row['period_multiple'])}; {impacts})"
