"""Map of the basins over the starts, and of the forcing periods until a start has settled."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import StrMethodFormatter
from numpy.typing import NDArray

from vibropipe.figures.map_shapes import cell_edges, frame, widest_spot
from vibropipe.figures.style import (
    BLACK,
    GREEN,
    LINE_MARKERS,
    PURPLE,
    REGION_LABEL,
    SKY,
    VERMILLION,
    YELLOW,
    legend,
    new_figure,
)
from vibropipe.figures.text import axis_label, parameter_line
from vibropipe.scenes.basins.text import MAX_BORDER, attractor_text

# Colours of the basins in turn: the first lie far apart in grey as well.
COLOURS = (YELLOW, SKY, "#003B5C", VERMILLION, "#EFEFEF", GREEN, PURPLE, "#7F7F7F")
NONE_COLOUR, PERIOD_COLOURS = "#FFFFFF", "cividis"
# Forcing periods from which on only powers of ten are labelled.
MANY_PERIODS = 30
# Crosses of unstable orbits, black on white, to be seen on every colour.
CROSSES: tuple[dict[str, Any], ...] = (
    {
        "linestyle": "none",
        "marker": "X",
        "markersize": 7.5,
        "color": "white",
        "markeredgewidth": 0.0,
    },
    {"linestyle": "none", "marker": "x", "markersize": 5.0, "color": BLACK, "markeredgewidth": 1.4},
)
STABLE_SET: dict[str, Any] = {"color": BLACK, "linestyle": "-", "linewidth": 0.8}
# Quantity of each map -> its height.
PANELS_CM = {"attractor": 8.6, "periods_to_attractor": 6.4}
LEGEND_CM, AXIS_CM = 1.8, 1.2


def draw_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the attractor of each start, and the periods until it has settled, or one of both."""
    heights = {name: height for name, height in PANELS_CM.items() if name in (show or PANELS_CM)}
    figure = new_figure(sum(heights.values()) + (LEGEND_CM if "attractor" in heights else AXIS_CM))
    column = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, height_ratios=[*heights.values()]
    )[:, 0]
    panels: dict[str, Axes] = dict(zip(heights, column, strict=True))
    edges = cell_edges(dataset["x0"].values), cell_edges(dataset["v0"].values)
    if upper := panels.get("attractor"):
        draw_attractor_map(upper, dataset, edges)
    column[0].set_title(parameter_line(dataset))
    if lower := panels.get("periods_to_attractor"):
        draw_periods(figure, lower, dataset, edges)
    for ax in column:
        ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
        ax.set_ylabel(axis_label(dataset["v0"]))
        frame(ax)
    column[-1].set_xlabel(axis_label(dataset["x0"]))
    if "attractor" in panels:
        legend(figure, legend_handles(dataset), "lower")
    return figure


def draw_attractor_map(
    ax: Axes, dataset: xr.Dataset, edges: tuple[NDArray[np.float64], NDArray[np.float64]]
) -> None:
    """Draw the attractor of each start, with the states of the attractors at the section."""
    attractor = dataset["attractor"].transpose("v0", "x0").values
    n = dataset.sizes["attractor_id"]
    colours = ListedColormap([NONE_COLOUR, *(COLOURS[i % len(COLOURS)] for i in range(n))])
    norm = BoundaryNorm(np.arange(n + 2) - 1.5, n + 1)
    ax.pcolormesh(*edges, attractor, cmap=colours, norm=norm, rasterized=True)
    at_section = float(dataset["start_phase"]) == 0.0
    if float(dataset["border"].mean()) <= MAX_BORDER:
        if at_section and dataset.sizes.get("stable_set_point"):
            curves = (dataset[f"stable_set_{name}"] for name in ("displacement", "velocity"))
            ax.plot(*curves, **STABLE_SET)
        else:
            draw_borders(ax, edges, attractor)
    write_numbers(ax, dataset, attractor)
    if at_section:
        draw_attractors(ax, dataset)
        if "border_orbit" not in dataset.dims:
            return
        points = [dataset[f"border_point_{name}"].values for name in ("displacement", "velocity")]
        for style in CROSSES:
            ax.plot(*points, **style)


