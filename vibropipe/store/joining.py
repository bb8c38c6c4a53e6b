"""Shards of a sweep streamed into one file over the grid of the swept parameters.

The file does not depend on how the sweep was cut, byte for byte: values are written in blocks of
the grid that know nothing of the shards, each chunk once, in one order. In memory is one block,
however many rows there are.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibropipe.store.atomic import StoreError, seal, whole_file
from vibropipe.store.encoding import (
    CHUNK_BYTES,
    Stored,
    chunk_shape,
    coordinates_attribute,
    create,
    storable,
)
from vibropipe.store.grid import Grid
from vibropipe.store.ragged import InOrder, OnDisk, Places, Turned
from vibropipe.store.shards import ROW, Rows, Shard, Variable, counts_of, inspect
from vibropipe.words.vocabulary import attributes

__all__ = ["join"]

BLOCK_BYTES = 8 << 20
BLOCK_ROWS = 1 << 16


def join(
    shard_paths: Sequence[str | PathLike[str]],
    path: str | PathLike[str],
    dims: Mapping[str, np.ndarray],
    follow_dim: str | None = None,
    attrs: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Join the shards of a sweep into the file ``path``.

    Shards run over ``row`` in C order over ``dims`` (swept parameter -> its values), the followed
    one moved last; the joined variables run over ``dims`` in their own order, ragged ones in C
    order of that grid. Attributes are those of the shards (a list where they differ), then
    ``attrs``. ``progress`` is told (rows joined, rows in all) again and again. Raises StoreError,
    naming files and rows, when a shard is damaged or of another sweep (its ``fingerprint`` is not
    that of the others, or of ``attrs``), when rows are missing or held twice, or when ``path`` cannot
    be written; ``path`` is then as it was.
    """
    path = Path(path)
    grid = Grid({name: np.asarray(values) for name, values in dims.items()}, follow_dim)
    shards = inspect([Path(shard) for shard in shard_paths], grid)
    asked = (attrs or {}).get("fingerprint")
    if asked is not None and shards[0].attrs.get("fingerprint") != asked:
        raise StoreError(
            f"{shards[0].path} is a shard of another study, or of this one before it was changed: "
            "solve its shards again"
        )
    with whole_file(path) as temporary:
        _write(shards, temporary, grid, _common(shards) | storable(attrs or {}), progress)
        seal(temporary)


def _write(
    shards: list[Shard],
    path: Path,
    grid: Grid,
    attrs: dict[str, Any],
    progress: Callable[[int, int], None] | None,
) -> None:
    import netCDF4

    first = shards[0]
    block_rows, variables = _layout(shards, grid)
    gridded = [name for name in first.gridded if name not in grid.dims]
    with ExitStack() as files:
        # room on the disk is taken before anything is written
        made = None if grid.in_order else _scratch(shards, path.parent, grid, variables, files)
        file = files.enter_context(netCDF4.Dataset(path, "w"))
        created = create(file, variables, attrs)
        ragged = {name: created[name] for name in first.ragged}
        samples = InOrder(ragged) if made is None else Turned(ragged, *made)
        rows = files.enter_context(closing(Rows(shards)))
        for block in grid.blocks(block_rows):
            values = rows.take(block.start, block.stop)
            for name in gridded:
                created[name][block.where] = grid.place(block, values[name])
            samples.put(block.start, block.stop, values)
            if progress is not None:
                progress(block.stop, grid.rows)
        samples.finish()


def _scratch(
    shards: list[Shard], folder: Path, grid: Grid, variables: list[Stored], files: ExitStack
) -> tuple[dict[str, tuple[str, Places]], dict[str, OnDisk]]:
    """Return where samples go (with the name of their count, by dimension), and room for them."""
    first = shards[0]
    counts = {
        dim: (
            name,
            Places(
                grid,
                OnDisk(files, folder, (grid.rows,), np.dtype(np.int64)),
                counts_of(shards, name),
            ),
        )
        for dim, name in first.samples.items()
    }
    kept = {
        item.name: OnDisk(files, folder, item.shape, item.dtype)
        for item in variables
        if item.name in first.ragged
    }
    return counts, kept


def _layout(shards: Sequence[Shard], grid: Grid) -> tuple[int, list[Stored]]:
    """Return the rows of a block, and the joined variables (values given where they are known)."""
    first = shards[0]
    totals = {dim: sum(shard.sizes[dim] for shard in shards) for dim in first.samples}
    gridded = [name for name in first.gridded if name not in grid.dims]
    row_bytes = sum(_bytes_per_row(first, first.variables[name]) for name in gridded)
    for name in first.ragged:
        variable = first.variables[name]
        row_bytes += _bytes_per_row(first, variable) * totals[variable.dims[0]] // grid.rows
    block_rows = min(BLOCK_ROWS, max(1, BLOCK_BYTES // max(1, row_bytes)))
    swept = [
        Stored(name, (name,), values.shape, values.dtype, storable(attributes(name)), values)
        for name, values in grid.values.items()
    ]
    joined = [
        _joined(name, item, first, grid, totals, block_rows)
        for name, item in first.variables.items()
        if name not in grid.dims
    ]
    coords = _coordinates(first, joined)
    for index, item in enumerate(joined):
        plain = {key: value for key, value in item.attrs.items() if key != "coordinates"}
        if "coordinates" in item.attrs:
            plain |= coordinates_attribute(item.dims, coords)
        joined[index] = replace(item, attrs=plain)
    return block_rows, swept + joined


def _joined(
    name: str,
    variable: Variable,
    first: Shard,
    grid: Grid,
    totals: Mapping[str, int],
    block_rows: int,
) -> Stored:
    """Return one variable of the shards as it lies in the joined file."""
    dims, values, chunks = variable.dims, None, None
    shape = tuple(first.sizes[dim] for dim in dims)
    if dims[:1] == (ROW,):
        most = CHUNK_BYTES // _bytes_per_row(first, variable)
        chunks = grid.chunks(min(block_rows, max(1, most))) + shape[1:]
        dims, shape = grid.dims + dims[1:], grid.shape + shape[1:]
    elif dims and dims[0] in totals:
        shape = (totals[dims[0]], *shape[1:])
        chunks = chunk_shape(shape, CHUNK_BYTES // variable.dtype.itemsize)
    else:
        values = first.constants[name]
    return Stored(name, dims, shape, variable.dtype, variable.attrs, values, chunks)


def _bytes_per_row(first: Shard, variable: Variable) -> int:
    sizes = (first.sizes[dim] for dim in variable.dims[1:])
    return int(np.prod([variable.dtype.itemsize, *sizes]))


def _coordinates(first: Shard, joined: Sequence[Stored]) -> dict[str, tuple[str, ...]]:
    """Return the coordinates the shards name (and their dimensions in the joined file)."""
    texts = [str(item.attrs.get("coordinates", "")) for item in first.variables.values()]
    named = set(" ".join([*texts, str(first.attrs.get("coordinates", ""))]).split())
    return {item.name: item.dims for item in joined if item.name in named}


def _common(shards: Sequence[Shard]) -> dict[str, Any]:
    """Return the attributes of the shards; where they differ, the list of what was found."""
    names = dict.fromkeys(name for shard in shards for name in shard.attrs)
    common: dict[str, Any] = {}
    for name in names:
        found = {
            str(shard.attrs[name]): shard.attrs[name] for shard in shards if name in shard.attrs
        }
        common[name] = found.popitem()[1] if len(found) == 1 else json.dumps(sorted(found))
    common.pop("coordinates", None)
    return common
