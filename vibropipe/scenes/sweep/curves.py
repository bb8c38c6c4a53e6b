"""A sweep along one parameter: its quantities as lines, the regime of every row in bars below.

The first further swept parameter gives lines, from light to dark; the next ones columns or small multiples. Rows that
were followed in both directions are drawn in one panel.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from string import ascii_lowercase
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibropipe.figures.canvas import (
    LEGEND_LINE,
    SMALL,
    axes,
    legend_below,
    note,
    plain_ticks,
    width_of,
    zero_line,
)
from vibropipe.figures.line_names import Named, label_lines
from vibropipe.figures.map_shapes import scale_of
from vibropipe.figures.palette import BLUES, HAIRLINE, SUPPORT_COLOURS, shades
from vibropipe.figures.style import keep_zero_scale, write_centred
from vibropipe.figures.text import format_number, symbol_of, value_text
from vibropipe.scenes.sweep.laws import Region, regions_of
from vibropipe.scenes.sweep.layout import (
    BAR_CM,
    LEFT,
    Layout,
    Spot,
    combinations_drawn,
    fitting_panels,
    lay_out,
    spot_axes,
    write_spot_titles,
)
from vibropipe.scenes.sweep.lines import BAR_NAME, breaks_of, draw_line, draw_strips, lines_of
from vibropipe.scenes.sweep.maps import LEGEND_COLUMNS, region_patches
from vibropipe.scenes.sweep.quantities import (
    COUNTED,
    SIGNED,
    WITH_ZERO_LINE,
    Panel,
    Series,
    family_size,
    fitted_label,
    panels_of,
)
from vibropipe.scenes.sweep.sweep_rows import axis_and_others, axis_of, with_impacts_per_period
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.vocabulary import OF_SOFT

# An axis of impacts ends at this quantile if the largest value is HIGH times as large.
HIGH_SHARE, HIGH = 0.99, 2.0
ROOM = 0.06  # of the largest value, that is left above it
ALIKE: Any = (0, (3, 2))
Curve = tuple[np.ndarray, np.ndarray]
BACKBONE: dict[str, Any] = {
    "color": HAIRLINE,
    "linewidth": 4.0,
    "zorder": 1,
    "solid_capstyle": "butt",
}
# Names of both directions at their lines, where these are so far apart, as a share of the largest value.
WAYS, APART = {"up": "upwards", "down": "downwards"}, 0.1
BESIDE_BAR = 0.15  # cm between a bar and its name


def draw_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> Figure:
    """Draw a sweep whose further parameters have few values.

    show : quantities of the panels (default: those of `panels_of`)
    backbone : backbone over amplitude, drawn under the curves
    """
    along, others = axis_and_others(dataset)
    dataset = with_impacts_per_period(dataset.sortby(along))
    codes, regions = regions_of(dataset)
    dataset = dataset.assign(region=codes)
    lines_dim = others[0] if others else None
    panels = fitting_panels(dataset, others[1:], panels_of(dataset, show, joined=lines_dim is None))
    first: dict[Panel, Axes] = {}
    names: list[tuple[Axes, list[Named], list[Curve]]] = []

    def draw(ax: Axes, spot: Spot) -> str:
        arrows = not names or lines_dim is None
        names.append((ax, *draw_panel(ax, spot, along, lines_dim, backbone, arrows)))
        first.setdefault(spot.panel, ax)
        return spot.panel.title(dataset, spot.words_cm)

    figure, drawn = draw_above_bars(dataset, regions, others[1:], panels, draw, lines_dim)
    scale_ordinates(first, dataset)
    # once the limits are known
    for ax, named_lines, other_lines in names:
        label_lines(ax, named_lines, other_lines)
    if lines_dim is not None and drawn:
        name_lines(drawn[0], along, lines_dim, backbone)
    return figure


def draw_above_bars(
    dataset: xr.Dataset,
    regions: Sequence[Region],
    dims: Sequence[str],
    panels: Sequence[Panel],
    draw: Callable[[Axes, Spot], str],
    lines_dim: str | None = None,
) -> tuple[Figure, list[tuple[Spot, Axes]]]:
    """Draw panels above bars of regions, with a legend of the regions that no bar has room to name.

    dataset : the rows in order, with their `region`
    dims : further parameters, of which each combination has panels of its own
    draw : draws a panel, and returns its title
    """
    along, first = axis_of(dataset), dataset.isel(combinations_drawn(dataset, dims)[0])
    lines = len(list(lines_of(first, lines_dim)))

    def with_room(legend: Sequence[Patch]) -> Layout:
        below = -(-len(legend) // LEGEND_COLUMNS) * LEGEND_LINE + 0.1
        return lay_out(dataset, dims, panels, lines, lines_dim is None, below)

    legend = region_patches(list(regions))
    trial = draw_bars(with_room(legend), dataset, regions, along, lines_dim)
    named = {text.get_text() for ax in trial for text in ax.texts if text.get_gid() == BAR_NAME}
    legend = [patch for patch in legend if patch.get_label() not in named]
    layout = with_room(legend)
    drawn = spot_axes(layout, along)
    letters = iter(ascii_lowercase if len(drawn) > 1 == len(layout.bars) else "")
    for spot, ax in drawn:
        words = draw(ax, spot)
        write_spot_titles(ax, spot, next(letters, ""), words)
    finish(layout, drawn, draw_bars(layout, dataset, regions, along, lines_dim), dataset, along)
    legend_below(layout.figure, legend, LEGEND_COLUMNS, LEFT)
    return layout.figure, drawn


def draw_bars(
    layout: Layout,
    dataset: xr.Dataset,
    regions: Sequence[Region],
    along: str,
    lines_dim: str | None,
) -> list[Axes]:
    """Draw the bars of regions below each column, with the label of the abscissa."""
    found = []
    for bars in layout.bars:
        strips = list(lines_of(bars.part, lines_dim))
        if lines_dim is not None:
            named = f"{symbol_of(dataset[lines_dim])} = {strips[0].text}"
            if width_of(layout.figure, named, SMALL) < LEFT - BESIDE_BAR:
                strips[0] = replace(strips[0], text=named)
        height = BAR_CM * len(strips)
        ax = axes(layout.figure, bars.left, bars.bottom - height, bars.width, height)
        ax.set_xscale(scale_of(bars.part[along].values))
        draw_strips(ax, strips, regions, along, bars.is_first, bars.width)
        ax.set_xlabel(fitted_label(dataset[along], bars.width))
        plain_ticks(ax.xaxis, 7 if bars.width > 6.0 else 4)
        found.append(ax)
    return found


def finish(
    layout: Layout,
    drawn: list[tuple[Spot, Axes]],
    bars: list[Axes],
    dataset: xr.Dataset,
    along: str,
) -> None:
    """Give panels the abscissa of the bars below them; a panel beside the bars has labels of its own."""
    lowest = min((spot.bottom for spot, _ in drawn), default=0.0)
    for spot, ax in drawn:
        ax.set_xlim(bars[0].get_xlim())
        plain_ticks(ax.yaxis, 5 if spot.height > 3.0 else 3)
        plain_ticks(ax.xaxis, 7 if spot.width > 6.0 else 4)
        is_labelled = (
            spot.bottom == lowest < layout.bars[0].bottom and spot.left > layout.bars[-1].left
        )
        ax.tick_params(which="both", labelbottom=is_labelled)
        if is_labelled:
            ax.set_xlabel(fitted_label(dataset[along], spot.width))


def name_lines(
    drawn: tuple[Spot, Axes], along: str, lines_dim: str, backbone: xr.Dataset | None
) -> None:
    """Write the value of each line on it; of two directions once."""
    spot, ax = drawn
    series = spot.panel.series[0]
    colours = shades(spot.part.sizes[lines_dim])
    named, others = [], []
    for line in lines_of(spot.part, lines_dim):
        x, y = line.row[along].values, series.of(line.row).values
        if line.direction == "down" and DIRECTION in spot.part["regime"].dims:
            others.append((x, y))
            continue
        text = value_text(spot.part[lines_dim], float(line.row[lines_dim]))
        text = text if line.position == 0 else text.rpartition(" = ")[2]
        breaks = breaks_of(x, y, line, series.name in COUNTED)
        named.append(Named(x, y, text, colours[line.position], breaks=breaks))
    label_lines(ax, named, [*others, *backbone_curves(spot.panel, along, backbone)])


def draw_panel(
    ax: Axes,
    spot: Spot,
    along: str,
    lines_dim: str | None,
    backbone: xr.Dataset | None,
    arrows: bool,
) -> tuple[list[Named], list[Curve]]:
    """Draw the series of a panel; return those that share it, with their names, and lines that names avoid."""
    part, series = spot.part, spot.panel.series
    for x, y in backbone_curves(spot.panel, along, backbone):
        ax.plot(x, y, **BACKBONE)
    if series[0].name in WITH_ZERO_LINE | SIGNED:
        zero_line(ax)
    values = [each.of(part).values for each in series]
    if not any(np.isfinite(each).any() for each in values):
        write_centred(ax, empty_text(spot.panel))
    colours = shades(part.sizes[lines_dim]) if lines_dim else series_colours(series)
    named: list[Named] = []
    others: list[Curve] = []  # of the other direction, where they differ
    for number, each in enumerate(series):
        for line in lines_of(part, lines_dim):
            colour = colours[line.position if lines_dim else number]
            x, y = line.row[along].values, each.of(line.row).values
            # where both supports are struck alike, both lines are seen
            dashes = ALIKE if lines_dim is None and each.dim == "support" and each.position else "-"
            draw_line(
                ax, x, y, line, {"color": colour, "linestyle": dashes}, arrows, each.name in COUNTED
            )
            if lines_dim is None and len(series) > 1 and line.direction != "down":
                breaks = breaks_of(x, y, line, each.name in COUNTED)
                named.append(Named(x, y, each.text, colour, breaks=breaks))
            elif named:
                others.append((x, np.where(np.isclose(y, named[-1].y), np.nan, y)))
    if lines_dim is None and len(series) == 1 and DIRECTION in part["regime"].dims:
        named = ways_of(part, series[0], along, colours[0])
    return named, others


def ways_of(part: xr.Dataset, series: Series, along: str, colour: str) -> list[Named]:
    """Return both directions of one line, named where their values differ."""
    lines = list(lines_of(part, None))
    values = [series.of(line.row).values for line in lines]
    apart = np.abs(values[0] - values[-1])
    differ = apart > APART * np.nanmax(np.abs(values), initial=0.0)
    if len(lines) < 2 or not differ.any():
        return []
    return [
        Named(line.row[along].values, np.where(differ, own, np.nan), WAYS[line.direction], colour)
        for line, own in zip(lines, values, strict=True)
    ]


def series_colours(series: tuple[Series, ...]) -> list[str]:
    """Return the colours of series that share a panel: supports have their own, others go from dark to light."""
    if series[0].dim == "support":
        return [SUPPORT_COLOURS[(each.position or 0) + 1] for each in series]
    return shades(len(series), (BLUES[1], BLUES[0])) if len(series) > 1 else [BLUES[1]]


def empty_text(panel: Panel) -> str:
    """Return the reason why a panel without finite values is empty."""
    own = panel.series[0]
    if own.name not in ("impact_velocity_max", *OF_SOFT) or own.dim != "support":
        return "No finite values"
    alone = len(panel.series) == 1 and own.position is not None
    return f"Support {(own.position or 0) + 1} is not struck" if alone else "No support is struck"


def scale_ordinates(drawn: dict[Panel, Axes], dataset: xr.Dataset) -> None:
    """Start the axes of amplitudes at zero, and keep axes of vanishing quantities from being scaled to rounding.

    Quantities are compared with the largest of their family.
    """
    for each, ax in drawn.items():
        name = each.series[0].name
        if name not in SIGNED:
            ax.set_ylim(0.0, max(ax.get_ylim()[1], (1.0 + ROOM) * panel_size(dataset, each)))
        if name == "impacts_per_period":
            cut_high(ax, each, dataset)
        keep_zero_scale(ax, panel_size(dataset, each), family_size(dataset, name))
        if name not in SIGNED:
            ax.set_ylim(bottom=0.0)
        if not any(series.of(dataset).notnull().any() for series in each.series):
            ax.set_yticks([])


def cut_high(ax: Axes, panel: Panel, dataset: xr.Dataset) -> None:
    """End an axis below a few very large values (chatter), and write the largest."""
    values = np.concatenate([series.of(dataset).values.ravel() for series in panel.series])
    values = values[np.isfinite(values)]
    end = 1.15 * float(np.quantile(values, HIGH_SHARE)) if values.size else 0.0
    if 0.0 < HIGH * end < values.max(initial=0.0):
        ax.set_ylim(top=end)
        note(ax, 0.99, 0.95, f"up to {format_number(float(values.max()), 3)}", ha="right")


def panel_size(dataset: xr.Dataset, panel: Panel) -> float:
    """Return the largest finite magnitude of a panel."""
    values = np.stack([np.abs(series.of(dataset).values) for series in panel.series])
    return float(values[np.isfinite(values)].max(initial=0.0))


def backbone_curves(panel: Panel, along: str, backbone: xr.Dataset | None) -> list[Curve]:
    """Return the curves of the backbone of the conservative exciter under those of a panel over the frequency."""
    if backbone is None or along not in ("nu", "omega") or "eigenfrequency" not in backbone:
        return []
    found = []
    for series in panel.series:
        position = series.position or 0
        if series.name in backbone and position < backbone.sizes.get("harmonic", 1):
            found.append((backbone["eigenfrequency"].values, series.of(backbone).values))
    return found
