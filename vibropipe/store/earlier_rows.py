"""Rows of an earlier dataset of a sweep, put among those that are solved for a grid with further values.

Values are taken as they are stored, so a file does not show which of its rows were solved when.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path

import numpy as np

from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store.atomic import StoreError
from vibropipe.store.encoding import Encoded
from vibropipe.store.shards import ROW_RANGE_ATTRS, Shard, Values

# Rows of the earlier file that are read though they are not taken, so that those around them are read at once.
MAX_GAP = 64


class NotTakenError(StoreError):
    """No rows can be taken from an earlier dataset; the message says why."""


@dataclass(frozen=True)
class EarlierRows:
    """Rows of an earlier dataset that are rows of a sweep.

    path : the earlier dataset
    shape : shape of its grid; its rows are in C order
    rows : row in it of each consecutive row of the sweep, -1 for one that is solved (n,); ascending, as both grids do
    """

    path: Path
    shape: tuple[int, ...]
    rows: np.ndarray

    @property
    def n_taken(self) -> int:
        """Number of rows that are taken."""
        return int(np.count_nonzero(self.rows >= 0))

    def merge(
        self, solved: Iterator[Encoded], grid: SweepGrid, start: int, size: int
    ) -> Generator[Encoded]:
        """Yield all rows of the sweep in encoded blocks of `size` rows; memory holds one block, and 8 bytes a row.

        solved : encoded blocks of the rows that are solved, in their order, at least one
        grid : grid of the sweep as it is stored; the first row is its row `start`
        Raises NotTakenError if the earlier dataset does not hold the same variables, or cannot be read.
        """
        items, attrs = next(solved)
        head = Shard.of(self.path, 0, 0, {}, items, grid)
        with closing(_Earlier(self.path, self.shape, head)) as earlier:
            waiting = _row_values((items, attrs), head)
            for begin in range(0, len(self.rows), size):
                rows = self.rows[begin : begin + size]
                new, old = np.flatnonzero(rows < 0), np.flatnonzero(rows >= 0)
                while len(waiting[head.gridded[0].name]) < len(new):
                    waiting = _concatenate([waiting, _row_values(next(solved), head)])
                count = len(waiting[head.gridded[0].name])
                parts = [_select_rows(waiting, head, np.arange(len(new)))]
                waiting = _select_rows(waiting, head, np.arange(len(new), count))
                parts += earlier.read(rows[old], size)
                place = np.argsort(np.concatenate([new, old]))
                values = _select_rows(_concatenate(parts), head, place)
                first, stop = start + begin, start + begin + len(rows)
                swept = grid.parameters(tuple(grid.values), np.arange(first, stop)).T
                values |= dict(zip(grid.values, swept, strict=True))
                block = [replace(i, values=values.get(i.name, i.values)) for i in items]
                yield block, {**attrs, **dict(zip(ROW_RANGE_ATTRS, (first, stop), strict=True))}


class _Earlier:
    """The open file of an earlier dataset, which must have the variables of `head`."""

    def __init__(self, path: Path, shape: tuple[int, ...], head: Shard) -> None:
        import h5py

        self.path, self.shape, self.head = path, shape, head
        with _reading(path):
            # each chunk is read once, or twice if two blocks share it: a cache would only use memory
            self.file = h5py.File(path, "r", rdcc_nbytes=0)
            try:
                # each look-up of a variable takes as long as reading a few rows of it
                self.stored = {name: self.file[name] for name in head.variables}
                self.ends = {
                    dim: np.cumsum(np.ravel(self.stored[name][...]), dtype=np.int64)
                    for dim, name in head.samples.items()
                }
                self._check()
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def _check(self) -> None:
        """Raise NotTakenError unless types and shapes are those of the head, and values that all rows share."""
        gridded, ragged = (
            [i.name for i in items] for items in (self.head.gridded, self.head.ragged)
        )
        for name, item in self.head.variables.items():
            held, shape, shared = self.stored[name], item.shape, b""
            if name in gridded:
                shape = (*self.shape, *shape[1:])
            elif name in ragged:
                shape = (int(self.ends[item.dims[0]][-1]), *shape[1:])
            else:
                shared = np.asarray(item.values).tobytes()
            is_same = (held.shape, held.dtype) == (shape, item.dtype)
            if not is_same or (shared and held[()].tobytes() != shared):
                raise NotTakenError(f"{self.path}: {name} is not stored as it would be now")

    def read(self, rows: np.ndarray, size: int) -> Iterator[Values]:
        """Yield the values of ascending rows; at most `size` of the file are read at once, and no long gaps."""
        for run in np.split(rows, np.flatnonzero(np.diff(rows) > MAX_GAP) + 1):
            while len(run):
                part, run = np.split(run, [np.searchsorted(run, run[0] + size)])
                with _reading(self.path):
                    values = self._consecutive(int(part[0]), int(part[-1]) + 1)
                yield _select_rows(values, self.head, part - part[0])

    def _consecutive(self, start: int, stop: int) -> Values:
        """Return the values of the rows [start, stop)."""
        values = {}
        for item in self.head.gridded:
            boxes = [self.stored[item.name][box] for box in _boxes(self.shape, start, stop)]
            values[item.name] = np.concatenate([b.reshape(-1, *item.shape[1:]) for b in boxes])
        for item in self.head.ragged:
            ends = self.ends[item.dims[0]]
            first = int(ends[start - 1]) if start else 0
            values[item.name] = self.stored[item.name][first : int(ends[stop - 1])]
        return values


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Turn errors of h5py into a NotTakenError that names the file."""
    try:
        yield
    except NotTakenError:
        raise
    except (OSError, RuntimeError, KeyError) as error:
        raise NotTakenError(f"{path}: cannot be read: {error}") from error


def _boxes(shape: tuple[int, ...], start: int, stop: int) -> Iterator[tuple[slice, ...]]:
    """Yield boxes of an array of a shape that together hold its elements [start, stop) in C order, in that order."""
    inner = prod(shape[1:])
    while start < stop:
        first, within = divmod(start, inner)
        if within == 0 and stop - start >= inner:
            last = first + (stop - start) // inner
            yield (slice(first, last), *map(slice, shape[1:]))
            start = last * inner
        else:
            end = min(stop - first * inner, inner)
            for box in _boxes(shape[1:], within, end):
                yield (slice(first, first + 1), *box)
            start = first * inner + end


def _row_values(block: Encoded, head: Shard) -> Values:
    names = {item.name for item in (*head.gridded, *head.ragged)}
    return {item.name: np.asarray(item.values) for item in block[0] if item.name in names}


def _concatenate(parts: list[Values]) -> Values:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _select_rows(values: Mapping[str, np.ndarray], head: Shard, rows: np.ndarray) -> Values:
    """Return some rows, with their samples."""
    # loads numba, which a command that reads only does without
    from vibropipe.solve.rows.label import ragged_indices

    samples = {dim: ragged_indices(values[name], rows) for dim, name in head.samples.items()}
    return {
        **{item.name: values[item.name][rows] for item in head.gridded},
        **{item.name: values[item.name][samples[item.dims[0]]] for item in head.ragged},
    }
