"""What effects and outputs cost: ratios of times and bytes on disk, a row for each motion."""

from __future__ import annotations

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
from vibropipe.figures.text import (
    format_number,
)
from vibropipe.scenes.kind import only_picture
from vibropipe.words.wording import count, series, share

ROW_CM = 0.62
# kernel of the dataset -> how its ratio is drawn and called
AGAINST: dict[str, tuple[str, str]] = {
    "all": ("o", "all effects, same motion"),
    "full": ("s", "all effects, motion that has them all"),
}
APART = 0.22  # of a row, between kinds of ratios
OTHER = ("D", "the motion that the target names")
TARGET = "target, passed up to it"


def draw_effects(dataset: xr.Dataset) -> Figure:
    """Draw ratios of times with their quartiles, targets as bars, and bytes beside them."""
    names = [str(name).replace("_", " ") for name in dataset["motion"].values]
    figure = new_figure(3.4 + ROW_CM * len(names))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[3, 1])
    for ax in (left, right):
        for row in range(len(names)):
            ax.axhline(row, color=NEUTRAL, linewidth=0.4, zorder=0)
        ax.tick_params(axis="y", length=0)
        ax.set_xscale("log")
    handles = draw_ratios(left, dataset)
    left.axvline(1.0, color=BLACK, linewidth=0.8, zorder=0)
    left.set_xlabel("ratio of times")
    left.set_yticks(range(len(names)), names, fontsize=SMALL_FONT_SIZE)
    left.set_ylim(len(names) - 0.4, -0.6)
    sizes = dataset["bytes_per_row"].sel(kernel="own").values
    right.plot(sizes, range(len(names)), "P", color=BLACK)
    right.set_xlabel("bytes stored")
    legend(figure, handles, "upper", "Time of a motion's own kernel over that of")
    return figure


def draw_ratios(ax: Axes, dataset: xr.Dataset) -> list[Line2D]:
    """Draw the ratios of all motions, kind above kind, and return the entries of the legend."""
    handles = []
    rows = np.arange(dataset.sizes["motion"])
    for place, (kernel, (marker, words)) in enumerate(AGAINST.items()):
        style = {"marker": marker, "color": line_style(place)["color"], "linestyle": "none"}
        draw_spread(ax, dataset.sel(kernel=kernel), "time_ratio", rows + APART * (place - 1), style)
        handles.append(Line2D([], [], label=words, **style))
    compared = dataset["target_against"].values != "all effects"
    style = {"marker": OTHER[0], "color": line_style(2)["color"], "linestyle": "none"}
    if compared.any():
        draw_spread(
            ax, dataset.isel(motion=compared), "target_ratio", rows[compared] + APART, style
        )
        handles.append(Line2D([], [], label=OTHER[1], **style))
    target = dataset["target"].values
    aimed = np.isfinite(target)
    if aimed.any():
        ax.vlines(target[aimed], rows[aimed] - 0.4, rows[aimed] + 0.4, color=GREY, linewidth=2)
        bar: dict[str, Any] = {"marker": "|", "markersize": 9, "markeredgewidth": 2.5}
        handles.append(Line2D([], [], label=TARGET, color=GREY, linestyle="none", **bar))
    return handles


def draw_spread(
    ax: Axes, dataset: xr.Dataset, name: str, rows: np.ndarray, style: dict[str, Any]
) -> None:
    """Draw medians with their quartiles."""
    middle = dataset[name].values
    spread = np.abs([dataset[f"{name}_{side}"].values - middle for side in ("low", "high")])
    ax.errorbar(middle, rows, xerr=spread, elinewidth=0.8, **style)


def describe_effects(dataset: xr.Dataset) -> str:
    """Say which targets are met, and by how much the others are missed."""
    met = dataset["target_met"].values
    asked, passed = int((met != 2).sum()), int((met == 1).sum())
    said = [f"{count(dataset.sizes['motion'], 'motion')}; {share(passed, asked, 'target')} met"]
    missed = [missed_words(dataset.isel(motion=place)) for place in np.flatnonzero(met == 0)]
    return ". ".join([*said, *([f"Missed: {series(missed)}"] if missed else [])]) + "."


def missed_words(one: xr.Dataset) -> str:
    """Say by how much a motion misses its target."""
    name, against = str(one["motion"].item()).replace("_", " "), str(one["target_against"].item())
    found, aimed = (
        format_number(float(one["target_ratio"]), 2),
        format_number(float(one["target"]), 3),
    )
    return f"{name} ({found} of {against_words(against)}, aimed at {aimed})"


def against_words(name: str) -> str:
    """Name what a target is about."""
    return "the kernel of all effects" if name == "all effects" else name.replace("_", " ")


PICTURES = (only_picture("costs", draw_effects, describe_effects),)
