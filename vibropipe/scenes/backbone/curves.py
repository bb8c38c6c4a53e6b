"""Free vibration with impacts on both supports, eq. (10): figures 2 and 3 of the paper."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import LINE_MARKERS, legend, line_style, new_figure
from vibropipe.figures.text import mathtext
from vibropipe.words.vocabulary import label, quantity


def draw_backbone(dataset: xr.Dataset) -> Figure:
    """Draw velocity_over_l against tau_bar and omega_bar, one line per delta_over_l.

    Hollow markers, one shape per line, show simulated conservative motions.
    """
    figure = new_figure(8.6)
    by_period, by_frequency = figure.subplots(1, 2, sharey=True)
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
        by_period.plot(dataset["tau_bar"], line, **style)
        by_frequency.plot(dataset["omega_bar"], line, **style)
        shown: dict[str, Any] = {}
        if "simulated_tau_bar" in dataset:
            points = dataset.isel(delta_over_l=position)
            tau_bar = points["simulated_tau_bar"].values
            height = points["simulated_velocity_over_l"].values
            by_period.plot(tau_bar, height, linestyle="none", **marker)
            by_frequency.plot(2.0 * np.pi / tau_bar, height, linestyle="none", **marker)
            shown = marker
        handles.append(Line2D([], [], **style, **shown, label=f"{symbol} = {mathtext(value)}"))
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
    by_period.set(xlabel=label("tau_bar"), ylabel=label("velocity_over_l"))
    by_frequency.set(xlabel=label("omega_bar"))
    for ax in (by_period, by_frequency):
        ax.set_ylim(bottom=0.0)
    legend(figure, handles, "upper")
    return figure
