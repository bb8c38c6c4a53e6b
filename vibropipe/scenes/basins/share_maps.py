"""Maps of the starts at some values of a parameter, as small multiples."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibropipe.figures.map_shapes import cell_edges, frame
from vibropipe.figures.style import legend, new_figure
from vibropipe.figures.text import axis_label, parameter_line, value_text
from vibropipe.scenes.basins.basin_map import draw_attractor_map
from vibropipe.scenes.basins.laws import swept_name
from vibropipe.scenes.basins.share_bands import handles_of

# Largest number of maps, beside each other, and height of a row of them.
MAX_MAPS, COLUMNS, ROW_CM, MARGINS_CM = 6, 2, 5.2, 3.5


def mapped_values(dataset: xr.Dataset) -> list[int]:
    """Return the indices of the values that are mapped: spread over those where attractors coexist, or over all."""
    name = swept_name(dataset)
    several = np.flatnonzero(dataset["basin_share"].count("attractor_id").values > 1)
    candidates = several if several.size else np.arange(dataset.sizes[name])
    spread = np.linspace(0, candidates.size - 1, min(MAX_MAPS, candidates.size))
    chosen: list[int] = candidates[np.unique(spread.round().astype(int))].tolist()
    return chosen


def draw_share_maps(dataset: xr.Dataset) -> Figure:
    """Draw the attractor of each start at up to MAX_MAPS values of the parameter."""
    name, chosen = str(swept_name(dataset)), mapped_values(dataset)
    columns = min(COLUMNS, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = new_figure(MARGINS_CM + rows * ROW_CM)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    edges = cell_edges(dataset["x0"].values), cell_edges(dataset["v0"].values)
    for ax, index in zip(axes.flat, chosen, strict=False):
        at = dataset.isel({name: index})
        draw_attractor_map(ax, at, edges)
        ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
        ax.set_title(value_text(at[name]))
        ax.xaxis.set_major_locator(MaxNLocator(4))
        frame(ax)
    for ax in axes.flat[len(chosen) :]:
        ax.set_axis_off()
    for ax in axes[:, 0]:
        ax.set_ylabel(axis_label(dataset["v0"], width=24))
    for ax in axes.flat[: len(chosen)][-columns:]:  # the lowest of each column
        ax.set_xlabel(axis_label(dataset["x0"]))
        ax.tick_params(labelbottom=True)
    figure.suptitle(parameter_line(dataset))
    shown = np.unique(dataset["attractor"].isel({name: chosen}))
    legend(figure, handles_of(dataset, None, shown[shown >= 0]), "lower")
    return figure
