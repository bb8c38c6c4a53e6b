"""Free vibration with impacts on both supports, eq. (10): figures 2 and 3 of the paper."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.canvas import WIDE, new_canvas
from vibropipe.figures.canvas import axes as placed
from vibropipe.figures.palette import shades
from vibropipe.figures.style import LINE_MARKERS
from vibropipe.figures.text import axis_label, format_number
from vibropipe.words.vocabulary import PHYSICAL_NAMES, quantity

HEIGHT, LEFT, BOTTOM, GAP = 7.6, 1.6, 1.1, 0.7  # cm


def draw_backbone(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw velocity_over_l against tau_bar and omega_bar (or those of `show`), one line per delta_over_l.

    Hollow markers, one shape per line, show simulated conservative motions.
    """
    figure = new_canvas(HEIGHT)
    names = [name for name in ("tau_bar", "omega_bar") if name in (show or (name,))]
    width = (WIDE - LEFT - 0.3 - GAP * (len(names) - 1)) / len(names)
    axes = {
        name: placed(figure, LEFT + n * (width + GAP), BOTTOM, width, HEIGHT - BOTTOM - 0.3)
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
            ax.plot(dataset[name], line, **style)
        shown: dict[str, Any] = {}
        if "simulated_tau_bar" in dataset:
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
