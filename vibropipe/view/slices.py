"""Slices of a plane through the crosshair, coloured by region; of one axis, the curves in place of a map."""

from __future__ import annotations

import numpy as np
from bokeh.models import ColumnDataSource, Span
from bokeh.plotting import figure

from vibropipe.figures.map_shapes import scale_of
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.view.plane import Plane
from vibropipe.view.words import label_of

# The quantity of the slices while the map shows regions.
OF_REGIONS = ("impact_velocity_max", "displacement_amplitude", "displacement_mean")
MARKERS = ("circle", "triangle", "inverted_triangle", "square")
COLUMNS = ("at", "value", "colour", "marker")
LEVEL_HEIGHT, UPRIGHT_WIDTH, CURVES_HEIGHT = 150, 150, 540


def shown_series(plane: Plane, series: Series | None) -> list[Series]:
    """Return what slices show: a quantity, or all elements of the first of OF_REGIONS that there is."""
    if series is not None:
        return [series]
    for name in OF_REGIONS:
        found = [each for each in plane.series.values() if each.name == name]
        if found:
            return found if found[0].dim == "support" else found[:1]
    return list(plane.series.values())[:1]


class Slice:
    """One slice along an axis of a plane.

    Parameters
    ----------
    plane : Plane
    axis : int
        Index of the axis that it runs along.
    span : Span
        Line of the crosshair through it.
    beside : bokeh figure, optional
        The map whose range it shares.
    """

    def __init__(self, plane: Plane, axis: int, span: Span, beside: figure | None = None) -> None:
        self.plane, self.axis = plane, axis
        self.is_level = axis == 0
        self.points = ColumnDataSource({name: [] for name in COLUMNS})
        self.lines = ColumnDataSource({"at": [], "value": []})
        scale = scale_of(plane.values[axis])
        options: dict = {
            "tools": "pan,wheel_zoom,reset",
            "active_drag": None,
            "toolbar_location": None,
        }
        if self.is_level:
            options |= {"x_axis_type": scale, "x_axis_label": plane.labels[0], "width": 560,
                        "height": LEVEL_HEIGHT if beside else CURVES_HEIGHT, "name": "slice_x"}  # fmt: skip
            if beside:
                options["x_range"] = beside.x_range
        else:
            options |= {
                "y_axis_type": scale,
                "width": UPRIGHT_WIDTH,
                "height": 390,
                "name": "slice_y",
            }
            if beside:
                options["y_range"] = beside.y_range
        self.figure = figure(**options)
        x, y = ("at", "value") if self.is_level else ("value", "at")
        self.figure.line(x, y, source=self.lines, color="#9A9A9A", line_width=1)
        self.figure.scatter(
            x, y, source=self.points, marker="marker", size=4.5, fill_color="colour",
            line_color="#333333", line_width=0.4,
        )  # fmt: skip
        self.figure.add_layout(span)

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
        label = (
            label_of(self.plane.dataset[chosen[0].name])
            if len(chosen) > 1
            else self.plane.label(chosen[0])
        )
        ruler = self.figure.yaxis[0] if self.is_level else self.figure.xaxis[0]
        ruler.axis_label = (
            label if len(label) < 42 or not self.plane.axes[1:] else label.split()[-1]
        )

    def _along(self, at: tuple[int, ...], one: Series, others: dict[str, int]) -> tuple:
        """Return values and codes along the axis through a row."""
        values, codes = self.plane.field(one, **others), self.plane.codes(**others)
        if len(self.plane.axes) == 1:
            return values, codes
        index = (at[1], slice(None)) if self.is_level else (slice(None), at[0])
        return values[index], codes[index]
