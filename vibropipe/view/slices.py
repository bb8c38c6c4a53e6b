"""Slices of a plane through the crosshair, coloured by region; of one axis, the curves in place of a map."""

from __future__ import annotations

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure

from vibropipe.figures.map_shapes import cell_edges, scale_of
from vibropipe.figures.text import in_brackets
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.view.map_panel import (
    FRAME_HEIGHT,
    FRAME_WIDTH,
    LEFT_BORDER,
    draw_crosshair,
    limits_of,
)
from vibropipe.view.plane import MARKERS, Plane
from vibropipe.view.words import label_of, short_ticks, symbol

# The quantity of the slices while the map shows regions.
OF_REGIONS = (
    "impact_velocity_max",
    "displacement_amplitude",
    "displacement_mean",
    "periods_to_attractor",
)
# Least length of the axis of a quantity in a slice, over that of its colours: rounding is no curve.
MIN_LENGTH = 1e-3
COLUMNS = ("at", "value", "colour", "marker")
LEVEL_HEIGHT, UPRIGHT_WIDTH, CURVES_WIDTH, CURVES_HEIGHT = 105, 96, 590, 350


def shown_series(plane: Plane, series: Series | None) -> list[Series]:
    """Return what slices show: a quantity, or all elements of the first of OF_REGIONS with values."""
    if series is not None:
        return [series]
    for name in OF_REGIONS:
        parts = [each for each in plane.series.values() if each.name == name]
        if any(np.isfinite(series.of(plane.dataset).values).any() for series in parts):
            return parts if parts[0].dim == "support" else parts[:1]
    return list(plane.series.values())[:1]


def slice_label(plane: Plane, chosen: list[Series]) -> str:
    """Return the label of the quantity of slices: in full beside curves, its symbol beside a map."""
    array, one = plane.dataset[chosen[0].name], len(chosen) == 1
    if len(plane.axes) == 1:
        return plane.label(chosen[0]) if one else label_of(array)
    index = chosen[0].position
    mark = symbol(array, index + 1 if one and index is not None else None)
    return in_brackets(mark, array).strip()


def least_length(plane: Plane, series: Series) -> float:
    """Return the least length of the axis of a quantity."""
    low, high = limits_of(series.name, np.asarray(series.of(plane.dataset).values, float))
    return MIN_LENGTH * (high - low)


class Slice:
    """One slice along an axis of a plane.

    axis : index of the axis that it runs along
    beside : the map whose range it shares
    """

    def __init__(
        self, plane: Plane, axis: int, crosshair: ColumnDataSource, beside: figure | None = None
    ) -> None:
        self.plane, self.axis = plane, axis
        self.is_level = axis == 0
        self.points = ColumnDataSource({name: [] for name in COLUMNS})
        self.lines = ColumnDataSource({"at": [], "value": []})
        scale = scale_of(plane.values[axis])
        name = "slice_x" if self.is_level else "slice_y"
        options: dict = {"tools": "pan,wheel_zoom,reset", "active_drag": None,
                         "toolbar_location": None, "name": name}  # fmt: skip
        if self.is_level:
            options |= {"x_axis_type": scale, "x_axis_label": plane.labels[0],
                        "frame_width": FRAME_WIDTH if beside else CURVES_WIDTH,
                        "frame_height": LEVEL_HEIGHT if beside else CURVES_HEIGHT,
                        "min_border_left": LEFT_BORDER}  # fmt: skip
            # of curves the whole axis, wherever a quantity has values
            ends = cell_edges(plane.values[axis])[[0, -1]].tolist()
            options["x_range"] = beside.x_range if beside else Range1d(*ends)
        else:
            # a toolbar as high as that of the map, without buttons, keeps both frames level
            options |= {"y_axis_type": scale, "toolbar_location": "above",
                        "frame_width": UPRIGHT_WIDTH, "frame_height": FRAME_HEIGHT,
                        "min_border_left": 12, "min_border_right": 12}  # fmt: skip
            if beside:
                options["y_range"] = beside.y_range
        self.figure = figure(**options)
        self.figure.toolbar.logo = None
        if not self.is_level:
            self.figure.yaxis.visible = False
            for tool in self.figure.tools:
                tool.visible = False
        self.ruler = (self.figure.yaxis if self.is_level else self.figure.xaxis)[0]
        self.ruler.ticker.desired_num_ticks = 4 if self.is_level else 2
        self.ruler.formatter = short_ticks()
        self.range = self.figure.y_range if self.is_level else self.figure.x_range
        x, y = ("at", "value") if self.is_level else ("value", "at")
        self.figure.line(x, y, source=self.lines, color="#9A9A9A", line_width=1)
        self.figure.scatter(
            x, y, source=self.points, marker="marker", size=4.5, fill_color="colour",
            line_color="#333333", line_width=0.4,
        )  # fmt: skip
        # the crosshair has no value: it stretches no range
        self.range.renderers = list(self.figure.renderers)
        draw_crosshair(self.figure, crosshair, "x" if self.is_level else "y")

    def show(self, series: Series | None, at: tuple[int, ...]) -> None:
        """Show a quantity (None: what goes with regions) through the row at indices of the axes."""
        chosen = shown_series(self.plane, series)
        parts: dict[str, list] = {name: [] for name in COLUMNS}
        lines: dict[str, list] = {"at": [], "value": []}
        axis = self.plane.values[self.axis]
        colours = np.array([region.colour for region in self.plane.regions])
        for n, one in enumerate(chosen):
            for m, direction in enumerate(self.plane.directions):
                others = {"direction": m} if direction else {}
                values, codes = self._along(at, one, others)
                parts["at"].append(axis)
                parts["value"].append(values)
                parts["colour"].append(colours[codes])
                marker = MARKERS[(n * len(self.plane.directions) + m) % len(MARKERS)]
                parts["marker"].append(np.full(axis.size, marker))
                lines["at"] += [axis, [np.nan]]
                lines["value"] += [values, [np.nan]]
        self.points.data = {name: np.concatenate(each) for name, each in parts.items()}
        self.lines.data = {name: np.concatenate(each) for name, each in lines.items()}
        self.ruler.axis_label = slice_label(self.plane, chosen)
        self.range.min_interval = least_length(self.plane, chosen[0])

    def _along(self, at: tuple[int, ...], one: Series, others: dict[str, int]) -> tuple:
        """Return values and codes along the axis through a row."""
        values, codes = self.plane.field(one, **others), self.plane.codes(**others)
        if len(self.plane.axes) == 1:
            return values, codes
        index = (at[1], slice(None)) if self.is_level else (slice(None), at[0])
        return values[index], codes[index]
