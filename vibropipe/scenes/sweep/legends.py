"""Marks of rows, arrows of directions, and the legends that name them."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.lines import Line2D

from vibropipe.figures.style import BLACK, GREY, line_style
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.quantities import row_kinds

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
BACKBONE_STYLE: dict[str, Any] = {"color": GREY, "linewidth": 3.2, "alpha": 0.45, "zorder": 1}
# Full and hollow, pointing the way that was followed.
DIRECTION_MARKERS: dict[str, dict[str, Any]] = {
    "up": {"linestyle": "none", "marker": ">", "markersize": 4.6, "markeredgewidth": 0.8, "zorder": 4},
    "down": {"linestyle": "none", "marker": "<", "markersize": 4.6, "markeredgewidth": 0.8,
             "markerfacecolor": "white", "zorder": 4},
}  # fmt: skip
DIRECTION_TEXT = {"up": "followed upwards", "down": "followed downwards"}


def line_handles(dataset: xr.Dataset, lines_dim: str | None, backbone: bool) -> list[Line2D]:
    """Return legend entries of the lines by value, and of the backbone."""
    handles: list[Line2D] = []
    if lines_dim is not None:
        for position, value in enumerate(dataset[lines_dim].values):
            text = value_text(dataset[lines_dim], float(value))
            handles.append(Line2D([], [], **line_style(position), label=text))
    if backbone:
        handles.append(Line2D([], [], **BACKBONE_STYLE, label="conservative exciter"))
    return handles


def direction_handles(directions: list[str]) -> list[Line2D]:
    """Return legend entries of the directions in which rows were followed."""
    return [
        Line2D([], [], **{"markerfacecolor": BLACK} | DIRECTION_MARKERS[way], markeredgecolor=BLACK,
               label=DIRECTION_TEXT[way])
        for way in directions
    ]  # fmt: skip


def mark_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of the marks that occur."""
    kinds = row_kinds(dataset)
    return [
        Line2D([], [], **marks, markeredgecolor=BLACK, label=ROW_TEXT[kind])
        for kind, marks in ROW_MARKS.items()
        if kinds[kind].any()
    ]
