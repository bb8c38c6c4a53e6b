"""The rows of a sweep: their order, the chains in which they are followed, the cuts, and their places in the grid.

A sweep is solved row after row: C order over the swept parameters, except that the followed one varies fastest,
whatever its place among them. Rows that seed each other are a chain, which no cut divides. Datasets keep the order
of the study.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, NamedTuple, TypeVar

import numpy as np

Item = TypeVar("Item")
Follow = tuple[str, str] | None

DIRECTIONS = ("up", "down")
# Rows per call of the driver: few enough for a word of progress and Ctrl-C, many enough that calls cost nothing.
# Towards the end a share of what is left, and ever fewer, so that threads end together.
ROWS_PER_CALL, MIN_ROWS_PER_CALL, TAIL_FRACTION = 256, 64, 4


class Block(NamedTuple):
    """Consecutive rows [start, stop) that fill a box of the grid.

    `shape` is that of the box in the order of the rows, `where` the box in the order of the grid.
    """

    start: int
    stop: int
    shape: tuple[int, ...]
    where: tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class SweepGrid:
    """The grid of a sweep and all that depends on the order of its rows.

    Parameters
    ----------
    values : mapping of str to np.ndarray
        Values of each swept parameter, in the order of the study.
    follow : (str, str), optional
        The followed parameter and the direction in which it is followed, one of `DIRECTIONS`.
    shared : mapping of str to float, optional
        The parameters that are the same in every row.
    """

    values: Mapping[str, np.ndarray]
    follow: Follow = None
    shared: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        values = {name: np.array(array) for name, array in self.values.items()}
        for array in values.values():
            array.flags.writeable = False
        object.__setattr__(self, "values", values)

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Names of the swept parameters, in the order of the study."""
        return tuple(self.values)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Sizes in the order of the study."""
        return tuple(len(values) for values in self.values.values())

    @property
    def rows(self) -> int:
        """Number of rows."""
        return prod(self.shape)

    @property
    def chain_length(self) -> int:
        """Rows that are solved one after the other, each seeded by the one before."""
        return 1 if self.follow is None else len(self.values[self.follow[0]])

    @property
    def chains(self) -> int:
        """Number of chains; more shards than that there cannot be."""
        return self.rows // self.chain_length

    @cached_property
    def row_axes(self) -> tuple[int, ...]:
        """For each dimension in the order of the rows, its axis in the grid."""
        axes = list(range(len(self.dims)))
        if self.follow is not None:
            axes.append(axes.pop(self.dims.index(self.follow[0])))
        return tuple(axes)

    @cached_property
    def row_shape(self) -> tuple[int, ...]:
        """Sizes in the order of the rows."""
        return tuple(self.shape[axis] for axis in self.row_axes)

    @property
    def in_order(self) -> bool:
        """Whether rows count in the order of the grid."""
        return self.row_axes == tuple(range(len(self.dims)))

    def indices(self, rows: Any) -> tuple[Any, ...]:
        """Return the index of numbered rows along each dimension of the grid."""
        return self.in_grid_order(np.unravel_index(rows, self.row_shape))

    def points(self, start: int, stop: int) -> np.ndarray:
        """Return the place of each of the rows [start, stop) in C order of the grid."""
        places = self.indices(np.arange(start, stop))
        return np.asarray(np.ravel_multi_index(places, self.shape))

    def rows_of_points(self) -> np.ndarray:
        """Return the row at each point of the grid, points in C order."""
        return np.arange(self.rows).reshape(self.row_shape).transpose(self._places).ravel()

    def parameters(self, names: Sequence[str], rows: np.ndarray) -> np.ndarray:
        """Return the values (rows, names) of parameters, swept or shared, in numbered rows."""
        places = dict(zip(self.dims, self.indices(rows), strict=True))
        columns = np.empty((len(rows), len(names)))
        for column, name in enumerate(names):
            swept = name in places
            columns[:, column] = self.values[name][places[name]] if swept else self.shared[name]
        return columns

    def text(self, row: int) -> str:
        """Return the swept parameters of a row in words."""
        values = zip(self.values.items(), self.indices(row), strict=True)
        return ", ".join(f"{name} = {float(array[at])!r}" for (name, array), at in values)

    def cuts(self, shards: int) -> list[int]:
        """Return the ends of so many shards of about as many rows: shard I, from 1, has [ends[I - 1], ends[I])."""
        return [shard * self.chains // shards * self.chain_length for shard in range(shards + 1)]

    def is_cut(self, start: int, stop: int) -> bool:
        """Whether the rows [start, stop) are whole chains of the sweep."""
        length = self.chain_length
        return 0 <= start < stop <= self.rows and start % length == stop % length == 0

    def solved(self, start: int, stop: int) -> np.ndarray:
        """Return the rows that are solved as number `start` to `stop` - 1 of all.

        A chain is solved in the direction in which it is followed: for whole chains these are the rows
        [start, stop) in another order.
        """
        numbers = np.arange(start, stop)
        return numbers - numbers % self.chain_length + self._along[numbers % self.chain_length]

    @cached_property
    def _along(self) -> np.ndarray:
        """Places in a chain in the order in which they are solved."""
        if self.follow is None:
            return np.zeros(1, int)
        order = np.argsort(self.values[self.follow[0]])
        return order if self.follow[1] == "up" else order[::-1]

    def blocks(self, box: tuple[int, ...]) -> Iterator[Block]:
        """Cut the grid into boxes of shape `box`, in the order of the rows, and return them in that order."""
        shape, start = self.row_shape, 0
        for corner in product(*(range(0, n, size) for n, size in zip(shape, box, strict=True))):
            ends = tuple(map(min, map(sum, zip(corner, box, strict=True)), shape))
            sizes = tuple(end - first for first, end in zip(corner, ends, strict=True))
            where = self.in_grid_order(tuple(map(slice, corner, ends)))
            yield Block(start, start + prod(sizes), sizes, where)
            start += prod(sizes)

    def place(self, block: Block, values: np.ndarray) -> np.ndarray:
        """Return `values` (rows first) of a block as the box `block.where` of the grid."""
        boxed = values.reshape(*block.shape, *values.shape[1:])
        return boxed.transpose(*self._places, *range(len(self.dims), boxed.ndim))

    @cached_property
    def _places(self) -> tuple[int, ...]:
        """For each axis of the grid, its place in the order of the rows."""
        return tuple(self.row_axes.index(axis) for axis in range(len(self.dims)))

    def in_grid_order(self, items: tuple[Item, ...]) -> tuple[Item, ...]:
        """Bring what stands for each dimension from the order of the rows to that of the grid."""
        return tuple(items[place] for place in self._places)


def row_blocks(
    rows: int, chain_length: int = 1, block_rows: int | None = None
) -> list[list[list[int]]]:
    """Cut rows into blocks, and these into pieces that are solved side by side; the same for any number of threads.

    Parameters
    ----------
    rows, chain_length : int
        Rows in whole chains, and those of a chain.
    block_rows : int, optional
        Rows that a block has at least; all if left out.

    Returns
    -------
    list of list of list of int
        For each block, for each of its pieces, the ends of the calls that solve it one after the other: whole
        chains that one call takes, or parts of one chain that is longer than that.
    """
    blocks: list[list[list[int]]] = []
    first = begin = 0
    while first < rows:
        most = min(ROWS_PER_CALL, max(MIN_ROWS_PER_CALL, (rows - first) // TAIL_FRACTION))
        stop = min(rows, first + max(1, most // chain_length) * chain_length)
        if not blocks or first - begin >= (rows if block_rows is None else block_rows):
            blocks.append([])
            begin = first
        blocks[-1].append([*range(first, stop, ROWS_PER_CALL), stop])
        first = stop
    return blocks
