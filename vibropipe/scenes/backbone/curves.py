"""Free vibration with impacts on both supports, eq. (10): figures 2 and 3 of the paper."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import LINE_MARKERS, legend, line_style, new_figure
from vibropipe.figures.text import axis_label, format_number
from vibropipe.words.vocabulary import PHYSICAL_NAMES, quantity


def draw_backbone(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw velocity_over_l against tau_bar and omega_bar (or those of `show`), one line per delta_over_l.

    Hollow markers, one shape per line, show simulated conservative motions.
    """
    figure = new_figure(8.6)
    names = [name for name in ("tau_bar", "omega_bar") if name in (show or (name,))]
    axes = dict(
        zip(names, figure.subplots(1, len(names), sharey=True, squeeze=False)[0], strict=True)
    )
    dataset = dataset.rename(
        {new: name for name, new in PHYSICAL_NAMES.items() if new in dataset.variables}
    )
    # 2 pi, or 2000 pi for milliseconds beside rad/s
    turn = float(dataset["tau_bar"][0] * dataset["omega_bar"][0])
    symbol = quantity("delta_over_l").symbol
    handles = []
    for position, value in enumerate(dataset["delta_over_l"].values):
        style = line_style(position)
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
    if "simulated_tau_bar" in dataset:
        handles.append(
            Line2D(
                [],
                [],
                linestyle="none",
                marker="o",
                markerfacecolor="white",
                markeredgecolor="black",
                label="markers: simulated",
            )
        )
    for name, ax in axes.items():
        ax.set_xlabel(axis_label(dataset[name]))
        ax.set_ylim(bottom=0.0)
    figure.axes[0].set_ylabel(axis_label(dataset["velocity_over_l"]))
    legend(figure, handles, "upper")
    return figure
