"""Picture of the times to reach an accuracy: a row per motion, a mark per method; below, medians over all motions."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    LINE_MARKERS,
    NEUTRAL,
    SMALL_FONT_SIZE,
    legend,
    line_style,
    new_figure,
)
from vibropipe.figures.text import format_number
from vibropipe.scenes.accuracy.summary import of_errors, time_to_reach
from vibropipe.scenes.accuracy.text import COARSE, FINE, error_text, left_out_text
from vibropipe.words.measurements import Outcome

ROW_CM = 1.1
MEDIAN_CM = 5.6
MARGINS_CM = 3.4
SPREAD = 0.85  # of a row, over which the marks of the methods are spread
NOT_REACHED = 6.0  # width of the band of marks that are not reached, a factor of time
METHOD_TEXT = {
    "crude": "crude: impact at end of step",
    "newmark": "Newmark, event location",
    "exact": "exact",
    "RK45": "scipy RK45, events by hand",
    "DOP853": "scipy DOP853, events by hand",
    "Radau": "scipy Radau, events by hand",
    "heyoka": "heyoka",
}


def installed(dataset: xr.Dataset) -> xr.Dataset:
    """Return the data of the methods that were installed."""
    absent = (dataset["outcome"] == int(Outcome.NOT_INSTALLED)).any("setting").all("motion")
    return dataset.isel(method=np.flatnonzero(~absent.values))


def style_of(name: str, names: list[str]) -> dict[str, Any]:
    """Return line and marker of a method."""
    index = names.index(name)
    return {**line_style(index), "marker": LINE_MARKERS[index % len(LINE_MARKERS)]}


def add_legend(figure: Figure, names: list[str]) -> None:
    """Add the legend of the methods above the axes."""
    handles = [
        Line2D([], [], **style_of(name, names), label=METHOD_TEXT.get(name, name)) for name in names
    ]
    legend(figure, handles, "upper")


def draw_times(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the times per forcing period to reach two accuracies, and their medians over all accuracies."""
    dataset = installed(of_errors(dataset, show))
    times = time_to_reach(dataset)
    names = [str(name) for name in times["method"].values]
    n_motions = times.sizes["motion"]
    figure = new_figure(MARGINS_CM + ROW_CM * n_motions + MEDIAN_CM)
    grid = figure.add_gridspec(2, 2, height_ratios=[ROW_CM * n_motions, MEDIAN_CM])
    left = figure.add_subplot(grid[0, 0])
    right = figure.add_subplot(grid[0, 1], sharex=left, sharey=left)
    finite = times.values[np.isfinite(times.values)]
    span = (finite.min() / 2, finite.max() * 2) if finite.size else (1.0, 10.0)
    for ax, accuracy in ((left, COARSE), (right, FINE)):
        draw_rows(ax, times.sel(accuracy=accuracy), names, span)
        ax.set_title(f"error at most {format_number(accuracy)}")
    left.set_yticks(range(n_motions), [str(m).replace("_", " ") for m in times["motion"].values])
    right.tick_params(labelleft=False)
    draw_medians(figure.add_subplot(grid[1, :]), times, names)
    add_legend(figure, names)
    return figure


def draw_rows(ax: Axes, times: xr.DataArray, names: list[str], span: tuple[float, float]) -> None:
    """Draw the time of each method on each motion; hollow in the band on the right if not reached."""
    edge = span[1] * NOT_REACHED
    ax.axvspan(span[1], edge, color=NEUTRAL, linewidth=0)
    rows = np.arange(times.sizes["motion"])
    for row in rows[1:]:
        ax.axhline(row - 0.5, color=NEUTRAL, linewidth=0.5, zorder=0)
    for index, name in enumerate(names):
        height = rows + SPREAD * ((index + 0.5) / len(names) - 0.5)
        time, style = times.sel({"method": name}).values, style_of(name, names)
        mark = {"linestyle": "none", "marker": style["marker"], "color": style["color"]}
        ax.plot(np.where(np.isfinite(time), time, np.nan), height, **mark)
        missing = np.isnan(time)
        at = np.full(missing.sum(), np.sqrt(span[1] * edge))
        ax.plot(at, height[missing], **mark, markerfacecolor="white")
    ax.text(
        1.0, 1.01, "not reached", transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL_FONT_SIZE
    )  # fmt: skip
    ax.set(xscale="log", xlabel="ns per forcing period")
    ax.set_xlim(span[0], edge)
    ax.set_ylim(rows.size - 0.5, -0.5)
    ax.tick_params(axis="y", length=0)


def draw_medians(ax: Axes, times: xr.DataArray, names: list[str]) -> None:
    """Draw the median over motions of the time to reach each accuracy; hollow if not all motions reach it."""
    accuracy = times["accuracy"].values
    reached = np.isfinite(times.values).sum(axis=0)
    for index, name in enumerate(names):
        kept = 2 * reached[index] > times.sizes["motion"]
        if not kept.any():
            continue
        middle = np.nanmedian(times.values[:, index, kept], axis=0)
        style = style_of(name, names)
        is_complete = reached[index][kept] == times.sizes["motion"]
        ax.plot(accuracy[kept], middle, **{**style, "marker": ""})
        for full, face in ((True, style["color"]), (False, "white")):
            part = is_complete == full
            ax.plot(
                accuracy[kept][part], middle[part], linestyle="none", marker=style["marker"],
                color=style["color"], markerfacecolor=face,
            )  # fmt: skip
    ax.set(xscale="log", yscale="log", xlabel="error to reach", ylabel="ns per forcing period")
    ax.set_xlim(2 * accuracy.max(), accuracy.min() / 2)
    ax.set_title("all motions, median")


def describe_times(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the times."""
    text, left_out = error_text(dataset, show), left_out_text(dataset, show)
    return (
        f"Shortest time per forcing period on one core with an {text} of at most {format_number(COARSE, 1)} and "
        f"{format_number(FINE, 1)}, for each motion; hollow marks in the grey band: not reached by any tested setting. "
        "Below: median over the motions that reach an error, if more than half of them do; hollow: not all do."
        f"{left_out}"
    )
