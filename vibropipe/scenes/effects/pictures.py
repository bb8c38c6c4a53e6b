"""Cost of effects and outputs: ratios of run times, and stored bytes, in one row per motion."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    BLACK,
    GREY,
    NEUTRAL,
    SMALL_FONT_SIZE,
    legend,
    line_style,
    new_figure,
)
from vibropipe.figures.text import format_number, sentences
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.measurements import Passed
from vibropipe.words.wording import count, series, share

ROW_CM = 0.62
# Kernel of the dataset -> marker and legend text of its ratio.
AGAINST: dict[str, tuple[str, str]] = {
    "all": ("o", "all-effects kernel, same motion"),
    "full": ("s", "all-effects kernel, motion with all effects"),
}
OFFSET = 0.22  # of a row, between kinds of ratios
REFERENCE = ("D", "reference motion of the target")
TARGET = "target (upper limit)"
# Quantity of each panel -> its width, relative to the others.
PANELS = {"time_ratio": 3, "bytes_per_row": 1}


def draw_effects(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw ratios of run times with quartiles, targets as bars, and stored bytes, or one of both."""
    names = [str(name).replace("_", " ") for name in dataset["motion"].values]
    figure = new_figure(3.4 + ROW_CM * len(names))
    widths = {name: width for name, width in PANELS.items() if name in (show or PANELS)}
    row_of_axes = figure.subplots(
        1, len(widths), sharey=True, squeeze=False, width_ratios=[*widths.values()]
    )[0]
    panels: dict[str, Axes] = dict(zip(widths, row_of_axes, strict=True))
    for ax in panels.values():
        for row in range(len(names)):
            ax.axhline(row, color=NEUTRAL, linewidth=0.4, zorder=0)
        ax.tick_params(axis="y", length=0)
        ax.set_xscale("log")
    if left := panels.get("time_ratio"):
        handles = draw_ratios(left, dataset)
        left.axvline(1.0, color=BLACK, linewidth=0.8, zorder=0)
        left.set_xlabel("ratio of run times")
        legend(figure, handles, "upper", "Run time of the specialised kernel relative to")
    row_of_axes[0].set_yticks(range(len(names)), names, fontsize=SMALL_FONT_SIZE)
    row_of_axes[0].set_ylim(len(names) - 0.4, -0.6)
    if right := panels.get("bytes_per_row"):
        sizes = dataset["bytes_per_row"].sel(kernel="own").values
        right.plot(sizes, range(len(names)), "P", color=BLACK)
        right.set_xlabel("bytes stored")
    return figure


def draw_ratios(ax: Axes, dataset: xr.Dataset) -> list[Line2D]:
    """Draw the ratios of all motions and return the legend entries."""
    handles = []
    rows = np.arange(dataset.sizes["motion"])
    for index, (kernel, (marker, text)) in enumerate(AGAINST.items()):
        style = {"marker": marker, "color": line_style(index)["color"], "linestyle": "none"}
        draw_spread(
            ax, dataset.sel(kernel=kernel), "time_ratio", rows + OFFSET * (index - 1), style
        )
        handles.append(Line2D([], [], label=text, **style))
    compared = dataset["target_against"].values != "all effects"
    style = {"marker": REFERENCE[0], "color": line_style(2)["color"], "linestyle": "none"}
    if compared.any():
        draw_spread(
            ax, dataset.isel(motion=compared), "target_ratio", rows[compared] + OFFSET, style
        )
        handles.append(Line2D([], [], label=REFERENCE[1], **style))
    target = dataset["target"].values
    has_target = np.isfinite(target)
    if has_target.any():
        at = rows[has_target]
        ax.vlines(target[has_target], at - 0.4, at + 0.4, color=GREY, linewidth=2)
        bar: dict[str, Any] = {"marker": "|", "markersize": 9, "markeredgewidth": 2.5}
        handles.append(Line2D([], [], label=TARGET, color=GREY, linestyle="none", **bar))
    return handles


def draw_spread(
    ax: Axes, dataset: xr.Dataset, name: str, rows: np.ndarray, style: dict[str, Any]
) -> None:
    """Draw medians with quartiles."""
    middle = dataset[name].values
    spread = np.abs([dataset[f"{name}_{side}"].values - middle for side in ("low", "high")])
    ax.errorbar(middle, rows, xerr=spread, elinewidth=0.8, **style)


def describe_effects(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption: number of targets met, and measured ratios of those that are missed, or stored bytes."""
    if show and "time_ratio" not in show:
        return bytes_text(dataset)
    met = dataset["target_met"].values
    n_met, total = int((met == Passed.PASSED).sum()), int((met != Passed.NOT_ASKED).sum())
    missed = [
        missed_text(dataset.isel(motion=index))
        for index in np.flatnonzero(met == Passed.NOT_PASSED)
    ]
    return sentences(
        f"{count(dataset.sizes['motion'], 'motion')}; {share(n_met, total, 'target')} met",
        f"Missed: {series(missed)}" if missed else "",
    )


def bytes_text(dataset: xr.Dataset) -> str:
    """Return the caption of the stored bytes alone: the fewest and the most."""
    own = dataset["bytes_per_row"].sel(kernel="own")
    least, most = (
        f"{format_number(float(own[index]))} ({str(own['motion'].values[index]).replace('_', ' ')})"
        for index in (int(own.values.argmin()), int(own.values.argmax()))
    )
    motions = count(dataset.sizes["motion"], "motion")
    return sentences(f"Bytes stored of {motions}: from {least} to {most}")


def missed_text(one: xr.Dataset) -> str:
    """Write the measured ratio and the target of a motion."""
    name, against = (str(one[key].item()).replace("_", " ") for key in ("motion", "target_against"))
    reference = "the all-effects kernel" if against == "all effects" else against
    ratio = format_number(float(one["target_ratio"]), 2)
    return f"{name} ({ratio} of {reference}, target {format_number(float(one['target']), 3)})"


PICTURES = (Picture("costs", draw_effects, describe_effects, keywords=showing),)
