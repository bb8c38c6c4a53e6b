"""Where common methods fail: energy over impacts, grazing depth, chatter over restitution, error over steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import (
    SMALL,
    axes,
    crosses,
    label,
    missed_band,
    new_canvas,
    panel,
    power_ticks,
)
from vibropipe.figures.palette import EXACT, GREY, METHODS
from vibropipe.figures.text import format_number, sentences
from vibropipe.scenes.kind import Picture
from vibropipe.words.measurements import Outcome
from vibropipe.words.wording import series

ROW_CM = 5.65
EPS = float(np.finfo(float).eps)
FLOOR = 3e-17  # where an error of 0 is drawn
BOTTOM, TOP = 1e-17, 1e2
BAND = (1e1, 3e3)  # of what fails
RANGE = "#DCE6F0"  # region below what the start is rounded to
LIGHT_DOP853 = replace(METHODS["dop853"], colour="#CE7F66")  # 61
LIGHT = ("crude", "DOP853_loose", "DOP853_short")
STYLES = {
    **{name: METHODS[name] for name in ("crude", "newmark", "exact")},
    "DOP853": METHODS["dop853"],
    "DOP853_loose": LIGHT_DOP853,
    "DOP853_short": LIGHT_DOP853,
    "closed": METHODS["exact"],
}


def questions_in(dataset: xr.Dataset) -> list[str]:
    """Return the questions that a dataset answers."""
    return [name for name in PANELS if f"{name}_error" in dataset]


def has_failures(dataset: xr.Dataset) -> bool:
    """Return whether common methods were asked."""
    return bool(questions_in(dataset))


def draw_failures(dataset: xr.Dataset) -> Figure:
    """Draw a panel for each question."""
    names = questions_in(dataset)
    rows = -(-len(names) // 2)
    figure = new_canvas(rows * ROW_CM + 0.05)
    for k, name in enumerate(names):
        left, bottom = 1.5 + 7.9 * (k % 2), 1.0 + (rows - 1 - k // 2) * ROW_CM
        ax = axes(figure, left, bottom, 6.35, 4.1)
        draw, title = PANELS[name]
        draw(ax, dataset)
        panel(ax, "abcd"[k] if len(names) > 1 else "", title, indent=-1.2)
    return figure


def errors_of(dataset: xr.Dataset, question: str, method: str) -> tuple[np.ndarray, np.ndarray]:
    """Return error and outcome of a method over the abscissa of a question."""
    one = dataset.sel({"method": method})
    return one[f"{question}_error"].values, one[f"{question}_outcome"].values


def asked_of(dataset: xr.Dataset, question: str) -> list[str]:
    """Return the methods that were asked a question, the exact ones last."""
    outcome = dataset[f"{question}_outcome"].values
    asked = (outcome != Outcome.NOT_TRIED).any(axis=1)
    return [str(m) for m, is_asked in zip(dataset["method"].values, asked, strict=True) if is_asked]


def error_axis(ax: Axes, has_failed: bool) -> None:
    """Set the axis of errors, with a band for what fails."""
    ax.set(yscale="log", ylim=(BOTTOM, BAND[1] if has_failed else TOP))
    power_ticks(ax, "y", (-16, -12, -8, -4, 0))
    if has_failed:
        missed_band(ax, *BAND, text="")
    ax.axhline(EPS, color=GREY, lw=0.4, ls=(0, (1, 2)), zorder=0)


def line_of(method: str, size: float = 2.6) -> dict[str, Any]:
    """Return colour and marker of a method."""
    style = STYLES[method]
    return {"color": style.colour, "marker": style.marker, "ms": size}


def name_line(ax: Axes, x: float, y: float, text: str, method: str, **options: Any) -> None:
    """Write the name of a method at a point; of two methods whose names are equally dark, one in italics."""
    font = {"weight": "bold"} if method in ("exact", "closed") else {}
    if method in LIGHT:
        font = {"style": "italic"}
    label(ax, x, y, text, STYLES[method].colour, linespacing=1.1, va="center", **font, **options)


def draw_energy(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the energy error of a free motion over its impacts; runs that end do so with a mark."""
    error_axis(ax, has_failed=False)
    count = dataset["impact_count"].values
    ax.set(xscale="log", xlim=(1, count[-1]))
    power_ticks(ax, "x", range(0, int(np.log10(count[-1])) + 1, 2))
    for method in asked_of(dataset, "energy"):
        error, _outcome = errors_of(dataset, "energy", method)
        known = np.isfinite(error)
        x, y = count[known], np.maximum(error[known], FLOOR)
        thick = 2.0 if method in ("exact", "closed") else 1.2
        dashes = (0, (3, 1)) if method == "closed" else "-"
        ax.plot(x, y, color=STYLES[method].colour, lw=thick, ls=dashes, zorder=3)
        if not known.all() and x.size:
            mark = "x" if method == "crude" else "|"
            ax.plot(x[-1], y[-1], mark, color=STYLES[method].colour, ms=4, mew=1.0)
    name_line(ax, 1.5, 4.0, "impact at step's end", "crude", ha="left")
    x, y = last_of(dataset, "DOP853_loose")
    name_line(ax, 1.7 * x, y, "DOP853, 10⁻⁶", "DOP853_loose", ha="left")
    x, y = last_of(dataset, "DOP853")
    name_line(ax, 1.3 * x, 14.0 * y, "DOP853, 10⁻¹⁰", "DOP853", ha="right")
    name_line(ax, 7e5, 2e-8, "Newmark", "newmark", ha="right")
    name_line(ax, 1.5e4, 4e-13, "exact, marched", "exact", ha="left")
    name_line(ax, 7e5, 2e-15, "exact, closed form", "closed", ha="right")
    ax.set(xlabel="impacts", ylabel="relative error of the energy")


