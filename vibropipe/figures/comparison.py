"""Pictures of what differs between two sweeps: rows with another law of motion, and the change of a quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import Colormap, ListedColormap, Normalize

from vibropipe.figures.canvas import (
    BODY,
    GAP,
    SMALL,
    WIDE,
    axes,
    colour_bar,
    new_canvas,
    plain_ticks,
)
from vibropipe.figures.map_shapes import cell_edges, frame
from vibropipe.figures.palette import FAILED, GREY, INK, MAGNITUDES
from vibropipe.figures.text import axis_label
from vibropipe.words.wording import part_text

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT, BOTTOM, HIGH, BAR = 1.5, 1.2, 5.6, 0.25


def laws_title(changed: xr.DataArray, rows: int) -> str:
    """Return in how many rows laws differ."""
    if amount := int(changed.sum()):
        return f"Another law of motion in {part_text(amount, rows, 'row')}"
    return "All laws of motion are equal"


def moved_title(moved: xr.DataArray) -> str:
    """Return what is drawn of a quantity."""
    return f"Size of B − A: {axis_label(moved)}"


def draw_map(changed: xr.DataArray | None, moved: xr.DataArray | None, rows: int) -> Figure:
    """Draw maps of a sweep over two parameters, side by side: laws that differ, and |B - A| of a quantity."""
    width = (WIDE - 2 * LEFT - GAP) / 2 - 0.9
    figure = new_canvas(BOTTOM + HIGH + 1.0)
    for n, part in enumerate((changed, moved)):
        if part is None:
            continue
        x, y = map(str, part.dims)
        ax = axes(figure, LEFT + n * (width + LEFT + GAP), BOTTOM, width, HIGH)
        frame(ax)
        edges = cell_edges(part[x].values), cell_edges(part[y].values)
        top = 1.0 if n == 0 else float(part.where(np.isfinite(part)).max())
        colours: Colormap | str = ListedColormap(["#F2F2F2", FAILED]) if n == 0 else MAGNITUDES
        norm = Normalize(0.0, top or 1.0)
        drawn = ax.pcolormesh(
            *edges, part.values.T.astype(float), cmap=colours, norm=norm, rasterized=True
        )
        label_axes(ax, part, x, y)
        if n == 1:
            colour_bar(figure, drawn, LEFT + width + LEFT + GAP + width + 0.2, BOTTOM, BAR, HIGH)
        title(ax, laws_title(part, rows) if n == 0 else moved_title(part))
    return figure


def draw_curve(changed: xr.DataArray | None, moved: xr.DataArray | None, rows: int) -> Figure:
    """Draw |B - A| of a quantity along one parameter, and rows whose law of motion differs as marks below."""
    width = WIDE - LEFT - 0.6
    figure = new_canvas(BOTTOM + HIGH + 1.0)
    ax = axes(figure, LEFT, BOTTOM, width, HIGH)
    told = changed if changed is not None else moved
    assert told is not None
    x = str(told.dims[0])
    if moved is not None:
        ax.plot(moved[x].values, moved.values, color=INK, lw=1.0)
        ax.set_ylim(bottom=0.0)
    if changed is not None:
        at = changed[x].values[changed.values]
        ax.plot(at, np.zeros(at.size), "|", color=FAILED, markersize=7, clip_on=False)
    label_axes(ax, told, x, None)
    texts = [moved_title(moved)] if moved is not None else []
    if changed is not None:
        marks = " (marks)" if bool(changed.any()) else ""
        texts.append(laws_title(changed, rows) + marks)
    title(ax, ". ".join(texts))
    return figure


def label_axes(ax: Axes, part: xr.DataArray, x: str, y: str | None) -> None:
    """Label both axes of a picture with their parameters."""
    ax.set_xlabel(axis_label(part[x]), fontsize=SMALL)
    plain_ticks(ax.xaxis, 5)
    if y is not None:
        ax.set_ylabel(axis_label(part[y]), fontsize=SMALL)
        plain_ticks(ax.yaxis, 5)


def title(ax: Axes, text: str) -> None:
    """Write the title above a picture."""
    ax.set_title(text, loc="left", fontsize=BODY, color=INK if text else GREY)
