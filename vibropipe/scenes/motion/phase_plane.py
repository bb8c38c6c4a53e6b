"""A motion in the plane of displacement and velocity: phase portrait, and section once per forcing period."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.phase_plane import (
    Impacts,
    draw_points,
    draw_portrait,
    draw_walls,
    path,
    portrait_handles,
    walls_of,
)
from vibropipe.figures.style import SUPPORT_COLOURS, SUPPORT_MARKERS, legend, new_figure
from vibropipe.figures.text import (
    axis_label,
    clock,
    parameter_line,
    sentences,
    times_of,
)
from vibropipe.scenes.motion.curves import curve, forcing_period, velocities_at_impacts
from vibropipe.scenes.motion.panels import window
from vibropipe.words.vocabulary import label
from vibropipe.words.wording import count

PORTRAIT_CM, SECTION_CM = 10.0, 8.0
SECTION_TOLERANCE = 1e-6  # forcing periods by which a sample at the section may be off


def draw_phase_portrait(dataset: xr.Dataset, periods: float | None = None) -> Figure:
    """Draw the curve of a sampled motion with its supports, and its jumps as vertical lines.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion with samples.
    periods : float, optional
        Number of forcing periods to show, up to the end of the record (default: all).
    """
    first, last = window(dataset, periods)
    time = dataset[clock(dataset)].values
    kept = (time >= first) & (time <= last)
    x, v = dataset["displacement"].values[kept], dataset["velocity"].values[kept]
    impacts = impacts_of(dataset).within(time[kept][0], time[kept][-1])
    walls = walls_of(dataset)
    figure = new_figure(PORTRAIT_CM)
    ax = figure.subplots()
    if "impact_support" in dataset:
        x, v = path(time[kept], x, v, impacts, walls)
    else:
        broken, v = curve(dataset.isel({clock(dataset): np.flatnonzero(kept)}), "velocity")
        x = np.interp(broken, time[kept], x)
    draw_portrait(ax, x, v, impacts, walls)
    labels = axis_label(dataset["displacement"]), axis_label(dataset["velocity"])
    ax.set(xlabel=labels[0], ylabel=labels[1])
    figure.suptitle(parameter_line(dataset))
    legend(figure, portrait_handles({int(s) for s in impacts.support}), "lower")
    return figure


def impacts_of(dataset: xr.Dataset) -> Impacts:
    """Return the impacts of a motion; none if they are not stored."""
    if "impact_support" not in dataset:
        none = np.empty(0)
        return Impacts(none, np.empty(0, np.int8), none, none)
    return Impacts(
        times_of(dataset, "impact").values,
        dataset["impact_support"].values,
        *velocities_at_impacts(dataset),
    )


def turns(dataset: xr.Dataset, time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times in forcing periods."""
    return time / forcing_period(dataset)


def visits(dataset: xr.Dataset) -> NDArray[np.intp]:
    """Return the indices of the samples at the section, where the phase of the force is 0."""
    at = turns(dataset, dataset[clock(dataset)].values)
    return np.flatnonzero(np.abs(at - np.round(at)) <= SECTION_TOLERANCE * np.maximum(1.0, at))


def fits_section(dataset: xr.Dataset) -> bool:
    """Return whether a motion has samples at the section, or impacts."""
    is_sampled = bool(dataset.sizes.get(clock(dataset))) and "velocity" in dataset
    return bool(dataset.sizes.get("impact")) or (is_sampled and visits(dataset).size > 0)


def draw_section(dataset: xr.Dataset) -> Figure:
    """Draw the states at the section (left), and the impacts by phase of the force (right)."""
    figure = new_figure(SECTION_CM)
    is_sampled = "velocity" in dataset and visits(dataset).size > 0
    names = [name for name, is_there in (("state", is_sampled), ("impact", True)) if is_there]
    axes = dict(zip(names, figure.subplots(1, len(names), squeeze=False)[0], strict=True))
    if "state" in axes:
        at, ax = visits(dataset), axes["state"]
        x, v = dataset["displacement"].values[at], dataset["velocity"].values[at]
        draw_points(ax, x, v)
        draw_walls(ax, float(x.min()), float(x.max()), walls_of(dataset))
        ax.set(xlabel=axis_label(dataset["displacement"]), ylabel=axis_label(dataset["velocity"]))
        ax.set_title("states, once per forcing period")
    ax, impacts = axes["impact"], impacts_of(dataset)
    for support in (1, 2):
        own = impacts.support == support
        phase = np.mod(turns(dataset, impacts.time[own]), 1.0)
        if own.any():
            draw_points(
                ax, phase, impacts.before[own], SUPPORT_COLOURS[support], SUPPORT_MARKERS[support]
            )
    velocity = dataset.get("impact_velocity", dataset["displacement_end"])
    text = axis_label(velocity) if "impact_velocity" in dataset else label("impact_velocity")
    ax.set(xlim=(0, 1), xlabel=label("impact_phase"), ylabel=text)
    ax.set_title("impacts")
    figure.suptitle(parameter_line(dataset))
    handles = portrait_handles({int(s) for s in impacts.support})
    for handle in handles:
        handle.set_linestyle("none")
    legend(figure, handles, "lower")
    return figure


def describe_portrait(dataset: xr.Dataset) -> str:
    """Return the caption of a phase portrait."""
    return sentences(
        "Velocity against displacement; grey: beyond the supports; dotted: jumps of the velocity at impacts"
    )


def describe_section(dataset: xr.Dataset) -> str:
    """Return the caption of a section: numbers of states and impacts."""
    states = ""
    if "velocity" in dataset and visits(dataset).size:
        states = (
            f"Left: {count(visits(dataset).size, 'state')} of the motion at the section, where the phase of "
            "the force is 0"
        )
    struck = count(dataset.sizes.get("impact", 0), "impact")
    if dataset.sizes.get("rest"):  # a chatter has infinitely many
        struck = "impacts"
    impacts = f"{struck} by phase of the force and velocity before it"
    return sentences(states, f"Right: {impacts}" if states else impacts)
