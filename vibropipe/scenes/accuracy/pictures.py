"""Error against time of several methods: a panel per motion, and one for all of them together."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import LINE_MARKERS, SMALL_FONT_SIZE, legend, line_style, new_figure
from vibropipe.scenes.accuracy.summary import orders, sound, time_to_reach, worst_error
from vibropipe.scenes.accuracy.text import describe_work_precision
from vibropipe.scenes.kind import only_picture
from vibropipe.words.measurements import Outcome

COLUMNS = 3
PANEL_HEIGHT_CM = 5.4
LEGEND_HEIGHT_CM = 1.6
TOP, BOTTOM = 30.0, 1e-17
FAILED_AT = 5.0
METHOD_WORDS = {
    "crude": "Newmark, impact at the step's end",
    "newmark": "Newmark, impact located",
    "exact": "exact",
    "heyoka": "heyoka",
}
WITHOUT_TIME = {
    Outcome.DID_NOT_END: "no end",
    Outcome.NOT_INSTALLED: "not installed",
}


def draw_work_precision(dataset: xr.Dataset) -> Figure:
    """Draw each motion's errors over time per forcing period, then the time to reach an accuracy."""
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
        Line2D([], [], **style_of(place), label=METHOD_WORDS.get(name, name))
        for place, name in enumerate(methods)
    ]
    legend(figure, handles, "upper")
    return figure


def style_of(place: int) -> dict[str, Any]:
    """Return how the method at ``place`` is drawn."""
    return {**line_style(place), "marker": LINE_MARKERS[place % len(LINE_MARKERS)]}


def draw_motion_panel(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw all methods on one motion: lines of sound runs, crosses of failed ones, orders, notes."""
    error, good = worst_error(dataset)[0].values, sound(dataset)[0].values
    order = orders(dataset)[0].values
    dataset = dataset.isel(motion=0)
    time = dataset["time_per_period"].values
    quartiles = [dataset[f"time_per_period_{side}"].values for side in ("low", "high")]
    notes: dict[str, list[str]] = {}
    for place, method in enumerate(dataset["method"].values):
        drawn = good[place] & np.isfinite(time[place])
        x, y = time[place][drawn], np.clip(error[place][drawn], 2 * BOTTOM, TOP)
        spread = np.abs([side[place][drawn] - x for side in quartiles])
        style = style_of(place)
        ax.errorbar(x, y, xerr=spread, elinewidth=0.6, **style)
        if np.isfinite(order[place]):
            # below the last point, where the line has ended
            annotation = ax.annotate(
                f"{order[place]:.1f}", (x[-1], y[-1]), (0, -4), textcoords="offset points",
                ha="center", va="top", color=style["color"], fontsize=SMALL_FONT_SIZE,
            )  # fmt: skip
            annotation.set_in_layout(False)
        failed = ~good[place] & np.isfinite(time[place])
        if failed.any():
            at = np.full(failed.sum(), FAILED_AT)
            ax.plot(time[place][failed], at, "x", color=style["color"])
        for outcome, words in WITHOUT_TIME.items():
            if (dataset["outcome"].values[place] == outcome).any():
                notes.setdefault(words, []).append(str(method))
    ax.set(xscale="log", yscale="log", ylim=(BOTTOM, TOP))
    ax.set_title(str(dataset["motion"].values).replace("_", " "))
    note = ax.text(
        0.98, 0.02, "\n".join(f"{words}: {', '.join(who)}" for words, who in notes.items()),
        transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL_FONT_SIZE - 2,
    )  # fmt: skip
    note.set_in_layout(False)


def draw_summary_panel(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the median over motions of the time to reach each accuracy; hollow where not all reach it."""
    times = time_to_reach(dataset).values
    reached = np.isfinite(times).sum(axis=0)
    accuracy = time_to_reach(dataset)["accuracy"].values
    for place in range(times.shape[1]):
        kept = 2 * reached[place] > times.shape[0]
        if not kept.any():
            continue
        middle = np.nanmedian(times[:, place, kept], axis=0)
        style = style_of(place)
        all_of_them = reached[place][kept] == times.shape[0]
        ax.plot(accuracy[kept], middle, **{**style, "marker": ""})
        for full, face in ((True, style["color"]), (False, "white")):
            part = all_of_them == full
            ax.plot(
                accuracy[kept][part], middle[part], linestyle="none", marker=style["marker"],
                color=style["color"], markerfacecolor=face,
            )  # fmt: skip
    ax.set(xscale="log", yscale="log", xlabel="error to reach", ylabel="ns per forcing period")
    ax.invert_xaxis()
    # The other panels share an axis at the left.
    ax.yaxis.tick_right()
    ax.yaxis.set_label_position("right")
    ax.spines["left"].set_visible(False)
    ax.spines["right"].set_visible(True)
    ax.set_title("all motions, median")


PICTURES = (only_picture("work_precision", draw_work_precision, describe_work_precision),)
