"""Pictures of an accuracy scene: time over error, and what is asked of the program and reached."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import (
    BODY,
    SMALL,
    TIGHT_GROUND,
    arrow,
    axes,
    crosses,
    label,
    missed_band,
    new_canvas,
    note,
    open_mark,
    power_ticks,
)
from vibropipe.figures.palette import EXACT, GREY, INK
from vibropipe.scenes.accuracy.report import ASKED
from vibropipe.scenes.accuracy.summary import (
    LEAST_ERROR,
    NS,
    STYLES,
    curve,
    error_axis,
    failed,
    motion_title,
    multiple_text,
    of_errors,
    succeeded,
    time_axis,
    time_span,
    time_to_error,
)
from vibropipe.scenes.accuracy.text import describe_work_precision, title_of
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.measurements import Outcome

FAILED = "failed"  # in the legend, beside the methods
HERO_CM = 9.6
COLUMNS = 4
PITCH_CM = 4.2  # of rows of panels
WORST = 3.0  # left end of the axis of errors
BAND = 3e3  # left end of the band of failed runs
MARK_AT, CROSS_AT = 400.0, 20.0  # in that band: whose run, and that it failed
PRICE_AT = 1e-9  # error at which the line of the exact method is named
COMPARED_DIGITS = 1e-12  # error at which an arrow compares with the exact method
NO_ROOM = 3e-15  # error right of which no name has room
LONG_NAMES = {"crude": "impact at the\nend of a step", "newmark": "Newmark,\nimpacts located"}
MIN_GAP = 0.36  # cm between labels above each other


def draw_work_precision(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw time over error: one motion in one picture, several in a panel each."""
    dataset = of_errors(dataset, show)
    return draw_one(dataset) if dataset.sizes["motion"] == 1 else draw_several(dataset)


def table_part(dataset: xr.Dataset, method: str) -> np.ndarray:
    """Return which of the runs of a step method read their force from a table: the cheaper steps."""
    one = dataset.sel({"method": method})
    good = succeeded(one).values & np.isfinite(one["time_per_period"].values)
    has_table = method in ("crude", "newmark")
    limit = dataset.attrs.get("tabulated_steps", np.inf) if has_table else np.inf
    is_cheap: np.ndarray = ~(one["setting_value"].values[good] > limit)
    return is_cheap


def draw_one(dataset: xr.Dataset) -> Figure:
    """Draw all methods on one motion, each line with its name, beside multiples of the exact method."""
    figure = new_canvas(HERO_CM)
    ax = axes(figure, 1.55, 1.05, 12.9, HERO_CM - 1.35)
    dataset = dataset.isel(motion=0)
    error_axis(ax, range(-16, 1, 2), WORST)
    low, high = time_span(dataset)
    time_axis(ax, low / 1.5, high)
    ends = []
    for method in map(str, dataset["method"].values):
        error, time = curve(dataset, method)
        if not error.size:
            continue
        style, time = STYLES[method], time * NS
        error = np.maximum(error, LEAST_ERROR)
        cheap = table_part(dataset, method)
        last = int(cheap.sum())
        line: dict[str, Any] = {"color": style.colour, "marker": style.marker, "zorder": 3}
        if method == "exact":
            ax.plot([WORST, error[0]], [time[0]] * 2, color=EXACT, lw=0.6, ls=(0, (4, 2)), zorder=1)
            ax.text(PRICE_AT, time[0] / 1.25, "whatever the error",
                    color=EXACT, va="top", ha="center", fontsize=SMALL)  # fmt: skip
        ax.plot(error[:last], time[:last], **line, ms=7 if method == "exact" else 3.6)
        if last < error.size:
            dotted = slice(max(0, last - 1), None)
            ax.plot(error[dotted], time[dotted], color=style.colour, lw=0.7, ls=(0, (1, 1)))
            ax.plot(error[last:], time[last:], **{**line, "ls": "none", "mfc": "white"})
        ends.append((method, error[-1], time[-1], last < error.size))
    name_lines(ax, ends)
    exact = curve(dataset, "exact") if "exact" in dataset["method"].values else (np.empty(0),) * 2
    if exact[1].size:
        multiples(ax, exact[1][0] * NS)
        compare(ax, dataset, float(exact[0][0]), float(exact[1][0]))
    ax.set_xlabel("error reached (largest of all that are compared)   →  more accurate")
    ax.set_ylabel("time per forcing period, one core")
    return figure


