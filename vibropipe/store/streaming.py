"""Rows of a sweep written while they are solved: in memory is one block of them, however many there are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibropipe.solve.sweep_grid import SweepGrid
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
"""Of samples, whose number is not known when their file is laid out: the last chunk is never full."""


def write_rows(blocks: Iterable[xr.Dataset], path: str | PathLike[str], rows: int) -> None:
    """Write ``blocks`` of a sweep, ``rows`` rows in all, to the shard ``path``.

    Blocks run over ``row``, follow each other (``row_start``, ``row_stop``) and have the same variables.
    Each is written before the next one is asked for. Raises NotWrittenError as :func:`write`,
    ValueError where rows are missing; ``path`` is then as it was.
    """
    with atomic_file(path) as temporary:
        _stream(blocks, temporary, rows)


def write_grid(blocks: Iterable[xr.Dataset], path: str | PathLike[str], grid: SweepGrid) -> None:
    """Write ``blocks`` of all rows of a sweep as :func:`write_rows` takes them, joined over its grid.

    The file is that of :func:`join`, byte for byte; the rows lie in a scratch file meanwhile.
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
            stored, attrs = encode(block)
            if not created:
                first = int(attrs[ROW_RANGE_ATTRS[0]])
                attrs |= dict(zip(ROW_RANGE_ATTRS, (first, first + rows), strict=True))
                laid_out = _layout(stored, rows)
                created = define_variables(file, laid_out, attrs)
                over_rows = [item.name for item in laid_out if item.dims[:1] == (ROW,)]
                samples = SequentialWriter(created[item.name] for item in laid_out if item.grows)
            if int(block.attrs[ROW_RANGE_ATTRS[0]]) != first + written:
                raise ValueError(
                    f"block of row {block.attrs[ROW_RANGE_ATTRS[0]]}: row {first + written} is next"
                )
            values = {item.name: item.values for item in stored if item.values is not None}
            start, written = written, written + block.sizes[ROW]
            for name in over_rows:
                created[name][start:written] = values[name]
            samples.put(start, written, values)
        if written != rows:
            raise ValueError(f"{written} rows came, {rows} were expected")
        samples.finish(created)
    seal(path)


def _layout(stored: Iterable[StoredVariable], rows: int) -> list[StoredVariable]:
    """Return the variables of the first block as they lie in a file of so many rows.

    A chunk holds rows of one block; the dimension of samples grows with them.
    """
    stored = list(stored)
    growing = {item.attrs.get("sample_dimension") for item in stored}
    laid_out = []
    for item in stored:
        if item.dims[:1] == (ROW,):
            chunks = chunk_shape(item.shape, CHUNK_BYTES // item.dtype.itemsize)
            item = replace(item, shape=(rows, *item.shape[1:]), values=None, chunks=chunks)
        elif growing & set(item.dims):
            most = SAMPLE_CHUNK_BYTES // item.dtype.itemsize
            item = replace(item, values=None, grows=True, chunks=(most, *item.shape[1:]))
        laid_out.append(item)
    return laid_out
