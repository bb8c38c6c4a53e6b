"""Amplitude-frequency characteristics of the conservative exciter: figures 5 and 8 of the paper.

Constant part and harmonics of displacement and velocity against the eigenfrequency, which is 1 at any
amplitude without impacts and grows with the amplitude once a support is struck.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.canvas import axes as placed
from vibropipe.figures.canvas import new_canvas, panel
from vibropipe.figures.palette import BAND, GREY, INK, SUPPORT_COLOURS
from vibropipe.figures.style import ROUNDING, keep_zero_scale
from vibropipe.figures.text import ORDINALS, axis_label, in_brackets, regime_name, symbol_of

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
        rows.append(
            (
                f"constant part\n{in_brackets(symbol_of(dataset[mean]), dataset[mean])}",
                dataset[mean].values,
            )
        )
    if not show or peak in show:
        for k in range(min(3, dataset.sizes["harmonic"])):
            symbol = in_brackets(symbol_of(dataset[peak], k + 1), dataset[peak])
            values = dataset[peak].isel(harmonic=k).transpose("amplitude").values
            rows.append((f"{ORDINALS[k]} harmonic\n{symbol}", values))
    return rows


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
        ax.plot(x[piece], y[piece], **PART_STYLES[name])


def draw_amplitude_frequency(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw rows: constant part, first three harmonics; columns: displacement, velocity; or those of `show`."""
    names = [name for name in ("displacement", "velocity") if f"{name}_mean" in dataset]
    found = {name: without_rounding(rows_of(dataset, name, show)) for name in names}
    columns = [name for name in names if found[name]]
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
