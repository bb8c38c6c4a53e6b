"""Ragged variables of a sweep brought into the order of its grid, with little memory.

Rows arrive in the order in which they were solved. Where this is the order of the grid, their samples are written
directly. Where a parameter is followed, they are kept in unnamed scratch files beside the joined file (which vanish
whatever happens) and copied from there in order.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from math import prod
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.encoding import StoredVariable
from vibropipe.store.shards import Shard, counts_of

if TYPE_CHECKING:
    import netCDF4

# zeros written at once to reserve space
ZEROS = bytes(1 << 20)
# rows whose positions are computed at once
ROWS_AT_ONCE = 1 << 20


class SequentialWriter:
    """Writer of samples that arrive in the order of the file; each chunk is written once, when full."""

    def __init__(self, variables: Iterable[netCDF4.Variable]) -> None:
        self._variables = {variable.name: variable for variable in variables}
        self._written = dict.fromkeys(self._variables, 0)
        self._waiting = {
            name: np.empty((0, *item.shape[1:]), item.dtype)
            for name, item in self._variables.items()
        }

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Add the samples of the rows [start, stop), which follow the previous ones."""
        for name, variable in self._variables.items():
            waiting = np.concatenate([self._waiting[name], values[name]])
            n_full = len(waiting) - len(waiting) % int(variable.chunking()[0])
            self._write(name, waiting[:n_full])
            self._waiting[name] = waiting[n_full:].copy()

    def finish(self, _created: Mapping[str, netCDF4.Variable]) -> None:
        """Write the last, incomplete chunks."""
        for name, values in self._waiting.items():
            self._write(name, values)

    def _write(self, name: str, values: np.ndarray) -> None:
        """Append samples to a variable."""
        if len(values):
            start = self._written[name]
            self._written[name] = start + len(values)
            self._variables[name][start : start + len(values)] = values


class ReorderingWriter:
    """Writer of samples that arrive in another order than that of the file, kept on disk until all are there.

    `items` are the ragged variables. The positions of the samples of each row are computed first, 8 bytes per row, on
    disk as well; `files` closes the scratch files in `folder`.
    """

    def __init__(
        self,
        items: Sequence[StoredVariable],
        shards: Sequence[Shard],
        grid: SweepGrid,
        folder: Path,
        files: ExitStack,
    ) -> None:
        self._grid, self._items, self._counts = grid, items, shards[0].samples
        self._starts = {
            dim: ScratchArray(files, folder, (grid.rows,), np.dtype(np.int64))
            for dim in self._counts
        }
        for dim, name in self._counts.items():
            self._locate(self._starts[dim], counts_of(shards, name))
        self._kept = {
            item.name: ScratchArray(files, folder, item.shape, item.dtype) for item in items
        }

    def _locate(self, starts: ScratchArray, counts: Iterable[tuple[int, np.ndarray]]) -> None:
        """Compute where the samples of each row begin, from the counts in pieces with their first row."""
        for row, piece in counts:
            starts.scatter(self._grid.points(row, row + len(piece)), piece)
        before = 0
        for at, piece in starts.blocks(ROWS_AT_ONCE):
            ends = before + np.cumsum(piece)
            starts.scatter(slice(at, at + len(piece)), ends - piece)
            before = int(ends[-1])

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Keep the samples of the rows [start, stop)."""
        positions = {}
        for dim, name in self._counts.items():
            counts = values[name]
            first = self._starts[dim].gather(self._grid.points(start, stop))
            shifts = np.repeat(first - (np.cumsum(counts, dtype=np.int64) - counts), counts)
            positions[dim] = shifts + np.arange(len(shifts))
        for item in self._items:
            self._kept[item.name].scatter(positions[item.dims[0]], values[item.name])

    def finish(self, created: Mapping[str, netCDF4.Variable]) -> None:
        """Copy all samples into the file, chunk by chunk."""
        for name, kept in self._kept.items():
            for start, values in kept.blocks(16 * int(created[name].chunking()[0])):
                created[name][start : start + len(values)] = values


class ScratchArray:
    """An array in an unnamed scratch file in `folder`, closed by `files`.

    It is mapped anew in each call: pages of a lasting map would count as memory of the process.
    """

    def __init__(
        self, files: ExitStack, folder: Path, shape: tuple[int, ...], dtype: np.dtype
    ) -> None:
        self._shape, self._dtype = shape, dtype
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
        files.callback(self._file.close)
        _reserve(self._file, prod(shape) * dtype.itemsize)

    def scatter(self, positions: np.ndarray | slice, values: np.ndarray) -> None:
        """Store `values` at `positions`."""
        if len(values):
            self._mapped()[positions] = values

    def gather(self, positions: np.ndarray) -> np.ndarray:
        """Return the values at `positions`."""
        return np.asarray(self._mapped()[positions])

    def blocks(self, length: int) -> Iterator[tuple[int, np.ndarray]]:
        """Yield the values in order, in blocks of `length`, each with its start."""
        for start in range(0, self._shape[0], length):
            yield start, np.array(self._mapped()[start : start + length])

    def _mapped(self) -> np.ndarray:
        """Map the array."""
        return np.memmap(self._file, dtype=self._dtype, mode="r+", shape=self._shape)


def _reserve(file: IO[bytes], length: int) -> None:
    """Reserve `length` bytes on the disk for a file.

    A full disk then raises OSError; without it, writing to the map would kill the process.
    """
    if not length:
        return
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, length)
        return
    for start in range(0, length, len(ZEROS)):
        file.write(ZEROS[: length - start])
    file.flush()
