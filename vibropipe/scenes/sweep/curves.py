"""A sweep along one parameter: mean and harmonics as lines, every row's regime in strips below.

Further swept parameters are lines (the first of them) and columns (the next).
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
    LINES,
    keep_zero_scale,
    legend,
    line_style,
    new_figure,
    write_text,
)
from vibropipe.figures.text import (
    ORDINALS,
    mathtext,
    parameter_line,
)
from vibropipe.scenes.sweep.strips import draw_strips, regime_patches, scale_of
from vibropipe.words.vocabulary import REGIMES, label, quantity

MAX_LINES = len(LINES)
PERIODIC_BELOW = REGIMES["aperiodic"]  # regimes from here on have no orbit
PANEL_HEIGHT_CM = 3.0
COLUMN_HEIGHT_CM = 3.6
STRIP_CM = 0.36
MARGINS_CM = 2.7  # legends and the words of the abscissa
MANY_POINTS = 200  # marks shrink beyond this
SMALL_MARKS = 0.6


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the swept dimensions of a sweep, in the order of the study."""
    return [str(name) for name in dataset["regime"].dims]


def axis_and_others(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the parameter of the abscissa (the finest grid) and the other swept ones."""
    dims = swept(dataset)
    along = max(dims, key=lambda name: dataset.sizes[name])
    return along, [name for name in dims if name != along]


Panel = tuple[str, str, int | None]  # words of the ordinate, variable, position of the harmonic


def panels_of(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Panel]:
    """Return what can be drawn of the quantities shown: without a choice mean and harmonics, else velocities."""
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
            says = f"{ORDINALS[k]} harmonic {letter.replace('_k', f'_{k + 1}')}"
            panels.append((says, "displacement_amplitude", k))
    if "impact_velocity_max" in show and "impact_velocity_max" in dataset:
        symbol = quantity("impact_velocity_max").symbol
        for position, support in enumerate(dataset["support"].values):
            panels.append((f"support {support}: {symbol}", "impact_velocity_max", position))
    return panels


def values_of(dataset: xr.Dataset, panel: Panel) -> xr.DataArray:
    """Return what ``panel`` shows, over the swept dimensions of ``dataset``."""
    _, name, position = panel
    if position is None:
        return dataset[name]
    dim: Hashable = "harmonic" if name.endswith("_amplitude") else "support"
    return dataset[name].isel({dim: position})


def draw_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> Figure:
    """Draw a sweep whose further parameters have few values; see the module's first line.

    show: quantities of the panels, those of `panels_of` if empty; backbone: drawn under the curves.
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
        for place, panel in enumerate(panels):
            spot, beside = spots[place][column], first_of_row.get(place)
            ax = figure.add_subplot(spot, sharex=shared, sharey=beside)
            shared = shared or ax
            first_of_row.setdefault(place, ax)
            draw_panel(ax, part, panel, along, lines_dim, backbone)
            ax.set_title(title if place == 0 else "")
            # folded panels stand above one half of the bars and need numbers of their own
            folded = len(columns) == 1 and place >= len(panels) - 2
            ax.tick_params(labelbottom=folded, labelleft=column == 0)
            ax.set_ylabel(panel[0] if column == 0 else "")
        bottom = figure.add_subplot(bottoms[column], sharex=shared)
        bottom.set_xscale(scale_of(part[along].values))
        shared = shared or bottom
        draw_strips(bottom, part, along, lines_dim, named=column == 0)
        bottom.set_xlabel(label(along))
    scale_ordinates(first_of_row, panels, dataset)
    # bars name their values themselves
    lines = line_handles(dataset, along, lines_dim, backbone) if panels else []
    marks = mark_handles(dataset) if panels else []
    legend(figure, lines, "upper", parameter_line(dataset))
    legend(figure, [*marks, *regime_patches(dataset)], "lower")
    return figure


def lines_of(dataset: xr.Dataset, lines_dim: str | None) -> int:
    """Return how many lines a panel has."""
    return 1 if lines_dim is None else dataset.sizes[lines_dim]


Spots = list[list[SubplotSpec]]


def lay_out(panels: int, columns: int, lines: int) -> tuple[Figure, Spots, list[SubplotSpec]]:
    """Make the figure and the places of its panels [panel][column] and of the bars under them.

    One column of panels is folded into two beside each other, with the bars under both.
    """
    strip = STRIP_CM * lines + 0.25
    if columns > 1:
        figure = new_figure(panels * COLUMN_HEIGHT_CM + strip + MARGINS_CM)
        heights = [*[COLUMN_HEIGHT_CM] * panels, strip]
        grid = figure.add_gridspec(panels + 1, columns, height_ratios=heights)
        spots = [[grid[place, column] for column in range(columns)] for place in range(panels)]
        return figure, spots, [grid[panels, column] for column in range(columns)]
    side = min(2, max(1, panels))
    rows = -(-panels // side)
    figure = new_figure(rows * PANEL_HEIGHT_CM + strip + MARGINS_CM)
    grid = figure.add_gridspec(rows + 1, side, height_ratios=[*[PANEL_HEIGHT_CM] * rows, strip])
    return figure, [[grid[n // side, n % side]] for n in range(panels)], [grid[rows, :]]


def stack_columns(dataset: xr.Dataset, dims: list[str]) -> list[tuple[str, xr.Dataset]]:
    """Return (title, part) of each combination of the values of ``dims``; one part without dims."""
    if not dims:
        return [("", dataset)]
    first, *further = dims
    return [
        (
            ", ".join(
                filter(None, [f"{quantity(first).symbol} = {mathtext(float(value))}", title])
            ),
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
    """Draw one quantity: stable orbits of one forcing period as lines, all else as marks."""
    draw_backbone(ax, panel, along, backbone)
    if not np.isfinite(values_of(part, panel)).any():
        write_text(ax, nothing_words(panel))
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


def nothing_words(panel: Panel) -> str:
    """Say why a panel without a finite value is empty."""
    _, name, position = panel
    if name == "impact_velocity_max" and position is not None:
        return f"Support {position + 1} is not struck"
    return "No row has an average"


def isolated(mask: np.ndarray) -> np.ndarray:
    """Return which points have no neighbour in ``mask``: a line would not show them."""
    padded = np.concatenate([[False], mask, [False]])
    return mask & ~padded[:-2] & ~padded[2:]


def scale_ordinates(axes: dict[int, Axes], panels: list[Panel], dataset: xr.Dataset) -> None:
    """Start amplitudes at zero, once all is drawn; a vanishing quantity gets a calm axis."""
    sizes = [
        float(np.nanmax(np.abs(values_of(dataset, panel).values), initial=0.0)) for panel in panels
    ]
    for place, ax in axes.items():
        if panels[place][1] != "displacement_mean":
            ax.set_ylim(bottom=0.0)
        keep_zero_scale(ax, sizes[place], max(sizes))


ROW_MARKS: dict[str, dict[str, Any]] = {
    "multiple": {
        "linestyle": "none", "marker": "o", "markersize": 3.2, "markerfacecolor": "white",
        "markeredgewidth": 0.7,
    },
    "unstable": {"linestyle": "none", "marker": "x", "markersize": 3.4, "markeredgewidth": 0.8},
    "no_orbit": {"linestyle": "none", "marker": ".", "markersize": 2.8, "markeredgewidth": 0.5},
}  # fmt: skip
ROW_WORDS = {
    "multiple": r"$m>1$ periods: harmonics of $\nu/m$",
    "unstable": "unstable",
    "no_orbit": "no orbit: averaged",
}


def row_kinds(row: xr.Dataset) -> dict[str, np.ndarray]:
    """Return which points are drawn how; together the masks hold every point exactly once."""
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
    """Draw the free vibration of the conservative exciter under the forced one, over nu."""
    if backbone is None or along != "nu" or "eigenfrequency" not in backbone:
        return
    if panel[1] in backbone and (panel[2] is None or panel[2] < backbone.sizes.get("harmonic", 0)):
        ax.plot(backbone["eigenfrequency"], values_of(backbone, panel), **BACKBONE_STYLE)


BACKBONE_STYLE: dict[str, Any] = {"color": GREY, "linewidth": 3.2, "alpha": 0.45, "zorder": 1}


def line_handles(
    dataset: xr.Dataset, along: str, lines_dim: str | None, backbone: xr.Dataset | None
) -> list[Line2D]:
    """Return the legend of the lines by value, and of the curve beside them."""
    handles: list[Line2D] = []
    if lines_dim is not None:
        symbol = quantity(lines_dim).symbol
        for position, value in enumerate(dataset[lines_dim].values):
            says = f"{symbol} = {mathtext(float(value))}"
            handles.append(Line2D([], [], **line_style(position), label=says))
    if backbone is not None and along == "nu" and "eigenfrequency" in backbone:
        handles.append(Line2D([], [], **BACKBONE_STYLE, label="conservative exciter"))
    return handles


def mark_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return the legend of the marks that occur."""
    kinds = row_kinds(dataset)
    return [
        Line2D([], [], **marks, markeredgecolor=BLACK, label=ROW_WORDS[kind])
        for kind, marks in ROW_MARKS.items()
        if kinds[kind].any()
    ]
