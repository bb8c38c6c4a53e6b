"""Starts of the rows of a sweep, the same for all rows or swept like parameters."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import Any

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.rows.many import Start
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.parameters import STARTS


def check_swept_start(over: Mapping[str, Any], x0: Any, v0: Any) -> None:
    """Raise a ParameterError if a part of the start is both swept and given."""
    for name, value in zip(STARTS, (x0, v0), strict=True):
        if name in over and value is not None:
            raise ParameterError(name, value, must=f"must be left out, since {name} is swept")


def check_corners(grid: SweepGrid, x0: float | None, v0: float) -> tuple[float | None, float]:
    """Return the start as floats; ParameterError if a corner of the grid is no valid exciter for it."""
    ends = ({float(values.min()), float(values.max())} for values in grid.values.values())
    for corner in itertools.product(*ends):
        given = {**grid.shared, **dict(zip(grid.values, corner, strict=True))}
        at = given.pop("x0", x0), given.pop("v0", v0)
        Exciter(**given).check_start(*at)
    return None if x0 is None else float(x0), float(v0)


def starts_of_rows(
    grid: SweepGrid, x0: float | None, v0: float, row_start: int
) -> Start | Callable[[int, int], Start]:
    """Return the start of all rows, or the function that returns those of rows counted from `row_start`."""
    swept = [name for name in STARTS if name in grid.values]
    if not swept:
        return x0, v0

    def starts(begin: int, stop: int) -> Start:
        columns = grid.parameters(swept, grid.solved(row_start + begin, row_start + stop)).T
        each = {"x0": x0, "v0": v0, **dict(zip(swept, columns, strict=True))}
        return each["x0"], each["v0"]

    return starts
