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
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from vibropipe.figures.style import (
    BLACK,
    GREEN,
    NEUTRAL,
    REGIME_STYLES,
    keep_zero_scale,
    legend,
    new_figure,
)
from vibropipe.figures.text import (
    ORDINALS,
    REGIME_TEXT,
    axis_label,
    in_brackets,
    parameter_line,
    regime_name,
    symbol_of,
)

PART_COLOURS = {"no_impact": BLACK, "two_sided": GREEN}


def part_style(name: str) -> dict[str, Any]:
    """Return the line style of the part of a curve in one regime."""
    style = REGIME_STYLES[name]
    colour = PART_COLOURS.get(name, style.colour)
    linestyle = "-" if name in PART_COLOURS else style.linestyle
    return {"color": colour, "linestyle": linestyle, "linewidth": 1.6}


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


def draw_parts(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], regime: NDArray[np.int8]
) -> None:
    """Draw one curve in its parts, with a pale band where only one support is struck."""
    for code, piece in parts(regime):
        if regime_name(code).startswith("one_sided"):
            ax.axvspan(x[piece].min(), x[piece].max(), color=NEUTRAL, alpha=0.6, lw=0, zorder=0)
    for code, piece in parts(regime):
        ax.plot(x[piece], y[piece], **part_style(regime_name(code)))


def draw_amplitude_frequency(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw rows: constant part, first three harmonics; columns: displacement, velocity; or those of `show`."""
    names = [name for name in ("displacement", "velocity") if f"{name}_mean" in dataset]
    found = {name: rows_of(dataset, name, show) for name in names}
    columns = [name for name in names if found[name]]
    depth = max(len(found[name]) for name in columns)
    figure = new_figure(2.2 + 3.0 * depth)
    grid = figure.subplots(depth, len(columns), sharex=True, squeeze=False)
    x, regime = dataset["eigenfrequency"].values, dataset["regime"].values
    for column, name in enumerate(columns):
        curves = found[name]
        axes = grid[depth - len(curves) :, column]
        for ax in grid[: depth - len(curves), column]:
            ax.set_visible(False)
        largest = max(float(np.nanmax(np.abs(values))) for _, values in curves)
        axes[0].set_title(name)
        for ax, (text, values) in zip(axes, curves, strict=True):
            draw_parts(ax, x, values, regime)
            ax.set_ylabel(text)
            keep_zero_scale(ax, float(np.nanmax(np.abs(values))), largest)
        axes[-1].set_xlabel(axis_label(dataset["eigenfrequency"]))
        figure.align_ylabels(axes)
    figure.suptitle(
        parameter_line(dataset, leave_out=("nu", "omega", "f", "F", "h", "H", "R1", "R2"))
    )
    present = list(dict.fromkeys(regime_name(code) for code, _ in parts(regime)))
    handles = [Line2D([], [], **part_style(name), label=part_text(name)) for name in present]
    legend(figure, handles, "lower")
    return figure


def part_text(name: str) -> str:
    """Return the legend text of the part in a regime."""
    return "linear: no impact" if name == "no_impact" else REGIME_TEXT[name]
