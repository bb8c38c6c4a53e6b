"""The lines of a panel: orbits as lines with breaks at jumps, other rows as marks, jumps of followed rows as arrows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vibropipe.figures.canvas import arrow, size_of
from vibropipe.figures.style import rasterise_many
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.jumps import jump_steps
from vibropipe.scenes.sweep.quantities import directions, row_kinds
from vibropipe.solve.sweep.sweep_grid import DIRECTION

Floats = NDArray[np.float64]
MARKS_PER_CM = 5.0  # of a kind of rows along a line
MAX_JUMPS = 4  # jumps of a line that have arrows; through chaos there are dozens
DIRECTION_SIGNS = {"up": "↑", "down": "↓"}
ROW_MARKS: dict[str, dict[str, Any]] = {
    "multiple": {"marker": "o", "markersize": 2.6, "markerfacecolor": "white", "markeredgewidth": 0.6},
    "unstable": {"marker": "x", "markersize": 3.0, "markeredgewidth": 0.7},
    "no_orbit": {"marker": ".", "markersize": 2.4, "markeredgewidth": 0.0},
}  # fmt: skip


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
            yield Line(position, own, way, f"{value} {DIRECTION_SIGNS[way]}".strip())


def draw_line(
    ax: Axes, x: Floats, y: Floats, line: Line, style: dict[str, Any], arrows: bool, steps: bool
) -> None:
    """Draw one line: orbits of any number of periods, broken at jumps, and marks of rows that are no plain orbits.

    The line of a number that is counted (`steps`) is broken at each change.
    """
    kinds, colour = row_kinds(line.row), style["color"]
    orbit = (kinds["line"] | kinds["multiple"]) & np.isfinite(y)
    shown = np.where(orbit, y, np.nan)
    jumps = (
        np.flatnonzero(np.diff(shown)) if steps else jump_steps(x, shown, line.row["regime"].values)
    )
    broken_y = np.insert(shown, jumps + 1, np.nan)
    drawn = ax.plot(np.insert(x, jumps + 1, x[jumps]), broken_y, **style, zorder=2)
    broken = np.zeros(x.size, np.bool_)
    broken[jumps] = True
    alone = isolated(orbit, broken)
    drawn += ax.plot(x[alone], y[alone], ".", markersize=2.4, color=colour, zorder=2)
    rasterise_many(drawn, x.size)
    for kind, marks in ROW_MARKS.items():
        at = np.flatnonzero(kinds[kind] & np.isfinite(y))
        if at.size:
            at = at if kind == "no_orbit" else thinned(ax, at, x.size)
            own = {**marks, "color": colour, "linestyle": "none", "zorder": 3}
            rasterise_many(ax.plot(x[at], y[at], **own), x.size)
    if arrows and not steps and line.direction and jumps.size <= MAX_JUMPS:
        draw_jumps(ax, x, y, jumps, line.direction, colour)


def draw_jumps(
    ax: Axes, x: Floats, y: Floats, jumps: NDArray[np.intp], direction: str, colour: str
) -> None:
    """Draw each jump as a dashed arrow in the direction in which the rows were followed."""
    for n in jumps.tolist():
        start, end = (n, n + 1) if direction == "up" else (n + 1, n)
        arrow(ax, (x[start], y[start]), (x[end], y[end]), colour, linestyle=(0, (2, 1.2)), lw=0.7)


def thinned(ax: Axes, at: NDArray[np.intp], size: int) -> NDArray[np.intp]:
    """Return as many of the rows as have room along a line for their marks, at least the first one of each range."""
    step = max(1, int(np.ceil(size / (MARKS_PER_CM * size_of(ax)[0]))))
    starts = np.flatnonzero(np.diff(at, prepend=-2) > 1)
    kept = np.zeros(at.size, np.bool_)
    for first, last in zip(starts, [*starts[1:], at.size], strict=True):
        kept[first:last:step] = True
    return at[kept]


def isolated(mask: NDArray[np.bool_], broken: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
    """Return which points have no neighbour in a mask, so that a line would not show them.

    `broken` tells after which points the line is broken.
    """
    cut = np.zeros_like(mask) if broken is None else broken
    joined = mask[:-1] & mask[1:] & ~cut[:-1]
    padded = np.concatenate([[False], joined, [False]])
    return mask & ~padded[:-1] & ~padded[1:]
