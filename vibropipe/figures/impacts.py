"""A motion of which only the impacts were kept: how hard each support is struck, and when."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.motion import MANY_IMPACTS, shade_rests
from vibropipe.figures.options import Options
from vibropipe.figures.style import (
    NEUTRAL,
    SUPPORT_COLOURS,
    SUPPORT_MARKERS,
    legend,
    new_figure,
)
from vibropipe.figures.words import (
    parameter_line,
)
from vibropipe.vocabulary import label
from vibropipe.wording import count


def draw_impacts_only(dataset: xr.Dataset, options: Options) -> Figure:
    """Draw impact_velocity as stems over tau, and the rests; a motion without impacts says so."""
    figure = new_figure(6.5)
    ax = figure.subplots()
    ax.axhline(0.0, color=NEUTRAL, linewidth=0.6)
    ax.set(xlabel=label("tau"), ylabel=label("impact_velocity"))
    figure.suptitle(parameter_line(dataset))
    handles = []
    for support in (1, 2) if "impact_tau" in dataset else ():
        tau, velocity = dataset["impact_tau"].values, dataset["impact_velocity"].values
        struck = dataset["impact_support"].values == support
        style: dict[str, Any] = {
            "color": SUPPORT_COLOURS[support],
            "marker": SUPPORT_MARKERS[support],
        }
        size = 4.5 if tau.size <= MANY_IMPACTS else 2.5
        ax.vlines(tau[struck], 0.0, velocity[struck], color=style["color"], linewidth=0.8)
        ax.plot(tau[struck], velocity[struck], linestyle="none", markersize=size, **style)
        says = f"{count(int(struck.sum()), 'impact')} on support {support}"
        handles.append(Line2D([], [], **style, label=says))
    shade_rests(ax, dataset, ax.get_xlim())
    legend(figure, handles, "lower")
    return figure
