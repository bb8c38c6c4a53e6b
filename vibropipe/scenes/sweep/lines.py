"""The lines of a panel and, below it, a bar for each line with how the mass moves in every row.

Orbits are lines with breaks at jumps, other rows marks, jumps of followed rows arrows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from vibropipe.figures.canvas import SMALL, TIGHT_GROUND, arrow, size_of
from vibropipe.figures.map_shapes import cell_edges, with_margin
from vibropipe.figures.style import BLACK, rasterise_many
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.laws import Region
from vibropipe.scenes.sweep.neighbours import jump_steps
from vibropipe.scenes.sweep.sweep_rows import directions, row_kinds
from vibropipe.solve.sweep.sweep_grid import DIRECTION

MAX_RUNS = 2000  # runs of equal regime in a bar: finer than a printer resolves
MANY_RUNS = 400  # a bar of more runs is stored as pixels
LETTER_CM = 0.145  # usual width of a letter
BAR_NAME = "name of a bar"
Floats = NDArray[np.float64]
MARKS_PER_CM = 5.0  # of a kind of rows along a line
MAX_JUMPS = 4  # jumps of a line that have arrows; through chaos there are dozens
DIRECTION_SIGNS = {"up": "↑", "down": "↓"}
ROW_MARKS: dict[str, dict[str, Any]] = {
    "multiple": {"marker": "o", "markersize": 2.6, "markerfacecolor": "white", "markeredgewidth": 0.6},
    "unstable": {"marker": "x", "markersize": 3.0, "markeredgewidth": 0.7},
    "no_orbit": {"marker": ".", "markersize": 3.6, "markeredgewidth": 0.0},
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
    orbit, jumps = _orbits_and_jumps(x, y, line, steps)
    shown = np.where(orbit, y, np.nan)
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
    if arrows and _has_arrows(line, steps, jumps):
        draw_jumps(ax, x, y, jumps, line.direction, colour)


def _orbits_and_jumps(
    x: Floats, y: Floats, line: Line, steps: bool
) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Return which rows of a line are orbits, and the rows after which it is broken."""
    kinds = row_kinds(line.row)
    orbit = (kinds["line"] | kinds["multiple"]) & np.isfinite(y)
    shown = np.where(orbit, y, np.nan)
    if steps:
        return orbit, np.flatnonzero(np.diff(shown))
    return orbit, jump_steps(x, shown, line.row["regime"].values)


def breaks_of(x: Floats, y: Floats, line: Line, steps: bool) -> list[int]:
    """Return the rows after which a line is broken: where it jumps, and beside rows without an orbit."""
    orbit, jumps = _orbits_and_jumps(x, y, line, steps)
    is_broken = ~(orbit[:-1] & orbit[1:])
    is_broken[jumps] = True
    return np.flatnonzero(is_broken).tolist()


def _has_arrows(line: Line, steps: bool, jumps: NDArray[np.intp]) -> bool:
    """Return whether jumps are drawn as arrows: of rows that were followed, and few."""
    return bool(line.direction) and not steps and 0 < jumps.size <= MAX_JUMPS


def has_arrows(x: Floats, y: Floats, line: Line, steps: bool) -> bool:
    """Return whether jumps of a line are drawn as arrows."""
    return _has_arrows(line, steps, _orbits_and_jumps(x, y, line, steps)[1])


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


def draw_strips(
    ax: Axes,
    strips: Sequence[Line],
    regions: Sequence[Region],
    along: str,
    named: bool = True,
    width_cm: float = 0.0,
) -> None:
    """Draw one bar per line with how the mass moves in every row, named in the bar where the name fits.

    ax : where; its abscissa is that of the panels above
    strips : the lines, from top to bottom, with the code of the region of each row as `region`
    regions : those of the rows
    along : parameter of the abscissa
    named : whether the bars have the texts of their lines beside them
    width_cm : printed width of the axes (default: no names in the bars)
    """
    edges = cell_edges(strips[0].row[along].values)
    ax.set_xlim(with_margin(edges))
    for position, strip in enumerate(strips):
        draw_bar(ax, strip.row["region"].values, regions, edges, position, width_cm)
    ax.set_ylim(len(strips) - 0.4, -0.6)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    ax.set_yticks(range(len(strips)), [strip.text if named else "" for strip in strips])


def draw_bar(
    ax: Axes,
    codes: NDArray[np.int64],
    regions: Sequence[Region],
    edges: Floats,
    position: int,
    width_cm: float,
) -> None:
    """Draw the bar of one line; of very many runs, one row of each MAX_RUNS-th part stands for the part."""
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(codes)) + 1, [codes.size]])
    if cuts.size > MAX_RUNS:
        kept = np.unique(np.linspace(0, codes.size, MAX_RUNS).astype(int))
        codes = np.repeat(codes[kept[:-1]], np.diff(kept))
        cuts = np.concatenate([[0], np.flatnonzero(np.diff(codes)) + 1, [codes.size]])
    low, high = position - 0.36, position + 0.36
    boxes: dict[int, list[list[tuple[float, float]]]] = {}
    for start, stop in pairwise(cuts.tolist()):
        left, right = float(edges[start]), float(edges[stop])
        box = [(left, low), (right, low), (right, high), (left, high)]
        boxes.setdefault(int(codes[start]), []).append(box)
    for region in (region for region in regions if region.code in boxes):
        polygons, style = boxes[region.code], region.style
        bars = PolyCollection(polygons, facecolor=style.colour, hatch=style.hatch,
                              edgecolor=style.hatch_colour if style.hatch else "black", linewidth=0.2)  # fmt: skip
        ax.add_collection(bars)
        name_boxes(ax, region, polygons, width_cm)
    if cuts.size > MANY_RUNS:
        for collection in ax.collections:
            collection.set_rasterized(True)


def name_boxes(
    ax: Axes, region: Region, polygons: list[list[tuple[float, float]]], width_cm: float
) -> None:
    """Write the name of a region into each of its boxes that is long enough."""
    text = region.words
    scaled = np.log if ax.get_xscale() == "log" else np.asarray
    first, last = scaled(np.array(ax.get_xlim()))
    for box in polygons:
        left, right = scaled(np.array([box[0][0], box[1][0]]))
        if (right - left) / (last - first) * width_cm < LETTER_CM * len(text) + 0.2:
            continue
        middle = 0.5 * (left + right)
        at = float(np.exp(middle)) if ax.get_xscale() == "log" else float(middle)
        ax.text(
            at, 0.5 * (box[0][1] + box[2][1]), text, ha="center", va="center",
            fontsize=SMALL, clip_on=True, gid=BAR_NAME,
            bbox=TIGHT_GROUND if region.style.hatch else None,
            color="white" if region.name == "unbounded" else BLACK,
        )  # fmt: skip
