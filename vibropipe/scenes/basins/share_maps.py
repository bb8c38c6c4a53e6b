"""Maps of the starts at some values of a parameter, as small multiples."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibropipe.figures.canvas import axes, new_canvas, panel
from vibropipe.figures.map_shapes import cell_edges, frame
from vibropipe.figures.text import axis_label, value_text
from vibropipe.scenes.basins.attractors import swept_name
from vibropipe.scenes.basins.basin_map import draw_attractor_map

# Largest number of maps, beside each other, and their sizes in cm.
MAX_MAPS, COLUMNS = 6, 3
LEFT, LOW, WIDE, HIGH, ACROSS, UP = 1.25, 1.05, 4.5, 3.6, 4.95, 4.3


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
    rows = -(-len(chosen) // COLUMNS)
    figure = new_canvas(LOW + rows * UP)
    edges = cell_edges(dataset["x0"].values), cell_edges(dataset["v0"].values)
    for position, index in enumerate(chosen):
        row, column = divmod(position, COLUMNS)
        ax = axes(figure, LEFT + column * ACROSS, LOW + (rows - 1 - row) * UP, WIDE, HIGH)
        draw_attractor_map(ax, dataset, edges, index)
        ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
        panel(ax, title=value_text(dataset[name].isel({name: index})))
        ax.xaxis.set_major_locator(MaxNLocator(4))
        frame(ax)
        is_lowest = position + COLUMNS >= len(chosen)
        ax.tick_params(labelbottom=is_lowest, labelleft=column == 0)
        if column == 0:
            ax.set_ylabel(axis_label(dataset["v0"], width=24))
        if is_lowest:
            ax.set_xlabel(axis_label(dataset["x0"], width=24))
    return figure
