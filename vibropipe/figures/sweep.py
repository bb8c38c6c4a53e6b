"""A sweep along one parameter: mean and harmonics as lines, every row's regime in strips below.

Further swept parameters are lines (the first of them) and columns (the next).
"""

from __future__ import annotations

from collections.abc import Hashable
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vibropipe.figures.options import Options
from vibropipe.figures.style import (
    BLACK,
    GREY,
    REGIME_STYLES,
    SMALL_FONT_SIZE,
    hold_zero,
    legend,
    line_style,
    new_figure,
)
from vibropipe.figures.words import (
    ORDINALS,
    REGIME_WORDS,
    mathtext,
    parameter_line,
    regime_name,
)
from vibropipe.vocabulary import REGIMES, label, quantity

MOST_LINES = 8
PERIODIC_BELOW = REGIMES["aperiodic"]  # regimes from here on have no orbit
PANEL_HEIGHT_CM = 4.1
STRIP_CM = 0.42


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the swept dimensions of a sweep, in the order of the study."""
    return [str(name) for name in dataset["regime"].dims]


def axis_and_rest(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the parameter of the abscissa (the finest grid) and the other swept ones."""
    dims = swept(dataset)
    along = max(dims, key=lambda name: dataset.sizes[name])
    return along, [name for name in dims if name != along]


Panel = tuple[str, str, int | None]  # words of the ordinate, variable, position of the harmonic


def panels_of(dataset: xr.Dataset) -> list[Panel]:
    """Return what can be drawn: mean and up to three harmonics, else velocities at the supports."""
    panels: list[Panel] = []
    if "displacement_mean" in dataset:
        mean = quantity("displacement_mean")
        panels.append((f"constant part {mean.symbol}", "displacement_mean", None))
        letter = quantity("displacement_amplitude").symbol
        for k in range(min(3, dataset.sizes["harmonic"])):
            says = f"{ORDINALS[k]} harmonic {letter.replace('_k', f'_{k + 1}')}"
            panels.append((says, "displacement_amplitude", k))
    elif "impact_velocity_max" in dataset:
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


