"""Where the maps of a sweep stand: panels of one size in rows, each titled, with labels at the outer ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import BODY, SMALL, WIDE, axes, new_canvas, plain_ticks, size_of
from vibropipe.figures.map_shapes import borders, cell_edges, frame, scale_of
from vibropipe.figures.palette import GREY, INK
from vibropipe.figures.style import rasterise_many
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.quantities import fitted_label
from vibropipe.scenes.sweep.sweep_rows import combinations, evenly, swept
from vibropipe.solve.sweep.sweep_grid import DIRECTION

LEFT, RIGHT, BETWEEN = 1.2, 0.15, 0.55  # cm left of the panels, right of them, between them
TITLE_LINE, LABELS = 0.38, 1.05  # cm of a line above a panel, and below the panels
Edges = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Place:
    """Corner and size of a panel in cm, and whether it is an outer one, whose axes have labels."""

    left: float
    bottom: float
    width: float
    height: float
    is_left: bool
    is_low: bool


def map_axes(dataset: xr.Dataset) -> tuple[str, str, list[str]]:
    """Return (abscissa, ordinate, further parameters): the two finest grids, in study order."""
    dims = swept(dataset)
    finest = sorted(dims, key=lambda name: -dataset.sizes[name])[:2]
    x, y = (name for name in dims if name in finest)
    further = [name for name in dims if name not in finest]
    return x, y, [*further, DIRECTION] if DIRECTION in dataset["regime"].dims else further


def by_combination(dataset: xr.Dataset, most: int) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield title and rows of each combination of further parameters, at most `most`, evenly spaced."""
    for one in evenly(combinations(dataset, map_axes(dataset)[2]), most):
        yield combination_text(dataset, one), dataset.isel(one)


def combination_text(dataset: xr.Dataset, indices: dict[str, int]) -> str:
    """Write the values at some indices of parameters as mathtext."""
    return ", ".join(
        value_text(dataset[name], dataset[name].values[n].item()) for name, n in indices.items()
    )


def places(
    amount: int, across: int, height: float, lines: int = 1, beside: float = 0.0, below: float = 0.0
) -> tuple[Figure, list[Place]]:
    """Return an empty figure and the places of some panels, row by row.

    amount, across : number of panels, and of those in a row
    height : height of a panel (cm)
    lines : lines above each panel
    beside, below : room right of each panel, for the scale of its colours, and below all, for a legend (cm)
    """
    down = -(-amount // across)
    width = (WIDE - LEFT - RIGHT - (across - 1) * BETWEEN) / across - beside
    pitch, rise = width + beside + BETWEEN, height + 0.35 + lines * TITLE_LINE
    figure = new_canvas(down * rise + LABELS + below)
    found = []
    for n in range(amount):
        row, column = divmod(n, across)
        bottom = below + LABELS + (down - 1 - row) * rise
        found.append(
            Place(LEFT + column * pitch, bottom, width, height, column == 0, n + across >= amount)
        )
    return figure, found


def map_panel(figure: Figure, place: Place, part: xr.Dataset, x: str, y: str) -> Axes:
    """Add the axes of a map with their scales, limits and, of an outer panel, labels."""
    ax = axes(figure, place.left, place.bottom, place.width, place.height)
    frame(ax)
    edges = edges_of(part, x, y)
    ax.set_xscale(scale_of(part[x].values))
    ax.set_yscale(scale_of(part[y].values))
    ax.set_xlim(edges[0][0], edges[0][-1])
    ax.set_ylim(edges[1][0], edges[1][-1])
    plain_ticks(ax.xaxis, 6 if place.width > 4.0 else 4)
    plain_ticks(ax.yaxis, 5)
    ax.tick_params(which="both", labelleft=place.is_left, labelbottom=place.is_low)
    if place.is_low:
        ax.set_xlabel(fitted_label(part[x], place.width))
    if place.is_left:
        ax.set_ylabel(fitted_label(part[y], place.height + 0.8))
    return ax


def write_titles(ax: Axes, title: str, second: str = "") -> None:
    """Write a line above a panel, and a grey one below it, closest to the panel."""
    high = size_of(ax)[1]
    line = TITLE_LINE / high
    y = 1 + 0.15 / high
    style: dict[str, Any] = {"transform": ax.transAxes, "va": "baseline"}
    ax.text(0, y + (line if second else 0.0), title, fontsize=BODY, **style)
    ax.text(0, y, second, fontsize=SMALL, color=GREY, **style)


def edges_of(part: xr.Dataset, x: str, y: str) -> Edges:
    """Return the borders of the cells of a map along both axes."""
    return cell_edges(part[x].values), cell_edges(part[y].values)


def outline(ax: Axes, codes: np.ndarray, edges: Edges, width: float = 0.45) -> None:
    """Draw the outlines of regions of equal code."""
    lines = borders(codes, *edges)
    if lines is not None:
        drawn = ax.plot(*lines, color=INK, linewidth=width, scalex=False, scaley=False)
        rasterise_many(drawn, lines[0].size)


MANY_CELLS = 62_500  # hatches of a larger map are stored as pixels
HATCH_CELLS = 250  # cells of a side that are enough for the shape of a hatched region


def draw_hatch(ax: Axes, edges: Edges, mask: np.ndarray, hatch: str, colour: str) -> None:
    """Hatch the cells of a mask; of a fine grid, every n-th cell gives the shape."""
    if not hatch or min(mask.shape) < 2:
        return
    rows, columns = (max(1, size // HATCH_CELLS) for size in mask.shape)
    kept = [
        np.append(each[:-1:n], each[-1]) for each, n in zip(edges, (columns, rows), strict=True)
    ]
    shape = as_steps((kept[0], kept[1]), mask[::rows, ::columns].astype(float))
    hatched = ax.contourf(*shape, levels=[0.5, 1.5], colors="none", hatches=[hatch])
    hatched.set_edgecolor(colour)
    hatched.set_linewidth(0.0)
    hatched.set_rasterized(mask.size > MANY_CELLS)


def as_steps(edges: Edges, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return corners of cells with the values of the cells, whose contours are borders of cells.

    Contours of values at the middles of the cells cut through cells, by a quarter of a grid of two or three values.
    """
    x, y = (np.repeat(each, 2)[1:-1] for each in edges)
    return x, y, np.repeat(np.repeat(values, 2, axis=0), 2, axis=1)