def last_of(dataset: xr.Dataset, method: str) -> tuple[float, float]:
    """Return the last known point of a line of the energy."""
    error, _outcome = errors_of(dataset, "energy", method)
    known = np.flatnonzero(np.isfinite(error))
    if not known.size:
        return 1.0, 1.0
    return float(dataset["impact_count"][known[-1]]), float(error[known[-1]])


def draw_grazing(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the velocity error of a grazing impact over its depth, and which impacts are missed."""
    error_axis(ax, has_failed=True)
    depth = dataset["depth"].values
    ax.set(xscale="log", xlim=(depth.max() * 16, depth.min() / 2))
    power_ticks(ax, "x", range(-2, -14, -3))
    below = np.geomspace(depth.max() * 16, depth.min() / 2, 40)
    ax.fill_between(below, BOTTOM, 0.5 * EPS / (2 * below), color=RANGE, lw=0, zorder=0)
    levels = iter((5e1, 4e2, 2e2))
    for method in asked_of(dataset, "grazing"):
        error, outcome = errors_of(dataset, "grazing", method)
        drawn = np.maximum(error, FLOOR)
        ls = "none" if method == "crude" else "-"
        ax.plot(depth, drawn, **line_of(method, 2.4), ls=ls, lw=0.6, zorder=3 + (method == "exact"))
        missed = outcome == Outcome.MISSED_IMPACT
        if missed.any():
            level = next(levels)
            crosses(ax, depth[missed], np.full(missed.sum(), level), STYLES[method].colour)
    ax.text(depth.max() * 10, 1.7e2, "missed", fontsize=SMALL, va="center")
    name_line(ax, 1.2e-8, 1.5e-2, "impact at step's end", "crude", ha="center")
    name_line(ax, 3e-9, 4e-6, "Newmark", "newmark", ha="right")
    name_line(ax, depth.max() * 10, 2e-8, "DOP853", "DOP853", ha="left")
    name_line(ax, depth.min(), 3e-11, "DOP853, short steps", "DOP853_short", ha="right")
    name_line(ax, 3e-7, 1e-13, "exact", "exact", ha="left")
    ax.text(
        depth.min(), 1.5e-14, "below: finer than\nthe start is rounded", fontsize=SMALL, color="#4A6079",
        ha="right", va="center", linespacing=1.1,
    )  # fmt: skip
    ax.set(xlabel="depth of the impact   →  shallower", ylabel="relative error of the velocity")


def draw_chatter(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the error of the end of a chatter over the restitution; methods that never come to rest fail."""
    error_axis(ax, has_failed=True)
    R = dataset["restitution"].values
    ax.set_xlim(-0.09, 1.02)
    ax.set_xticks([0.1, 0.3, 0.5, 0.7, 0.9])
    levels = iter((5e1, 4e2))
    for method in asked_of(dataset, "chatter"):
        error, outcome = errors_of(dataset, "chatter", method)
        good = outcome == Outcome.OK
        drawn = np.where(good, np.maximum(error, FLOOR), np.nan)
        ax.plot(R, drawn, **line_of(method, 3.0), lw=0.9)
        if not good.all():
            crosses(ax, R[~good], np.full((~good).sum(), next(levels)), STYLES[method].colour)
    name_line(ax, 0.36, 5e-3, "impact at step's end", "crude", ha="left")
    stuck, _outcome = errors_of(dataset, "chatter", "DOP853")
    early = f"DOP853: stuck, up to {format_number(100 * stuck.max(), 2)} % early"
    name_line(ax, 0.36, 1.2e-4, early, "DOP853", ha="left")
    name_line(ax, 0.3, 6e-8, "Newmark", "newmark", ha="left")
    name_line(ax, 0.3, 1.5e-13, "exact", "exact", ha="left")
    ax.text(-0.07, 1.7e2, "no rest", fontsize=SMALL, va="center")
    ax.set(xlabel="coefficient of restitution $R$", ylabel="relative error of the time of rest")


def draw_step(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the error of one motion over the steps per forcing period."""
    error_axis(ax, has_failed=False)
    ax.set(xscale="log", xlim=(4, 2.5e4))
    power_ticks(ax, "x", (1, 2, 3, 4))
    for method in ("crude", "newmark", "DOP853"):
        one = dataset.sel({"method": method})
        ax.plot(one["step_count"].values, one["step_error"].values, **line_of(method, 2.8), lw=1.0)
    exact = dataset.sel({"method": "exact"})
    ax.plot([4, 2.5e4], [float(exact["step_error"][0])] * 2, color=EXACT, lw=2.0)
    name_line(ax, 2.2e4, 5.0, "impact at step's end: first order", "crude", ha="right")
    name_line(ax, 1.6e2, 2e-6, "Newmark:\nsecond order", "newmark", ha="right")
    name_line(ax, 55, 1e-12, "DOP853", "DOP853", ha="left")
    name_line(ax, 2e4, 4e-14, "exact: no step", "exact", ha="right")
    ax.set(xlabel="steps per forcing period", ylabel="relative error")


Draw = Callable[[Axes, xr.Dataset], None]
PANELS: dict[str, tuple[Draw, str]] = {
    "energy": (draw_energy, "a million impacts: energy of a free motion"),
    "grazing": (draw_grazing, "grazing: velocity of an impact"),
    "chatter": (draw_chatter, "chatter: the time at which it ends"),
    "step": (draw_step, "step: the motion of figure 6 of the paper"),
}
TEXTS = {
    "energy": "Newmark's method: {energy_steps} steps a period, so that each flight is longer than a step",
    "grazing": "free motion from x = 0, its peak a little beyond a support; DOP853 with a tolerance of 10⁻¹², and with "
    "steps of at most 1/{steps} period",
    "chatter": "a mass that its spring presses on a support; DOP853 finds its next impact where the last one was",
    "step": "20 periods; error: the largest of end state, impact times, impact velocities and harmonics; DOP853 at "
    "tolerances of 10⁻³ to 10⁻¹²",
}


def describe_failures(dataset: xr.Dataset) -> str:
    """Return the caption: what each panel shows."""
    names, attrs = questions_in(dataset), dataset.attrs
    letters = "abcd" if len(names) > 1 else ""
    parts = [
        f"{letters[k]}: {TEXTS[name].format(**attrs)}" if letters else TEXTS[name].format(**attrs)
        for k, name in enumerate(names)
    ]
    return sentences(
        f"Impact at the step's end, and Newmark's method with impacts located: {attrs['steps']:,} steps a period, "
        "unless stated. DOP853: scipy's, with an event for each support",
        f"Truth: closed forms, and a solution of 40 digits. Dotted: rounding, {format_number(EPS, 2)}",
        "; ".join(parts),
        "Crosses in grey: failed; a mark at the end of a line: it no longer strikes, or was stopped",
        f"Errors below {format_number(FLOOR, 2)} are drawn there" if is_below(dataset) else "",
    )


def is_below(dataset: xr.Dataset) -> bool:
    """Return whether an error is drawn at the floor since it is smaller."""
    errors = [dataset[f"{name}_error"].values for name in questions_in(dataset) if name != "step"]
    return any(bool((error < FLOOR).any()) for error in errors)


def title_of_failures(dataset: xr.Dataset) -> str:
    """Return what the picture shows, as a sentence, if the exact method has no failure."""
    names = questions_in(dataset)
    outcomes = [dataset[f"{name}_outcome"] for name in names if name != "step"]
    has_failed = [(each != Outcome.OK) & (each != Outcome.NOT_TRIED) for each in outcomes]
    exact = any(bool(each.sel({"method": "exact"}).any()) for each in has_failed)
    if exact or not any(bool(each.any()) for each in has_failed):
        return f"Common methods and the exact one: {series(names)}"
    return "Some common methods miss impacts, or do not end; the exact one does neither"


FAILURES = Picture(
    "failures", draw_failures, describe_failures, has_failures, titled=title_of_failures
)
