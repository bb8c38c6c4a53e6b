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

from vibropipe.solve.sweep_grid import SweepGrid
from vibropipe.store.encoding import Stored, encode
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


def compare_rows(path: str | PathLike[str], shard: xr.Dataset, grid: SweepGrid) -> list[Difference]:
    """Compare some rows of a sweep: a shard over `row` with the file of the whole grid.

    Of the file only those rows are read, and the counts of what is ragged. Raises StoreError if the
    file cannot be read.
    """
    items = [item for item in encode(shard)[0] if item.name not in (ROW, *grid.dims)]
    counts = {
        item.attrs["sample_dimension"]: item for item in items if "sample_dimension" in item.attrs
    }
    varying = {ROW, *counts}
    start, stop = int(shard.attrs["row_start"]), int(shard.attrs["row_stop"])
    with opened(Path(path)) as file:
        missing = [n for n in (*grid.dims, *(i.name for i in items)) if n not in file.variables]
        if missing:
            return [Difference(missing[0], "", "nothing", "a quantity")]
        same = {item.name: _values(item) for item in items if not varying & set(item.dims)}
        found = [
            difference
            for name, values in {**grid.values, **same}.items()
            for difference in _differences(name, np.asarray(file.variables[name][...]), values)
        ]
        if found:  # of another grid: its rows have no place here
            return found
        rows = _Rows(file, items, counts, grid)
        return [item for row in range(start, stop) for item in rows.differences(row, row - start)]


class _Rows:
    """The rows of a sweep in a file, beside those of a shard; `counts` are those of each sample dimension."""

    def __init__(
        self,
        file: netCDF4.Dataset,
        items: Sequence[Stored],
        counts: Mapping[str, Stored],
        grid: SweepGrid,
    ) -> None:
        self._file, self._grid = file, grid
        self._items = [item for item in items if item.dims and item.dims[0] in (ROW, *counts)]
        self._own = {dim: _ends(_values(item)) for dim, item in counts.items()}
        self._ends = {
            dim: _ends(np.asarray(file.variables[item.name][...])) for dim, item in counts.items()
        }

    def differences(self, row: int, own: int) -> list[Difference]:
        """Compare a row of the grid with the row `own` of the shard."""
        place, point = self._grid.indices(row), int(self._grid.points(row, row + 1)[0])
        found = []
        for item in self._items:
            values, stored = _values(item), self._file.variables[item.name]
            if item.dims[0] == ROW:
                stored, again = stored[place], values[own]
            else:
                begin, end = self._own[item.dims[0]][own : own + 2]
                again, last = values[begin:end], int(self._ends[item.dims[0]][point + 1])
                stored = stored[max(0, last - len(again)) : last]
            found += _differences(item.name, np.asarray(stored), again, self._grid.text(row))
        return found


def _values(item: Stored) -> np.ndarray:
    return np.asarray(item.values)


def _ends(counts: np.ndarray) -> np.ndarray:
    """Return where the samples of each row begin, in C order, and where the last ones end."""
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])


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