def name_lines(ax: Axes, ends: list[tuple[str, float, float, bool]]) -> None:
    """Write the names of lines at their ends, apart from each other."""
    inch = ax.figure.dpi / 2.54
    taken: list[tuple[float, float]] = []
    for method, error, time, is_dear in sorted(ends, key=lambda end: end[2]):
        style = STYLES[method]
        x, y = (value / inch for value in ax.transData.transform((error, time)))
        to_left = method in ("crude", "exact", "heyoka") or error < NO_ROOM
        shift = -0.22 if to_left else 0.22
        y += {"exact": -0.42, "heyoka": 0.32}.get(method, 0.0)
        while any(abs(y - other) < MIN_GAP and abs(x - at) < 3.0 for at, other in taken):
            y += 0.1
        taken.append((x, y))
        at = ax.transData.inverted().transform(((x + shift) * inch, y * inch))
        bold: dict[str, Any] = {"weight": "bold", "fontsize": BODY + 1} if method == "exact" else {}
        text = LONG_NAMES.get(method, style.label) + ("*" if is_dear else "")
        place: dict[str, Any] = {"ha": "right" if to_left else "left", "va": "center", "zorder": 5}
        label(ax, at[0], at[1], text, style.colour, linespacing=1.1, **place, **bold)


def multiples(ax: Axes, unit: float) -> None:
    """Add a second axis of multiples of a time."""
    right = ax.twinx()
    low, high = ax.get_ylim()
    right.set(yscale="log", ylim=(low / unit, high / unit))
    exponents = range(int(np.ceil(np.log10(low / unit))), int(np.log10(high / unit)) + 1)
    power_ticks(right, "y", exponents)
    right.tick_params(axis="y", which="minor", length=0, labelright=False)
    right.spines["right"].set_visible(True)
    right.set_ylabel("times the exact method", labelpad=2)


def compare(ax: Axes, dataset: xr.Dataset, error: float, time: float) -> None:
    """Draw an arrow from the exact method to the fastest other method with COMPARED_DIGITS, with the multiple."""
    others = {
        str(m): time_to_error(*curve(dataset, str(m)), COMPARED_DIGITS)
        for m in dataset["method"].values
        if m != "exact"
    }
    others = {name: value for name, value in others.items() if np.isfinite(value)}
    if not others or error > COMPARED_DIGITS:
        return
    name, slow = min(others.items(), key=lambda item: item[1])
    x = COMPARED_DIGITS
    arrow(ax, (x, time * NS), (x, slow * NS), INK, arrowstyle="<|-|>")
    text = f"{STYLES[name].label},\n12 digits:\n{multiple_text(slow / time)} times"
    ax.text(
        x * 2.2, np.sqrt(slow * time) * NS, text, ha="right", va="center", fontsize=SMALL,
        linespacing=1.1,
    )  # fmt: skip


