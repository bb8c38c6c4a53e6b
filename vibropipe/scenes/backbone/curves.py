"""Free vibration with impacts: eq. (10), figures 2 and 3 of the paper; over amplitude, figures 5 and 8.

Over amplitude: mean and harmonics against the eigenfrequency, which is 1 at any amplitude without impacts and
grows with the amplitude once a support is struck.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from vibropipe.figures.canvas import WIDE, new_canvas, panel
from vibropipe.figures.canvas import axes as placed
from vibropipe.figures.palette import BAND, GREY, INK, SUPPORT_COLOURS, shades
from vibropipe.figures.regime_words import regime_name
from vibropipe.figures.style import LINE_MARKERS, ROUNDING, keep_zero_scale
from vibropipe.figures.text import ORDINALS, axis_label, format_number, in_brackets, symbol_of
from vibropipe.solve.shown_units import in_si, shown_factor
from vibropipe.words.vocabulary import PHYSICAL_NAMES, held_name, quantity

LEFT, BOTTOM, PANEL, GAP, TOP = 1.75, 1.1, 2.05, 0.4, 0.55  # cm
WIDTH = 6.0  # cm, of a column
# Parts in which one support is struck stand out, with a band behind them.
PART_STYLES: dict[str, dict[str, Any]] = {
    "one_sided_1": {"color": SUPPORT_COLOURS[1], "linewidth": 2.0},
    "one_sided_2": {"color": SUPPORT_COLOURS[2], "linewidth": 2.0},
    "two_sided": {"color": INK, "linewidth": 1.2},
    "no_impact": {"color": GREY, "linewidth": 1.2, "linestyle": (0, (3, 1.2))},
}


def parts(regime: NDArray[np.int8]) -> list[tuple[int, slice]]:
    """Split the rows into (regime, slice) of equal regime; each slice starts at the last row before.

    The overlap joins the parts of a curve.
    """
    cuts = [int(cut) for cut in np.flatnonzero(np.diff(regime)) + 1]
    starts, stops = [0, *cuts], [*cuts, regime.size]
    return [(int(regime[a]), slice(max(a - 1, 0), b)) for a, b in zip(starts, stops, strict=True)]


def rows_of(
    dataset: xr.Dataset, name: str, show: Collection[str] = ()
) -> list[tuple[str, NDArray[np.float64]]]:
    """Return (label, values over amplitude) of the mean and up to three harmonics, as far as `show` has them."""
    mean, peak = f"{name}_mean", f"{name}_amplitude"
    rows = []
    if not show or mean in show:
        symbol = in_brackets(symbol_of(dataset[mean]), dataset[mean])
        rows.append((f"mean {name}\n{symbol}", dataset[mean].values))
    if not show or peak in show:
        for k in range(min(3, dataset.sizes["harmonic"])):
            symbol = in_brackets(symbol_of(dataset[peak], k + 1), dataset[peak])
            values = dataset[peak].isel(harmonic=k).transpose("amplitude").values
            rows.append((f"{ORDINALS[k]} harmonic\n{symbol}", values))
    return rows


def drawn_kinds(dataset: xr.Dataset, show: Collection[str] = ()) -> list[str]:
    """Return which of displacement and velocity have curves, or have any of `show`."""
    names = [name for name in ("displacement", "velocity") if f"{name}_mean" in dataset]
    return [name for name in names if rows_of(dataset, name, show)]


def without_rounding(
    rows: list[tuple[str, NDArray[np.float64]]],
) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the rows without those that are only rounding beside the largest; all if there is nothing else."""
    sizes = [float(np.nanmax(np.abs(values))) for _, values in rows]
    kept = [row for row, size in zip(rows, sizes, strict=True) if size > ROUNDING * max(sizes)]
    return kept or rows


def draw_parts(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], regime: NDArray[np.int8]
) -> None:
    """Draw one curve in its parts, with a pale band where only one support is struck."""
    for code, piece in parts(regime):
        name = regime_name(code)
        if name.startswith("one_sided"):
            ax.axvspan(x[piece].min(), x[piece].max(), color=BAND, lw=0, zorder=0)
        ax.plot(x[piece], y[piece], **PART_STYLES[name], **lone_mark(y[piece]))


def lone_mark(values: NDArray[np.float64]) -> dict[str, Any]:
    """Return the mark of a line of one point, which is none; empty for others."""
    return {"marker": "."} if np.isfinite(values).sum() == 1 else {}


