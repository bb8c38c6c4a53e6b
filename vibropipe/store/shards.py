"""Shards of a sweep as files: their headers, the check that they fit together, and their rows in order.

Variables of a shard are of four kinds: over `row` (and further dimensions); ragged, over the sample dimension of a
count per row (CF contiguous ragged arrays); swept parameters over `row`, which must be those of the study; and those
that are equal in every shard.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.atomic import AGAIN, StoreError, check_intact
from vibropipe.store.encoding import NO_CACHE, StoredVariable

if TYPE_CHECKING:
    import h5py
    import netCDF4

ROW = "row"
ROW_RANGE_ATTRS = ("row_start", "row_stop")
IDENTITY_ATTRS = ("kernel_hash", "fingerprint")
"""Attributes that all shards of a sweep share: the code, and what it computed."""
ROWS_AT_ONCE = 1 << 16
"""Rows of a swept parameter that are compared with the study at once."""


@dataclass(frozen=True)
class Shard:
    """Header of a shard: its rows [start, stop), and the values of variables that are equal in every row.

    Swept parameters are not among the variables: they are checked against the study.
    """

    path: Path
    start: int
    stop: int
    attrs: dict[str, Any]
    variables: dict[str, StoredVariable]

    @classmethod
    def of(
        cls,
        path: Path,
        start: int,
        stop: int,
        attrs: dict[str, Any],
        items: Sequence[StoredVariable],
        grid: SweepGrid,
    ) -> Shard:
        """Return the header of rows with the variables `items`."""
        # numbers of rows and samples start anew in each shard
        left_out = {ROW, *(item.attrs.get("sample_dimension") for item in items), *grid.dims}
        return cls(path, start, stop, attrs, {i.name: i for i in items if i.name not in left_out})

    @cached_property
    def samples(self) -> dict[str, str]:
        """Name of the count per row, for each sample dimension."""
        items = self.variables.values()
        return {i.attrs["sample_dimension"]: i.name for i in items if "sample_dimension" in i.attrs}

    @property
    def gridded(self) -> list[StoredVariable]:
        """Variables over `row`."""
        return [item for item in self.variables.values() if item.dims[:1] == (ROW,)]

    @property
    def ragged(self) -> list[StoredVariable]:
        """Variables over a sample dimension."""
        return [item for item in self.variables.values() if set(item.dims) & set(self.samples)]


Values = dict[str, np.ndarray]


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn errors of netCDF4 and h5py into a StoreError that names the file."""
    try:
        yield
    except StoreError:
        raise
    except (OSError, RuntimeError, KeyError) as error:  # the last: a group of a damaged file
        check_intact(path)
        raise StoreError(f"{path}: cannot be read: {error}") from error


