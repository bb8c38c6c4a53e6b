"""Ragged values of a sweep brought into the order of its grid, with little in memory.

Rows come in the order in which they were solved. Where that is the order of the grid, their
samples follow each other in the file too. Where a parameter is followed, they may not: they are
then kept in unnamed scratch files beside the joined one (nothing is left of them, whatever
happens) and copied from there in order.
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

from vibropipe.solve.sweep_grid import SweepGrid
from vibropipe.store.encoding import StoredVariable
from vibropipe.store.shards import Shard, counts_of

if TYPE_CHECKING:
    import netCDF4

ZEROS = bytes(1 << 20)
AT_ONCE = 1 << 20


class SequentialWriter:
    """Samples that lie in the order in which they come: each chunk of `variables` is written once, when full."""

    def __init__(self, variables: Iterable[netCDF4.Variable]) -> None:
        self._variables = {variable.name: variable for variable in variables}
        self._written = dict.fromkeys(self._variables, 0)
        self._waiting = {
            name: np.empty((0, *item.shape[1:]), item.dtype)
            for name, item in self._variables.items()
        }

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Take the samples of the rows [start, stop), which come in order."""
        for name, variable in self._variables.items():
            waiting = np.concatenate([self._waiting[name], values[name]])
            whole = len(waiting) - len(waiting) % int(variable.chunking()[0])
            self._write(name, waiting[:whole])
            self._waiting[name] = waiting[whole:].copy()

    def finish(self, _created: Mapping[str, netCDF4.Variable]) -> None:
        """Write the last chunks, which are not full."""
        for name, values in self._waiting.items():
            self._write(name, values)

    def _write(self, name: str, values: np.ndarray) -> None:
        if len(values):
            start = self._written[name]
            self._written[name] = start + len(values)
            self._variables[name][start : start + len(values)] = values


class ReorderingWriter:
    """Samples that come in another order than they lie in: kept on disk until all are there.

    `items` are the variables that they fill. Where the samples of each row lie is counted first, 8 bytes a row, on
    disk too; `files` closes all that is made in `folder`.
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
        """Find where the samples of each row begin, from their number in each, in pieces with their first row."""
        for row, piece in counts:
            starts.scatter(self._grid.points(row, row + len(piece)), piece)
        before = 0
        for at, piece in starts.blocks(AT_ONCE):
            ends = before + np.cumsum(piece)
            starts.scatter(slice(at, at + len(piece)), ends - piece)
            before = int(ends[-1])

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Take the samples of the rows [start, stop)."""
        places = {}
        for dim, name in self._counts.items():
            counts = values[name]
            first = self._starts[dim].gather(self._grid.points(start, stop))
            shifts = np.repeat(first - (np.cumsum(counts, dtype=np.int64) - counts), counts)
            places[dim] = shifts + np.arange(len(shifts))
        for item in self._items:
            self._kept[item.name].scatter(places[item.dims[0]], values[item.name])

    def finish(self, created: Mapping[str, netCDF4.Variable]) -> None:
        """Copy all samples into the file, chunk by chunk."""
        for name, kept in self._kept.items():
            for start, values in kept.blocks(16 * int(created[name].chunking()[0])):
                created[name][start : start + len(values)] = values


class ScratchArray:
    """An array in an unnamed scratch file in ``folder``; ``files`` closes it.

    It is mapped for each call alone: pages of a long map would count as memory of the process.
    """

    def __init__(
        self, files: ExitStack, folder: Path, shape: tuple[int, ...], dtype: np.dtype
    ) -> None:
        self._shape, self._dtype = shape, dtype
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
        files.callback(self._file.close)
        _reserve(self._file, prod(shape) * dtype.itemsize)

    def scatter(self, places: np.ndarray | slice, values: np.ndarray) -> None:
        """Keep ``values`` at ``places``."""
        if len(values):
            self._mapped()[places] = values

    def gather(self, places: np.ndarray) -> np.ndarray:
        """Return the values at ``places``."""
        return np.asarray(self._mapped()[places])

    def blocks(self, length: int) -> Iterator[tuple[int, np.ndarray]]:
        """Return the values in order, in blocks of ``length``, each with its start."""
        for start in range(0, self._shape[0], length):
            yield start, np.array(self._mapped()[start : start + length])

    def _mapped(self) -> np.ndarray:
        return np.memmap(self._file, dtype=self._dtype, mode="r+", shape=self._shape)


def _reserve(file: IO[bytes], length: int) -> None:
    """Make a file ``length`` bytes long and take its room on the disk now.

    On a full disk this raises OSError; without it, writing to the map would kill the process.
    """
    if not length:
        return
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, length)
        return
    for start in range(0, length, len(ZEROS)):
        file.write(ZEROS[: length - start])
    file.flush()
