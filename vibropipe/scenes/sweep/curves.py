"""A sweep along one parameter: mean and harmonics as lines, the regime of every row in bars below.

The first further swept parameter gives lines, the next one columns.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    BLACK,
    GREY,
    keep_zero_scale,
    legend,
    line_style,
    new_figure,
    write_centred,
)
from vibropipe.figures.text import (
    ORDINALS,
    mathtext,
    parameter_line,
)
from vibropipe.scenes.sweep.strips import draw_strips, regime_patches, scale_of
from vibropipe.words.vocabulary import REGIMES, label, quantity

PERIODIC_BELOW = REGIMES["aperiodic"]  # regimes from here on have no orbit
PANEL_HEIGHT_CM = 3.0
COLUMN_HEIGHT_CM = 3.6
STRIP_CM = 0.36
MARGINS_CM = 2.7  # legends and the label of the abscissa
MANY_POINTS = 200  # marks shrink beyond this
SMALL_MARKS = 0.6


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the swept dimensions, in the order of the study."""
    return [str(name) for name in dataset["regime"].dims]


def axis_and_others(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the parameter of the abscissa, which has the finest grid, and the other swept parameters."""
    dims = swept(dataset)
    along = max(dims, key=lambda name: dataset.sizes[name])
    return along, [name for name in dims if name != along]


Panel = tuple[str, str, int | None]  # label of the ordinate, variable, index of harmonic or support


def panels_of(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Panel]:
    """Return a panel per quantity to show; by default mean and harmonics, or velocities without these."""
    if not show:
        quantities = ("displacement_mean", "displacement_amplitude")
        show = quantities if "displacement_mean" in dataset else ("impact_velocity_max",)
    panels: list[Panel] = []
    if "displacement_mean" in show and "displacement_mean" in dataset:
        mean = quantity("displacement_mean")
        panels.append((f"constant part {mean.symbol}", "displacement_mean", None))
    if "displacement_amplitude" in show and "displacement_amplitude" in dataset:
        letter = quantity("displacement_amplitude").symbol
        for k in range(min(3, dataset.sizes["harmonic"])):
            text = f"{ORDINALS[k]} harmonic {letter.replace('_k', f'_{k + 1}')}"
            panels.append((text, "displacement_amplitude", k))
    if "impact_velocity_max" in show and "impact_velocity_max" in dataset:
        symbol = quantity("impact_velocity_max").symbol
        for position, support in enumerate(dataset["support"].values):
            panels.append((f"support {support}: {symbol}", "impact_velocity_max", position))
    return panels


def values_of(dataset: xr.Dataset, panel: Panel) -> xr.DataArray:
    """Return the quantity of a panel, over the swept dimensions of a dataset."""
    _, name, position = panel
    if position is None:
        return dataset[name]
    dim: Hashable = "harmonic" if name.endswith("_amplitude") else "support"
    return dataset[name].isel({dim: position})


def draw_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> Figure:
    """Draw a sweep whose further parameters have few values.

    Parameters
    ----------
    dataset : xarray.Dataset
        The sweep.
    show : collection of str
        Quantities of the panels (default: those of `panels_of`).
    backbone : xarray.Dataset, optional
        Backbone over amplitude, drawn under the curves.
    """
    along, others = axis_and_others(dataset)
    dataset = dataset.sortby(along)
    lines_dim = others[0] if others else None
    columns = stack_columns(dataset, others[1:])
    panels = panels_of(dataset, show)
    figure, spots, bottoms = lay_out(len(panels), len(columns), lines_of(dataset, lines_dim))
    shared: Axes | None = None
    first_of_row: dict[int, Axes] = {}
    for column, (title, part) in enumerate(columns):
        for index, panel in enumerate(panels):
            spot, neighbour = spots[index][column], first_of_row.get(index)
            ax = figure.add_subplot(spot, sharex=shared, sharey=neighbour)
            shared = shared or ax
            first_of_row.setdefault(index, ax)
            draw_panel(ax, part, panel, along, lines_dim, backbone)
            ax.set_title(title if index == 0 else "")
            # Panels in two columns share one abscissa below, so each needs its own numbers.
            is_folded = len(columns) == 1 and index >= len(panels) - 2
            ax.tick_params(labelbottom=is_folded, labelleft=column == 0)
            ax.set_ylabel(panel[0] if column == 0 else "")
        bottom = figure.add_subplot(bottoms[column], sharex=shared)
        bottom.set_xscale(scale_of(part[along].values))
        shared = shared or bottom
        draw_strips(bottom, part, along, lines_dim, named=column == 0)
        bottom.set_xlabel(label(along))
    scale_ordinates(first_of_row, panels, dataset)
    # The bars are labelled by their own values.
    lines = line_handles(dataset, along, lines_dim, backbone) if panels else []
    marks = mark_handles(dataset, panels) if panels else []
    legend(figure, lines, "upper", parameter_line(dataset))
    legend(figure, [*marks, *regime_patches(dataset)], "lower")
    return figure


def lines_of(dataset: xr.Dataset, lines_dim: str | None) -> int:
    """Return the number of lines of a panel."""
    return 1 if lines_dim is None else dataset.sizes[lines_dim]


Spots = list[list[SubplotSpec]]


def lay_out(panels: int, columns: int, lines: int) -> tuple[Figure, Spots, list[SubplotSpec]]:
    """Return the figure, the cells of its panels [panel][column], and the cells of the bars below.

    A single column of panels is folded into two, with the bars below both.
    """
    strip = STRIP_CM * lines + 0.25
    if columns > 1:
        figure = new_figure(panels * COLUMN_HEIGHT_CM + strip + MARGINS_CM)
        heights = [*[COLUMN_HEIGHT_CM] * panels, strip]
        grid = figure.add_gridspec(panels + 1, columns, height_ratios=heights)
        spots = [[grid[index, column] for column in range(columns)] for index in range(panels)]
        return figure, spots, [grid[panels, column] for column in range(columns)]
    side = min(2, max(1, panels))
    rows = -(-panels // side)
    figure = new_figure(rows * PANEL_HEIGHT_CM + strip + MARGINS_CM)
    grid = figure.add_gridspec(rows + 1, side, height_ratios=[*[PANEL_HEIGHT_CM] * rows, strip])
    return figure, [[grid[n // side, n % side]] for n in range(panels)], [grid[rows, :]]


def stack_columns(dataset: xr.Dataset, dims: list[str]) -> list[tuple[str, xr.Dataset]]:
    """Return (title, part) of each combination of values of some dimensions; one part if there are none."""
    if not dims:
        return [("", dataset)]
    first, *further = dims
    return [
        (
            ", ".join(filter(None, [f"{quantity(first).symbol} = {mathtext(value)}", title])),
            part,
        )
        for position, value in enumerate(dataset[first].values)
        for title, part in stack_columns(dataset.isel({first: position}), further)
    ]


def draw_panel(
    ax: Axes,
    part: xr.Dataset,
    panel: Panel,
    along: str,
    lines_dim: str | None,
    backbone: xr.Dataset | None,
) -> None:
    """Draw one quantity: stable orbits of one forcing period as lines, other rows as marks."""
    draw_backbone(ax, panel, along, backbone)
    if not np.isfinite(values_of(part, panel)).any():
        write_centred(ax, empty_text(panel))
    for position in range(lines_of(part, lines_dim)):
        row = part if lines_dim is None else part.isel({lines_dim: position})
        x, y = row[along].values, values_of(row, panel).values
        style = line_style(position)
        for kind, mask in row_kinds(row).items():
            shown = np.where(mask, y, np.nan)
            if kind == "line":
                ax.plot(x, shown, **style, zorder=2)
                alone = np.where(isolated(mask & np.isfinite(y)), y, np.nan)
                ax.plot(x, alone, ".", markersize=2.8, color=style["color"], zorder=2)
            elif np.isfinite(shown).any():
                marks = {**ROW_MARKS[kind], "markeredgecolor": style["color"]}
                marks["markersize"] *= SMALL_MARKS if x.size > MANY_POINTS else 1.0
                ax.plot(x, shown, **marks, zorder=3)


def empty_text(panel: Panel) -> str:
    """Return the reason why a panel without finite values is empty."""
    _, name, position = panel
    if name == "impact_velocity_max" and position is not None:
        return f"Support {position + 1} is not struck"
    return "No finite values"


def isolated(mask: np.ndarray) -> np.ndarray:
    """Return which points have no neighbour in a mask, so that a line would not show them."""
    padded = np.concatenate([[False], mask, [False]])
    return mask & ~padded[:-2] & ~padded[2:]


def scale_ordinates(axes: dict[int, Axes], panels: list[Panel], dataset: xr.Dataset) -> None:
    """Start the axes of amplitudes at zero, and keep axes of vanishing quantities from being scaled to rounding."""
    sizes = [
        float(np.nanmax(np.abs(values_of(dataset, panel).values), initial=0.0)) for panel in panels
    ]
    for index, ax in axes.items():
        if panels[index][1] != "displacement_mean":
            ax.set_ylim(bottom=0.0)
        keep_zero_scale(ax, sizes[index], max(sizes))


ROW_MARKS: dict[str, dict[str, Any]] = {
    "multiple": {
        "linestyle": "none", "marker": "o", "markersize": 3.2, "markerfacecolor": "white",
        "markeredgewidth": 0.7,
    },
    "unstable": {"linestyle": "none", "marker": "x", "markersize": 3.4, "markeredgewidth": 0.8},
    "no_orbit": {"linestyle": "none", "marker": ".", "markersize": 2.8, "markeredgewidth": 0.5},
}  # fmt: skip
ROW_TEXT = {
    "multiple": r"$m>1$ periods",
    "unstable": "unstable",
    "no_orbit": "no orbit: average",
}


def row_kinds(row: xr.Dataset) -> dict[str, np.ndarray]:
    """Return a mask of the points by kind of mark; each point is in exactly one mask."""
    orbit = row["regime"].values < PERIODIC_BELOW
    stable = row["stable"].values != 0 if "stable" in row else np.ones_like(orbit)
    multiple = (
        row["period_multiple"].values > 1 if "period_multiple" in row else ~np.ones_like(orbit)
    )
    return {
        "line": orbit & stable & ~multiple,
        "multiple": orbit & stable & multiple,
        "unstable": orbit & ~stable,
        "no_orbit": ~orbit,
    }


def draw_backbone(ax: Axes, panel: Panel, along: str, backbone: xr.Dataset | None) -> None:
    """Draw the backbone of the conservative exciter under the curves over nu."""
    if backbone is None or along != "nu" or "eigenfrequency" not in backbone:
        return
    if panel[1] in backbone and (panel[2] is None or panel[2] < backbone.sizes.get("harmonic", 0)):
        ax.plot(backbone["eigenfrequency"], values_of(backbone, panel), **BACKBONE_STYLE)


BACKBONE_STYLE: dict[str, Any] = {"color": GREY, "linewidth": 3.2, "alpha": 0.45, "zorder": 1}


def line_handles(
    dataset: xr.Dataset, along: str, lines_dim: str | None, backbone: xr.Dataset | None
) -> list[Line2D]:
    """Return legend entries of the lines by value, and of the backbone."""
    handles: list[Line2D] = []
    if lines_dim is not None:
        symbol = quantity(lines_dim).symbol
        for position, value in enumerate(dataset[lines_dim].values):
            text = f"{symbol} = {mathtext(value)}"
            handles.append(Line2D([], [], **line_style(position), label=text))
    if backbone is not None and along == "nu" and "eigenfrequency" in backbone:
        handles.append(Line2D([], [], **BACKBONE_STYLE, label="conservative exciter"))
    return handles


def mark_handles(dataset: xr.Dataset, panels: list[Panel]) -> list[Line2D]:
    """Return legend entries of the marks that occur."""
    kinds, text = row_kinds(dataset), dict(ROW_TEXT)
    if any(name == "displacement_amplitude" for _, name, _ in panels):
        text["multiple"] += r": harmonics of $\nu/m$"
    return [
        Line2D([], [], **marks, markeredgecolor=BLACK, label=text[kind])
        for kind, marks in ROW_MARKS.items()
        if kinds[kind].any()
    ]
