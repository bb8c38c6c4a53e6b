"""Pictures of designs: beside each other, and as the Pareto front of two quantities."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    BLACK,
    BLUE,
    GREY,
    LINE_MARKERS,
    NEUTRAL,
    VERMILLION,
    legend,
    line_style,
    new_figure,
)
from vibropipe.figures.text import orbit_texts, parameter_line, symbol_of
from vibropipe.scenes.design.data import (
    Part,
    numbers,
    objectives,
    part_of,
    varied,
    wanted_parts,
)

PANEL_CM, FRAME_CM = 2.5, 2.6
POINT: dict[str, Any] = {"linestyle": "none", "markersize": 5.0, "color": BLACK}


def draw_designs(dataset: xr.Dataset) -> Figure:
    """Draw parameters, wanted quantities and margin of each design, one panel below the other."""
    parameters, parts = varied(dataset), wanted_parts(dataset)
    n = len(parameters) + len(parts) + 1
    figure = new_figure(n * PANEL_CM + FRAME_CM)
    axes = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    place = numbers(dataset)
    for ax, name in zip(axes, parameters, strict=False):
        draw_parameter(ax, dataset, name)
    for ax, part in zip(axes[len(parameters) :], parts, strict=False):
        draw_quantity(ax, dataset, part)
    axes[-1].plot(place, dataset["law_margin"], marker="D", **POINT)
    axes[-1].set_yscale("log")
    axes[-1].set_ylabel(symbol_of(dataset["law_margin"]))
    laws = orbit_texts(dataset, "design")
    ticks = [f"{number}\n{law}" for number, law in zip(place, laws, strict=True)]
    axes[-1].set_xticks(place, ticks)
    axes[-1].set_xlim(place[0] - 0.5, place[-1] + 0.5)
    axes[-1].set_xlabel("design, and its law of motion $(m;\\ p_1, p_2)$")
    for ax in axes:
        ax.grid(axis="x", color=NEUTRAL, linewidth=0.5)
    axes[0].set_title(parameter_line(dataset))
    figure.align_ylabels(axes)
    legend(figure, handles(dataset, parts), "lower")
    return figure


def draw_parameter(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw a varied parameter, with the tolerance it needs as a bar."""
    values = dataset[name].values
    width = dataset.get(f"{name}_tolerance")
    if width is not None:
        bars = np.nan_to_num(width.values)
        ax.errorbar(numbers(dataset), values, bars, fmt="none", ecolor=BLUE, capsize=2.5, lw=1.0)
    ax.plot(numbers(dataset), values, marker="o", **POINT)
    ax.set_ylabel(Part(name).label_text(dataset, short=True))


def draw_quantity(ax: Axes, dataset: xr.Dataset, part: Part) -> None:
    """Draw a quantity with its target and bounds."""
    values = part.of(dataset)
    ax.plot(numbers(dataset), values, marker="s", **POINT)
    if f"{part.variable}_worst" in dataset:
        worst = np.nan_to_num(part.of(dataset, "_worst").sel(estimate="samples").values)
        ax.errorbar(numbers(dataset), values, worst, fmt="none", ecolor=GREY, capsize=2.5, lw=1.0)
    for which, style in (("target", "-"), ("lower", "--"), ("upper", "--")):
        end = part.end(dataset, which)
        if np.isfinite(end):
            ax.axhline(end, color=VERMILLION, linestyle=style, linewidth=1.0, zorder=0)
    low, high = ax.get_ylim()
    room = 0.1 * max(high - low, 1e-3 * abs(high))
    ax.set_ylim(low - room, high + room)
    ax.set_ylabel(part.label_text(dataset, short=True).replace(", ", "\n"))


def handles(dataset: xr.Dataset, parts: list[Part]) -> list[Line2D]:
    """Return the entries of the legend: what bars and lines are."""
    found = []
    if any(str(name).endswith("_tolerance") for name in dataset.data_vars):
        found.append(
            Line2D([], [], color=BLUE, marker="_", label="tolerance that the parameter needs")
        )
    if any(f"{part.variable}_worst" in dataset for part in parts):
        found.append(
            Line2D([], [], color=GREY, marker="_", label="worst case for the given deviations")
        )
    if any(np.isfinite(part.end(dataset, "target")) for part in parts):
        found.append(Line2D([], [], color=VERMILLION, label="target"))
    if any(np.isfinite(part.end(dataset, end)) for part in parts for end in ("lower", "upper")):
        found.append(Line2D([], [], color=VERMILLION, linestyle="--", label="bound"))
    return found


def draw_front(dataset: xr.Dataset) -> Figure:
    """Draw the second quantity over the first, a marker for each law of motion."""
    figure = new_figure(9.5)
    ax = figure.subplots()
    first, second = (part_of(dataset, text.removeprefix("-")) for text in objectives(dataset))
    assert first is not None
    assert second is not None
    x, y = first.of(dataset).values, second.of(dataset).values
    ax.plot(x, y, color=GREY, linewidth=0.8, zorder=0)
    laws = orbit_texts(dataset, "design")
    drawn = []
    for n, law in enumerate(dict.fromkeys(laws)):
        chosen = np.array([each == law for each in laws])
        style = {"color": line_style(n)["color"], "marker": LINE_MARKERS[n % len(LINE_MARKERS)]}
        drawn += ax.plot(x[chosen], y[chosen], linestyle="none", markersize=5.5, label=law, **style)
    for number, at in enumerate(zip(x, y, strict=True), start=1):
        ax.annotate(str(number), at, xytext=(4, 4), textcoords="offset points", fontsize=7)
    ax.set_xlabel(first.label_text(dataset))
    ax.set_ylabel(second.label_text(dataset))
    ax.set_title(parameter_line(dataset))
    ax.margins(0.08)
    legend(figure, drawn, "lower", "law of motion $(m;\\ p_1, p_2)$")
    return figure


def is_front(dataset: xr.Dataset) -> bool:
    """Return whether designs are a Pareto front that can be drawn."""
    parts = [part_of(dataset, text.removeprefix("-")) for text in objectives(dataset)]
    return len(parts) == 2 and None not in parts and dataset.sizes["design"] > 1
