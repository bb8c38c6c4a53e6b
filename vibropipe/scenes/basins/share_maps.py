"""Maps of the starts at some values of a parameter, as small multiples."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibropipe.figures.canvas import WIDE as CANVAS
from vibropipe.figures.canvas import axes, new_canvas, note_height, panel, top_note
from vibropipe.figures.map_shapes import cell_edges, frame
from vibropipe.figures.text import axis_label, parameter_line, value_text
from vibropipe.scenes.basins.attractors import swept_name
from vibropipe.scenes.basins.basin_map import draw_attractor_map
from vibropipe.scenes.basins.shares_text import mapped_values

# Maps beside each other, and their sizes in cm.
COLUMNS = 3
LEFT, LOW, WIDE, HIGH, ACROSS, UP = 1.5, 1.05, 4.4, 3.6, 4.85, 4.3


def draw_share_maps(dataset: xr.Dataset) -> Figure:
    """Draw the attractor of each start at some values of the parameter."""
    name, chosen = str(swept_name(dataset)), mapped_values(dataset)
    rows = -(-len(chosen) // COLUMNS)
    note = parameter_line(dataset)
    height = LOW + rows * UP + note_height(note)
    figure = new_canvas(height)
    top_note(figure, note, LEFT)
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
    centre = LEFT + 0.5 * ((min(len(chosen), COLUMNS) - 1) * ACROSS + WIDE)
    middle = LOW + 0.5 * ((rows - 1) * UP + HIGH)
    figure.text(centre / CANVAS, 0.15 / height, axis_label(dataset["x0"]), ha="center")
    figure.text(0.1 / CANVAS, middle / height, axis_label(dataset["v0"]), rotation=90, va="center")
    return figure
