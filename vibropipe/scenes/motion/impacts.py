"""A motion without samples: its impacts and grazings over tau, or in words why there are none."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    NEUTRAL,
    SUPPORT_COLOURS,
    SUPPORT_MARKERS,
    legend,
    new_figure,
    write_text,
)
from vibropipe.figures.text import (
    IMPACTS_NOT_ASKED,
    NO_SUPPORT_STRUCK,
    SAMPLES_NOT_ASKED,
    parameter_line,
)
from vibropipe.scenes.motion.panels import GRAZING_STYLE, MANY_IMPACTS, shade_rests
from vibropipe.words.vocabulary import label
from vibropipe.words.wording import count


def draw_impacts_only(dataset: xr.Dataset) -> Figure:
    """Draw impact_velocity as stems over tau, grazings and rests; without any, say why."""
    if not has_events(dataset):
        return draw_words(dataset)
    figure = new_figure(6.5)
    ax = figure.subplots()
    ax.axhline(0.0, color=NEUTRAL, linewidth=0.6)
    ax.set(xlabel=label("tau"), ylabel=label("impact_velocity"))
    figure.suptitle(parameter_line(dataset))
    handles = []
    for support in (1, 2):
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
    grazing = dataset["grazing_tau"].values
    if grazing.size:
        ax.plot(grazing, 0.0 * grazing, **GRAZING_STYLE)
        handles.append(Line2D([], [], label=count(grazing.size, "grazing"), **GRAZING_STYLE))
    shade_rests(ax, dataset, ax.get_xlim())
    legend(figure, handles, "lower")
    return figure


def has_events(dataset: xr.Dataset) -> bool:
    """Return whether there is an impact or a grazing to draw."""
    return bool(dataset.sizes.get("impact") or dataset.sizes.get("grazing"))


def draw_words(dataset: xr.Dataset) -> Figure:
    """Return a figure that says what was not asked for, or that no support is struck."""
    figure = new_figure(2.6)
    figure.suptitle(parameter_line(dataset))
    ax = figure.subplots()
    ax.set_axis_off()
    impacts = NO_SUPPORT_STRUCK if "impact_tau" in dataset else IMPACTS_NOT_ASKED
    write_text(ax, SAMPLES_NOT_ASKED, impacts)
    return figure
