"""The rows of a sweep: their order, their chains, the cuts between them and their positions in the grid.

A sweep is solved row after row, in C order over the swept parameters, except that the followed one varies fastest
wherever it stands among them. Rows that seed each other form a chain, which no cut divides. A sweep followed in both
directions has the further dimension `direction`: all chains up come before all chains down. Datasets keep the order of
the study, after `direction`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, NamedTuple, TypeVar

import numpy as np

from vibropipe.physics.restitution import SUPPORTS, contact_damping
from vibropipe.physics.ties import Ties
from vibropipe.words.parameters import DEFAULTS

Item = TypeVar("Item")
Follow = tuple[str, str] | None

# Name of the dimension of a sweep that is followed in several directions.
DIRECTION = "direction"
# The second part of `follow`, and the directions in which the chains are solved.
DIRECTIONS: Mapping[str, tuple[str, ...]] = {
    "up": ("up",),
    "down": ("down",),
    "both": ("up", "down"),
}


class Block(NamedTuple):
    """Consecutive rows [start, stop) that fill a box of the grid.

    shape : of the box, in the order of the rows
    where : the box in the order of the grid
    """

    start: int
    stop: int
    shape: tuple[int, ...]
    where: tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class SweepGrid:
    """The grid of a sweep and the order of its rows.

    values : of each swept parameter, in the order of the study
    follow : the followed parameter, and a key of `DIRECTIONS`
    shared : the parameters that are the same in every row, beside those that are swept; those that are left out have
        their defaults. A damping of a support that is neither is what stiffness and restitution give in each row
    ties : expressions of further parameters; `values` then has names of one's own, too
    """

    values: Mapping[str, np.ndarray]
    follow: Follow = None
    shared: Mapping[str, float] = field(default_factory=dict)
    ties: Ties = field(default_factory=Ties)

    def __post_init__(self) -> None:
        values = {name: np.array(array) for name, array in self.values.items()}
        for array in values.values():
            array.flags.writeable = False
        object.__setattr__(self, "values", values)
        varied = {*values, *self.ties.parameters}
        shared = {name: value for name, value in self.shared.items() if name not in varied}
        object.__setattr__(self, "shared", shared)
        # What is tied to nothing that is swept is the same in every row.
        shared |= {name: float(tied) for name, (dims, tied) in self._of_ties.items() if not dims}
        for R, k, h in SUPPORTS:
            if h not in (self.varied | shared) and not {R, k} & self.varied.keys():
                damping = contact_damping(self.same(R), self.same(k))
                shared |= {h: damping} if damping else {}
        object.__setattr__(self, "shared", shared)

    @cached_property
    def _of_ties(self) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
        """Each tied parameter over the swept names that it depends on."""
        tied = {}
        for name in self.ties.parameters:
            roots = self.ties.roots[name]
            dims = tuple(each for each in self.values if each in roots)
            grids = np.meshgrid(*(self.values[each] for each in dims), indexing="ij")
            given = {each: self.same(each) for each in roots if each not in dims}
            given |= dict(zip(dims, grids, strict=True))
            tied[name] = dims, np.asarray(self.ties.checked(given, [name])[name])
        return tied

    @cached_property
    def tied(self) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
        """Each parameter that differs from row to row by its ties, over the swept names that it depends on."""
        return {name: (dims, tied) for name, (dims, tied) in self._of_ties.items() if dims}

    @cached_property
    def varied(self) -> dict[str, np.ndarray]:
        """All values (n,) of each name that is swept, and of each parameter that is tied to one."""
        return {**self.values, **{name: values.ravel() for name, (_, values) in self.tied.items()}}

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions in which the chains are solved, in the order of their rows; none without `follow`."""
        return () if self.follow is None else DIRECTIONS[self.follow[1]]

    @cached_property
    def coords(self) -> dict[str, np.ndarray]:
        """Coordinate values of each dimension: `direction` if there are several, then the swept parameters."""
        several = {DIRECTION: np.array(self.directions)} if len(self.directions) > 1 else {}
        return {**several, **self.values}

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(self.coords)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the dimensions."""
        return tuple(len(values) for values in self.coords.values())

    @property
    def rows(self) -> int:
        """Number of rows."""
        return prod(self.shape)

    @property
    def chain_length(self) -> int:
        """Number of rows in a chain, which are solved one after the other, each from the one before."""
        return 1 if self.follow is None else len(self.values[self.follow[0]])

    @property
    def chains(self) -> int:
        """Number of chains, and the largest number of shards."""
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

    def indices(self, rows: Any) -> tuple[Any, ...]:
        """Return the indices of rows along each dimension of the grid."""
        return self.in_grid_order(np.unravel_index(rows, self.row_shape)) if self.dims else ()

    def points(self, start: int, stop: int) -> np.ndarray:
        """Return the flat indices, in C order of the grid, of the rows [start, stop)."""
        indices = self.indices(np.arange(start, stop))
        return np.asarray(np.ravel_multi_index(indices, self.shape))

    def rows_of_points(self, start: int, stop: int) -> np.ndarray:
        """Return the row at each of the points [start, stop) of the grid, points in C order."""
        if not self.dims:
            return np.arange(start, stop)
        indices = np.unravel_index(np.arange(start, stop), self.shape)
        in_rows = tuple(indices[axis] for axis in self.row_axes)
        return np.asarray(np.ravel_multi_index(in_rows, self.row_shape))

    def rows_in(self, other: SweepGrid, start: int, stop: int) -> np.ndarray:
        """Return the rows of another grid with the values of the rows [start, stop) to the last bit, -1 where none has.

        Both grids sweep the same parameters in the same order, and follow none.
        """
        places = zip(self.values.values(), other.values.values(), strict=True)
        at = zip(places, self.indices(np.arange(start, stop)), strict=True)
        found = np.array([_places(*both)[index] for both, index in at])
        rows = np.ravel_multi_index(tuple(np.maximum(found, 0)), other.shape)
        return np.where(found.min(axis=0) < 0, -1, rows)

    def parameters(self, names: Sequence[str], rows: np.ndarray) -> np.ndarray:
        """Return the values (rows, names) of parameters, swept or shared, of the given rows."""
        indices = dict(zip(self.dims, self.indices(rows), strict=True))

        def values(name: str) -> Any:
            if name in self.of_restitution:
                R, k, _h = next(support for support in SUPPORTS if name in support)
                return contact_damping(values(R), values(k))
            if name in self.tied:
                dims, tied = self.tied[name]
                return tied[tuple(indices[dim] for dim in dims)]
            return self.values[name][indices[name]] if name in indices else self.same(name)

        columns = np.empty((len(rows), len(names)))
        for column, name in enumerate(names):
            columns[:, column] = values(name)
        return columns

    @cached_property
    def of_restitution(self) -> tuple[str, ...]:
        """Dampings of supports that follow from a restitution or a stiffness that differs from row to row."""
        given = self.varied.keys() | self.shared.keys()

        def differs(name: str) -> bool:
            values = self.varied[name] if name in self.varied else self.same(name)
            return bool(np.any(values != DEFAULTS[name]))

        return tuple(
            h
            for R, k, h in SUPPORTS
            if h not in given and {R, k} & self.varied.keys() and differs(R) and differs(k)
        )

    @property
    def following(self) -> tuple[str, ...]:
        """Parameters that differ from row to row with those that are swept."""
        return (*self.of_restitution, *self.tied)

    def row_coords(self, rows: np.ndarray) -> dict[str, tuple[Any, np.ndarray]]:
        """Return the parameters of rows as coordinates: shared ones as scalars, swept over `row`."""
        names = list(self.values)
        swept = self.parameters(names, rows)
        shared = {name: ((), np.array(value)) for name, value in self.shared.items()}
        return shared | {name: ("row", swept[:, column]) for column, name in enumerate(names)}

    def same(self, name: str) -> float:
        """Return the value of a parameter that is the same in every row."""
        return self.shared[name] if name in self.shared else DEFAULTS[name]

    def text(self, row: int) -> str:
        """Return the coordinates of a row as text."""
        values = zip(self.coords.items(), self.indices(row), strict=True)
        return ", ".join(f"{name} = {array[index].item()}" for (name, array), index in values)

    def cuts(self, shards: int) -> list[int]:
        """Return the ends of shards of nearly equal length: shard I, from 1, has the rows [ends[I - 1], ends[I])."""
        return [shard * self.chains // shards * self.chain_length for shard in range(shards + 1)]

    def solved(self, start: int, stop: int) -> np.ndarray:
        """Return the rows in the order in which they are solved, from position `start` to `stop` - 1.

        A chain is solved in its direction: for whole chains the result is a permutation of the rows [start, stop).
        """
        positions = np.arange(start, stop)
        in_chain = positions % self.chain_length
        direction = positions * len(self._along) // self.rows
        return positions - in_chain + self._along[direction, in_chain]

    @cached_property
    def _along(self) -> np.ndarray:
        """Positions in a chain in the order in which they are solved, shape (directions, chain_length)."""
        if self.follow is None:
            return np.zeros((1, 1), int)
        upwards = np.argsort(self.values[self.follow[0]])
        return np.array([upwards if way == "up" else upwards[::-1] for way in self.directions])

    def blocks(self, box: tuple[int, ...]) -> Iterator[Block]:
        """Cut the grid into boxes of shape `box` and yield them in the order of the rows."""
        shape, start = self.row_shape, 0
        for corner in product(*(range(0, n, step) for n, step in zip(shape, box, strict=True))):
            ends = tuple(map(min, map(sum, zip(corner, box, strict=True)), shape))
            sizes = tuple(end - begin for begin, end in zip(corner, ends, strict=True))
            where = self.in_grid_order(tuple(map(slice, corner, ends)))
            yield Block(start, start + prod(sizes), sizes, where)
            start += prod(sizes)

    def to_box(self, block: Block, values: np.ndarray) -> np.ndarray:
        """Return `values` (rows first) of a block as the box `block.where` of the grid."""
        boxed = values.reshape(*block.shape, *values.shape[1:])
        return boxed.transpose(*self._row_positions, *range(len(self.dims), boxed.ndim))

    @cached_property
    def _row_positions(self) -> tuple[int, ...]:
        """For each axis of the grid, its position in the order of the rows."""
        return tuple(self.row_axes.index(axis) for axis in range(len(self.dims)))

    def in_grid_order(self, items: tuple[Item, ...]) -> tuple[Item, ...]:
        """Return items of the dimensions, given in the order of the rows, in the order of the grid."""
        return tuple(items[position] for position in self._row_positions)


def _places(values: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Return the index of each value among others, to the last bit (0.0 is not -0.0); -1 where it is not there."""
    bits, others = (np.asarray(array, float).view(np.int64) for array in (values, among))
    known, index = np.unique(others, return_index=True)
    at = np.minimum(np.searchsorted(known, bits), len(known) - 1)
    return np.where(known[at] == bits, index[at], -1)
