"""A motion without samples: impacts and grazings over time, or the reason why there are none."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.phase_plane import impact_style
from vibropipe.figures.style import (
    NEUTRAL,
    SUPPORT_COLOURS,
    SUPPORT_MARKERS,
    legend,
    new_figure,
    write_centred,
)
from vibropipe.figures.text import (
    NO_IMPACTS,
    NO_SAMPLES,
    NO_SUPPORT_STRUCK,
    axis_label,
    clock,
    parameter_line,
    time_label,
    times_of,
)
from vibropipe.scenes.motion.panels import GRAZING_STYLE, shade_rests
from vibropipe.words.wording import count


def draw_impacts_only(dataset: xr.Dataset) -> Figure:
    """Draw impact velocities as stems over tau, with grazings and rests, or write why there are none."""
    if not has_events(dataset):
        return draw_reason(dataset)
    figure = new_figure(6.5)
    ax = figure.subplots()
    ax.axhline(0.0, color=NEUTRAL, linewidth=0.6)
    times = times_of(dataset, "impact")
    ax.set(xlabel=time_label(dataset, "impact"), ylabel=axis_label(dataset["impact_velocity"]))
    figure.suptitle(parameter_line(dataset))
    handles = []
    for support in (1, 2):
        tau, velocity = times.values, dataset["impact_velocity"].values
        struck = dataset["impact_support"].values == support
        style: dict[str, Any] = {
            "color": SUPPORT_COLOURS[support],
            "marker": SUPPORT_MARKERS[support],
        }
        size = impact_style(support, tau.size)["markersize"]
        ax.vlines(tau[struck], 0.0, velocity[struck], color=style["color"], linewidth=0.8)
        ax.plot(tau[struck], velocity[struck], linestyle="none", markersize=size, **style)
        text = f"{count(int(struck.sum()), 'impact')} on support {support}"
        handles.append(Line2D([], [], **style, label=text))
    grazing = times_of(dataset, "grazing").values
    if grazing.size:
        ax.plot(grazing, 0.0 * grazing, **GRAZING_STYLE)
        handles.append(Line2D([], [], label=count(grazing.size, "grazing"), **GRAZING_STYLE))
    shade_rests(ax, dataset, ax.get_xlim())
    legend(figure, handles, "lower")
    return figure


def has_events(dataset: xr.Dataset) -> bool:
    """Return whether the data have an impact or a grazing."""
    return bool(dataset.sizes.get("impact") or dataset.sizes.get("grazing"))


def is_sampled(dataset: xr.Dataset) -> bool:
    """Return whether displacement and velocity are stored."""
    return bool(dataset.sizes.get(clock(dataset)))


def draw_reason(dataset: xr.Dataset) -> Figure:
    """Return a figure with the reason why nothing is drawn."""
    figure = new_figure(2.6)
    figure.suptitle(parameter_line(dataset))
    ax = figure.subplots()
    ax.set_axis_off()
    impacts = NO_SUPPORT_STRUCK if "impact_support" in dataset else NO_IMPACTS
    write_centred(ax, *([] if is_sampled(dataset) else [NO_SAMPLES]), impacts)
    return figure
