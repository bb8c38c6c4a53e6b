"""Shards of a sweep streamed into one file over the grid of the swept parameters.

The file does not depend on how the sweep was cut, byte for byte: values are written in blocks of
the grid that know nothing of the shards, each chunk once, in one order. In memory are one shard,
one block, and a few integers per row.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
from vibropipe.store.ragged import Places, Scratch
from vibropipe.store.shards import ROW, Rows, Shard, Variable, inspect
from vibropipe.vocabulary import attributes

if TYPE_CHECKING:
    import netCDF4

__all__ = ["join"]

BLOCK_BYTES = 32 << 20
BLOCK_ROWS = 1 << 16


def join(
    shard_paths: Sequence[str | PathLike[str]],
    path: str | PathLike[str],
    dims: Mapping[str, np.ndarray],
    follow_dim: str | None = None,
    attrs: Mapping[str, Any] | None = None,
) -> None:
    """Join the shards of a sweep into the file ``path``.

    Shards run over ``row`` in C order over ``dims`` (swept parameter -> its values), the followed
    one moved last; the joined variables run over ``dims`` in their own order, ragged ones in C
    order of that grid. Attributes are those of the shards (a list where they differ), then
    ``attrs``. Raises StoreError, naming files and rows, when a shard is damaged or of another
    sweep, when rows are missing or held twice, or when ``path`` cannot be written; ``path`` is
    then as it was.
    """
    path = Path(path)
    grid = Grid({name: np.asarray(values) for name, values in dims.items()}, follow_dim)
    shards = inspect([Path(shard) for shard in shard_paths], grid)
    with whole_file(path) as temporary:
        _write(shards, temporary, grid, _common(shards) | storable(attrs or {}))
        seal(temporary)


def _write(shards: list[Shard], path: Path, grid: Grid, attrs: dict[str, Any]) -> None:
    import netCDF4

    first = shards[0]
    places = {
        dim: Places(grid, [shard.counts[name] for shard in shards])
        for dim, name in first.samples.items()
    }
    block_rows, variables = _layout(first, grid, places)
    ragged = {
        item.name: (item.shape, item.dtype) for item in variables if item.name in first.ragged
    }

    def keep(shard: Shard, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        _check_grid(shard, values, grid)
        for dim in shard.samples:
            where = places[dim].of_rows(shard.start, shard.stop)
            for name in ragged:
                if first.variables[name].dims[0] == dim:
                    scratch.put(name, where, values[name])
        return {name: values[name] for name in first.gridded if name not in grid.dims}

    with Scratch(path.parent, ragged) as scratch, netCDF4.Dataset(path, "w") as file:
        created = create(file, variables, attrs)
        rows = Rows(shards, keep)
        for block in grid.blocks(block_rows):
            for name, values in rows.take(block.start, block.stop).items():
                created[name][block.where] = grid.place(block, values)
        _write_ragged(scratch, created, list(ragged))


def _write_ragged(
    scratch: Scratch, created: Mapping[str, netCDF4.Variable], names: Sequence[str]
) -> None:
    for name in names:
        chunk = int(created[name].chunking()[0])
        for start, values in scratch.blocks(name, 16 * chunk):
            created[name][start : start + len(values)] = values


def _layout(first: Shard, grid: Grid, places: Mapping[str, Places]) -> tuple[int, list[Stored]]:
    """Return the rows of a block, and the joined variables (values given where they are known)."""
    gridded = [name for name in first.gridded if name not in grid.dims]
    row_bytes = {name: _bytes_per_row(first, first.variables[name]) for name in gridded}
    block_rows = min(BLOCK_ROWS, max(1, BLOCK_BYTES // max(1, sum(row_bytes.values()))))
    swept = [
        Stored(name, (name,), values.shape, values.dtype, storable(attributes(name)), values)
        for name, values in grid.values.items()
    ]
    joined = [
        _joined(name, item, first, grid, places, block_rows)
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
    places: Mapping[str, Places],
    block_rows: int,
) -> Stored:
    """Return one variable of the shards as it lies in the joined file."""
    dims, values, chunks = variable.dims, None, None
    shape = tuple(first.sizes[dim] for dim in dims)
    if dims[:1] == (ROW,):
        most = CHUNK_BYTES // _bytes_per_row(first, variable)
        chunks = grid.chunks(min(block_rows, max(1, most))) + shape[1:]
        dims, shape = grid.dims + dims[1:], grid.shape + shape[1:]
    elif dims and dims[0] in places:
        shape = (places[dims[0]].total, *shape[1:])
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


def _check_grid(shard: Shard, values: Mapping[str, np.ndarray], grid: Grid) -> None:
    """Raise unless the swept parameters a shard holds are those of its rows in the grid."""
    for name in grid.dims:
        if name in values:
            expected = grid.coordinate(name, shard.start, shard.stop)
            if not np.array_equal(values[name], expected):
                raise StoreError(
                    f"{shard.path} was solved for other values of {name} than its rows "
                    f"{shard.start} to {shard.stop - 1} have in the study: solve it again"
                )


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
