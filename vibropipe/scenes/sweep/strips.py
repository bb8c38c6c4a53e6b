"""Bars of the regime of every row along a line, coloured and hatched, and the legend of regimes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

from vibropipe.figures.canvas import SMALL
from vibropipe.figures.map_shapes import cell_edges
from vibropipe.figures.palette import REGIME_STYLES
from vibropipe.figures.style import BLACK
from vibropipe.figures.text import REGIME_TEXT, regime_name

MAX_RUNS = 2000  # runs of equal regime in a bar: finer than a printer resolves
MANY_RUNS = 400  # a bar of more runs is stored as pixels
LETTER_CM = 0.145  # usual width of a letter
BAR_NAME = "name of a bar"
LONE_MARGIN = 4.5  # widths of the bar of a single row that are left free on either side


@dataclass(frozen=True)
class Strip:
    """The rows along one line, with the label of their bar."""

    text: str
    row: xr.Dataset


def draw_strips(
    ax: Axes, strips: Sequence[Strip], along: str, named: bool = True, width_cm: float = 0.0
) -> None:
    """Draw one bar per line with the regime of every row, named in the bar where the name fits.

    Parameters
    ----------
    ax : Axes
        Where; its abscissa is that of the panels above.
    strips : sequence of Strip
        The lines, from top to bottom.
    along : str
        Parameter of the abscissa.
    named : bool
        Whether the bars have the texts of their lines beside them.
    width_cm : float
        Printed width of the axes (default: no names in the bars).
    """
    edges = cell_edges(strips[0].row[along].values)
    # a lone bar that filled the axis would claim a range
    margin = LONE_MARGIN * (edges[-1] - edges[0]) if edges.size == 2 else 0.0
    ax.set_xlim(edges[0] - margin, edges[-1] + margin)
    for position, strip in enumerate(strips):
        draw_bar(ax, strip.row["regime"].values, edges, position, width_cm)
    ax.set_ylim(len(strips) - 0.4, -0.6)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    ax.set_yticks(range(len(strips)), [strip.text if named else "" for strip in strips])


def draw_bar(
    ax: Axes, regime: NDArray[np.int8], edges: NDArray[np.float64], position: int, width_cm: float
) -> None:
    """Draw the bar of one line; of very many runs, one row of each MAX_RUNS-th part stands for the part."""
    cuts = np.concatenate([[0], np.flatnonzero(np.diff(regime)) + 1, [regime.size]])
    if cuts.size > MAX_RUNS:
        kept = np.unique(np.linspace(0, regime.size, MAX_RUNS).astype(int))
        regime = np.repeat(regime[kept[:-1]], np.diff(kept))
        cuts = np.concatenate([[0], np.flatnonzero(np.diff(regime)) + 1, [regime.size]])
    low, high = position - 0.36, position + 0.36
    boxes: dict[int, list[list[tuple[float, float]]]] = {}
    for start, stop in pairwise(cuts.tolist()):
        left, right = float(edges[start]), float(edges[stop])
        box = [(left, low), (right, low), (right, high), (left, high)]
        boxes.setdefault(int(regime[start]), []).append(box)
    for code, polygons in boxes.items():
        style = REGIME_STYLES[regime_name(code)]
        bars = PolyCollection(polygons, facecolor=style.colour, hatch=style.hatch,
                              edgecolor=style.hatch_colour if style.hatch else "black", linewidth=0.2)  # fmt: skip
        ax.add_collection(bars)
        name_boxes(ax, code, polygons, width_cm)
    if cuts.size > MANY_RUNS:
        for collection in ax.collections:
            collection.set_rasterized(True)


def name_boxes(
    ax: Axes,
    code: int,
    polygons: list[list[tuple[float, float]]],
    width_cm: float,
) -> None:
    """Write the name of a regime into each of its boxes that is long enough."""
    name = regime_name(code)
    text = REGIME_TEXT[name].replace(", support", "")
    ground: Any = {"boxstyle": "square,pad=0.08", "facecolor": "white", "edgecolor": "none"}
    scaled = np.log if ax.get_xscale() == "log" else np.asarray
    first, last = scaled(np.array(ax.get_xlim()))
    for box in polygons:
        left, right = scaled(np.array([box[0][0], box[1][0]]))
        if (right - left) / (last - first) * width_cm < LETTER_CM * len(text) + 0.2:
            continue
        middle = 0.5 * (left + right)
        at = float(np.exp(middle)) if ax.get_xscale() == "log" else float(middle)
        ax.text(
            at, 0.5 * (box[0][1] + box[2][1]), text, ha="center", va="center",
            fontsize=SMALL, clip_on=True, gid=BAR_NAME,
            bbox=ground if REGIME_STYLES[name].hatch else None,
            color="white" if name == "unbounded" else BLACK,
        )  # fmt: skip