def draw_sweep(dataset: xr.Dataset, options: Options) -> Figure:
    """Draw a sweep whose further parameters have few values; see the module's first line."""
    along, rest = axis_and_rest(dataset)
    lines_dim = rest[0] if rest else None
    columns = stack_columns(dataset, rest[1:])
    panels = panels_of(dataset)
    lines = 1 if lines_dim is None else dataset.sizes[lines_dim]
    side = len(columns) if len(columns) > 1 else min(2, max(1, len(panels)))
    rows = len(panels) if len(columns) > 1 else -(-len(panels) // side)
    strip = STRIP_CM * lines + 0.3
    figure = new_figure(rows * PANEL_HEIGHT_CM + strip + 3.6)
    grid = figure.add_gridspec(rows + 1, side, height_ratios=[PANEL_HEIGHT_CM] * rows + [strip])
    shared: Axes | None = None
    first_of_row: dict[int, Axes] = {}
    for column, (title, part) in enumerate(columns):
        for place, panel in enumerate(panels):
            spot = grid[place, column] if len(columns) > 1 else grid[place // side, place % side]
            ax = figure.add_subplot(spot, sharex=shared, sharey=first_of_row.get(place))
            shared = shared or ax
            draw_panel(ax, part, panel, along, lines_dim, options)
            ax.set_title(title if place == 0 else "")
            ax.tick_params(labelbottom=False)
            if column > 0:
                ax.tick_params(labelleft=False)
                ax.set_ylabel("")
            first_of_row.setdefault(place, ax)
        spot = grid[rows, column] if len(columns) > 1 else grid[rows, :]
        bottom = figure.add_subplot(spot, sharex=shared)
        shared = shared or bottom
        draw_strips(bottom, part, along, lines_dim, named=column == 0)
        bottom.set_xlabel(label(along))
    settle_ordinates(first_of_row, panels, dataset)
    above = legend_handles(dataset, along, lines_dim, options)
    legend(figure, above, "upper", title=parameter_line(dataset))
    legend(figure, regime_patches(dataset), "lower")
    return figure


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
    ax: Axes, part: xr.Dataset, panel: Panel, along: str, lines_dim: str | None, options: Options
) -> None:
    """Draw one quantity: stable orbits of one forcing period as lines, all else as marks."""
    ax.set_ylabel(panel[0])
    draw_beside(ax, panel, along, options)
    count = 1 if lines_dim is None else part.sizes[lines_dim]
    for position in range(count):
        row = part if lines_dim is None else part.isel({lines_dim: position})
        x, y = row[along].values, values_of(row, panel).values
        style = line_style(position)
        for kind, mask in row_kinds(row).items():
            shown = np.where(mask, y, np.nan)
            if kind == "line":
                ax.plot(x, shown, **style, zorder=2)
            elif np.isfinite(shown).any():
                ax.plot(x, shown, **ROW_MARKS[kind], markeredgecolor=style["color"], zorder=3)


def settle_ordinates(axes: dict[int, Axes], panels: list[Panel], dataset: xr.Dataset) -> None:
    """Start amplitudes at zero, once all is drawn; a vanishing quantity gets a calm axis."""
    sizes = [
        float(np.nanmax(np.abs(values_of(dataset, panel).values), initial=0.0)) for panel in panels
    ]
    for place, ax in axes.items():
        if panels[place][1] != "displacement_mean":
            ax.set_ylim(bottom=0.0)
        hold_zero(ax, sizes[place], max(sizes))


ROW_MARKS: dict[str, dict[str, Any]] = {
    "multiple": {
        "linestyle": "none", "marker": "o", "markersize": 3.2, "markerfacecolor": "white",
        "markeredgewidth": 0.7,
    },
    "unstable": {"linestyle": "none", "marker": "x", "markersize": 3.4, "markeredgewidth": 0.8},
    "no_orbit": {"linestyle": "none", "marker": ".", "markersize": 2.8, "markeredgewidth": 0.5},
}  # fmt: skip
ROW_WORDS = {
    "multiple": "orbit of $m>1$ forcing periods",
    "unstable": "unstable orbit",
    "no_orbit": "no orbit: averaged over a window",
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


def draw_beside(ax: Axes, panel: Panel, along: str, options: Options) -> None:
    """Draw the free vibration of the conservative exciter under the forced one, over nu."""
    beside = options.beside
    if beside is None or along != "nu" or "eigenfrequency" not in beside:
        return
    if panel[1] in beside and (panel[2] is None or panel[2] < beside.sizes.get("harmonic", 0)):
        ax.plot(beside["eigenfrequency"], values_of(beside, panel), **BESIDE_STYLE)


BESIDE_STYLE: dict[str, Any] = {"color": GREY, "linewidth": 3.2, "alpha": 0.45, "zorder": 1}


def draw_strips(ax: Axes, part: xr.Dataset, along: str, lines_dim: str | None, named: bool) -> None:
    """Draw one bar per line: the regime of every row of the sweep, in colour and hatch."""
    edges = cell_edges(part[along].values)
    count = 1 if lines_dim is None else part.sizes[lines_dim]
    for position in range(count):
        row = part if lines_dim is None else part.isel({lines_dim: position})
        regime = row["regime"].values
        cuts = [0, *(np.flatnonzero(np.diff(regime)) + 1), regime.size]
        boxes: dict[int, list[list[tuple[float, float]]]] = {}
        for start, stop in pairwise(cuts):
            left, right = edges[start], edges[stop]
            low, high = position - 0.36, position + 0.36
            box = [(left, low), (right, low), (right, high), (left, high)]
            boxes.setdefault(int(regime[start]), []).append(box)
        for code, polygons in boxes.items():
            style = REGIME_STYLES[regime_name(code)]
            ax.add_collection(
                PolyCollection(polygons, facecolor=style.colour, hatch=style.hatch,
                               edgecolor="black", linewidth=0.2)
            )  # fmt: skip
    ax.set_ylim(count - 0.4, -0.6)
    ax.set_xlim(edges[0], edges[-1])
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    says = [""] if lines_dim is None else [mathtext(float(v)) for v in part[lines_dim].values]
    ax.set_yticks(range(count), says if named else [""] * count)
    if named:
        name = "regime" if lines_dim is None else f"regime\nat {quantity(lines_dim).symbol} ="
        ax.set_ylabel(name, fontsize=SMALL_FONT_SIZE)


def cell_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders between neighbouring grid values, half-way; one value gets a width."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def legend_handles(
    dataset: xr.Dataset, along: str, lines_dim: str | None, options: Options
) -> list[Line2D]:
    """Return lines by value, marks that occur, and the curve beside."""
    handles: list[Line2D] = []
    if lines_dim is not None:
        symbol = quantity(lines_dim).symbol
        for position, value in enumerate(dataset[lines_dim].values):
            handles.append(
                Line2D([], [], **line_style(position), label=f"{symbol} = {mathtext(float(value))}")
            )
    kinds = row_kinds(dataset)
    for kind, marks in ROW_MARKS.items():
        if kinds[kind].any():
            handles.append(Line2D([], [], **marks, markeredgecolor=BLACK, label=ROW_WORDS[kind]))
    if options.beside is not None and along == "nu" and "eigenfrequency" in options.beside:
        handles.append(Line2D([], [], **BESIDE_STYLE, label="conservative exciter"))
    return handles


def regime_patches(dataset: xr.Dataset) -> list[Patch]:
    """Return a legend entry for each regime that occurs in ``dataset``."""
    patches = []
    for code in np.unique(dataset["regime"].values):
        name = regime_name(int(code))
        style = REGIME_STYLES[name]
        patches.append(
            Patch(facecolor=style.colour, hatch=style.hatch, edgecolor=BLACK, linewidth=0.4,
                  label=REGIME_WORDS[name])
        )  # fmt: skip
    return patches
