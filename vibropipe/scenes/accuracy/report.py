"""Part of the report on accuracy scenes: answers, the times to errors of one motion, and how it is measured;
the errors that are asked for and reached.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import (
    SMALL,
    TIGHT_GROUND,
    axes,
    hairlines,
    label,
    new_canvas,
    note,
    panel,
    power_ticks,
)
from vibropipe.figures.palette import BAND, EXACT, GREY, INK, METHODS
from vibropipe.report.exciter import side_of_first
from vibropipe.report.parts import Answer, Datasets, Line, of_each, tables_of_each
from vibropipe.scenes.accuracy.summary import error_text, motion_subject, multiple_text
from vibropipe.scenes.accuracy.text import answers, packages_of, times_table
from vibropipe.scenes.kind import Picture, ReportPart
from vibropipe.words.status import Status
from vibropipe.words.wording import count

HEIGHT_CM = 5.6
BEST, LOWEST = 3e-16, 1e-17


def has_asked(dataset: xr.Dataset) -> bool:
    """Return whether accuracies were asked for."""
    return "asked_error" in dataset


def draw_asked(dataset: xr.Dataset) -> Figure:
    """Draw, for the first motion, errors and times over the accuracy that is asked for."""
    one = dataset.isel(motion=0)
    figure = new_canvas(HEIGHT_CM)
    draw_errors(axes(figure, 1.55, 1.0, 6.3, 4.0), one)
    draw_times(axes(figure, 9.5, 1.0, 6.3, 4.0), one)
    for ax in figure.axes:
        ax.set_xlabel("accuracy asked for   →  more accurate")
    return figure


def kept(one: xr.Dataset) -> np.ndarray:
    """Return which accuracies are reached by the program's own estimate."""
    return one["asked_status"].values == Status.OK


def asked_axis(ax: Axes, one: xr.Dataset) -> None:
    """Let the axis of the accuracies grow more accurate to the right."""
    asked = one["accuracy"].values
    ax.set(xscale="log", xlim=(max(1.0, asked.max()), min(BEST, asked.min() / 3)))
    power_ticks(ax, "x", range(-15, 1, 5))


def draw_errors(ax: Axes, one: xr.Dataset) -> None:
    """Draw the estimated and the true error, beside the region that is worse than asked."""
    asked, good = one["accuracy"].values, kept(one)
    asked_axis(ax, one)
    ends = np.array(ax.get_xlim())
    ax.set(yscale="log", ylim=(LOWEST, 1.0))
    power_ticks(ax, "y", range(-16, 1, 4))
    ax.fill_between(ends, ends, [1.0, 1.0], color=BAND, linewidth=0)
    ax.plot(ends, ends, color=INK, lw=0.6)
    note(ax, 0.97, 0.93, "worse than asked", ha="right")
    estimate = np.maximum(one["asked_estimate"].values, 2 * LOWEST)
    error = np.maximum(one["asked_error"].values, 2 * LOWEST)
    blue = METHODS["newmark"].colour
    # wide, to be seen under a true error that is almost the same
    ax.plot(asked, estimate, color=METHODS["crude"].colour, lw=5.0, alpha=0.6)
    draw_marks(ax, one, error)
    label(ax, asked[0], estimate[0] * 4, "wide: estimated by the program", blue, va="bottom")
    label(ax, asked[0], error[0] / 4, "true error", EXACT, va="top")
    if not good.all():
        ax.text(
            asked[~good].min(), estimate[~good].max() * 4, "refused", fontsize=SMALL, ha="right",
            va="bottom", color=GREY,
        )  # fmt: skip
    ax.set_ylabel("error")
    panel(ax, "a", indent=-1.4)


def draw_marks(ax: Axes, one: xr.Dataset, values: np.ndarray) -> None:
    """Draw values over the accuracies, hollow where these are not reached."""
    asked, good = one["accuracy"].values, kept(one)
    ax.plot(asked[good], values[good], "D", color=EXACT)
    ax.plot(asked[~good], values[~good], "D", color=EXACT, markerfacecolor="white")


