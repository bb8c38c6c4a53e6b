"""Shards of a sweep joined into one file over the grid of the swept parameters, block by block.

The bytes of the file do not depend on the shards: values are written in blocks of the grid, each chunk once, in one
order. One block is in memory, whatever the number of rows.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from math import prod
from os import PathLike
from pathlib import Path
from typing import Any

from vibropipe.solve.physical import grid_attributes
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.atomic import StoreError, atomic_file, seal
from vibropipe.store.encoding import (
    CHUNK_BYTES,
    StoredVariable,
    chunk_shape,
    coordinates_attribute,
    define_variables,
    encode_coords,
    storable,
)
from vibropipe.store.ragged import ReorderingWriter, SequentialWriter
from vibropipe.store.shards import Shard, Values, read_headers, read_rows
from vibropipe.words.progress import Progress

# Limits of a block in memory: bytes of its variables, and rows.
BLOCK_BYTES = 8 << 20
BLOCK_ROWS = 1 << 16


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

    Parameters
    ----------
    shard_paths : sequence of path-like
        Files over `row`, rows counted as in `grid`, in any order. Each holds the parameters of its rows.
    path : path-like
        File to write.
    grid : SweepGrid
        Grid of the study, with the parameters that the shards must have.
    attrs : mapping, optional
        Global attributes of the joined file.
    progress : callable, optional
        Called as `progress(done, total)` with the number of rows.

    Raises
    ------
    StoreError
        If a shard is damaged, was solved with other parameters or is of another sweep (its `fingerprint` differs from
        the others or from `attrs`), if rows are missing or held twice, or if `path` cannot be written; `path` is then
        as before. The message names files and rows.
    """
    path = Path(path)
    shards = _headers(shard_paths, grid, attrs)
    with atomic_file(path) as temporary:
        _write(shards, temporary, grid, _common(shards) | storable(attrs or {}), progress)
        seal(temporary)


def read_shards(
    shard_paths: Sequence[str | PathLike[str]],
    grid: SweepGrid,
    attrs: Mapping[str, Any] | None = None,
) -> tuple[Values, dict[str, Any]]:
    """Read the shards of a scene into memory, after the checks of `join`.

    Returns
    -------
    values : dict of str to array
        What varies over `row`, all rows in order.
    attrs : dict
        Attributes of the shards (a list where they differ).
    """
    shards = _headers(shard_paths, grid, attrs)
    with closing(read_rows(shards, [grid.rows])) as rows:
        return next(rows), _common(shards)


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


def _write(
    shards: list[Shard],
    path: Path,
    grid: SweepGrid,
    attrs: dict[str, Any],
    progress: Progress | None,
) -> None:
    """Write the joined file without its seal."""
    import netCDF4

    block_rows, variables = _layout(shards, grid)
    variables = [replace(v, attrs=v.attrs | grid_attributes(v.name, grid)) for v in variables]
    gridded = [item.name for item in shards[0].gridded]
    names = {item.name for item in shards[0].ragged}
    ragged = [item for item in variables if item.name in names]
    with ExitStack() as files:
        # reserve space on the disk before anything is written
        reordering = (
            None if grid.in_order else ReorderingWriter(ragged, shards, grid, path.parent, files)
        )
        file = files.enter_context(netCDF4.Dataset(path, "w"))
        created = define_variables(file, variables, attrs)
        samples = reordering or SequentialWriter(created[item.name] for item in ragged)
        blocks = list(grid.blocks(chunk_shape(grid.row_shape, block_rows)))
        rows = files.enter_context(closing(read_rows(shards, (block.stop for block in blocks))))
        for block, values in zip(blocks, rows, strict=True):
            for name in gridded:
                created[name][block.where] = grid.to_box(block, values[name])
            samples.put(block.start, block.stop, values)
            if progress is not None:
                progress(block.stop, grid.rows)
        samples.finish(created)


def _layout(shards: Sequence[Shard], grid: SweepGrid) -> tuple[int, list[StoredVariable]]:
    """Return the rows of a block and the joined variables, with those values that are known."""
    first = shards[0]
    totals = {dim: sum(shard.count(dim) for shard in shards) for dim in first.samples}
    row_bytes = sum(map(_bytes_each, first.gridded))
    row_bytes += sum(_bytes_each(item) * totals[item.dims[0]] // grid.rows for item in first.ragged)
    block_rows = min(BLOCK_ROWS, max(1, BLOCK_BYTES // max(1, row_bytes)))
    joined = dict(first.variables)
    for item in first.gridded:
        max_elements = min(block_rows, max(1, CHUNK_BYTES // _bytes_each(item)))
        chunks = grid.in_grid_order(chunk_shape(grid.row_shape, max_elements)) + item.shape[1:]
        dims, shape = grid.dims + item.dims[1:], grid.shape + item.shape[1:]
        joined[item.name] = replace(item, dims=dims, shape=shape, chunks=chunks)
    for item in first.ragged:
        shape = (totals[item.dims[0]], *item.shape[1:])
        chunks = chunk_shape(shape, CHUNK_BYTES // item.dtype.itemsize)
        joined[item.name] = replace(item, shape=shape, chunks=chunks)
    texts = [first.attrs, *(item.attrs for item in joined.values())]
    referenced = " ".join(str(attrs.get("coordinates", "")) for attrs in texts).split()
    coords = {name: item.dims for name, item in joined.items() if name in referenced}
    for name, item in joined.items():
        attrs = {key: value for key, value in item.attrs.items() if key != "coordinates"}
        if "coordinates" in item.attrs:
            attrs |= coordinates_attribute(item.dims, coords)
        joined[name] = replace(item, attrs=attrs)
    return block_rows, [*encode_coords(grid.coords), *joined.values()]


def _bytes_each(item: StoredVariable) -> int:
    """Return the bytes of a row, or of a sample, of a variable."""
    return item.dtype.itemsize * prod(item.shape[1:])


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
