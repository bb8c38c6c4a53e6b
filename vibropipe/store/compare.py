"""Whether a file holds what was computed again, bit for bit.

Both sides are compared as they lie on disk, so that nothing is lost in decoding: the sign of a zero and the
last bit of a number count. One nan is like another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.solve.sweep_grid import SweepGrid
from vibropipe.store.encoding import StoredVariable, encode
from vibropipe.store.shards import ROW, open_raw

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr


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
    with open_raw(Path(path)) as file:
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
    counted = [item for item in items if "sample_dimension" in item.attrs]
    varying = {ROW, *(item.attrs["sample_dimension"] for item in counted)}
    same = {item.name: _values(item) for item in items if not varying & set(item.dims)}
    with open_raw(Path(path)) as file:
        missing = [n for n in (*grid.dims, *(i.name for i in items)) if n not in file.variables]
        if missing:
            return [Difference(missing[0], "", "nothing", "a quantity")]
        found = []
        for name, values in {**grid.values, **same}.items():
            found += _differences(name, np.asarray(file.variables[name][...]), values)
        if found:  # of another grid: its rows have no place here
            return found
        # where the samples of each row end, of the file and of the shard
        ends = {
            item.attrs["sample_dimension"]: (
                np.cumsum(np.asarray(file.variables[item.name][...]).reshape(-1), dtype=np.int64),
                np.cumsum(_values(item), dtype=np.int64),
            )
            for item in counted
        }
        rows = range(int(shard.attrs["row_start"]), int(shard.attrs["row_stop"]))
        for (own, row), item in product(enumerate(rows), items):
            if item.name not in same:
                stored, again = _row_of(file.variables[item.name], item, own, row, grid, ends)
                found += _differences(item.name, np.asarray(stored), again, grid.text(row))
    return found


def _row_of(
    variable: netCDF4.Variable,
    item: StoredVariable,
    own: int,
    row: int,
    grid: SweepGrid,
    ends: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray]:
    """Return a row of the grid in the file, and the same one in the shard, where it is number `own`."""
    if item.dims[0] == ROW:
        return variable[grid.indices(row)], _values(item)[own]
    in_file, in_shard = ends[item.dims[0]]
    first, last = int(in_shard[own - 1]) if own else 0, int(in_shard[own])
    end = int(in_file[grid.points(row, row + 1)[0]])
    return variable[max(0, end - (last - first)) : end], _values(item)[first:last]


def _values(item: StoredVariable) -> np.ndarray:
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
