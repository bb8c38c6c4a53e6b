"""A sweep along one parameter: its quantities as lines, the regime of every row in bars below.

The first further swept parameter gives lines, the next ones columns or small multiples. Rows that were followed in
both directions are drawn in one panel.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.map_shapes import scale_of
from vibropipe.figures.style import (
    GREY,
    SMALL_FONT_SIZE,
    SUPPORT_COLOURS,
    keep_zero_scale,
    legend,
    line_style,
    write_centred,
)
from vibropipe.figures.text import (
    format_number,
    frequency,
    parameter_line,
    symbol_of,
)
from vibropipe.scenes.sweep.layout import Column, Spots, columns_of, lay_out
from vibropipe.scenes.sweep.legends import (
    BACKBONE_STYLE,
    direction_handles,
    line_handles,
    mark_handles,
)
from vibropipe.scenes.sweep.lines import branches_differ, draw_arrows, draw_line, lines_of
from vibropipe.scenes.sweep.quantities import (
    SIGNED,
    WITH_ZERO_LINE,
    Panel,
    Series,
    abscissa_label,
    axis_and_others,
    directions,
    panels_of,
    with_impacts_per_period,
)
from vibropipe.scenes.sweep.strips import Strip, draw_strips, regime_patches
from vibropipe.solve.shown_units import shows_cycles
from vibropipe.solve.sweep_grid import DIRECTION
from vibropipe.words.contacts import OF_SOFT

HIGH_SHARE, HIGH = (
    0.99,
    2.0,
)  # an axis of impacts ends at this quantile if the largest value is HIGH times as large


def draw_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> Figure:
    """Draw a sweep whose further parameters have few values.

    Parameters
    ----------
    dataset : xarray.Dataset
        The sweep.
    show : collection of str
        Quantities of the panels (default: `quantities.DEFAULT_SHOW`).
    backbone : xarray.Dataset, optional
        Backbone over amplitude, drawn under the curves.
    """
    along, others = axis_and_others(dataset)
    dataset = with_impacts_per_period(dataset.sortby(along))
    lines_dim = others[0] if others else None
    panels = panels_of(dataset, show, joined=lines_dim is None)
    rows = columns_of(dataset, others[1:], panels, fold=lines_dim is not None)
    lines = list(lines_of(rows[0][0].part, lines_dim))
    figure, spots = lay_out(rows, len(lines))
    shared: dict[Any, Axes] = {}
    name = "regime" if lines_dim is None else f"regime at\n{symbol_of(dataset[lines_dim])} ="
    for row, row_spots in zip(rows, spots, strict=True):
        for number, (column, own) in enumerate(zip(row, row_spots, strict=True)):
            axes = draw_column(figure, column, own, along, lines_dim, backbone, shared)
            bottom = axes[-1]
            strips = [Strip(line.text, line.row) for line in lines_of(column.part, lines_dim)]
            draw_strips(bottom, strips, along, name if number == 0 else "", own.width_cm)
            bottom.set_xlabel(abscissa_label(dataset[along], own.width_cm))
            figure.align_ylabels(axes[:-1])
            if number > 0 and column.panels == row[0].panels:
                for ax in axes[:-1]:
                    ax.tick_params(labelleft=False)
                    ax.set_ylabel("")
    used = [panel for panel in panels if panel in shared]
    scale_ordinates({panel: shared[panel] for panel in used}, dataset)
    add_legends(figure, dataset, used, along, lines_dim, backbone)
    return figure


def draw_column(
    figure: Figure,
    column: Column,
    spots: Spots,
    along: str,
    lines_dim: str | None,
    backbone: xr.Dataset | None,
    shared: dict[Any, Axes],
) -> list[Axes]:
    """Draw the panels of a column and return their axes, with that of the bars at the end."""
    axes: list[Axes] = []
    for panel, spot in zip(column.panels, spots.panels, strict=True):
        ax = figure.add_subplot(spot, sharex=shared.get("x"), sharey=shared.get(panel))
        shared.setdefault("x", ax)
        shared.setdefault(panel, ax)
        axes.append(ax)
        draw_panel(ax, column.part, panel, along, lines_dim, backbone)
        ax.tick_params(labelbottom=False)
        ax.set_ylabel(panel.fitted(spots.height_cm))
    bottom = figure.add_subplot(spots.strip, sharex=shared.get("x"))
    shared.setdefault("x", bottom)
    bottom.set_xscale(scale_of(column.part[along].values))
    top = axes[0] if axes else bottom
    top.set_title(column.title)
    if along == "omega" and axes and not shows_cycles(column.part[along]):
        hertz = top.secondary_xaxis("top", functions=(to_hertz, from_hertz))
        hertz.set_xlabel("frequency (Hz)")
    return [*axes, bottom]


def to_hertz(omega: Any) -> Any:
    """Convert rad/s to Hz."""
    return np.asarray(omega) / (2 * np.pi)


def from_hertz(hertz: Any) -> Any:
    """Convert Hz to rad/s."""
    return np.asarray(hertz) * 2 * np.pi


def add_legends(
    figure: Figure,
    dataset: xr.Dataset,
    panels: list[Panel],
    along: str,
    lines_dim: str | None,
    backbone: xr.Dataset | None,
) -> None:
    """Add lines, directions and parameters above, marks and regimes below."""
    is_under = backbone is not None and along == frequency(dataset) and "eigenfrequency" in backbone
    above = line_handles(dataset, lines_dim, is_under) if panels else []
    above += direction_handles(directions(dataset)) if panels else []
    legend(figure, above, "upper", parameter_line(dataset))
    marks = mark_handles(dataset) if panels else []
    legend(figure, [*marks, *regime_patches(dataset)], "lower")


def draw_panel(
    ax: Axes,
    part: xr.Dataset,
    panel: Panel,
    along: str,
    lines_dim: str | None,
    backbone: xr.Dataset | None,
) -> None:
    """Draw the series of a panel: stable orbits of one forcing period as lines, other rows as marks."""
    draw_backbone(ax, panel, along, backbone)
    if panel.series[0].name in WITH_ZERO_LINE:
        ax.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    both = DIRECTION in part["regime"].dims
    values = [series.of(part).values for series in panel.series]
    if not any(np.isfinite(each).any() for each in values):
        write_centred(ax, empty_text(panel))
    is_joined = len(panel.series) > 1
    for number, series in enumerate(panel.series):
        for line in lines_of(part, lines_dim):
            style = series_style(series, number) if is_joined else line_style(line.position)
            label = series.text if is_joined and not np.isnan(values[number]).all() else ""
            x, y = line.row[along].values, series.of(line.row).values
            draw_line(ax, x, y, line.row, {**style, "label": label})
            if line.direction:
                rows = part if lines_dim is None else part.isel({lines_dim: line.position})
                differs = branches_differ(series.of(rows)) if both else None
                draw_arrows(ax, x, y, line, differs, style["color"])
    if is_joined and ax.get_legend_handles_labels()[0]:
        by_text = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
        ax.legend(
            by_text.values(), by_text.keys(), loc="upper left", bbox_to_anchor=(1.0, 1.05),
            handlelength=2.6, borderaxespad=0.2,
        )  # fmt: skip


def series_style(series: Series, number: int) -> dict[str, Any]:
    """Return colour and dashes of a series in a joined panel; supports have their own colours."""
    style = line_style(number)
    if series.dim == "support" and series.position is not None:
        style["color"] = SUPPORT_COLOURS.get(series.position + 1, style["color"])
    return style


def empty_text(panel: Panel) -> str:
    """Return the reason why a panel without finite values is empty."""
    supports = [series.position for series in panel.series if series.dim == "support"]
    if panel.series[0].name in ("impact_velocity_max", *OF_SOFT) and supports:
        return (
            f"Support {supports[0] + 1} is not struck"
            if len(supports) == 1 and supports[0] is not None
            else "No support is struck"
        )
    return "No finite values"


def scale_ordinates(axes: dict[Panel, Axes], dataset: xr.Dataset) -> None:
    """Start the axes of amplitudes at zero, and keep axes of vanishing quantities from being scaled to rounding.

    Quantities are compared with the largest of the same units.
    """
    sizes = {panel: panel_size(dataset, panel) for panel in axes}
    for panel, ax in axes.items():
        name = panel.series[0].name
        if name not in SIGNED:
            ax.set_ylim(bottom=0.0)
        if name == "impacts_per_period":
            cut_high(ax, panel, dataset)
        stem = name.partition("_")[0]
        alike = [size for other, size in sizes.items() if other.series[0].name.startswith(stem)]
        keep_zero_scale(ax, sizes[panel], max(alike))


def cut_high(ax: Axes, panel: Panel, dataset: xr.Dataset) -> None:
    """End an axis below a few very large values (chatter), and write the largest."""
    values = np.concatenate([series.of(dataset).values.ravel() for series in panel.series])
    values = values[np.isfinite(values)]
    end = 1.15 * float(np.quantile(values, HIGH_SHARE)) if values.size else 0.0
    if 0.0 < HIGH * end < values.max(initial=0.0):
        ax.set_ylim(top=end)
        ax.text(
            0.99, 0.95, f"up to {format_number(float(values.max()), 3)}", transform=ax.transAxes,
            ha="right", va="top", fontsize=SMALL_FONT_SIZE,
        )  # fmt: skip


def panel_size(dataset: xr.Dataset, panel: Panel) -> float:
    """Return the largest finite magnitude of a panel."""
    values = np.stack([np.abs(series.of(dataset).values) for series in panel.series])
    return float(values[np.isfinite(values)].max(initial=0.0))


def draw_backbone(ax: Axes, panel: Panel, along: str, backbone: xr.Dataset | None) -> None:
    """Draw the backbone of the conservative exciter under the curves over the frequency."""
    if backbone is None or along not in ("nu", "omega") or "eigenfrequency" not in backbone:
        return
    for series in panel.series:
        position = series.position or 0
        if series.name in backbone and position < backbone.sizes.get("harmonic", 1):
            ax.plot(backbone["eigenfrequency"], series.of(backbone), **BACKBONE_STYLE)