def draw_borders(
    ax: Axes, edges: tuple[NDArray[np.float64], NDArray[np.float64]], attractor: NDArray[np.int32]
) -> None:
    """Draw a line along the sides that cells of different basins share."""
    style: dict[str, Any] = {"color": BLACK, "linewidth": 0.4, "rasterized": True}
    xs, ys = edges
    row, column = np.nonzero(attractor[:, 1:] != attractor[:, :-1])
    gap = np.full(row.size, np.nan)
    at = xs[column + 1]
    ax.plot(np.ravel([at, at, gap], "F"), np.ravel([ys[row], ys[row + 1], gap], "F"), **style)
    row, column = np.nonzero(attractor[1:] != attractor[:-1])
    gap = np.full(row.size, np.nan)
    at = ys[row + 1]
    ends = xs[column], xs[column + 1]
    ax.plot(np.ravel([*ends, gap], "F"), np.ravel([at, at, gap], "F"), **style)


def write_numbers(ax: Axes, dataset: xr.Dataset, attractor: NDArray[np.int32]) -> None:
    """Write the number of the attractor into the widest place of its basin, if there is one."""
    for index in range(dataset.sizes["attractor_id"]):
        spot = widest_spot(attractor == index)
        if spot is not None:
            at = dataset["x0"].values[spot[1]], dataset["v0"].values[spot[0]]
            ax.text(*at, str(index), **REGION_LABEL)


def draw_attractors(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the states of each attractor at the section: markers, or dots for one without an orbit."""
    for index in range(dataset.sizes["attractor_id"]):
        row = dataset.isel(attractor_id=index)
        n_states = int(row["period_multiple"]) or row.sizes["visit"]
        states = [
            row[f"poincare_{name}"].values[-n_states:] for name in ("displacement", "velocity")
        ]
        ax.plot(*states, clip_on=True, **marker(dataset, index))


def marker(dataset: xr.Dataset, index: int) -> dict[str, Any]:
    """Return the marker of an attractor."""
    if int(dataset["period_multiple"][index]) == 0:
        size = {"marker": ".", "markersize": 2.4, "markeredgewidth": 0.0}
        return {"linestyle": "none", "color": BLACK, "rasterized": True, **size}
    shape = LINE_MARKERS[index % len(LINE_MARKERS)]
    face = {"markerfacecolor": "white", "markeredgecolor": BLACK, "markeredgewidth": 0.8}
    return {"linestyle": "none", "marker": shape, "markersize": 5.0, **face}


def draw_periods(
    figure: Figure,
    ax: Axes,
    dataset: xr.Dataset,
    edges: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> None:
    """Draw the forcing periods until each start has settled, on a logarithmic scale."""
    periods = dataset["periods_to_attractor"].transpose("v0", "x0")
    shown = np.maximum(periods.values, 1)
    norm = LogNorm(int(shown.min()), max(2, int(shown.max())) + int(shown.min() == shown.max()))
    ax.pcolormesh(*edges, shown, cmap=PERIOD_COLOURS, norm=norm, rasterized=True)
    text = "forcing periods until settled"
    symbol = dataset["periods_to_attractor"].attrs["symbol"]
    bar = figure.colorbar(
        ScalarMappable(norm, PERIOD_COLOURS), ax=ax, aspect=30, pad=0.02, label=f"{text} {symbol}"
    )
    # Whole numbers of periods, not powers of ten with one digit.
    bar.ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    if (norm.vmax or 1.0) < MANY_PERIODS:
        bar.ax.yaxis.set_minor_formatter(StrMethodFormatter("{x:g}"))


def legend_handles(dataset: xr.Dataset) -> list[Artist]:
    """Return legend entries: the colour of each basin, with the marker of its attractor."""
    handles: list[Artist] = []
    drawn = float(dataset["start_phase"]) == 0.0
    for index in range(dataset.sizes["attractor_id"]):
        colour, text = COLOURS[index % len(COLOURS)], attractor_text(dataset, index)
        if drawn and int(dataset["period_multiple"][index]):
            style = {**marker(dataset, index), "markerfacecolor": colour, "markersize": 7.0}
            handles.append(Line2D([], [], label=text, **style))
        else:
            handles.append(Patch(facecolor=colour, edgecolor=BLACK, linewidth=0.4, label=text))
    if drawn and dataset.sizes["border_orbit"]:
        is_smooth = float(dataset["border"].mean()) <= MAX_BORDER
        has_line = is_smooth and dataset.sizes["stable_set_point"]
        line, text = (STABLE_SET, ", and its stable set") if has_line else ({}, "")
        handles.append(
            Line2D([], [], label=f"unstable orbit on a border{text}", **CROSSES[1] | line)
        )
    if bool((dataset["attractor"] < 0).any()):
        handles.append(none_handle())
    return handles


def none_handle() -> Artist:
    """Return the legend entry of starts for which no attractor was found."""
    return Patch(facecolor=NONE_COLOUR, edgecolor=BLACK, linewidth=0.4, label="no attractor found")
