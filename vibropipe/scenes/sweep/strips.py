"""Bars of the regime of every row along a line, coloured and hatched, and the legend of regimes."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Patch

from vibropipe.figures.style import BLACK, REGIME_STYLES, SMALL_FONT_SIZE
from vibropipe.figures.text import REGIME_TEXT, mathtext, regime_name
from vibropipe.words.vocabulary import quantity

MIN_LOG_POINTS = 4


def draw_strips(ax: Axes, part: xr.Dataset, along: str, lines_dim: str | None, named: bool) -> None:
    """Draw one bar per line with the regime of every row."""
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
    labels = [""] if lines_dim is None else [mathtext(v) for v in part[lines_dim].values]
    ax.set_yticks(range(count), labels if named else [""] * count)
    if named:
        name = "regime" if lines_dim is None else f"regime\nat {quantity(lines_dim).symbol} ="
        ax.set_ylabel(name, fontsize=SMALL_FONT_SIZE)


def cell_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders half-way between ascending grid values, on the scale of their axis.

    A single value gets a cell of width 1.
    """
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    if scale_of(values) == "log":
        return np.exp(cell_edges(np.log(values)))
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def scale_of(values: np.ndarray) -> Literal["linear", "log"]:
    """Return the scale of an axis: log if its values grow by a constant factor."""
    if values.size < MIN_LOG_POINTS or values.min() <= 0.0 or values.max() < 5.0 * values.min():
        return "linear"
    steps = np.diff(np.log(np.sort(values)))
    return "log" if np.ptp(steps) <= 1e-6 * steps.mean() else "linear"


def regime_patches(dataset: xr.Dataset) -> list[Patch]:
    """Return a legend entry for each regime that occurs in a dataset."""
    patches = []
    for code in np.unique(dataset["regime"].values):
        name = regime_name(int(code))
        style = REGIME_STYLES[name]
        patches.append(
            Patch(facecolor=style.colour, hatch=style.hatch, edgecolor=BLACK, linewidth=0.4,
                  label=REGIME_TEXT[name])
        )  # fmt: skip
    return patches
