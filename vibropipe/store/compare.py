"""Bitwise comparison of a file with recomputed values.

Both sides are compared as encoded on disk, so that the sign of a zero and the last bit of a number count; all nan are
equal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.solve.shown_units import DISPLAY_UNITS, Shown, units_from_text
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.encoding import StoredVariable, encode, encode_coords
from vibropipe.store.shards import ROW, open_raw
from vibropipe.words.units import plain_units

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr


@dataclass(frozen=True)
class Difference:
    """A stored value that differs from the recomputed one; `where` is its position as text."""

    name: str
    where: str
    stored: str
    again: str

    def __str__(self) -> str:
        at = f" at {self.where}" if self.where else ""
        return f"{self.name}{at}: {self.stored} in the file, {self.again} computed again"


def compare(
    path: str | PathLike[str], again: xr.Dataset, skip: Callable[[str], bool] = lambda _: False
) -> list[Difference]:
    """Compare a file with a recomputed dataset, and return the first difference of each variable.

    skip : returns True for the name of a variable that is not compared
    Raises StoreError if the file cannot be read.
    """
    differences, items = [], encode(again)[0]
    with open_raw(Path(path)) as file:
        for item in items:
            if skip(item.name):
                continue
            if item.name not in file.variables:
                differences.append(Difference(item.name, "", "nothing", "a quantity"))
                continue
            variable = file.variables[item.name]
            differences += _differences(item.name, np.asarray(variable[...]), _values(item))
        names = {item.name for item in items}
        differences += [
            Difference(name, "", "a quantity", "nothing")
            for name in file.variables
            if name not in names and not skip(name)
        ]
        return [_with_unit(file, each) for each in differences]


def compare_rows(path: str | PathLike[str], shard: xr.Dataset, grid: SweepGrid) -> list[Difference]:
    """Compare rows of a sweep with the file of the whole grid; of the file, only these rows are read.

    shard : recomputed rows over `row`
    Returns differences by row and variable.
    Raises StoreError if the file cannot be read.
    """
    items = [item for item in encode(shard)[0] if item.name not in (ROW, *grid.dims)]
    counted = [item for item in items if "sample_dimension" in item.attrs]
    varying = {ROW, *(item.attrs["sample_dimension"] for item in counted)}
    shared = {item.name: _values(item) for item in items if not varying & set(item.dims)}
    with open_raw(Path(path)) as file:
        missing = [n for n in (*grid.dims, *(i.name for i in items)) if n not in file.variables]
        if missing:
            return [Difference(missing[0], "", "nothing", "a quantity")]
        differences = []
        grid_coords = {item.name: _values(item) for item in encode_coords(grid.coords)}
        for name, values in {**grid_coords, **shared}.items():
            differences += _differences(name, np.asarray(file.variables[name][...]), values)
        if differences:  # of another grid, which has other rows
            return differences
        # end of the samples of each row, in the file and in the shard
        ends = {
            item.attrs["sample_dimension"]: (
                np.cumsum(np.asarray(file.variables[item.name][...]).reshape(-1), dtype=np.int64),
                np.cumsum(_values(item), dtype=np.int64),
            )
            for item in counted
        }
        rows = range(int(shard.attrs["row_start"]), int(shard.attrs["row_stop"]))
        for (index, row), item in product(enumerate(rows), items):
            if item.name not in shared:
                stored, new = _row_of(file.variables[item.name], item, index, row, grid, ends)
                place = _place(file, grid, row)
                differences += _differences(item.name, np.asarray(stored), new, place)
        return [_with_unit(file, each) for each in differences]


def _place(file: netCDF4.Dataset, grid: SweepGrid, row: int) -> str:
    """Return the coordinates of a row as text, in the units of the study."""
    shown = Shown(units_from_text(getattr(file, DISPLAY_UNITS, "")))
    if not shown.units:
        return grid.text(row)
    parts = []
    for (name, values), index in zip(grid.coords.items(), grid.indices(row), strict=True):
        value, unit = values[index].item(), getattr(file.variables[name], "units", "1")
        (text,), unit = (
            ([value], "") if isinstance(value, str) else shown.texts(name, [value], unit)
        )
        parts.append(f"{name} = {text}{unit}")
    return ", ".join(parts)


def _with_unit(file: netCDF4.Dataset, difference: Difference) -> Difference:
    """Return a difference whose values have their unit, in which they are stored."""
    unit = plain_units(getattr(file.variables.get(difference.name), "units", "1"))
    if unit == "1" or not difference.where:
        return difference
    stored, again = (f"{value} {unit}" for value in (difference.stored, difference.again))
    return replace(difference, stored=stored, again=again)


def _row_of(
    variable: netCDF4.Variable,
    item: StoredVariable,
    shard_index: int,
    row: int,
    grid: SweepGrid,
    ends: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray]:
    """Return row `row` of the grid as stored, and as recomputed in the shard, where its index is `shard_index`."""
    if item.dims[0] == ROW:
        return variable[grid.indices(row)], _values(item)[shard_index]
    in_file, in_shard = ends[item.dims[0]]
    first, last = int(in_shard[shard_index - 1]) if shard_index else 0, int(in_shard[shard_index])
    end = int(in_file[grid.points(row, row + 1)[0]])
    return variable[max(0, end - (last - first)) : end], _values(item)[first:last]


def _values(item: StoredVariable) -> np.ndarray:
    return np.asarray(item.values)


def _differences(
    name: str, stored: np.ndarray, recomputed: np.ndarray, where: str = ""
) -> list[Difference]:
    """Return the first difference of two arrays as encoded on disk, or nothing."""
    if stored.dtype.kind == "S":
        stored, recomputed = _joined_characters(stored), _joined_characters(recomputed)
    if stored.dtype != recomputed.dtype or stored.shape != recomputed.shape:
        return [Difference(name, where, _type_text(stored), _type_text(recomputed))]
    is_different = ~_is_equal(stored, recomputed)
    if not is_different.any():
        return []
    index = tuple(int(i) for i in np.argwhere(is_different)[0]) if is_different.ndim else ()
    position = [where] if where else []
    position += [f"[{', '.join(map(str, index))}]"] if index else []
    return [
        Difference(
            name, " ".join(position), repr(stored[index].item()), repr(recomputed[index].item())
        )
    ]


def _is_equal(stored: np.ndarray, recomputed: np.ndarray) -> np.ndarray:
    """Return where two arrays are bitwise equal, all nan alike."""
    if stored.dtype.kind != "f":
        return np.asarray(stored == recomputed)
    same_signs = np.signbit(stored) == np.signbit(recomputed)
    return np.asarray((stored == recomputed) & same_signs | np.isnan(stored) & np.isnan(recomputed))


def _joined_characters(letters: np.ndarray) -> np.ndarray:
    """Return blocks of characters as text, whose width depends on the longest one."""
    characters = np.ascontiguousarray(letters)
    return characters.view(f"S{characters.shape[-1]}")[..., 0].astype(object).astype(str)


def _type_text(values: np.ndarray) -> str:
    return f"{values.dtype} of shape {values.shape}"
