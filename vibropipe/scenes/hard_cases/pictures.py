"""Hard cases: measured deviation of each solver from the known property, relative to its bound."""

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
    LINE_MARKERS,
    NEUTRAL,
    SMALL_FONT_SIZE,
    legend,
    line_style,
    new_figure,
)
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.measurements import Passed
from vibropipe.words.wording import count, series

LEFT, RIGHT = 1e-9, 1e2  # abscissae of no deviation and of deviations beyond the scale
ROW_CM = 0.42
SPREAD = 0.5  # of a row, over which the markers of its solvers are spread


def shares(dataset: xr.Dataset) -> np.ndarray:
    """Return measured/bound over (case, solver): 0 without deviation, nan where not applicable.

    A count that should be zero and is not gives inf, and so does a value that is not a number.
    """
    measured, bound = dataset["measured"].values, dataset["bound"].values
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(measured == 0.0, 0.0, measured / bound)
    share[np.isnan(share)] = np.inf
    return np.where(dataset["passed"].values != Passed.NOT_ASKED, share, np.nan)


def by_solvers(dataset: xr.Dataset, show: Collection[str]) -> xr.Dataset:
    """Return the results of the solvers to show (default: all), in the order of the data."""
    return dataset.isel(solver=np.isin(dataset["solver"].values, list(show))) if show else dataset


def draw_hard_cases(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw measured/bound on a log axis, one row per case and one marker per solver.

    Markers at the left edge have no deviation; those right of 1 do not pass. Of the solvers, those of `show` are drawn.
    """
    dataset = by_solvers(dataset, show)
    cases = [str(name).replace("_", " ") for name in dataset["case"].values]
    figure = new_figure(2.6 + ROW_CM * len(cases))
    ax = figure.subplots()
    ax.axvspan(1.0, RIGHT * 4, color=NEUTRAL, linewidth=0)
    ax.axvline(1.0, color=BLACK, linewidth=0.8)
    for row in range(len(cases)):
        ax.axhline(row, color=NEUTRAL, linewidth=0.4, zorder=0)
    handles = draw_solvers(ax, dataset)
    ax.set_xscale("log")
    ax.set_xlim(LEFT / 4, RIGHT * 4)
    ticks = [LEFT, *(10.0**n for n in range(-7, 1, 1)), RIGHT]
    tick_labels = ["0", *(rf"$10^{{{n}}}$" for n in range(-7, 0)), "1", "off"]
    ax.set_xticks(ticks, tick_labels)
    ax.minorticks_off()
    ax.set_yticks(range(len(cases)), cases, fontsize=SMALL_FONT_SIZE)
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(len(cases) - 0.4, -0.6)
    ax.set_xlabel("measured / allowed deviation (pass up to 1)")
    legend(figure, handles, "upper")
    return figure


def draw_solvers(ax: Axes, dataset: xr.Dataset) -> list[Line2D]:
    """Draw the markers of every solver, filled if passed, and return the legend entries."""
    share, passed = shares(dataset), dataset["passed"].values == Passed.PASSED
    solvers = dataset["solver"].values
    offsets = np.linspace(-SPREAD / 2, SPREAD / 2, len(solvers)) if len(solvers) > 1 else [0.0]
    handles = []
    for index, (solver, offset) in enumerate(zip(solvers, offsets, strict=True)):
        style: dict[str, Any] = {
            "linestyle": "none",
            "marker": LINE_MARKERS[index % len(LINE_MARKERS)],
            "color": line_style(index)["color"],
            "markersize": 3.2,
        }
        x = np.clip(share[:, index], LEFT, RIGHT)
        y = np.arange(share.shape[0]) + offset
        good = passed[:, index] & np.isfinite(x)
        bad = ~passed[:, index] & np.isfinite(x)
        ax.plot(x[good], y[good], **style)
        ax.plot(x[bad], y[bad], **style | {"markerfacecolor": "white", "markersize": 5.0})
        handles.append(Line2D([], [], **style, label=str(solver)))
    return handles


def describe_hard_cases(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption: number of cases, by which solvers if not all, and which of them do not pass."""
    dataset = by_solvers(dataset, show)
    failed = np.asarray((dataset["passed"].values == Passed.NOT_PASSED).any(axis=1))
    names = [str(name) for name in dataset["case"].values[failed]]
    solvers = f" by {series(map(str, dataset['solver'].values))}" if show else ""
    total = f"{count(int(dataset.sizes['case']), 'case')}{solvers}"
    verdict = f"not passed: {series(names)}" if names else "all passed"
    short = int(dataset["short_flight_motions"].values.sum())
    motions = count(int(dataset["motions"].values.sum()), "motion")
    return f"{total}, {verdict}. {short} of {motions} had flights shorter than the step."


PICTURES = (Picture("margins", draw_hard_cases, describe_hard_cases, keywords=showing),)
