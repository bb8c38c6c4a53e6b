"""Sweeps on disk: each block of rows is written at its place of one file, as it is solved or read from a shard.

The bytes of a file do not depend on the blocks and shards in which the rows come: values are written in boxes of the
grid, each chunk once, in one order. Ragged variables, whose length is known at the end, follow then; until then their
samples are in unnamed scratch files beside the file, which vanish whatever happens. One block and one box are in
memory, whatever the number of rows.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.solve.physical import grid_attributes
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.atomic import StoreError, atomic_file, seal
from vibropipe.store.encoding import (
    CHUNK_BYTES,
    Encoded,
    StoredVariable,
    chunk_shape,
    coordinates_attribute,
    define_variables,
    encode,
    encode_coords,
    storable,
)
from vibropipe.store.shards import ROW, ROW_RANGE_ATTRS, Shard, Values, read_headers, read_rows
from vibropipe.words.progress import Progress

if TYPE_CHECKING:
    import xarray as xr

    # A block of rows as it is, or encoded.
    Block = xr.Dataset | Encoded

# Limits of a box in memory: bytes of its variables, and rows.
BLOCK_BYTES = 8 << 20
BLOCK_ROWS = 1 << 16


def write_rows(blocks: Iterable[Block], path: str | PathLike[str], rows: int) -> None:
    """Write blocks of a sweep to a shard, each before the next one is requested.

    blocks : consecutive blocks over `row` (`row_start`, `row_stop`) with the same variables, encoded or not
    rows : number of rows in all
    Raises NotWrittenError as of `save`, or ValueError if rows are missing; `path` is then as before.
    """
    write_grid(blocks, path, SweepGrid({ROW: np.arange(rows)}))


def write_grid(blocks: Iterable[Block], path: str | PathLike[str], grid: SweepGrid) -> None:
    """Write blocks of all rows of a sweep to one file over its grid, bitwise that of `join`.

    Parameters and errors as of `write_rows`; `grid` is the grid of the sweep.
    """
    with atomic_file(path) as temporary:
        with ExitStack() as files:
            writer, first = None, 0
            for block in blocks:
                items, attrs = block if isinstance(block, tuple) else encode(block)
                attrs = dict(attrs)
                start, _stop = (int(attrs.pop(name)) for name in ROW_RANGE_ATTRS)
                if writer is None:
                    first = start
                    head = Shard.of(temporary, start, start + grid.rows, attrs, items, grid)
                    if ROW in grid.dims:
                        attrs |= dict(zip(ROW_RANGE_ATTRS, (head.start, head.stop), strict=True))
                    else:
                        attrs.pop("coordinates", None)
                    writer = _Writer(head, grid, attrs, files)
                if start != first + writer.rows:
                    raise ValueError(f"block of row {start}: row {first + writer.rows} is next")
                writer.put({item.name: np.asarray(item.values) for item in items})
            written = 0 if writer is None else writer.rows
            if writer is None or written != grid.rows:
                raise ValueError(f"{written} rows came, {grid.rows} were expected")
            writer.finish()
        seal(temporary)


def join(
    shard_paths: Sequence[str | PathLike[str]],
    path: str | PathLike[str],
    grid: SweepGrid,
    attrs: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
) -> None:
    """Join the shards of a sweep into one file.

    The joined variables run over the swept parameters in the order of the study, ragged ones in C order of that grid.
    Attributes are those of the shards (a list where they differ), then `attrs`.

    shard_paths : files over `row`, rows counted as in `grid`, in any order. Each holds the parameters of its rows
    grid : grid of the study, with the parameters that the shards must have
    progress : called as `progress(done, total)` with the number of rows
    Raises StoreError if a shard is damaged, was solved with other parameters or is of another sweep (its
    `fingerprint` differs from the others or from `attrs`), if rows are missing or held twice, or if `path` cannot be
    written; `path` is then as before. The message names files and rows.
    """
    shards = _headers(shard_paths, grid, attrs)
    with atomic_file(path) as temporary:
        with ExitStack() as files:
            head = replace(shards[0], path=temporary)
            writer = _Writer(head, grid, _common(shards) | storable(attrs or {}), files)
            for values in read_rows(shards, BLOCK_ROWS, BLOCK_BYTES):
                writer.put(values)
                if progress is not None:
                    progress(writer.rows, grid.rows)
            writer.finish()
        seal(temporary)


def read_shards(
    shard_paths: Sequence[str | PathLike[str]],
    grid: SweepGrid,
    attrs: Mapping[str, Any] | None = None,
) -> tuple[Values, dict[str, Any]]:
    """Read the shards of a scene into memory, after the checks of `join`.

    Returns the values: what varies over `row`, all rows in order; attrs: attributes of the shards (a list where they
    differ).
    """
    shards = _headers(shard_paths, grid, attrs)
    parts = list(read_rows(shards, BLOCK_ROWS, BLOCK_BYTES))
    return {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}, _common(shards)


def _headers(
    shard_paths: Sequence[str | PathLike[str]], grid: SweepGrid, attrs: Mapping[str, Any] | None
) -> list[Shard]:
    """Read the headers of shards, which must be those of the study that `attrs` name."""
    shards = read_headers([Path(shard) for shard in shard_paths], grid)
    fingerprint = (attrs or {}).get("fingerprint")
    if fingerprint is not None and shards[0].attrs.get("fingerprint") != fingerprint:
        raise StoreError(
            f"{shards[0].path}: is a shard of another study, or of this one before it was changed: "
            "recompute the shards"
        )
    return shards


def _common(shards: Sequence[Shard]) -> dict[str, Any]:
    """Return the attributes of the shards, and the list of values where they differ."""
    names = dict.fromkeys(name for shard in shards for name in shard.attrs)
    common: dict[str, Any] = {}
    for name in names:
        values = {
            str(shard.attrs[name]): shard.attrs[name] for shard in shards if name in shard.attrs
        }
        common[name] = values.popitem()[1] if len(values) == 1 else json.dumps(sorted(values))
    common.pop("coordinates", None)
    return common


class _Writer:
    """Writer of rows, which come in their order, to the new file `head.path` over a grid.

    head : variables of the rows, with the values of those that are equal in every row
    grid : grid of the file, or all rows along `row`
    files : closes the file and the scratch files
    """

    def __init__(
        self, head: Shard, grid: SweepGrid, attrs: Mapping[str, Any], files: ExitStack
    ) -> None:
        import netCDF4

        self.rows, self._grid, self._head = 0, grid, head
        row_bytes = sum(item.bytes_each for item in head.gridded)
        block_rows = min(BLOCK_ROWS, max(1, BLOCK_BYTES // max(1, row_bytes)))
        self._file = files.enter_context(netCDF4.Dataset(head.path, "w"))
        self._laid_out = _laid_out(head, grid, block_rows)
        ragged = {item.name for item in head.ragged}
        fixed = [item for name, item in self._laid_out.items() if name not in ragged]
        coords = [] if ROW in grid.dims else encode_coords(grid.coords)
        coords = [replace(v, attrs=v.attrs | grid_attributes(v.name, grid)) for v in coords]
        self._created = define_variables(self._file, [*coords, *fixed], attrs)
        self._boxes = grid.blocks(chunk_shape(grid.row_shape, block_rows))
        self._box = next(self._boxes, None)
        self._waiting: Values = {
            item.name: np.empty((0, *item.shape[1:]), item.dtype) for item in head.gridded
        }

        def scratch() -> Any:
            return files.enter_context(tempfile.TemporaryFile(dir=head.path.parent))

        self._samples = {name: scratch() for name in ragged}
        # for each sample dimension, the end of the samples of each row
        self._ends = {dim: scratch() for dim in head.samples}
        self._totals = dict.fromkeys(head.samples, 0)

    def put(self, values: Values) -> None:
        """Add rows, which follow the previous ones."""
        for name, waiting in self._waiting.items():
            self._waiting[name] = np.concatenate([waiting, values[name]])
        for name, file in self._samples.items():
            file.write(np.ascontiguousarray(values[name]).data)
        for dim, name in self._head.samples.items():
            ends = self._totals[dim] + np.cumsum(values[name], dtype=np.int64)
            self._ends[dim].write(ends.data)
            self._totals[dim] = int(ends[-1])
        self.rows += len(values[self._head.gridded[0].name])
        while self._box is not None and self._box.stop <= self.rows:
            size = self._box.stop - self._box.start
            for name, waiting in self._waiting.items():
                self._created[name][self._box.where] = self._grid.to_box(self._box, waiting[:size])
                self._waiting[name] = waiting[size:]
            self._box = next(self._boxes, None)

    def finish(self) -> None:
        """Write the samples in the order of the grid, each chunk once."""
        for scratch in (*self._samples.values(), *self._ends.values()):
            scratch.flush()
        for dim, total in self._totals.items():
            items = []
            for item in [each for each in self._head.ragged if each.dims[0] == dim]:
                shape = (total, *item.shape[1:])
                chunks = chunk_shape(shape, CHUNK_BYTES // item.dtype.itemsize)
                items.append(replace(self._laid_out[item.name], shape=shape, chunks=chunks))
            created = define_variables(self._file, items, {})
            if total:
                for item in items:
                    self._copy(dim, item, created[item.name])

    def _copy(self, dim: str, item: StoredVariable, variable: Any) -> None:
        """Copy the samples of a variable from its scratch file."""
        # the place of a sample takes as much memory as some samples
        samples_at_once = BLOCK_BYTES // (32 + item.bytes_each)
        step = min(BLOCK_ROWS, max(1, samples_at_once * self.rows // self._totals[dim]))
        written, waiting = 0, np.empty((0, *item.shape[1:]), item.dtype)
        for point in range(0, self.rows, step):
            # mapped anew in each step: pages of a lasting map would count as memory of the process
            ends = np.memmap(self._ends[dim], np.int64, "r")
            samples = np.memmap(self._samples[item.name], item.dtype, "r", shape=item.shape)
            rows = self._grid.rows_of_points(point, min(point + step, self.rows))
            first = np.where(rows > 0, ends[rows - 1], 0)
            counts = ends[rows] - first
            shifts = np.repeat(first - (np.cumsum(counts) - counts), counts)
            waiting = np.concatenate([waiting, samples[shifts + np.arange(len(shifts))]])
            size = len(waiting)
            if point + step < self.rows:
                size -= size % int(variable.chunking()[0])
            if size:
                variable[written : written + size] = waiting[:size]
                written, waiting = written + size, waiting[size:]


def _laid_out(head: Shard, grid: SweepGrid, block_rows: int) -> dict[str, StoredVariable]:
    """Return the variables over a grid; ragged ones have their length and chunks later."""
    variables = dict(head.variables)
    for item in head.gridded:
        max_elements = min(block_rows, max(1, CHUNK_BYTES // item.bytes_each))
        chunks = grid.in_grid_order(chunk_shape(grid.row_shape, max_elements)) + item.shape[1:]
        dims, shape = grid.dims + item.dims[1:], grid.shape + item.shape[1:]
        variables[item.name] = replace(item, dims=dims, shape=shape, chunks=chunks, values=None)
    for item in head.ragged:
        variables[item.name] = replace(item, values=None)
    texts = [head.attrs, *(item.attrs for item in variables.values())]
    referenced = " ".join(str(attrs.get("coordinates", "")) for attrs in texts).split()
    coords = {name: item.dims for name, item in variables.items() if name in referenced}
    for name, item in variables.items():
        attrs = {key: value for key, value in item.attrs.items() if key != "coordinates"}
        if "coordinates" in item.attrs:
            attrs |= coordinates_attribute(item.dims, coords)
        variables[name] = replace(item, attrs=attrs)
    return variables
