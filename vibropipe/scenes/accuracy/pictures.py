"""Pictures of an accuracy scene: error against time, a panel per motion, and the times to reach an accuracy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.style import SMALL_FONT_SIZE, new_figure
from vibropipe.scenes.accuracy.summary import of_errors, orders, succeeded, worst_error
from vibropipe.scenes.accuracy.text import describe_work_precision
from vibropipe.scenes.accuracy.times import (
    add_legend,
    describe_times,
    draw_times,
    installed,
    style_of,
)
from vibropipe.scenes.kind import showing_picture
from vibropipe.words.measurements import Outcome

FEW_MOTIONS = 8  # as many as fill a page in two columns; more stand in three
PANEL_HEIGHT_CM = 4.5
LEGEND_HEIGHT_CM = 2.0
TOP, BOTTOM = 30.0, 1e-17  # limits of the error axis
FAILED_ERROR = 5.0  # ordinate of the crosses of failed runs


def draw_work_precision(dataset: xr.Dataset, show: Sequence[str] = ()) -> Figure:
    """Draw the errors of each motion against time per forcing period, a panel per motion."""
    dataset = installed(of_errors(dataset, show))
    symbol = f" {dataset[show[0]].attrs['symbol']}" if len(show) == 1 else ""
    panels = dataset.sizes["motion"]
    columns = 2 if panels <= FEW_MOTIONS else 3
    rows = -(-panels // columns)
    figure = new_figure(PANEL_HEIGHT_CM * rows + LEGEND_HEIGHT_CM)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    times = dataset["time_per_period"].values
    span = (np.nanmin(times) / 2, np.nanmax(times) * 2) if np.isfinite(times).any() else (1, 10)
    for position, ax in enumerate(axes[:panels]):
        draw_motion_panel(ax, dataset.isel(motion=[position]))
        ax.set_xlim(span)
        left, low = position % columns == 0, position + columns >= panels
        ax.tick_params(labelleft=left, labelbottom=low)
        ax.set(
            ylabel=f"error{symbol}" if left else "", xlabel="ns per forcing period" if low else ""
        )
    for ax in axes[panels:]:
        ax.set_visible(False)
    add_legend(figure, [str(name) for name in dataset["method"].values])
    return figure


def draw_motion_panel(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw all methods on one motion: lines of successful runs, crosses of failed ones, orders, notes."""
    error, good = worst_error(dataset)[0].values, succeeded(dataset)[0].values
    order = orders(dataset)[0].values
    dataset = dataset.isel(motion=0)
    time = dataset["time_per_period"].values
    quartiles = [dataset[f"time_per_period_{side}"].values for side in ("low", "high")]
    notes: list[str] = []
    names = [str(name) for name in dataset["method"].values]
    for index, method in enumerate(names):
        drawn = good[index] & np.isfinite(time[index])
        x, y = time[index][drawn], np.clip(error[index][drawn], 2 * BOTTOM, TOP)
        spread = np.abs([side[index][drawn] - x for side in quartiles])
        style = style_of(method, names)
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
        if (dataset["outcome"].values[index] == Outcome.DID_NOT_END).any():
            notes.append(method)
    ax.set(xscale="log", yscale="log", ylim=(BOTTOM, TOP))
    ax.set_title(str(dataset["motion"].values).replace("_", " "))
    # below the lines and above the exact method, at rounding level
    note = ax.text(
        0.98, 0.35, f"did not finish: {', '.join(notes)}" if notes else "",
        transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL_FONT_SIZE - 1,
    )  # fmt: skip
    note.set_in_layout(False)


PICTURES = (
    showing_picture("work_precision", draw_work_precision, describe_work_precision),
    showing_picture("times", draw_times, describe_times),
)
