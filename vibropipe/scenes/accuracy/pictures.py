"""Work-precision diagrams: error against time, a panel per motion and one for all motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import LINE_MARKERS, SMALL_FONT_SIZE, legend, line_style, new_figure
from vibropipe.scenes.accuracy.summary import orders, succeeded, time_to_reach, worst_error
from vibropipe.scenes.accuracy.text import describe_work_precision
from vibropipe.scenes.kind import only_picture
from vibropipe.words.measurements import Outcome

COLUMNS = 3
PANEL_HEIGHT_CM = 5.4
LEGEND_HEIGHT_CM = 1.6
TOP, BOTTOM = 30.0, 1e-17  # limits of the error axis
FAILED_ERROR = 5.0  # ordinate of the crosses of failed runs
METHOD_TEXT = {
    "crude": "Newmark, impact at end of step",
    "newmark": "Newmark, event location",
    "exact": "exact",
    "heyoka": "heyoka",
}
WITHOUT_TIME = {
    Outcome.DID_NOT_END: "did not finish",
    Outcome.NOT_INSTALLED: "not installed",
}


def draw_work_precision(dataset: xr.Dataset) -> Figure:
    """Draw the errors of each motion against time per forcing period, then the time to reach an accuracy."""
    panels = dataset.sizes["motion"] + 1
    rows = -(-panels // COLUMNS)
    figure = new_figure(PANEL_HEIGHT_CM * rows + LEGEND_HEIGHT_CM)
    axes = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    methods = [str(name) for name in dataset["method"].values]
    times = dataset["time_per_period"].values
    span = (np.nanmin(times) / 2, np.nanmax(times) * 2) if np.isfinite(times).any() else (1, 10)
    for position, ax in enumerate(axes[: panels - 1]):
        draw_motion_panel(ax, dataset.isel(motion=[position]))
        ax.set_xlim(span)
        left, low = position % COLUMNS == 0, position + COLUMNS >= panels - 1
        ax.tick_params(labelleft=left, labelbottom=low)
        ax.set(ylabel="error" if left else "", xlabel="ns per forcing period" if low else "")
    draw_summary_panel(axes[panels - 1], dataset)
    for ax in axes[panels:]:
        ax.set_visible(False)
    handles = [
        Line2D([], [], **style_of(index), label=METHOD_TEXT.get(name, name))
        for index, name in enumerate(methods)
    ]
    legend(figure, handles, "upper")
    return figure


def style_of(index: int) -> dict[str, Any]:
    """Return line and marker of the method at `index`."""
    return {**line_style(index), "marker": LINE_MARKERS[index % len(LINE_MARKERS)]}


def draw_motion_panel(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw all methods on one motion: lines of successful runs, crosses of failed ones, orders, notes."""
    error, good = worst_error(dataset)[0].values, succeeded(dataset)[0].values
    order = orders(dataset)[0].values
    dataset = dataset.isel(motion=0)
    time = dataset["time_per_period"].values
    quartiles = [dataset[f"time_per_period_{side}"].values for side in ("low", "high")]
    notes: dict[str, list[str]] = {}
    for index, method in enumerate(dataset["method"].values):
        drawn = good[index] & np.isfinite(time[index])
        x, y = time[index][drawn], np.clip(error[index][drawn], 2 * BOTTOM, TOP)
        spread = np.abs([side[index][drawn] - x for side in quartiles])
        style = style_of(index)
        ax.errorbar(x, y, xerr=spread, elinewidth=0.6, **style)
        if np.isfinite(order[index]):
            # Below the last point, beyond the end of the line.
            annotation = ax.annotate(
                f"{order[index]:.1f}", (x[-1], y[-1]), (0, -4), textcoords="offset points",
                ha="center", va="top", color=style["color"], fontsize=SMALL_FONT_SIZE,
            )  # fmt: skip
            annotation.set_in_layout(False)
        failed = ~good[index] & np.isfinite(time[index])
        if failed.any():
            at = np.full(failed.sum(), FAILED_ERROR)
            ax.plot(time[index][failed], at, "x", color=style["color"])
        for outcome, text in WITHOUT_TIME.items():
            if (dataset["outcome"].values[index] == outcome).any():
                notes.setdefault(text, []).append(str(method))
    ax.set(xscale="log", yscale="log", ylim=(BOTTOM, TOP))
    ax.set_title(str(dataset["motion"].values).replace("_", " "))
    note = ax.text(
        0.98, 0.02, "\n".join(f"{text}: {', '.join(names)}" for text, names in notes.items()),
        transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL_FONT_SIZE - 2,
    )  # fmt: skip
    note.set_in_layout(False)


def draw_summary_panel(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the median over motions of the time to reach each accuracy; hollow if not all motions reach it."""
    times = time_to_reach(dataset).values
    reached = np.isfinite(times).sum(axis=0)
    accuracy = time_to_reach(dataset)["accuracy"].values
    for index in range(times.shape[1]):
        kept = 2 * reached[index] > times.shape[0]
        if not kept.any():
            continue
        middle = np.nanmedian(times[:, index, kept], axis=0)
        style = style_of(index)
        is_complete = reached[index][kept] == times.shape[0]
        ax.plot(accuracy[kept], middle, **{**style, "marker": ""})
        for full, face in ((True, style["color"]), (False, "white")):
            part = is_complete == full
            ax.plot(
                accuracy[kept][part], middle[part], linestyle="none", marker=style["marker"],
                color=style["color"], markerfacecolor=face,
            )  # fmt: skip
    ax.set(xscale="log", yscale="log", xlabel="error to reach", ylabel="ns per forcing period")
    ax.invert_xaxis()
    # The labels on the left belong to the other panels.
    ax.yaxis.tick_right()
    ax.yaxis.set_label_position("right")
    ax.spines["left"].set_visible(False)
    ax.spines["right"].set_visible(True)
    ax.set_title("all motions, median")


PICTURES = (only_picture("work_precision", draw_work_precision, describe_work_precision),)
