"""Starts of the rows of a sweep, and the exciters at the corners of its grid that they begin in."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.parameters import STARTS, of_effect

if TYPE_CHECKING:
    from vibropipe.solve.rows.many import Start

# Parameters whose own range is all that an exciter checks of them.
ALONE = of_effect("forcing", "damping", "friction", "second_harmonic")


def corners(grid: SweepGrid) -> Iterator[dict[str, float]]:
    """Yield parameters and starts at the corners of a grid and, of tied parameters, each value with its others."""
    clashing = {name: tied for name, tied in grid.tied.items() if name not in ALONE}
    dims = [name for name in grid.values if any(name in of for of, _ in clashing.values())]
    places = np.meshgrid(*(np.arange(len(grid.values[name])) for name in dims), indexing="ij")
    at = dict(zip(dims, (place.ravel() for place in places), strict=True))
    columns = {name: grid.values[name][at[name]] for name in dims if name not in grid.ties.own}
    columns |= {
        name: values[tuple(at[dim] for dim in of)] for name, (of, values) in clashing.items()
    }
    together = np.unique(np.column_stack([*columns.values()]), axis=0).tolist() if columns else [[]]
    others = [name for name in grid.values if name not in (*dims, *grid.ties.own)]
    ends = [{float(grid.values[name].min()), float(grid.values[name].max())} for name in others]
    base = {**grid.shared, **{name: float(tied.flat[0]) for name, (_, tied) in grid.tied.items()}}
    for point, corner in itertools.product(together, itertools.product(*ends)):
        varied = dict(zip((*columns, *others), (*point, *corner), strict=True))
        yield {**base, **varied}


def check_swept_start(over: Mapping[str, Any], x0: Any, v0: Any) -> None:
    """Raise a ParameterError if a part of the start is both swept and given."""
    for name, value in zip(STARTS, (x0, v0), strict=True):
        if name in over and value is not None:
            raise ParameterError(name, value, must=f"must be left out, since {name} is swept")


def check_corners(grid: SweepGrid, x0: float | None, v0: float) -> tuple[float | None, float]:
    """Return the start as floats; ParameterError if a corner of the grid is no valid exciter for it."""
    for given in corners(grid):
        at = given.pop("x0", x0), given.pop("v0", v0)
        Exciter(**given).check_start(*at)
    return None if x0 is None else float(x0), float(v0)


def starts_of_rows(
    grid: SweepGrid, x0: float | None, v0: float, numbers: Callable[[int, int], np.ndarray]
) -> Start | Callable[[int, int], Start]:
    """Return the start of all rows, or the function that returns those of rows, whose numbers a function gives."""
    swept = [name for name in STARTS if name in grid.values]
    if not swept:
        return x0, v0

    def starts(begin: int, stop: int) -> Start:
        columns = grid.parameters(swept, numbers(begin, stop)).T
        each = {"x0": x0, "v0": v0, **dict(zip(swept, columns, strict=True))}
        return each["x0"], each["v0"]

    return starts
