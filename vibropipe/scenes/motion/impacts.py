"""A motion without samples: impacts and grazings over time, or the reason why there are none."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.canvas import axes, new_canvas, panel, zero_line
from vibropipe.figures.palette import SUPPORT_COLOURS, SUPPORT_MARKERS
from vibropipe.figures.phase_plane import impact_style
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import (
    NO_IMPACTS,
    NO_SAMPLES,
    NO_SUPPORT_STRUCK,
    axis_label,
    clock,
    time_label,
    times_of,
)
from vibropipe.scenes.motion.panels import GRAZING_STYLE, shade_rests
from vibropipe.words.wording import count

HEIGHT = 6.5  # cm


def draw_impacts_only(dataset: xr.Dataset) -> Figure:
    """Draw impact velocities as stems over tau, with grazings and rests, or write why there are none."""
    if not has_events(dataset):
        return draw_reason(dataset)
    figure = new_canvas(HEIGHT)
    ax = axes(figure, 1.7, 1.1, 14.0, HEIGHT - 1.75)
    times = times_of(dataset, "impact")
    ax.set(xlabel=time_label(dataset, "impact"), ylabel=axis_label(dataset["impact_velocity"]))
    velocity = dataset["impact_velocity"].values
    notes = []
    for support in (1, 2):
        struck = dataset["impact_support"].values == support
        colour, marker = SUPPORT_COLOURS[support], SUPPORT_MARKERS[support]
        size = impact_style(support, velocity.size)["markersize"]
        at, height = times.values[struck], velocity[struck]
        ax.vlines(at, 0.0, height, color=colour, linewidth=0.8)
        ax.plot(at, height, marker, color=colour, markersize=size)
        notes.append(f"{count(int(struck.sum()), 'impact')} on support {support}")
    grazing = times_of(dataset, "grazing").values
    if grazing.size:
        ax.plot(grazing, 0.0 * grazing, **GRAZING_STYLE)
        notes.append(f"{count(grazing.size, 'grazing')} (ring{'s' if grazing.size > 1 else ''})")
    zero_line(ax)
    shade_rests(ax, dataset, ax.get_xlim())
    panel(ax, note="; ".join(notes))
    return figure


def has_events(dataset: xr.Dataset) -> bool:
    """Return whether the data have an impact or a grazing."""
    return bool(dataset.sizes.get("impact") or dataset.sizes.get("grazing"))


def is_sampled(dataset: xr.Dataset) -> bool:
    """Return whether displacement and velocity are stored."""
    return bool(dataset.sizes.get(clock(dataset)))


def draw_reason(dataset: xr.Dataset) -> Figure:
    """Return a figure with the reason why nothing is drawn."""
    figure = new_canvas(2.2)
    ax = axes(figure, 0.2, 0.2, 15.6, 1.8)
    ax.set_axis_off()
    impacts = NO_SUPPORT_STRUCK if "impact_support" in dataset else NO_IMPACTS
    write_centred(ax, *([] if is_sampled(dataset) else [NO_SAMPLES]), impacts)
    return figure
