"""The nearest border of regimes: how far it is, and what lies beyond it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibropipe.figures.claims import between_text
from vibropipe.figures.map_shapes import scale_of
from vibropipe.figures.regime_words import regime_text
from vibropipe.figures.text import sentences
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.view.plane import Plane
from vibropipe.view.words import number, symbol, value_of

ROUNDING = 1e-12  # of half-way points, relative to the length of their axis


class Border(NamedTuple):
    """The nearest place between rows of two regimes: its point, the code beyond, and both rows along which axis."""

    at: tuple[float, ...]
    beyond: int
    axis: int
    rows: tuple[float, float]


def _rounded(value: float, length: float) -> float:
    """Return a value on an axis of a length; one that is 0 but for rounding as 0."""
    return 0.0 if abs(value) < ROUNDING * length else value


def regime_codes(plane: Plane) -> tuple[NDArray[np.int64], Callable[[int], str]]:
    """Return the code of each row of a plane, whatever its orbit, and the text of a code."""
    if plane.of_starts:
        return plane.codes(), lambda code: plane.regions[code].text
    codes = plane.at_further(plane.dataset["regime"]).astype(np.int64)
    return codes, regime_text


def first_step(plane: Plane, axis: int) -> int:
    """Return the index of the step from the first row of followed lines, which starts anew; -1 along other axes."""
    along, _, way = str(plane.dataset.attrs.get("follow", "")).partition(" ")
    if along != plane.axes[axis]:
        return -1
    if DIRECTION in plane.further:
        way = str(plane.dataset[DIRECTION].values[plane.further[DIRECTION]])
    values = plane.values[axis]
    return 0 if (way == "up") == (values[0] < values[-1]) else values.size - 2


class Borders:
    """The places half-way between neighbouring rows of different regimes.

    A followed line starts anew in its first row: what lies between it and the next one is no border. Distances count
    each axis in shares of its length, on its own scale.
    """

    def __init__(self, plane: Plane) -> None:
        codes, self.text = regime_codes(plane)
        self._of_starts = plane.of_starts
        self._arrays = [plane.dataset[name] for name in plane.axes]
        self._values = [np.asarray(values, float) for values in plane.values]
        self._logs = [scale_of(values) == "log" for values in plane.values]
        grids = [np.log(v) if log else v for v, log in zip(plane.values, self._logs, strict=True)]
        self._length = np.array([np.ptp(grid) or 1.0 for grid in grids])
        self._codes, self._grids = codes, grids
        places, sides, steps = [], [], []
        for axis, grid in enumerate(grids):
            along = codes.ndim - 1 - axis
            first = np.take(codes, np.arange(grid.size - 1), along)
            second = np.take(codes, np.arange(1, grid.size), along)
            index = np.nonzero(first != second)
            sides.append(np.stack([first[index], second[index]], axis=1))
            columns = [each[index[codes.ndim - 1 - n]] for n, each in enumerate(grids)]
            kept = index[along] != first_step(plane, axis)
            index, columns = tuple(each[kept] for each in index), [each[kept] for each in columns]
            sides[-1] = sides[-1][kept]
            step = index[along]
            columns[axis] = 0.5 * (grid[step] + grid[step + 1])
            places.append(np.stack(columns, axis=1))
            steps.append(np.stack([np.full_like(step, axis), step], axis=1))
        self._places, self._sides = np.concatenate(places), np.concatenate(sides)
        self._steps = np.concatenate(steps)

    def nearest(self, at: tuple[int, ...]) -> Border | None:
        """Return the nearest border of the row at indices of the axes; None if there is none."""
        if not self._places.size:
            return None
        here = np.array([grid[n] for grid, n in zip(self._grids, at, strict=True)])
        best = int(np.argmin((((self._places - here) / self._length) ** 2).sum(axis=1)))
        own = self._codes[tuple(reversed(at))]
        first, second = self._sides[best]
        place = [
            float(np.exp(value)) if log else _rounded(float(value), float(length))
            for value, log, length in zip(self._places[best], self._logs, self._length, strict=True)
        ]
        axis, step = map(int, self._steps[best])
        rows = self._values[axis][step], self._values[axis][step + 1]
        return Border(tuple(place), int(second if first == own else first), axis, rows)

    def sentence(self, at: tuple[int, ...], point: tuple[float, ...]) -> str:
        """Write between which rows the nearest border of a row lies, and the way to it along other axes."""
        border = self.nearest(at)
        if border is None:
            if np.unique(self._codes).size > 1 or (self._of_starts and self._codes.flat[0] < 0):
                return "No border is known."
            if self._of_starts:
                return "All starts shown have one attractor."
            return "All rows shown have one regime."
        ways = [between_text(self._arrays[border.axis], *border.rows)]
        ways += [
            f"{symbol(array)} = {value_of(array, there, 4)} "
            f"({'−' if there < here else '+'}{number(abs(there - here), 2)})"
            for axis, (array, there, here) in enumerate(
                zip(self._arrays, border.at, point, strict=True)
            )
            if there != here and axis != border.axis
        ]
        return sentences(f"Nearest border: {self.text(border.beyond)}, {', '.join(ways)}")
