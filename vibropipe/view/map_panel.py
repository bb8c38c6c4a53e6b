"""The map: regions or values as one image, with outlines, words, and a crosshair."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    CustomJSHover,
    GlyphRenderer,
    HoverTool,
    LinearColorMapper,
    Range1d,
)
from bokeh.palettes import cividis
from bokeh.plotting import figure
from numpy.typing import NDArray

from vibropipe.figures.map_shapes import borders, cell_edges, scale_of, widest_spot
from vibropipe.figures.style import GREEN, PURPLE, SKY, VERMILLION, YELLOW
from vibropipe.scenes.sweep.maps import HIGHEST_SHARE
from vibropipe.scenes.sweep.quantities import SIGNED, Series
from vibropipe.view.plane import Plane
from vibropipe.view.words import symbol

# Of the frame of the map, which the slices share, and of what is left of it.
FRAME_WIDTH, FRAME_HEIGHT, LEFT_BORDER = 430, 340, 70
# Beside the frame, for the colour bar, whether it is shown or not.
RIGHT_BORDER = 66
NO_VALUE = "#FFFFFF"
# Of words, far apart in grey as well.
COLOURS = (YELLOW, SKY, "#003B5C", VERMILLION, "#EFEFEF", GREEN, PURPLE, "#7F7F7F")
WORDS, EDGE = ("x", "y", "text", "align"), 0.1
# Cells of a side of the image of an irregular grid.
FINE = 800
# Codes are whole: the hover says their words, and for values none.
HOVER = """
const words = regions.data.text
return words.length ? (words[Math.round(value)] ?? "") : Number(value).toPrecision(5)
"""


def even_cells(values: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return which values the even cells of an image show; of an even grid, each once."""
    edges = cell_edges(values)
    if scale_of(values) == "log":
        edges = np.log(edges)
    sizes = np.diff(edges)
    if np.ptp(sizes) <= 1e-6 * sizes.max():
        return np.arange(values.size)
    n = max(FINE, values.size)
    centres = edges[0] + (np.arange(n) + 0.5) * (edges[-1] - edges[0]) / n
    return np.clip(np.searchsorted(edges, centres) - 1, 0, values.size - 1)


def limits_of(name: str, values: NDArray) -> tuple[float, float]:
    """Return the ends of the colour scale of a quantity: from 0 unless it has both signs, less the largest values."""
    finite = values[np.isfinite(values)]
    if not finite.size:
        return 0.0, 1.0
    is_signed = name in SIGNED or bool((finite < 0).any())
    low = float(np.quantile(finite, 1 - HIGHEST_SHARE)) if is_signed else 0.0
    high = float(np.quantile(finite, HIGHEST_SHARE))
    return low, high if high > low else low + 1.0


def _align(share: float) -> str:
    """Return the alignment of a word at a share of the width: it must not leave the map."""
    if share < EDGE:
        return "left"
    return "right" if share > 1.0 - EDGE else "center"


def flag_colours(flags: dict[int, str]) -> list[str]:
    """Return the colours of the values of a quantity that are words, from 0 on."""
    return [COLOURS[n % len(COLOURS)] for n in range(max(flags, default=-1) + 1)]


def draw_crosshair(plot: figure, crosshair: ColumnDataSource, lines: str) -> None:
    """Draw the upright line of the crosshair at its x, the level one at its y, or both."""
    # on the layer above: a moved crosshair repaints no map
    style: dict[str, Any] = {
        "source": crosshair,
        "line_color": "#CC0000",
        "line_width": 1.5,
        "level": "overlay",
    }
    if "x" in lines:
        plot.vspan(x="x", **style)
    if "y" in lines:
        plot.hspan(y="y", **style)


