"""Whether a file holds what was computed again, bit for bit.

Both sides are compared as they lie on disk, so that nothing is lost in decoding: the sign of a zero and the
last bit of a number count. One nan is like another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.store.encoding import Stored, encode
from vibropipe.store.grid import Grid
from vibropipe.store.shards import ROW, opened

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

__all__ = ["Difference", "compare", "compare_rows"]


@dataclass(frozen=True)
class Difference:
    """A value in a file that is not what was computed again; `where` is its place, in words."""

    name: str
    where: str
    stored: str
    again: str

    def __str__(self) -> str:
        at = f" at {self.where}" if self.where else ""
        return f"{self.name}{at}: {self.stored} in the file, {self.again} computed again"


def compare(
    path: str | PathLike[str],
    again: xr.Dataset,
    part: tuple[str, Sequence[int]] | None = None,
    skip: Callable[[str], bool] = lambda _: False,
) -> list[Difference]:
    """Compare a whole dataset, or its places along one dimension given as (dimension, places).

    Variables whose name `skip` takes are left out. Raises StoreError if the file cannot be read.
    """
    dim, places = part if part is not None else ("", ())
    found, items = [], encode(again)[0]
    with opened(Path(path)) as file:
        for item in items:
            if skip(item.name):
                continue
            if item.name not in file.variables:
                found.append(Difference(item.name, "", "nothing", "a quantity"))
                continue
            variable = file.variables[item.name]
            values = np.asarray(variable[...])
            for axis, own in enumerate(variable.dimensions):
                if own == dim and max(places) < values.shape[axis]:
                    values = values.take(places, axis)
            found += _differences(item.name, values, _values(item))
        known = {item.name for item in items}
        found += [
            Difference(name, "", "a quantity", "nothing")
            for name in file.variables
            if name not in known and not skip(name)
        ]
    return found


def compare_rows(path: str | PathLike[str], shard: xr.Dataset, grid: Grid) -> list[Difference]:
    """Compare some rows of a sweep: a shard over `row` with the file of the whole grid.

    Of the file only those rows are read, and the counts of what is ragged. Raises StoreError if the
    file cannot be read.
    """
    items = {item.name: item for item in encode(shard)[0] if item.name != ROW}
    start, stop = int(shard.attrs["row_start"]), int(shard.attrs["row_stop"])
    with opened(Path(path)) as file:
        found = _shared(file, items, grid)
        if found:  # of another grid: its rows have no place here
            return found
        rows = _Rows(file, items, grid)
        for row in range(start, stop):
            found += rows.differences(row, row - start)
    return found


def _shared(file: netCDF4.Dataset, items: Mapping[str, Stored], grid: Grid) -> list[Difference]:
    """Compare the swept parameters, and what is the same in every row."""
    missing = [name for name in (*grid.dims, *items) if name not in file.variables]
    if missing:
        return [Difference(missing[0], "", "nothing", "a quantity")]
    counted = {item.attrs.get("sample_dimension") for item in items.values()}
    constant = {
        name: _values(item) for name, item in items.items() if not {ROW, *counted} & set(item.dims)
    }
    found = []
    for name, values in {**grid.values, **constant}.items():
        found += _differences(name, np.asarray(file.variables[name][...]), values)
    return found


class _Rows:
    """The rows of a sweep in a file, beside those of a shard."""

    def __init__(self, file: netCDF4.Dataset, items: Mapping[str, Stored], grid: Grid) -> None:
        self._file, self._grid = file, grid
        self._gridded = [item for item in items.values() if item.dims[:1] == (ROW,)]
        self._counts = {
            item.attrs["sample_dimension"]: _values(item)
            for item in self._gridded
            if "sample_dimension" in item.attrs
        }
        self._ends = {
            item.attrs["sample_dimension"]: _ends(file, item.name)
            for item in self._gridded
            if "sample_dimension" in item.attrs
        }
        self._ragged = [item for item in items.values() if set(item.dims) & set(self._counts)]

    def differences(self, row: int, own: int) -> list[Difference]:
        """Compare a row of the grid with the row `own` of the shard."""
        place, where = _place(self._grid, row)
        found = []
        for item in self._gridded:
            stored = np.asarray(self._file.variables[item.name][place])
            found += _differences(item.name, stored, _values(item)[own], where)
        number = int(np.ravel_multi_index(place, self._grid.shape))
        for item in self._ragged:
            count = self._counts[item.dims[0]]
            size, last = int(count[own]), int(count[: own + 1].sum())
            end = int(self._ends[item.dims[0]][number])
            stored = np.asarray(self._file.variables[item.name][max(0, end - size) : end])
            found += _differences(item.name, stored, _values(item)[last - size : last], where)
        return found


def _values(item: Stored) -> np.ndarray:
    return np.asarray(item.values)


def _ends(file: netCDF4.Dataset, name: str) -> np.ndarray:
    """Return where the samples of each row end, rows in the order of the grid."""
    return np.cumsum(np.asarray(file.variables[name][...]).reshape(-1), dtype=np.int64)


def _place(grid: Grid, row: int) -> tuple[tuple[int, ...], str]:
    """Return the place of a row in the grid, and its swept parameters in words."""
    index = [0] * len(grid.dims)
    for axis, place in zip(grid.row_axes, np.unravel_index(row, grid.row_shape), strict=True):
        index[axis] = int(place)
    words = [
        f"{name} = {float(values[at])!r}"
        for at, (name, values) in zip(index, grid.values.items(), strict=True)
    ]
    return tuple(index), ", ".join(words)


def _differences(
    name: str, stored: np.ndarray, again: np.ndarray, where: str = ""
) -> list[Difference]:
    """Return the first difference of two arrays as they lie on disk, if there is one."""
    if stored.dtype.kind == "S":
        stored, again = _texts(stored), _texts(again)
    if stored.dtype != again.dtype or stored.shape != again.shape:
        return [Difference(name, where, _kind(stored), _kind(again))]
    apart = ~_same(stored, again)
    if not apart.any():
        return []
    place = tuple(int(index) for index in np.argwhere(apart)[0]) if apart.ndim else ()
    at = [where] if where else []
    at += [f"[{', '.join(map(str, place))}]"] if place else []
    return [Difference(name, " ".join(at), repr(stored[place].item()), repr(again[place].item()))]


def _same(stored: np.ndarray, again: np.ndarray) -> np.ndarray:
    if stored.dtype.kind != "f":
        return np.asarray(stored == again)
    signs = np.signbit(stored) == np.signbit(again)
    return np.asarray((stored == again) & signs | np.isnan(stored) & np.isnan(again))


def _texts(letters: np.ndarray) -> np.ndarray:
    """Return blocks of characters as text: how wide the block is depends on the longest one."""
    cut = np.ascontiguousarray(letters)
    return cut.view(f"S{cut.shape[-1]}")[..., 0].astype(object).astype(str)


def _kind(values: np.ndarray) -> str:
    return f"{values.dtype} of shape {values.shape}"
