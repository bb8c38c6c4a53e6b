"""Rows of a sweep written as they are solved: one block is in memory, whatever the number of rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.atomic import atomic_file, scratch_file, seal
from vibropipe.store.encoding import (
    CHUNK_BYTES,
    StoredVariable,
    chunk_shape,
    define_variables,
    encode,
)
from vibropipe.store.joining import join
from vibropipe.store.ragged import SequentialWriter
from vibropipe.store.shards import ROW, ROW_RANGE_ATTRS

if TYPE_CHECKING:
    import xarray as xr

SAMPLE_CHUNK_BYTES = CHUNK_BYTES // 8
"""Chunk of samples, whose number is not known in advance: small, since the last chunk is stored at full length."""


def write_rows(blocks: Iterable[xr.Dataset], path: str | PathLike[str], rows: int) -> None:
    """Write blocks of a sweep to a shard, each before the next one is requested.

    Parameters
    ----------
    blocks : iterable of xarray.Dataset
        Consecutive blocks over `row` (`row_start`, `row_stop`) with the same variables.
    path : path-like
        File to write.
    rows : int
        Number of rows in all.

    Raises
    ------
    NotWrittenError
        As of `write`.
    ValueError
        If rows are missing; `path` is then as before.
    """
    with atomic_file(path) as temporary:
        _stream(blocks, temporary, rows)


def write_grid(blocks: Iterable[xr.Dataset], path: str | PathLike[str], grid: SweepGrid) -> None:
    """Write blocks of all rows of a sweep to one file over its grid.

    Parameters as of `write_rows`; `grid` is the grid of the sweep. The file is bitwise that of `join`; until then the
    rows are in a scratch file.
    """
    with scratch_file(path) as scratch:
        _stream(blocks, scratch, grid.rows)
        join([scratch], path, grid)


def _stream(blocks: Iterable[xr.Dataset], path: Path, rows: int) -> None:
    """Write blocks to a new file, and its seal."""
    import netCDF4

    written, first = 0, 0
    with netCDF4.Dataset(path, "w") as file:
        created: dict[str, netCDF4.Variable] = {}
        for block in blocks:
            block_variables, attrs = encode(block)
            if not created:
                first = int(attrs[ROW_RANGE_ATTRS[0]])
                attrs |= dict(zip(ROW_RANGE_ATTRS, (first, first + rows), strict=True))
                variables = _layout(block_variables, rows)
                created = define_variables(file, variables, attrs)
                over_rows = [item.name for item in variables if item.dims[:1] == (ROW,)]
                samples = SequentialWriter(created[item.name] for item in variables if item.grows)
            if int(block.attrs[ROW_RANGE_ATTRS[0]]) != first + written:
                raise ValueError(
                    f"block of row {block.attrs[ROW_RANGE_ATTRS[0]]}: row {first + written} is next"
                )
            values = {item.name: item.values for item in block_variables if item.values is not None}
            start, written = written, written + block.sizes[ROW]
            for name in over_rows:
                created[name][start:written] = values[name]
            samples.put(start, written, values)
        if written != rows:
            raise ValueError(f"{written} rows came, {rows} were expected")
        samples.finish(created)
    seal(path)


def _layout(stored: Iterable[StoredVariable], rows: int) -> list[StoredVariable]:
    """Return the variables of the first block as laid out in a file of `rows` rows.

    A chunk holds rows of one block; the sample dimension grows with them.
    """
    stored = list(stored)
    growing = {item.attrs.get("sample_dimension") for item in stored}
    variables = []
    for item in stored:
        if item.dims[:1] == (ROW,):
            chunks = chunk_shape(item.shape, CHUNK_BYTES // item.dtype.itemsize)
            item = replace(item, shape=(rows, *item.shape[1:]), values=None, chunks=chunks)
        elif growing & set(item.dims):
            max_elements = SAMPLE_CHUNK_BYTES // item.dtype.itemsize
            item = replace(item, values=None, grows=True, chunks=(max_elements, *item.shape[1:]))
        variables.append(item)
    return variables