class MapPanel:
    """The map of a plane."""

    def __init__(self, plane: Plane, crosshair: ColumnDataSource) -> None:
        self.plane = plane
        x, y = plane.values
        self.edges = cell_edges(x), cell_edges(y)
        self._cells = even_cells(x), even_cells(y)
        self.mapper = LinearColorMapper(palette=[NO_VALUE], low=0.0, high=1.0, nan_color=NO_VALUE)
        (x_low, x_high), (y_low, y_high) = ((float(e[0]), float(e[-1])) for e in self.edges)
        self.image = ColumnDataSource(
            {
                "image": [np.zeros((1, 1), np.float32)],
                "x": [x_low],
                "y": [y_low],
                "dw": [x_high - x_low],
                "dh": [y_high - y_low],
            }
        )
        self.outlines = ColumnDataSource({"x": [], "y": []})
        self.words = ColumnDataSource({name: [] for name in WORDS})
        self.regions = ColumnDataSource({"text": []})
        self.figure = figure(
            frame_width=FRAME_WIDTH, frame_height=FRAME_HEIGHT,
            min_border_left=LEFT_BORDER, min_border_right=RIGHT_BORDER,
            x_range=Range1d(x_low, x_high), y_range=Range1d(y_low, y_high),
            x_axis_type=scale_of(x), y_axis_type=scale_of(y), tools="pan,wheel_zoom,box_zoom,reset,save",
            active_drag=None, active_scroll="wheel_zoom", y_axis_label=plane.labels[1],
            toolbar_location="above", name="map",
        )  # fmt: skip
        self.figure.toolbar.logo = None
        drawn = self.figure.image(source=self.image, color_mapper=self.mapper)
        self.figure.line("x", "y", source=self.outlines, color="#000000", line_width=0.7)
        self.figure.text(
            "x", "y", "text", source=self.words, text_align="align", text_baseline="middle",
            text_font_size="11px", background_fill_color="white", background_fill_alpha=0.85, padding=2,
        )  # fmt: skip
        self.bar = ColorBar(color_mapper=self.mapper, width=8, visible=False, padding=4)
        self.figure.add_layout(self.bar, "right")
        self._hover(drawn)
        draw_crosshair(self.figure, crosshair, "xy")

    def _hover(self, drawn: GlyphRenderer) -> None:
        code = CustomJSHover(args={"regions": self.regions}, code=HOVER)
        marks = [symbol(self.plane.dataset[name]) for name in self.plane.axes]
        tips = [(marks[0], "$x"), (marks[1], "$y"), ("", "@image{custom}")]
        self.figure.add_tools(
            HoverTool(
                renderers=[drawn],
                tooltips=tips,
                formatters={"@image": code},
                attachment="horizontal",
            )
        )

    def show(self, series: Series | None) -> None:
        """Show a quantity; None shows the regions."""
        codes = self.plane.codes()
        lines = borders(codes, *self.edges)
        empty = np.empty(0)
        self.outlines.data = dict(zip("xy", lines or (empty, empty), strict=True))
        flags = self.plane.flags(series) if series is not None else {}
        if series is None:
            self._show_regions(codes)
        elif flags:
            self._show_flags(series, flags)
        else:
            self._show_values(series)

    def _show_regions(self, codes: NDArray[np.int64]) -> None:
        regions = self.plane.regions
        # The mapper keeps its limits: codes that are absent must not shift the colours.
        self.mapper.update(
            palette=[each.colour for each in regions], low=-0.5, high=len(regions) - 0.5
        )
        self.bar.visible = False
        self.regions.data = {"text": [each.text for each in regions]}
        self._show_image(codes)
        x, y = self.plane.values
        spots = [(n, widest_spot(codes == n)) for n in np.unique(codes)]
        placed = [
            (x[at[1]], y[at[0]], regions[n].short, _align(at[1] / x.size))
            for n, at in spots
            if at is not None
        ]
        self.words.data = {name: [each[n] for each in placed] for n, name in enumerate(WORDS)}

    def _show_flags(self, series: Series, flags: dict[int, str]) -> None:
        self.mapper.update(palette=flag_colours(flags), low=-0.5, high=max(flags) + 0.5)
        self.bar.visible = False
        self.regions.data = {"text": [flags.get(n, "") for n in range(max(flags) + 1)]}
        self.words.data = {name: [] for name in WORDS}
        self._show_image(self.plane.field(series))

    def _show_values(self, series: Series) -> None:
        values = self.plane.field(series)
        low, high = limits_of(series.name, values)
        self.mapper.update(palette=cividis(256), low=low, high=high)
        self.bar.visible = True
        self.regions.data = {"text": []}
        self.words.data = {name: [] for name in WORDS}
        self._show_image(values)

    def _show_image(self, values: NDArray) -> None:
        columns, rows = self._cells
        image = values[np.ix_(rows, columns)].astype(np.float32)
        self.image.data = {**self.image.data, "image": [image]}
