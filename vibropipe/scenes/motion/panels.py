"""One motion over time, force, displacement and velocity above each other, with its path in the phase plane.

Figures 4 and 7 (no force), 6 and 9 to 12 of the paper.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.canvas import (
    SMALL,
    WHITE_GROUND,
    axes,
    label_region,
    new_canvas,
    panel,
    plain_ticks,
    support_bands,
    zero_line,
)
from vibropipe.figures.palette import INK, REGIME_STYLES, SUPPORT_COLOURS
from vibropipe.figures.phase_plane import (
    JUMP_LINE,
    Impacts,
    draw_jumps,
    impact_style,
    near_walls,
    path,
    walls_of,
)
from vibropipe.figures.style import EXACT_COLOUR, rasterise_many
from vibropipe.figures.text import axis_label, clock, is_forced, times_of
from vibropipe.scenes.motion.curves import curve, forcing_period, jumps, velocities_at_impacts

HEIGHTS = {"force": 1.6, "displacement": 2.8, "velocity": 2.8, "housing_velocity": 2.4}  # cm
LABEL_LETTERS = 18  # of a line of the label of an axis
LEFT, BOTTOM, TOP, GAP = 1.8, 1.1, 0.55, 0.45  # cm
TIME_CM, PLANE_LEFT, PLANE_CM = 8.1, 11.75, 4.05
WALL_SHARE = 0.16  # of the range of displacements, on each side
REST = REGIME_STYLES["with_rest"]
GRAZING_STYLE: dict[str, Any] = {
    "linestyle": "none", "marker": "o", "markersize": 6.5, "markerfacecolor": "none", "markeredgecolor": INK,
    "markeredgewidth": 1.1, "zorder": 4,
}  # fmt: skip
MANY_POINTS = 4000  # of a path, which is then a thin line


def panel_names(dataset: xr.Dataset, show: Collection[str] = ()) -> list[str]:
    """Return the panels: those of `show`, or all but a force that is zero and a housing that is fixed."""
    absent = () if show or is_forced(dataset) else ("force",)
    return [
        name
        for name in HEIGHTS
        if name in (show or HEIGHTS) and name not in absent and name in dataset
    ]


def draw_motion(
    dataset: xr.Dataset, show: Collection[str] = (), periods: float | None = None
) -> Figure:
    """Draw one motion over tau, and in the phase plane.

    dataset : a motion with samples, as `vp.simulate` returns it
    show : panels among force, displacement, velocity, then without the phase plane (default: all, without the force
        if it is zero, with the velocity of a housing that slides)
    periods : number of forcing periods to show, up to the end of the record (default: all)
    """
    view = window(dataset, periods)
    names = panel_names(dataset, show)
    high = sum(HEIGHTS[name] for name in names) + GAP * (len(names) - 1)
    figure = new_canvas(BOTTOM + high + TOP)
    width = 16.0 - LEFT - 0.3 if show else TIME_CM
    limits = limits_of([dataset])
    bottom = BOTTOM + high
    for name in names:
        bottom -= HEIGHTS[name]
        ax = axes(figure, LEFT, bottom, width, HEIGHTS[name])
        ax.set(ylabel=axis_label(dataset[name]), xlim=view)
        if name not in limits:
            zero_line(ax)
            ax.plot(dataset[clock(dataset)], dataset[name], color=INK, linewidth=1.0)
            if name == "housing_velocity":
                ax.set_ylabel(axis_label(dataset[name], width=LABEL_LETTERS))
        else:
            ax.set_ylim(limits[name])
            draw_over_time(ax, dataset, name, view)
        if name != names[-1]:
            ax.tick_params(labelbottom=False)
        bottom -= GAP
    figure.axes[-1].set_xlabel(axis_label(dataset[clock(dataset)]))
    plain_ticks(figure.axes[-1].xaxis, 7)
    figure.align_ylabels(figure.axes)
    panel(figure.axes[0], note="; ".join(marks_in(dataset, view)))
    if not show:
        ax = axes(figure, PLANE_LEFT, BOTTOM, PLANE_CM, high)
        ax.set(xlim=limits["displacement"], ylim=limits["velocity"])
        ax.set(xlabel=axis_label(dataset["displacement"]), ylabel=axis_label(dataset["velocity"]))
        draw_plane(ax, dataset, view)
        panel(ax, note="phase plane")
    return figure


def window(dataset: xr.Dataset, periods: float | None) -> tuple[float, float]:
    """Return the first and last time to show: all, or the last `periods` forcing periods."""
    time = dataset[clock(dataset)]
    first, last = float(time[0]), float(time[-1])
    if periods is None:
        return first, last
    return max(first, last - periods * forcing_period(dataset)), last


def limits_of(datasets: Iterable[xr.Dataset]) -> dict[str, tuple[float, float]]:
    """Return the limits of the axes of displacement, with the supports that are near, and of velocity."""
    places: list[float] = []
    speeds: list[float] = [0.0]
    for dataset in datasets:
        x, v = dataset["displacement"].values, dataset["velocity"].values
        ends = float(np.nanmin(x)), float(np.nanmax(x))
        places += [*ends, *near_walls(*ends, walls_of(dataset)).values()]
        impacts = impacts_of(dataset)
        speeds += [float(np.nanmin(v)), float(np.nanmax(v)), *impacts.before, *impacts.after]
    low, high = min(places), max(places)
    margin = WALL_SHARE * (high - low or 1.0)
    fast = 1.18 * float(np.nanmax(np.abs(speeds)) or 1.0)
    return {"displacement": (low - margin, high + margin), "velocity": (-fast, fast)}


def impacts_of(dataset: xr.Dataset) -> Impacts:
    """Return the impacts of a motion; none if they are not stored."""
    if "impact_support" not in dataset:
        none = np.empty(0)
        return Impacts(none, np.empty(0, np.int8), none, none)
    return Impacts(
        times_of(dataset, "impact").values,
        dataset["impact_support"].values,
        *velocities_at_impacts(dataset),
    )


def events(
    dataset: xr.Dataset, name: str, view: tuple[float, float]
) -> dict[int, NDArray[np.intp]]:
    """Return the indices of the events (`impact` or `grazing`) in view, by support that has any."""
    if f"{name}_support" not in dataset:  # not stored
        return {}
    tau, at = times_of(dataset, name).values, dataset[f"{name}_support"].values
    seen = (tau >= view[0]) & (tau <= view[1])
    indices = {support: np.flatnonzero(seen & (at == support)) for support in (1, 2)}
    return {support: index for support, index in indices.items() if index.size}


def draw_over_time(
    ax: Axes, dataset: xr.Dataset, name: str, view: tuple[float, float], is_labelled: bool = True
) -> None:
    """Draw displacement or velocity, the supports or jumps, impacts, grazings and rests; the axes have their limits.

    Without `is_labelled` the supports have no names, and there is no exact motion under that of another method.
    """
    if is_labelled:
        draw_exact(ax, dataset, name)
    ax.plot(*curve(dataset, name), color=INK, linewidth=1.0, zorder=2)
    shade_rests(ax, dataset, view)
    if name == "displacement":
        draw_supports(ax, dataset, is_labelled)
        draw_grazings(ax, dataset, view)
    else:
        zero_line(ax)
    for support, index in events(dataset, "impact", view).items():
        tau, wall = times_of(dataset, "impact").values[index], walls_of(dataset)[support]
        before, after = (velocity[index] for velocity in velocities_at_impacts(dataset))
        if name == "velocity":
            colour = SUPPORT_COLOURS[support]
            ax.vlines(tau, before, after, color=colour, linestyle=JUMP_LINE, zorder=1)
        height = before if name == "velocity" else np.full(tau.size, wall)
        ax.plot(tau, height, **impact_style(support, tau.size) | {"zorder": 3})


def draw_supports(ax: Axes, dataset: xr.Dataset, is_labelled: bool) -> None:
    """Hatch what is beyond the supports within the limits of the vertical axis, and name them beyond the motion."""
    low, high = ax.get_ylim()
    walls, x = walls_of(dataset), dataset["displacement"].values
    support_bands(ax, max(walls[2], low), min(walls[1], high))
    ends = {1: (np.nanmax(x, initial=walls[1]), high), 2: (np.nanmin(x, initial=walls[2]), low)}
    for support, (end, edge) in ends.items():  # a mass goes on into a soft support
        if is_labelled and low < walls[support] < high:
            middle = (end + edge) / 2
            label_region(
                ax, 0.985, middle, f"support {support}", transform=ax.get_yaxis_transform(), ha="right",
                bbox={**WHITE_GROUND, "boxstyle": "square,pad=0.02"}, zorder=1,
            )  # fmt: skip


def draw_exact(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the exact motion, if the data have it, as a wide pale line under the motion."""
    if f"{name}_exact" not in dataset:
        return
    values = dataset[f"{name}_exact"].values.copy()
    tau = dataset[clock(dataset)].values
    if name == "velocity" and "impact_support" in dataset:
        indices = jumps(tau, values, times_of(dataset, "impact").values)
        tau, values = np.insert(tau, indices, np.nan), np.insert(values, indices, np.nan)
    ax.plot(tau, values, color=EXACT_COLOUR, linewidth=3.5, solid_capstyle="round", zorder=1)


