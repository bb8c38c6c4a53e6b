"""The lines of a panel: stable orbits as lines, other rows as marks, arrows where rows were followed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vibropipe.figures.style import rasterise_many
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.legends import DIRECTION_MARKERS, ROW_MARKS
from vibropipe.scenes.sweep.quantities import directions, row_kinds
from vibropipe.solve.sweep_grid import DIRECTION

MANY_POINTS = 200  # marks shrink beyond this
SMALL_MARKS = 0.6
SHORT_RUN = 0.01  # share of a line that is too short for an arrow
ARROWS = 6  # arrows along a whole line that was followed
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """The rows of one value of the parameter of lines, followed in one direction (or in none)."""

    position: int
    row: xr.Dataset
    direction: str
    text: str


def lines_of(part: xr.Dataset, lines_dim: str | None) -> Iterator[Line]:
    """Yield the lines of a panel: for each value of the parameter of lines, its directions."""
    ways = directions(part)
    both = DIRECTION in part["regime"].dims
    for position in range(1 if lines_dim is None else part.sizes[lines_dim]):
        row = part if lines_dim is None else part.isel({lines_dim: position})
        value = "" if lines_dim is None else value_text(part[lines_dim], row[lines_dim].item())
        value = value.rpartition(" = ")[2]
        if not both:
            yield Line(position, row, ways[0] if ways else "", value)
            continue
        for way in ways:
            own = row.sel({DIRECTION: way})
            yield Line(position, own, way, f"{value} {way}".strip())


def draw_line(ax: Axes, x: Floats, y: Floats, row: xr.Dataset, style: dict[str, Any]) -> None:
    """Draw one line, and marks of rows that are no plain orbits."""
    plain = {key: style[key] for key in ("color", "linestyle")}
    for kind, mask in row_kinds(row).items():
        shown = np.where(mask, y, np.nan)
        if kind == "line":
            drawn = ax.plot(x, shown, **plain, zorder=2, label=style["label"] or None)
            alone = isolated(mask & np.isfinite(y))
            drawn += ax.plot(
                x[alone], y[alone], ".", markersize=2.8, color=style["color"], zorder=2
            )
            rasterise_many(drawn, x.size)
        elif np.isfinite(shown).any():
            marks = {**ROW_MARKS[kind], "markeredgecolor": style["color"]}
            marks["markersize"] *= SMALL_MARKS if x.size > MANY_POINTS else 1.0
            at = np.isfinite(shown)
            rasterise_many(ax.plot(x[at], y[at], **marks, zorder=3), x.size)


def branches_differ(values: xr.DataArray) -> NDArray[np.bool_]:
    """Return where rows that were followed up and down have different values."""
    up, down = values.isel({DIRECTION: 0}).values, values.isel({DIRECTION: -1}).values
    return ~np.isclose(up, down, rtol=1e-3, atol=1e-9, equal_nan=True)


def draw_arrows(
    ax: Axes, x: Floats, y: Floats, line: Line, differs: NDArray[np.bool_] | None, colour: str
) -> None:
    """Draw arrows of the direction along a line, only where the directions differ if there are two."""
    kinds = row_kinds(line.row)
    drawn = np.isfinite(y) & (kinds["line"] | kinds["multiple"])
    at = arrow_indices(drawn if differs is None else drawn & differs, line.direction)
    style = {**DIRECTION_MARKERS[line.direction], "markeredgecolor": colour}
    ax.plot(x[at], y[at], **{"markerfacecolor": colour} | style)


def arrow_indices(drawn: NDArray[np.bool_], direction: str) -> NDArray[np.intp]:
    """Return indices of arrows: at least one in each long run of drawn points, apart for the two directions."""
    padded = np.concatenate([[0], drawn, [0]]).astype(np.int8)
    starts, stops = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    shift = 0.35 if direction == "up" else 0.65
    at: list[int] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        length = stop - start
        if length < SHORT_RUN * drawn.size:
            continue
        amount = max(1, round(length / drawn.size * ARROWS))
        at += [start + int((n + shift) / amount * length) for n in range(amount)]
    return np.array(at, np.intp)


def isolated(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which points have no neighbour in a mask, so that a line would not show them."""
    padded = np.concatenate([[False], mask, [False]])
    return mask & ~padded[:-2] & ~padded[2:]
