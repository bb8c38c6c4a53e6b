"""Ragged values of a sweep brought into the order of its grid, with little in memory.

Rows come in the order in which they were solved. Where that is the order of the grid, their
samples follow each other in the file too. Where a parameter is followed, they may not: they are
then kept in unnamed scratch files beside the joined one (nothing is left of them, whatever
happens) and copied from there in order.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from math import prod
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from vibropipe.store.grid import Grid

if TYPE_CHECKING:
    import netCDF4

__all__ = ["InOrder", "OnDisk", "Places", "Turned"]

ZEROS = bytes(1 << 20)
AT_ONCE = 1 << 20


class InOrder:
    """Samples that lie in the order in which they come: each chunk is written once, when full.

    ``created`` are the variables to fill, by name.
    """

    def __init__(self, created: Mapping[str, netCDF4.Variable]) -> None:
        self._created = created
        self._written = dict.fromkeys(created, 0)
        self._waiting: dict[str, list[np.ndarray]] = {name: [] for name in created}

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Take the samples of the rows [start, stop), which come in order."""
        for name, variable in self._created.items():
            waiting = np.concatenate([*self._waiting[name], values[name]])
            whole = len(waiting) - len(waiting) % int(variable.chunking()[0])
            self._write(name, waiting[:whole])
            self._waiting[name] = [waiting[whole:].copy()]

    def finish(self) -> None:
        """Write the last chunks, which are not full."""
        for name, waiting in self._waiting.items():
            for values in waiting:
                self._write(name, values)

    def _write(self, name: str, values: np.ndarray) -> None:
        if len(values):
            start = self._written[name]
            self._written[name] = start + len(values)
            self._created[name][start : start + len(values)] = values


class Turned:
    """Samples that come in another order than they lie in: kept on disk until all are there.

    ``counts`` gives, for the sample dimension of each variable, the name of its count per row and
    the places of its samples.
    """

    def __init__(
        self,
        created: Mapping[str, netCDF4.Variable],
        counts: Mapping[str, tuple[str, Places]],
        scratch: Mapping[str, OnDisk],
    ) -> None:
        self._created, self._counts, self._scratch = created, counts, scratch

    def put(self, start: int, stop: int, values: Mapping[str, np.ndarray]) -> None:
        """Take the samples of the rows [start, stop)."""
        where = {
            dim: places.of_rows(start, stop, values[count])
            for dim, (count, places) in self._counts.items()
        }
        for name, variable in self._created.items():
            self._scratch[name].scatter(where[variable.dimensions[0]], values[name])

    def finish(self) -> None:
        """Copy all samples into the file, chunk by chunk."""
        for name, variable in self._created.items():
            for start, values in self._scratch[name].blocks(16 * int(variable.chunking()[0])):
                variable[start : start + len(values)] = values


class Places:
    """Where the samples of each row lie in the order of the grid; 8 bytes per row, on disk.

    ``counts`` gives the number of samples of each row, in pieces that begin at the row given.
    """

    def __init__(
        self, grid: Grid, starts: OnDisk, counts: Iterable[tuple[int, np.ndarray]]
    ) -> None:
        self._grid, self._starts = grid, starts
        for row, piece in counts:
            starts.scatter(grid.in_grid(row, row + len(piece)), piece)
        before = 0
        for at, piece in starts.blocks(AT_ONCE):
            ends = before + np.cumsum(piece)
            starts.scatter(slice(at, at + len(piece)), ends - piece)
            before = int(ends[-1])

    def of_rows(self, start: int, stop: int, counts: np.ndarray) -> np.ndarray:
        """Return the place of each sample of the rows [start, stop), which have ``counts``."""
        starts = self._starts.gather(self._grid.in_grid(start, stop))
        before = np.cumsum(counts, dtype=np.int64) - counts
        shifts = np.repeat(starts - before, counts)
        return shifts + np.arange(len(shifts))


class OnDisk:
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