def draw_grazings(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Mark each grazing by a ring, and label the first one on each support, beyond it, where no curve is drawn."""
    for support, index in events(dataset, "grazing", view).items():
        tau, x = times_of(dataset, "grazing").values[index], walls_of(dataset)[support]
        ax.plot(tau, np.full(tau.size, x), **GRAZING_STYLE)
        ax.annotate(
            "grazing", (tau[0], x), xytext=(6, 3 if support == 1 else -3), textcoords="offset points",
            va="bottom" if support == 1 else "top", fontsize=SMALL, zorder=6,
            bbox={**WHITE_GROUND, "boxstyle": "square,pad=0.1"},
        )  # fmt: skip


def draw_plane(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> Impacts:
    """Draw the path of a motion in the phase plane, whose axes have their limits; return the impacts in view."""
    time = dataset[clock(dataset)].values
    kept = (time >= view[0]) & (time <= view[1])
    x, v = dataset["displacement"].values[kept], dataset["velocity"].values[kept]
    walls = walls_of(dataset)
    impacts = impacts_of(dataset).within(time[kept][0], time[kept][-1])
    if "impact_support" in dataset:
        x, v = path(time[kept], x, v, impacts, walls)
    else:
        broken, v = curve(dataset.isel({clock(dataset): np.flatnonzero(kept)}), "velocity")
        x = np.interp(broken, time[kept], x)
    low, high = ax.get_xlim()
    support_bands(ax, max(walls[2], low), min(walls[1], high), "x")
    width = 0.5 if x.size > MANY_POINTS else 1.0
    rasterise_many(ax.plot(x, v, color=INK, linewidth=width, zorder=2), x.size)
    zero_line(ax)
    draw_jumps(ax, impacts, walls)
    return impacts


def rests_in(dataset: xr.Dataset, view: tuple[float, float]) -> list[tuple[float, float]]:
    """Return the rests on a support within a range of times, cut to it; one without release lasts to the end."""
    if "rest_start" not in dataset:
        return []
    rests = zip(dataset["rest_start"].values, dataset["rest_end"].values, strict=True)
    return [
        (max(start, view[0]), min(end, view[1]))
        for start, end in rests
        if start <= view[1] and end >= view[0]
    ]


def shade_rests(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Shade the rests on a support."""
    for start, end in rests_in(dataset, view):
        ax.axvspan(start, end, facecolor=REST.colour, edgecolor=REST.hatch_colour, hatch=REST.hatch,
                   alpha=0.6, linewidth=0, zorder=0)  # fmt: skip


def marks_in(dataset: xr.Dataset, view: tuple[float, float]) -> list[str]:
    """Return what the marks are that not every motion has."""
    texts = ["pale: exact"] if "displacement_exact" in dataset else []
    return texts + (["shaded: rest on a support"] if rests_in(dataset, view) else [])
