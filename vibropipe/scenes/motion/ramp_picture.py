"""A motion on a ramp: the extreme displacements of each forcing cycle over the frequency that it passes."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view

from vibropipe.figures.canvas import BODY, axes, new_canvas, panel
from vibropipe.figures.claims import from_to
from vibropipe.figures.palette import INK
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import (
    axis_label,
    clock,
    format_number,
    parameters_text,
    plain_symbol,
    plain_symbol_of,
    sentences,
    with_units,
)
from vibropipe.scenes.kind import Picture
from vibropipe.scenes.motion.captions import impacts_text, rest_text
from vibropipe.scenes.motion.curves import Floats, curve
from vibropipe.scenes.motion.findings import ramp_answer, ramp_headline
from vibropipe.scenes.motion.impacts import is_sampled
from vibropipe.scenes.motion.panels import draw_supports, limits_of
from vibropipe.solve.shown_units import in_si

LEFT, BOTTOM, HIGH = 1.7, 1.1, 6.0  # cm
NAME_SHARE, PLACES = 0.3, 200  # of the width, for the name of a line; places along it
MOTION = "#dce6f2"  # between the lines; darker than it is what lies beyond the supports


def is_ramp(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is a motion on a ramp with samples of two forcing cycles, between which lines lead."""
    return "frequency" in dataset and is_sampled(dataset) and extremes(dataset)[0].size > 1


def extremes(dataset: xr.Dataset) -> tuple[Floats, Floats, Floats]:
    """Return frequency, least and largest displacement of each whole forcing cycle, each (n,)."""
    time, frequency = dataset[clock(dataset)], dataset["frequency"]
    seconds, omega = in_si(time), in_si(frequency)
    at, x = curve(dataset, "displacement")
    turns = (seconds - seconds[0]) * (omega[0] + omega) / (4.0 * math.pi)
    cycle = np.floor(np.interp(at, time.values, turns)).astype(np.intp)
    first = np.flatnonzero(np.diff(cycle, prepend=-1))
    if first.size > 1:  # the last cycle is not whole
        at, x, first = at[: first[-1]], x[: first[-1]], first[:-1]
    least, largest = np.minimum.reduceat(x, first), np.maximum.reduceat(x, first)
    last = np.append(first[1:], at.size) - 1
    nu = np.interp(at, time.values, frequency.values)
    return (nu[first] + nu[last]) / 2.0, least, largest


def draw_ramp(dataset: xr.Dataset) -> Figure:
    """Draw the extreme displacements of each forcing cycle over the frequency."""
    figure = new_canvas(BOTTOM + HIGH + 0.65)
    ax = axes(figure, LEFT, BOTTOM, 16.0 - LEFT - 0.3, HIGH)
    frequency = dataset["frequency"]
    ends = float(frequency[0]), float(frequency[-1])
    ax.set(xlim=sorted(ends), ylim=limits_of([dataset])["displacement"])
    ax.set(xlabel=axis_label(frequency), ylabel=axis_label(dataset["displacement"]))
    nu, least, largest = extremes(dataset)
    if nu.size < 2:
        write_centred(ax, "The ramp has no two whole forcing cycles")
        return figure
    ax.fill_between(nu, least, largest, color=MOTION, linewidth=0, zorder=1)
    draw_supports(ax, dataset, is_labelled=True)
    x, top, bottom = widest(nu, least, largest)
    for values, name, y, side in ((largest, "largest", top, 1), (least, "least", bottom, -1)):
        ax.plot(nu, values, color=INK, linewidth=1.0, zorder=2)
        ax.annotate(f"{name} in a forcing cycle", (x, y), (0, -3 * side), textcoords="offset points",
                    ha="center", va="top" if side > 0 else "bottom", fontsize=BODY)  # fmt: skip
    panel(ax, note=f"time runs to the {'right' if ends[0] < ends[1] else 'left'}")
    return figure


def widest(nu: Floats, least: Floats, largest: Floats) -> tuple[float, float, float]:
    """Return where names fit best between two lines: the frequency, and how far up and down there is room."""
    # evenly over the axis: more cycles lie at a high frequency
    even = np.linspace(float(nu.min()), float(nu.max()), PLACES)
    order, room = np.argsort(nu), int(NAME_SHARE * PLACES)
    largest, least = (np.interp(even, nu[order], line[order]) for line in (largest, least))
    tops = sliding_window_view(largest, room).min(axis=1)
    bottoms = sliding_window_view(least, room).max(axis=1)
    at = int(np.argmax(tops - bottoms))
    return float(even[at : at + room].mean()), float(tops[at]), float(bottoms[at])


def ramp_title(dataset: xr.Dataset) -> str:
    """Write what the ramp ends in, or between which frequencies the supports are struck."""
    if "settled_same" in dataset:
        return ramp_headline(dataset)
    if "impact_support" not in dataset:
        return ""
    if not dataset.sizes["impact"]:
        return "No support is struck on the ramp"
    time = dataset[clock(dataset)]
    at = dataset["impact_" + clock(dataset)].values[[0, -1]]
    first, last = np.interp(at, time.values, dataset["frequency"].values).tolist()
    ends = with_units(dataset["frequency"], from_to(first, last, 3))
    where = f"{frequency_symbol(dataset)} = {ends}"
    once = dataset.sizes["impact"] == 1
    return f"A support is struck once, at {where}" if once else f"Supports are struck from {where}"


def frequency_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the frequency of the ramp, over 2π if it is in cycles."""
    symbol = plain_symbol("omega" if clock(dataset) == "time" else "nu")
    return symbol + plain_symbol_of(dataset["frequency"]).removeprefix(plain_symbol("frequency"))


def describe_ramp(dataset: xr.Dataset) -> str:
    """Return the caption of a ramp: its ends and length, impacts, and what it ends in."""
    frequency, time = dataset["frequency"], dataset[clock(dataset)]
    ends = from_to(float(frequency[0]), float(frequency[-1]))
    length = with_units(time, format_number(float(time[-1] - time[0])))
    length = length if clock(dataset) == "time" else f"τ = {length}"
    answer = ramp_answer(dataset)
    return sentences(
        "Largest and least displacement in each forcing cycle",
        f"The frequency changes linearly, {frequency_symbol(dataset)} = {with_units(frequency, ends)} within {length}",
        impacts_text(dataset),
        rest_text(dataset, is_shaded=False),
        "" if answer is None else answer.rest.removesuffix("."),
        parameters_text(dataset, ("nu", "omega")),
    )


RAMP_PICTURE = Picture("ramp", draw_ramp, describe_ramp, is_ramp, titled=ramp_title)
