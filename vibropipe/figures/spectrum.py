"""Harmonics as a spectrum: amplitudes as stems over multiples of the forcing frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from vibropipe.figures.style import BLUE, VERMILLION

Floats = NDArray[np.float64]
FLOOR = 1e-6  # lowest amplitude on the axis, relative to the largest
STEMS: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "marker": "o"},
    {"color": VERMILLION, "marker": "D", "markerfacecolor": "white"},
)


def lines_of(row: xr.Dataset, name: str) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return (multiples of nu, amplitudes) of the harmonics of one row, then of its subharmonics.

    name : `displacement` or `velocity`
    """
    values = row[f"{name}_amplitude"].values
    harmonics = (np.asarray(row["harmonic"].values, float), values)
    between = f"subharmonic_{name}_amplitude"
    if between not in row:
        return harmonics, (np.empty(0), np.empty(0))
    multiple = max(1, int(row.get("period_multiple", xr.DataArray(1))))
    at = np.asarray(row["subharmonic"].values, float) / multiple
    kept = np.isfinite(row[between].values)
    return harmonics, (at[kept], row[between].values[kept])


def draw_spectrum(ax: Axes, row: xr.Dataset, name: str) -> None:
    """Draw the amplitudes of one row on a log axis; what is rounding error is left out."""
    largest = float(np.nanmax(row[f"{name}_amplitude"].values, initial=0.0))
    shown = np.concatenate([values for _, values in lines_of(row, name)])
    shown = shown[shown > FLOOR * largest]
    # subharmonics may be larger than all harmonics
    top = 3.0 * float(shown.max(initial=0.0) or 1.0)
    floor = 0.3 * float(shown.min(initial=largest or 1.0))
    for (at, values), style in zip(lines_of(row, name), STEMS, strict=True):
        kept = (values > floor) & (at < row.sizes["harmonic"] + 0.5)
        ax.vlines(at[kept], floor, values[kept], color=style["color"], linewidth=1.2)
        ax.plot(at[kept], values[kept], linestyle="none", markersize=3.6, **style)
    ax.set(yscale="log", ylim=(floor, top), xlim=(0, row.sizes["harmonic"] + 0.5))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=8))


def spectrum_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of harmonics and, if the data have them, of subharmonics."""
    texts = [r"harmonics, multiples of $\nu$"]
    if "subharmonic" in dataset.dims:
        texts.append(r"subharmonics, multiples of $\nu/m$")
    return [
        Line2D([], [], markersize=4, **style, label=text)
        for style, text in zip(STEMS, texts, strict=False)
    ]