def draw_several(dataset: xr.Dataset) -> Figure:
    """Draw a panel for each motion on common axes; runs that fail stand as crosses in a band."""
    amount = dataset.sizes["motion"]
    rows = -(-amount // COLUMNS)
    legend_apart = amount % COLUMNS == 0
    height = 0.85 + rows * PITCH_CM + (0.9 if legend_apart else 0.0)
    figure = new_canvas(height)
    span = time_span(dataset)
    methods = [str(m) for m in dataset["method"].values]
    has_late = bool((failed(dataset) & np.isfinite(dataset["time_per_period"])).any())
    methods += [FAILED] if has_late else []
    top = height - 1.05 - (0.9 if legend_apart else 0.0)
    for k in range(amount):
        column, row = k % COLUMNS, k // COLUMNS
        ax = axes(figure, 1.55 + column * 3.65, top - 2.75 - row * PITCH_CM, 3.3, 2.75)
        draw_panel(ax, dataset.isel(motion=k), span, has_late)
        below = k + COLUMNS >= amount
        ax.set_ylabel("time per period" if column == 0 else "", labelpad=1)
        ax.set_xlabel("error reached" if below else "", labelpad=2)
        ax.tick_params(labelleft=column == 0)
    if legend_apart:
        key = axes(figure, 1.55, height - 0.85, 14.25, 0.7)
        draw_key(key, methods, columns=4)
    else:
        last = amount % COLUMNS
        free = COLUMNS - last
        key = axes(figure, 1.75 + last * 3.65, 0.85, min(free, 2) * 3.65 - 0.55, 3.2)
        draw_key(key, methods, columns=1)
    return figure


def draw_panel(ax: Axes, dataset: xr.Dataset, span: tuple[float, float], has_band: bool) -> None:
    """Draw all methods on one motion; `has_band` tells whether there is room for runs that fail."""
    error_axis(ax, (-15, -10, -5, 0), BAND if has_band else WORST)
    time_axis(ax, *span)
    if has_band:
        missed_band(ax, BAND, WORST, axis="x")
    lost = []
    for method in map(str, dataset["method"].values):
        style, one = STYLES[method], dataset.sel({"method": method})
        error, time = curve(dataset, method)
        ax.plot(
            np.maximum(error, LEAST_ERROR), time * NS, color=style.colour, marker=style.marker, lw=1.0,
            ms=5 if method == "exact" else 2.8, zorder=3,
        )  # fmt: skip
        times = one["time_per_period"].values
        late = times[np.isfinite(times) & failed(one).values] * NS
        marks: dict[str, Any] = {"mfc": "white", "mec": style.colour, "ms": 2.8, "mew": 0.7}
        ax.plot(np.full(late.size, MARK_AT), late, style.marker, **marks)
        crosses(ax, np.full(late.size, CROSS_AT), late, style.colour)
        tried = one["outcome"].values[one["outcome"].values != Outcome.NOT_TRIED]
        if tried.size and (tried == Outcome.DID_NOT_END).all():
            lost.append(style.label)
    periods = int(dataset["periods_run"])
    title = motion_title(dataset["motion"].values)
    ax.text(0, 1.17, title, transform=ax.transAxes, weight="bold", fontsize=BODY, va="bottom")
    impacts = f"{float(dataset['impacts_per_period']):.3g} impacts a period"
    texts: dict[str, Any] = {"transform": ax.transAxes, "fontsize": SMALL}
    ax.text(0, 1.03, f"{periods} periods, {impacts}", color=GREY, va="bottom", **texts)
    if lost:
        lines = [", ".join(lost[:2]), *([", ".join(lost[2:])] if len(lost) > 2 else [])]
        text = "no run finishes:\n" + ",\n".join(lines)
        note(ax, 0.98, 0.98, text, ha="right", color=INK, linespacing=1.1, bbox=TIGHT_GROUND)


def draw_key(ax: Axes, methods: list[str], columns: int) -> None:
    """Draw line and marker of each method with its name, and what a hollow mark with a cross means."""
    ax.set_axis_off()
    rows = -(-len(methods) // columns)
    ax.set(xlim=(0, columns), ylim=(rows - 0.5, -0.5))
    wide = 0.1 if columns > 1 else 0.12
    for k, method in enumerate(methods):
        x, y = k // rows, k % rows
        if method != FAILED:
            style = STYLES[method]
            ends = [x + 0.02, x + wide] if method != "exact" else [x + 0.02 + wide / 2]
            ax.plot(ends, [y] * len(ends), color=style.colour, marker=style.marker, ms=3.6, lw=1.0,
                    clip_on=False)  # fmt: skip
            text = {"crude": "impact at step's end"}.get(method, style.label)
        else:
            ax.plot([x + 0.02], [y], **open_mark("o", 2.8, markeredgecolor=GREY), clip_on=False)
            crosses(ax, [x + 0.02 + wide], [y], GREY)
            text = FAILED
        ax.text(x + wide + 0.06, y, text, va="center", fontsize=BODY)


PICTURES = (
    Picture(
        "work_precision", draw_work_precision, describe_work_precision, keywords=showing,
        titled=title_of,
    ),
    ASKED,
)  # fmt: skip
