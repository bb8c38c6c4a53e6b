"""The rows of a sweep and their places in its grid.

A sweep is solved row after row: C order over the swept dimensions, except that the followed one
varies fastest, whatever its place. The grid keeps the order of the study.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import TypeVar

import numpy as np

from vibropipe.store.encoding import chunk_shape

__all__ = ["Block", "Grid"]

Item = TypeVar("Item")


@dataclass(frozen=True)
class Block:
    """Consecutive rows that fill a box of the grid."""

    start: int
    stop: int
    shape: tuple[int, ...]
    """Shape of the box in the order of the rows."""
    where: tuple[slice, ...]
    """The box in the order of the grid."""


@dataclass(frozen=True)
class Grid:
    """The swept dimensions, in the order of the study, and the followed one (or None)."""

    values: Mapping[str, np.ndarray]
    follow: str | None = None

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the swept dimensions in the order of the grid."""
        return tuple(self.values)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the swept dimensions in the order of the grid."""
        return tuple(len(values) for values in self.values.values())

    @property
    def rows(self) -> int:
        """Number of rows."""
        return prod(self.shape)

    @cached_property
    def row_axes(self) -> tuple[int, ...]:
        """For each dimension in the order of the rows, its axis in the grid."""
        axes = list(range(len(self.dims)))
        if self.follow is not None:
            axes.append(axes.pop(self.dims.index(self.follow)))
        return tuple(axes)

    @property
    def in_order(self) -> bool:
        """Whether rows are solved in the order of the grid."""
        return self.row_axes == tuple(range(len(self.dims)))

    @property
    def row_shape(self) -> tuple[int, ...]:
        """Sizes in the order of the rows."""
        return tuple(self.shape[axis] for axis in self.row_axes)

    def coordinate(self, name: str, start: int, stop: int) -> np.ndarray:
        """Return the value of the swept parameter ``name`` in each of the rows [start, stop)."""
        places = np.unravel_index(np.arange(start, stop), self.row_shape)
        return self.values[name][places[self.row_axes.index(self.dims.index(name))]]

    def chunks(self, most: int) -> tuple[int, ...]:
        """Return the shape, in the order of the grid, of a block of at most ``most`` rows."""
        return self._ordered(chunk_shape(self.row_shape, most))

    def blocks(self, most: int) -> Iterator[Block]:
        """Cut the grid into blocks of at most ``most`` rows, in the order of the rows."""
        shape = self.row_shape
        sizes = chunk_shape(shape, most)
        corners = product(*(range(0, n, size) for n, size in zip(shape, sizes, strict=True)))
        start = 0
        for corner in corners:
            ends = tuple(map(min, map(sum, zip(corner, sizes, strict=True)), shape))
            box = tuple(end - first for first, end in zip(corner, ends, strict=True))
            where = self._ordered(tuple(map(slice, corner, ends)))
            yield Block(start, start + prod(box), box, where)
            start += prod(box)

    def place(self, block: Block, values: np.ndarray) -> np.ndarray:
        """Return ``values`` (rows first) of a block as the box ``block.where`` of the grid."""
        boxed = values.reshape(*block.shape, *values.shape[1:])
        trailing = range(len(self.dims), boxed.ndim)
        return boxed.transpose(*self._places, *trailing)

    def in_grid(self, start: int, stop: int) -> np.ndarray:
        """Return the place of each of the rows [start, stop) in C order of the grid."""
        places = np.unravel_index(np.arange(start, stop), self.row_shape)
        return np.asarray(np.ravel_multi_index(self._ordered(places), self.shape))

    @cached_property
    def _places(self) -> tuple[int, ...]:
        """For each axis of the grid, its place in the order of the rows."""
        return tuple(self.row_axes.index(axis) for axis in range(len(self.dims)))

    def _ordered(self, items: tuple[Item, ...]) -> tuple[Item, ...]:
        """Bring ``items`` from the order of the rows to the order of the grid."""
        return tuple(items[place] for place in self._places)
