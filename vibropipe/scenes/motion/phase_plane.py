"""A motion in the plane of displacement and velocity: phase portrait, and section once per forcing period."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.canvas import axes, new_canvas, panel
from vibropipe.figures.claims import at_most
from vibropipe.figures.palette import SUPPORT_COLOURS, SUPPORT_MARKERS
from vibropipe.figures.phase_plane import draw_points, draw_walls, walls_of
from vibropipe.figures.style import keep_zero_scale
from vibropipe.figures.text import axis_label, clock, parameters_text, sentences, with_units
from vibropipe.report.findings import value_text
from vibropipe.scenes.kind import Picture
from vibropipe.scenes.motion.curves import forcing_period
from vibropipe.scenes.motion.panels import draw_plane, impacts_of, limits_of, window
from vibropipe.words.vocabulary import label
from vibropipe.words.wording import count

PORTRAIT_CM, SECTION_CM = 10.0, 8.0
SECTION_TOLERANCE = 1e-6  # forcing periods by which a sample at the section may be off
# Share of the fastest motion within which states are one, and that is shown on either side of it.
ONE_STATE, AROUND = 1e-6, 0.1


def draw_phase_portrait(dataset: xr.Dataset, periods: float | None = None) -> Figure:
    """Draw the curve of a sampled motion with its supports, and its jumps as vertical lines.

    periods : number of forcing periods to show, up to the end of the record (default: all)
    """
    figure = new_canvas(PORTRAIT_CM)
    ax = axes(figure, 1.7, 1.15, 13.9, PORTRAIT_CM - 1.4)
    limits = limits_of([dataset])
    ax.set(xlim=limits["displacement"], ylim=limits["velocity"])
    ax.set(xlabel=axis_label(dataset["displacement"]), ylabel=axis_label(dataset["velocity"]))
    draw_plane(ax, dataset, window(dataset, periods))
    return figure


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
    figure = new_canvas(SECTION_CM)
    is_sampled = "velocity" in dataset and visits(dataset).size > 0
    width, high = (6.2 if is_sampled else 13.9), SECTION_CM - 1.85
    if is_sampled:
        at, ax = visits(dataset), axes(figure, 1.6, 1.15, width, high)
        x, v = dataset["displacement"].values[at], dataset["velocity"].values[at]
        draw_points(ax, x, v)
        fastest = float(np.abs(dataset["velocity"].values).max())
        keep_zero_scale(ax, float(np.abs(v).max()), fastest)
        if np.ptp(v) < ONE_STATE * fastest < np.abs(v).max():
            ax.set_ylim(float(v.mean()) - AROUND * fastest, float(v.mean()) + AROUND * fastest)
        draw_walls(ax, float(x.min()), float(x.max()), walls_of(dataset))
        ax.set(xlabel=axis_label(dataset["displacement"]), ylabel=axis_label(dataset["velocity"]))
        panel(ax, "a", "states, once per forcing period")
    ax, impacts = axes(figure, 15.7 - width, 1.15, width, high), impacts_of(dataset)
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
    panel(ax, "b" if is_sampled else "", "impacts")
    return figure


def portrait_title(dataset: xr.Dataset) -> str:
    """Write how fast the mass is, in what the picture shows."""
    velocity = dataset["velocity"]
    speeds = np.abs(np.concatenate([velocity.values, impacts_of(dataset).before]))
    fastest = with_units(velocity, at_most(float(speeds.max()), 4))
    return f"In the phase plane no sample or impact is faster than {fastest}"


def section_title(dataset: xr.Dataset) -> str:
    """Write how hard the mass strikes at most, and in which part of the forcing period."""
    impacts = impacts_of(dataset)
    if "impact_support" not in dataset:
        return "The states of the motion, once per forcing period"
    if not impacts.time.size:
        return "The mass strikes no support, and its states are seen once per forcing period"
    phase = np.mod(turns(dataset, impacts.time), 1.0)
    top = int(np.abs(impacts.before).argmax())
    speed = value_text(dataset["impact_velocity"], abs(impacts.before[top]))
    return (
        f"The hardest impact, {speed}, comes {phase[top]:.2f} of a forcing period after its start"
    )


def describe_portrait(dataset: xr.Dataset) -> str:
    """Return the caption of a phase portrait."""
    return sentences(
        f"{parameters_text(dataset)}; hatched: beyond the supports; triangles: impacts, up (orange) on "
        "support 1, down (blue) on support 2"
    )


def describe_section(dataset: xr.Dataset) -> str:
    """Return the caption of a section: numbers of states and impacts."""
    states = ""
    if "velocity" in dataset and visits(dataset).size:
        states = (
            f"a: {count(visits(dataset).size, 'state')} of the motion at the section, where the phase of "
            "the force is 0"
        )
    if "impact_support" not in dataset:
        return sentences(states)
    struck = count(dataset.sizes.get("impact", 0), "impact")
    if dataset.sizes.get("rest"):  # a chatter has infinitely many
        struck = "impacts"
    impacts = f"{struck} by phase of the force and velocity before it, orange on support 1, blue on support 2"
    return sentences(states, f"b: {impacts}" if states else impacts)


SECTION = Picture("section", draw_section, describe_section, fits_section, titled=section_title)