def draw_amplitude_frequency(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw rows: mean, first three harmonics; columns: displacement, velocity; or those of `show`."""
    columns = drawn_kinds(dataset, show)
    found = {name: without_rounding(rows_of(dataset, name, show)) for name in columns}
    depth = max(len(found[name]) for name in columns)
    high = depth * (PANEL + GAP) - GAP
    figure = new_canvas(BOTTOM + high + TOP)
    x, regime = dataset["eigenfrequency"].values, dataset["regime"].values
    grid: dict[tuple[int, str], Axes] = {}
    for row in range(depth):
        for column, name in enumerate(columns):
            if row < len(found[name]):
                bottom = BOTTOM + (len(found[name]) - 1 - row) * (PANEL + GAP)
                left = LEFT + column * (WIDTH + 2.0)
                grid[row, name] = placed(figure, left, bottom, WIDTH, PANEL)
    for name in columns:
        curves = found[name]
        own = [grid[row, name] for row in range(len(curves))]
        largest = max(float(np.nanmax(np.abs(values))) for _, values in curves)
        for ax, (text, values) in zip(own, curves, strict=True):
            draw_parts(ax, x, values, regime)
            ax.set_ylabel(text)
            keep_zero_scale(ax, float(np.nanmax(np.abs(values))), largest)
            ax.tick_params(labelbottom=ax is own[-1])
        panel(own[0], title=name)
        own[-1].set_xlabel(axis_label(dataset["eigenfrequency"]))
        figure.align_ylabels(own)
    return figure


LAW_HEIGHT, LAW_LEFT, LAW_GAP = 7.6, 1.6, 0.7  # cm


def draw_backbone(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw velocity_over_l against tau_bar and omega_bar (or those of `show`), one line per delta_over_l.

    Hollow markers, one shape per line, show simulated conservative motions.
    """
    figure = new_canvas(LAW_HEIGHT)
    names = [name for name in ("tau_bar", "omega_bar") if name in (show or (name,))]
    width = (WIDE - LAW_LEFT - 0.3 - LAW_GAP * (len(names) - 1)) / len(names)
    axes = {
        name: placed(
            figure, LAW_LEFT + n * (width + LAW_GAP), BOTTOM, width, LAW_HEIGHT - BOTTOM - 0.3
        )
        for n, name in enumerate(names)
    }
    colours = shades(dataset.sizes["delta_over_l"])
    dataset = dataset.rename(
        {new: name for name, new in PHYSICAL_NAMES.items() if new in dataset.variables}
    )
    # 2 pi, or 2000 pi for milliseconds beside rad/s
    turn = float(dataset["tau_bar"][0] * dataset["omega_bar"][0])
    symbol = quantity("delta_over_l").symbol
    handles = []
    for position, value in enumerate(dataset["delta_over_l"].values):
        style: dict[str, Any] = {"color": colours[position]}
        marker: dict[str, Any] = {
            "marker": LINE_MARKERS[position % len(LINE_MARKERS)],
            "markerfacecolor": "white",
            "markeredgecolor": style["color"],
        }
        line = dataset["velocity_over_l"].isel(delta_over_l=position)
        for name, ax in axes.items():
            ax.plot(dataset[name], line, **style, **lone_mark(line.values))
        shown: dict[str, Any] = {}
        if has_simulated(dataset):
            points = dataset.isel(delta_over_l=position)
            tau_bar = points["simulated_tau_bar"].values
            height = points["simulated_velocity_over_l"].values
            for name, ax in axes.items():
                x = tau_bar if name == "tau_bar" else turn / tau_bar
                ax.plot(x, height, linestyle="none", **marker)
            shown = marker
        handles.append(Line2D([], [], **style, **shown, label=f"{symbol} = {format_number(value)}"))
    for name, ax in axes.items():
        ax.set_xlabel(axis_label(dataset[name]))
        ax.set_ylim(bottom=0.0)
        ax.tick_params(labelleft=ax is figure.axes[0])
    figure.axes[0].set_ylabel(axis_label(dataset["velocity_over_l"]))
    # both curves fall, or rise from the lower left: a corner of the first panel is free
    figure.axes[0].legend(handles=handles, loc="upper right" if "tau_bar" in axes else "upper left")
    return figure


def has_simulated(dataset: xr.Dataset) -> bool:
    """Return whether simulated motions are marked on the curves."""
    name = "simulated_velocity_over_l"
    return name in dataset and bool(dataset[name].notnull().any())


def longest_period(dataset: xr.Dataset, delta_over_l: float) -> float:
    """Return the period at which a motion touches the farther support: 2 arccos(-(1 - |d|) / (1 + |d|)), d = delta/l.

    Motions of every shorter period strike both supports, eq. (10).
    """
    off = abs(delta_over_l)
    period = 2.0 * math.acos(max(-1.0, -(1.0 - off) / (1.0 + off)))
    if not {"m", "C"} <= set(dataset.coords):
        return period
    unit = str(dataset[held_name(dataset, "tau_bar")].attrs.get("units", "s"))
    m, C = (float(in_si(dataset[name])) for name in ("m", "C"))
    return period * math.sqrt(m / C) * shown_factor(unit)


def first_strikes(dataset: xr.Dataset) -> tuple[float, float]:
    """Return the amplitudes from which motions strike the nearer and the farther support."""
    numbers = {
        name: float(in_si(dataset[name])) if name in dataset.coords else absent
        for name, absent in (("l", math.nan), ("delta", 0.0), ("load", 0.0), ("C", 1.0))
    }
    offset = abs(numbers["delta"] - numbers["load"] / numbers["C"])
    factor = shown_factor(str(dataset["amplitude"].attrs.get("units", "1")))
    return factor * (numbers["l"] - offset), factor * (numbers["l"] + offset)
