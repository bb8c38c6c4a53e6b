"""Pictures of an accuracy scene: error against time, a panel per motion, and the times to reach an accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

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
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.measurements import Outcome

FEW_MOTIONS = 8  # as many as fill a page in two columns; more stand in three
PANEL_HEIGHT_CM = 4.5
LEGEND_HEIGHT_CM = 2.0
TOP, BOTTOM = 30.0, 1e-17  # limits of the error axis
LABEL_OFFSETS = (
    (0.0, -8.0),
    (0.0, 8.0),
    (-12.0, 0.0),
    (12.0, 0.0),
)  # in points, the first if all are free
POINTS_PER_INCH = 72
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
        draw_motion_panel(ax, dataset.isel(motion=[position]), span)
        left, low = position % columns == 0, position + columns >= panels
        ax.tick_params(labelleft=left, labelbottom=low)
        ax.set(
            ylabel=f"error{symbol}" if left else "", xlabel="ns per forcing period" if low else ""
        )
    for ax in axes[panels:]:
        ax.set_visible(False)
    add_legend(figure, [str(name) for name in dataset["method"].values])
    return figure


def draw_motion_panel(ax: Axes, dataset: xr.Dataset, span: tuple[float, float]) -> None:
    """Draw all methods on one motion: lines of successful runs, crosses of failed ones, orders, notes.

    span : limits of the times.
    """
    ax.set(xscale="log", yscale="log", xlim=span, ylim=(BOTTOM, TOP))
    error, good = worst_error(dataset)[0].values, succeeded(dataset)[0].values
    order = orders(dataset)[0].values
    dataset = dataset.isel(motion=0)
    time = dataset["time_per_period"].values
    quartiles = [dataset[f"time_per_period_{side}"].values for side in ("low", "high")]
    notes: list[str] = []
    ends: list[tuple[str, tuple[float, float], Any]] = []
    lines: list[NDArray] = []
    names = [str(name) for name in dataset["method"].values]
    for index, method in enumerate(names):
        drawn = good[index] & np.isfinite(time[index])
        x, y = time[index][drawn], np.clip(error[index][drawn], 2 * BOTTOM, TOP)
        spread = np.abs([side[index] - time[index] for side in quartiles])
        style = style_of(method, names)
        # nan where a run failed: no line leads over it
        shown = np.where(drawn, np.clip(error[index], 2 * BOTTOM, TOP), np.nan)
        ax.errorbar(time[index], shown, xerr=spread, elinewidth=0.6, **style)
        lines.append(np.stack([x, y], axis=1))
        if np.isfinite(order[index]):
            ends.append((f"{order[index]:.1f}", (x[-1], y[-1]), style["color"]))
        failed = ~good[index] & np.isfinite(time[index])
        if failed.any():
            at = np.full(failed.sum(), FAILED_ERROR)
            ax.plot(time[index][failed], at, "x", color=style["color"])
        lost = dataset["outcome"].values[index] == Outcome.DID_NOT_END
        if lost.any():
            tried = dataset["outcome"].values[index] != Outcome.NOT_TRIED
            notes.append(
                method if lost[tried].all() else f"{method} ({lost.sum()} of {tried.sum()})"
            )
    for text, end, color in ends:
        write_beside(ax, text, end, lines, color)
    ax.set_title(str(dataset["motion"].values).replace("_", " "))
    # At rounding level, which no slow method reaches.
    note = ax.text(
        0.98, 0.03, f"did not finish: {', '.join(notes)}" if notes else "",
        transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL_FONT_SIZE - 1,
    )  # fmt: skip
    note.set_in_layout(False)


def write_beside(
    ax: Axes, text: str, end: tuple[float, float], lines: Sequence[NDArray], color: Any
) -> None:
    """Write a text around the end of a line where the lines, each (n, 2), are farthest."""
    at = ax.transData.transform([end])[0]
    centred = [ax.transData.transform(line) - at for line in lines if len(line)]
    along = np.concatenate([on_line(line) for line in centred])

    def room(offset: tuple[float, float]) -> float:
        apart = along - np.array(offset) * ax.figure.dpi / POINTS_PER_INCH
        return float(np.hypot(apart[:, 0] / 2, apart[:, 1]).min())  # a text is wider than high

    annotation = ax.annotate(
        text, end, max(LABEL_OFFSETS, key=room), textcoords="offset points", ha="center",
        va="center", color=color, fontsize=SMALL_FONT_SIZE,
    )  # fmt: skip
    annotation.set_in_layout(False)


def on_line(corners: NDArray) -> NDArray:
    """Return points (n, 2) close to each other on a line through corners."""
    where = np.linspace(0, len(corners) - 1, 16 * len(corners))
    return np.stack([np.interp(where, range(len(corners)), column) for column in corners.T], axis=1)


PICTURES = (
    Picture("work_precision", draw_work_precision, describe_work_precision, keywords=showing),
    Picture("times", draw_times, describe_times, keywords=showing),
)
