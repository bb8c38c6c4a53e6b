"""Ragged values of a sweep brought into the order of its grid on disk, not in memory.

Shards come in the order of the rows; where a parameter is followed, the grid has another order,
and the impacts of one shard go to many places. They are kept in an unnamed scratch file beside
the joined one (nothing is left of it, whatever happens) and copied from there in order.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from math import prod
from pathlib import Path
from typing import IO

import numpy as np

from vibropipe.store.grid import Grid

__all__ = ["Places", "Scratch"]

ZEROS = bytes(1 << 20)


class Places:
    """Where the samples of each row lie: ``counts`` per row, in the order of the rows."""

    def __init__(self, grid: Grid, counts: Sequence[np.ndarray]) -> None:
        self._counts = np.concatenate(counts)
        in_grid = grid.to_grid(self._counts).reshape(-1)
        ends = np.cumsum(in_grid, dtype=np.int64)
        self.total = int(ends[-1])
        self._starts = grid.to_rows((ends - in_grid).reshape(grid.shape))

    def of_rows(self, start: int, stop: int) -> np.ndarray:
        """Return the place in the grid's order of each sample of the rows [start, stop)."""
        counts, starts = self._counts[start:stop], self._starts[start:stop]
        before = np.cumsum(counts, dtype=np.int64) - counts
        shifts = np.repeat(starts - before, counts)
        return shifts + np.arange(len(shifts))


class Scratch:
    """Values of ragged variables, put at their places shard by shard, then read in order."""

    def __init__(self, folder: Path, shapes: Mapping[str, tuple[tuple[int, ...], np.dtype]]):
        self._shapes = shapes
        self._files: dict[str, IO[bytes]] = {}
        try:
            for name, (shape, dtype) in shapes.items():
                self._files[name] = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
                _reserve(self._files[name], prod(shape) * dtype.itemsize)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Scratch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Drop the files."""
        for file in self._files.values():
            file.close()

    def put(self, name: str, places: np.ndarray, values: np.ndarray) -> None:
        """Keep ``values`` at ``places``."""
        if len(places):
            # mapped for this call only: pages of a long map would count as memory of the process
            self._mapped(name)[places] = values

    def blocks(self, name: str, length: int) -> Iterator[tuple[int, np.ndarray]]:
        """Return the values in order, in blocks of ``length``, each with its start."""
        total = self._shapes[name][0][0]
        for start in range(0, total, length):
            yield start, np.array(self._mapped(name)[start : start + length])

    def _mapped(self, name: str) -> np.ndarray:
        shape, dtype = self._shapes[name]
        return np.memmap(self._files[name], dtype=dtype, mode="r+", shape=shape)


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