def draw_times(ax: Axes, one: xr.Dataset) -> None:
    """Draw the time of the call, with its quartiles, beside that of a call without accuracy and of the march alone."""
    asked = one["accuracy"].values
    asked_axis(ax, one)
    times, low, high = (one[f"asked_time{side}"].values for side in ("", "_low", "_high"))
    plain = float(one["plain_time"])
    size, unit = (1e3, "µs") if max(times.max(), plain) >= 1e3 else (1.0, "ns")
    ax.vlines(asked, low / size, high / size, color=EXACT, lw=0.6)
    draw_marks(ax, one, times / size)
    march = march_alone(one)
    for line in (plain, march):
        ax.axhline(line / size, color=EXACT, lw=0.6, ls=(0, (4, 2)))
    ax.set_ylim(0, 1.25 * max(high.max(), plain) / size)
    hairlines(ax, "y")
    top = ax.get_ylim()[1]
    low_text, high_text = plain / size - 0.03 * top, times.max() / size + 0.05 * top
    texts: dict[str, Any] = {"colour": EXACT, "va": "top", "bbox": TIGHT_GROUND}
    label(ax, asked[0], low_text, "the same call without an accuracy", **texts)
    if march < 0.8 * plain:
        label(ax, asked[0], march / size - 0.03 * top, "its march alone", **texts)
    texts["va"] = "bottom"
    label(ax, asked[0], high_text, "a call with an estimate of its error", **texts)
    ax.set_ylabel(f"time per forcing period, {unit}")
    panel(ax, "b", indent=-1.1)


def march_alone(one: xr.Dataset) -> float:
    """Return the time of the exact method without the checks and labels of a call; nan if it was not run."""
    if "exact" not in one["method"].values:
        return float("nan")
    return float(one["time_per_period"].sel({"method": "exact"})[0])


def describe_asked(dataset: xr.Dataset) -> str:
    """Return the caption: what is drawn."""
    one = dataset.isel(motion=0)
    refused = " Hollow: refused, since the estimate is larger than what is asked."
    return (
        f"{motion_subject(one['motion'].values)} over {count(int(one['periods_run']), 'period')}. Times are "
        "of whole calls, with their checks and labels; vertical lines: quartiles. The true error is against 40 digits: "
        f"absolute, or relative to the motion where that is larger.{'' if kept(one).all() else refused}"
    )


def asked_answer(dataset: xr.Dataset) -> Answer:
    """Return what asking for an accuracy brings."""
    ones = [dataset.isel(motion=n) for n in range(dataset.sizes["motion"])]
    reached = [(one, kept(one)) for one in ones if kept(one).any()]
    if not reached:
        return Answer("No accuracy that was asked for is reached.")
    worst = max(float(one["asked_error"].values[good].max()) for one, good in reached)
    factors = [
        float(one["asked_time"].values[good].mean() / one["plain_time"]) for one, good in reached
    ]
    lead = "Newmark's method is taken where it is enough."
    if all((one["asked_steps"].values[good] == 0).all() for one, good in reached):
        lead = "Asking for less saves nothing."
    times = [multiple_text(factor) for factor in (min(factors), max(factors))]
    longer = f"the estimate makes a call {' to '.join(dict.fromkeys(times))} times as long"
    return Answer(lead, f"The true error is at most {error_text(worst)}; {longer}.")


def title_of_asked(dataset: xr.Dataset) -> str:
    """Return what the picture shows, as a sentence."""
    one = dataset.isel(motion=0)
    good = kept(one)
    is_kept = bool((one["asked_error"].values[good] <= one["accuracy"].values[good]).all())
    if is_kept and good.all():
        return "What is asked for is reached"
    return "What is asked for is reached, or refused" if is_kept else "Asked, estimated and reached"


def answers_of_scene(data: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene: on the methods, if there are several, and on the errors asked for."""
    compared = [] if data["method"].size == 1 else answers(data)
    return [*compared, *([asked_answer(data)] if has_asked(data) else [])]


def methods(datasets: Datasets) -> list[Line]:
    """Return the lines on errors and times, and on other packages."""
    asks = any(has_asked(dataset) for dataset in datasets.values())
    asked = ", which the times of accuracies asked for include" if asks else ""
    timed = (
        "CPU time of one core without compilation, median of rounds in which all methods take turns; of this program "
        f"without the checks and labels of a call{asked}; errors: end state "
        "and impact velocities over their sizes, impact times over the period, harmonics over the amplitude; impacts "
        "slower than 5 % of the fastest are not compared"
    )
    return [Line("Measured", timed), Line("Others", packages_of(datasets.values()))]


ASKED = Picture(
    "asked",
    draw_asked,
    describe_asked,
    has_asked,
    titled=title_of_asked,
    heading="What do I get if I ask for an accuracy?",
)
REPORT = ReportPart(
    "Accuracy",
    "How long does a forcing period take, for the error that I accept?",
    of_each(answers_of_scene),
    tables_of_each(times_table),
    methods,
    side_of_first,
)