@contextmanager
def open_raw(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a netCDF4 file without decoding; raise StoreError if it cannot be read."""
    import netCDF4

    with reading(path), netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        file.set_auto_chartostring(False)
        for variable in file.variables.values():
            if variable.dimensions:
                # read once and completely: a cache would hold a second copy
                variable.set_var_chunk_cache(size=NO_CACHE)
        yield file


@contextmanager
def raw(path: Path) -> Iterator[h5py.File]:
    """Open a file for the bare values of its variables; raise StoreError if they cannot be read.

    h5py reads a block of rows in half the time of netCDF4, which looks up the variable in each call.
    """
    import h5py

    # each chunk is read once, or twice if two blocks share it: a cache would only use memory
    with reading(path), h5py.File(path, "r", rdcc_nbytes=0) as file:
        yield file


def read_headers(paths: Sequence[Path], grid: SweepGrid) -> list[Shard]:
    """Read the headers of shards, in the order of their rows.

    Raises StoreError if a shard is damaged or was solved with other parameters than those of the grid, if the shards
    do not hold each row exactly once, or if they come from different sweeps.
    """
    if not paths:
        raise StoreError("no shards to join: solve them first")
    shards = sorted(
        (_head(path, grid) for path in paths), key=lambda shard: (shard.start, shard.stop)
    )
    _check_cover(shards, grid.rows)
    for shard in shards:
        _check_parameters(shard.path, shard.start, shard.stop, grid)
        _check_alike(shards[0], shard)
    return shards


def _head(path: Path, grid: SweepGrid) -> Shard:
    """Read and check the header of a shard."""
    check_intact(path)
    with open_raw(path) as file:
        attrs = {name: file.getncattr(name) for name in file.ncattrs()}
        if not all(name in attrs for name in ROW_RANGE_ATTRS):
            raise StoreError(
                f"{path}: is no shard (it has no {' and '.join(ROW_RANGE_ATTRS)}): join shards only"
            )
        start, stop = (int(attrs.pop(name)) for name in ROW_RANGE_ATTRS)
        items = [_item(variable) for variable in file.variables.values()]
        shard = Shard.of(path, start, stop, attrs, items, grid)
        held = len(file.dimensions[ROW]) if ROW in file.dimensions else None
        if held != stop - start:
            raise StoreError(
                f"{path}: must hold rows {start} to {stop - 1}, got {held} rows: {AGAIN}"
            )
        for dim, name in shard.samples.items():
            samples = len(file.dimensions[dim])
            if file.variables[name][...].sum(dtype=np.int64) != samples:
                raise StoreError(
                    f"{path}: must hold as many {dim!r} as {name} counts, got {samples}: {AGAIN}"
                )
        for item in shard.variables.values():
            if not {ROW, *shard.samples} & set(item.dims):
                values = np.asarray(file.variables[item.name][...])
                shard.variables[item.name] = replace(item, values=values)
    return shard


def _item(variable: netCDF4.Variable) -> StoredVariable:
    names = (name for name in variable.ncattrs() if name != "_FillValue")
    attrs = {name: variable.getncattr(name) for name in names}
    return StoredVariable(
        variable.name, tuple(variable.dimensions), variable.shape, variable.dtype, attrs
    )


def _check_parameters(path: Path, start: int, stop: int, grid: SweepGrid) -> None:
    """Raise unless the rows [start, stop) in a file have the parameters of the grid."""
    with raw(path) as file:
        missing = [name for name in (*grid.values, *grid.shared) if name not in file]
        if missing:
            raise StoreError(f"{path}: does not hold the {missing[0]} of its rows: {AGAIN}")
        for name, expected in grid.shared.items():
            if (held := file[name][...]) != expected:
                raise _other_value(path, name, held, "every row", expected)
        for first in range(start, stop, ROWS_AT_ONCE):
            rows = np.arange(first, min(first + ROWS_AT_ONCE, stop))
            swept = grid.parameters(tuple(grid.values), rows).T
            for name, values in zip(grid.values, swept, strict=True):
                stored = file[name][rows[0] - start : rows[-1] + 1 - start]
                if (differs := stored != values).any():
                    index = int(differs.argmax())
                    raise _other_value(
                        path, name, stored[index], f"row {rows[index]}", values[index]
                    )


def _other_value(path: Path, name: str, held: Any, where: str, wanted: Any) -> StoreError:
    """Return the error of a parameter that differs from the study."""
    return StoreError(
        f"{path}: {name} of {where} differs from the study (must be {float(wanted)!r}, got {float(held)!r}): "
        f"recompute this shard ({AGAIN})"
    )


def _check_cover(shards: Sequence[Shard], rows: int) -> None:
    """Raise unless the shards hold each of the rows [0, rows) exactly once."""
    covered = 0
    for previous, shard in zip([None, *shards], shards, strict=False):
        if shard.start > covered:
            break
        if shard.start < covered and previous is not None:
            raise StoreError(
                f"{previous.path} and {shard.path}: both hold row {shard.start}: "
                "join the shards of one cut only"
            )
        covered = shard.stop
    if covered == rows:
        return
    if covered > rows:
        raise StoreError(
            f"{shards[-1].path}: must hold rows up to {rows - 1}, got rows up to {covered - 1}: "
            "join the shards of one sweep only"
        )
    following = next((shard.start for shard in shards if shard.start > covered), rows)
    held = f"in none of the {len(shards)} shards" if len(shards) > 1 else "not in the only shard"
    raise StoreError(
        f"rows {covered} to {following - 1} of {rows} are {held}: solve the shards that hold them"
    )


def _check_alike(first: Shard, other: Shard) -> None:
    """Raise unless two shards come from one sweep."""
    between = f"{first.path} and {other.path} belong to different sweeps"
    remedy = "recompute the older one"
    for name in IDENTITY_ATTRS:
        if first.attrs.get(name) != other.attrs.get(name):
            raise StoreError(f"{between} ({name} differs): {remedy}")
    if list(first.variables) != list(other.variables):
        odd = sorted(set(first.variables) ^ set(other.variables))
        held = f"only one holds {', '.join(odd)}" if odd else "the order of variables differs"
        raise StoreError(f"{between} ({held}): {remedy}")
    varying = {ROW, *first.samples}
    for name, item in first.variables.items():
        other_item = other.variables[name]
        if (item.dims, item.dtype) != (other_item.dims, other_item.dtype):
            raise StoreError(f"{between} (dimensions or type of {name} differ): {remedy}")
        sizes = zip(item.dims, item.shape, other_item.shape, strict=True)
        if any(one != two for dim, one, two in sizes if dim not in varying):
            raise StoreError(f"{between} (size of {name} differs): {remedy}")
        if _bytes(item) != _bytes(other_item):
            raise StoreError(f"{between} (values of {name} differ): {remedy}")


def _bytes(item: StoredVariable) -> bytes:
    """Return the bytes of the values of a variable, if it holds them."""
    return b"" if item.values is None else item.values.tobytes()


def read_rows(shards: Iterable[Shard], max_rows: int, max_bytes: int) -> Generator[Values]:
    """Yield the values of all variables over `row` or a sample dimension, some rows at a time, in their order."""
    for shard in shards:
        items, rows = [*shard.gridded, *shard.ragged], shard.stop - shard.start
        row_bytes = sum(item.bytes_each * item.shape[0] for item in items) // rows
        # a power of two, as chunks are, so that most of them are read once
        step = 1 << (min(max_rows, max(1, max_bytes // max(1, row_bytes))).bit_length() - 1)
        with raw(shard.path) as file:
            bounds = {
                dim: np.concatenate([[0], np.cumsum(file[name][...], dtype=np.int64)])
                for dim, name in shard.samples.items()
            }
            for start in range(0, rows, step):
                span = [start, min(start + step, rows)]
                ranges = {ROW: span} | {dim: ends[span] for dim, ends in bounds.items()}
                yield {item.name: file[item.name][slice(*ranges[item.dims[0]])] for item in items}
