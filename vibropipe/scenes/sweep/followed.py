"""What the rows of a followed sweep tell: where two motions are stable, and no border of either.

Each row starts from the steady state of the row before. The step of the parameter disturbs it, and the transient may
lead elsewhere although the motion is stable for some steps more: a row where a followed motion is left is no border of
it. The first row of a line starts anew, from the start of the sweep: a change after it is no border of anything.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least, at_most
from vibropipe.figures.text import with_units
from vibropipe.report.findings import point_text, symbol_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.sweep.quantities import directions
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime

# Of two rows in one orbit: they agree within this share of the largest value.
SAME_ORBIT = 1e-6
DIGITS = 6
# Quantities that tell orbits of one regime and period multiple apart, as far as a sweep has them.
COMPARED = ("impacts_per_period", "displacement_amplitude", "displacement_mean")
LEFT_EARLY = (
    "Each step starts a transient, which may leave a motion a step before it ends, and the first row of each line "
    "starts anew: a change between rows is no border of a motion"
)


class Rows(NamedTuple):
    """Neighbouring rows of one line, by the first and the last value of the parameter, and the line in words."""

    low: float
    high: float
    point: str


def is_followed(dataset: xr.Dataset) -> bool:
    """Return whether rows start from the steady states of their neighbours."""
    return bool(directions(dataset))


def differing_rows(dataset: xr.Dataset, axis: str) -> list[Rows]:
    """Return the rows in which both directions are on different stable orbits, the widest range first."""
    if DIRECTION not in dataset["regime"].dims:
        return []
    ordered = dataset.sortby(axis)
    up, down = (ordered.sel({DIRECTION: way}) for way in ("up", "down"))
    differs = (up["regime"] != down["regime"]) | (up["period_multiple"] != down["period_multiple"])
    for name in (name for name in COMPARED if name in dataset):
        change = abs(up[name] - down[name]) > SAME_ORBIT * float(abs(dataset[name]).max())
        extra = [dim for dim in change.dims if dim not in differs.dims]
        differs = differs | change.any(extra)
    for way in (up, down):
        differs = differs & (way["regime"] < Regime.APERIODIC)
        if "stable" in dataset:
            differs = differs & (way["stable"] != 0)
    found = [rows for line in _lines(differs, axis) for rows in line]
    return sorted(found, key=lambda rows: rows.low - rows.high)


def _lines(mask: xr.DataArray, axis: str) -> Iterator[list[Rows]]:
    """Yield the ranges of each line in which a mask is true."""
    others = [str(dim) for dim in mask.dims if dim != axis]
    values = mask[axis].values
    for position in np.ndindex(*(mask.sizes[name] for name in others)):
        line = mask.isel(dict(zip(others, position, strict=True)))
        runs = [list(run) for kept, run in groupby(range(values.size), line.values.item) if kept]
        point = point_text(line, others)
        yield [Rows(float(values[run[0]]), float(values[run[-1]]), point) for run in runs]


def together_answer(dataset: xr.Dataset, axis: str) -> Answer | None:
    """Return in which rows both directions are on different orbits; none if in none or not followed both ways."""
    found = differing_rows(dataset, axis)
    if not found:
        return None
    rows = found[0]
    where = f"{'from' if rows.low < rows.high else 'at'} {range_text(dataset, axis, rows)}"
    widest = "They are in the rows" if len(found) == 1 else "The widest range of such rows is"
    return Answer(
        "Among the motions followed here, at least two are stable together.", f"{widest} {where}."
    )


def range_text(dataset: xr.Dataset, axis: str, rows: Rows) -> str:
    """Write a range of rows, rounded inwards, so that all of them are within it."""
    low, high = at_most(rows.low, DIGITS), with_units(dataset[axis], at_least(rows.high, DIGITS))
    symbol = symbol_text(dataset[axis])
    return f"{symbol} = {low} to {high}" if rows.low < rows.high else f"{symbol} = {high}"
