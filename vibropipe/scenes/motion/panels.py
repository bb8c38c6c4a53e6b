"""One motion against time: force, displacement and velocity in panels that share tau.

Figures 4 and 7 (no force), 6 and 9 to 12 of the paper.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from vibropipe.figures.phase_plane import (
    JUMP_LINE,
    impact_style,
    near_walls,
    portrait_handles,
    walls_of,
)
from vibropipe.figures.style import (
    BLACK,
    EXACT_COLOUR,
    GREY,
    NEUTRAL,
    PURPLE,
    REST_COLOUR,
    SMALL_FONT_SIZE,
    SUPPORT_COLOURS,
    legend,
    new_figure,
)
from vibropipe.figures.text import (
    axis_label,
    clock,
    force_amplitude,
    parameter_line,
    times_of,
)
from vibropipe.scenes.motion.curves import (
    Floats,
    curve,
    forcing_period,
    jumps,
    velocities_at_impacts,
)

PANEL_HEIGHT_CM = 3.1
FORCE_HEIGHT_CM = 1.9
WALL_SHARE = 0.13  # of the height of the displacement panel, on each side


def panel_names(dataset: xr.Dataset, show: Collection[str] = ()) -> list[str]:
    """Return the panels among force, displacement, velocity: those of `show`, or all but a force that is zero."""
    absent = () if show or float(dataset[force_amplitude(dataset)]) != 0.0 else ("force",)
    names = ("force", "displacement", "velocity")
    return [name for name in names if name in (show or names) and name not in absent]


def draw_motion(
    dataset: xr.Dataset, show: Collection[str] = (), periods: float | None = None
) -> Figure:
    """Draw one motion over tau.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion with samples, as `vp.simulate` returns it.
    show : collection of str
        Panels among force, displacement, velocity (default: all, without the force if it is zero).
    periods : float, optional
        Number of forcing periods to show, up to the end of the record (default: all).
    """
    view = window(dataset, periods)
    forced = float(dataset[force_amplitude(dataset)]) != 0.0
    names = panel_names(dataset, show)
    heights = [FORCE_HEIGHT_CM if name == "force" else PANEL_HEIGHT_CM for name in names]
    figure = new_figure(sum(heights) + 2.2)
    axes = figure.subplots(len(names), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    panels = dict(zip(names, axes, strict=True))
    for name, ax in panels.items():
        ax.set_ylabel(axis_label(dataset[name]))
        ax.axhline(0.0, color=NEUTRAL, linewidth=0.6, zorder=0)
    if "force" in panels:
        panels["force"].plot(dataset[clock(dataset)], dataset["force"], color=BLACK)
    if "displacement" in panels:
        draw_displacement(panels["displacement"], dataset, view)
        shade_rests(panels["displacement"], dataset, view)
    if "velocity" in panels:
        draw_velocity(panels["velocity"], dataset, view)
        shade_rests(panels["velocity"], dataset, view)
    axes[-1].set_xlabel(axis_label(dataset[clock(dataset)]))
    axes[-1].set_xlim(view)
    figure.align_ylabels(axes)
    figure.suptitle(parameter_line(dataset, leave_out=() if forced else ("nu", "omega")))
    legend(figure, legend_handles(dataset, view), "lower")
    return figure


def window(dataset: xr.Dataset, periods: float | None) -> tuple[float, float]:
    """Return the first and last time to show: all, or the last `periods` forcing periods."""
    time = dataset[clock(dataset)]
    first, last = float(time[0]), float(time[-1])
    if periods is None:
        return first, last
    return max(first, last - periods * forcing_period(dataset)), last


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


def draw_exact(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the exact motion, if the data have it, as a wide pale line under the motion."""
    if f"{name}_exact" not in dataset:
        return
    values = dataset[f"{name}_exact"].values.copy()
    tau = dataset[clock(dataset)].values
    if name == "velocity" and "impact_support" in dataset:
        indices = jumps(tau, values, times_of(dataset, "impact").values)
        tau, values = np.insert(tau, indices, np.nan), np.insert(values, indices, np.nan)
    ax.plot(tau, values, color=EXACT_COLOUR, linewidth=4.0, solid_capstyle="round", zorder=1)


def draw_displacement(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Draw x with the supports, impacts and grazings."""
    draw_exact(ax, dataset, "displacement")
    ax.plot(*curve(dataset, "displacement"), color=BLACK, zorder=2)
    where = walls_of(dataset)
    ends = float(dataset["displacement"].min()), float(dataset["displacement"].max())
    near = near_walls(*ends, where)
    bounds = [*near.values(), *ends]
    margin = WALL_SHARE * (max(bounds) - min(bounds) or 1.0)
    ax.set_ylim(min(bounds) - margin, max(bounds) + margin)
    for support, x in near.items():
        edge = ax.get_ylim()[1 if support == 1 else 0]
        ax.axhspan(*sorted((x, edge)), facecolor=NEUTRAL, alpha=0.55, linewidth=0, zorder=0)
        ax.axhline(x, color=GREY, linewidth=0.8, zorder=1)
        ax.annotate(
            f"support {support}",
            (1.0, x),
            xycoords=("axes fraction", "data"),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=SMALL_FONT_SIZE,
            color=GREY,
        )
    for support, index in events(dataset, "impact", view).items():
        tau = times_of(dataset, "impact").values[index]
        draw_impacts(ax, support, tau, np.full(tau.size, where[support]))
    draw_grazings(ax, dataset, view)


def draw_impacts(ax: Axes, support: int, tau: Floats, values: Floats) -> None:
    """Mark impacts on a support at (tau, values)."""
    ax.plot(tau, values, **impact_style(support, tau.size) | {"zorder": 3})


def draw_grazings(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Mark each grazing by a ring, and label the first one on each support."""
    for support, index in events(dataset, "grazing", view).items():
        tau, x = times_of(dataset, "grazing").values[index], walls_of(dataset)[support]
        ax.plot(tau, np.full(tau.size, x), **GRAZING_STYLE)
        # Beyond the support, where no curve is drawn.
        ax.annotate(
            "grazing",
            (tau[0], x),
            xytext=(9, 3 if support == 1 else -3),
            textcoords="offset points",
            va="bottom" if support == 1 else "top",
            color=PURPLE,
            fontsize=SMALL_FONT_SIZE,
        )


GRAZING_STYLE: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 7.0,
    "markerfacecolor": "none",
    "markeredgecolor": PURPLE,
    "markeredgewidth": 1.2,
    "zorder": 4,
}


def draw_velocity(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Draw x' with a break at each impact; a dotted line joins the velocities before and after."""
    draw_exact(ax, dataset, "velocity")
    ax.plot(*curve(dataset, "velocity"), color=BLACK, zorder=2)
    for support, index in events(dataset, "impact", view).items():
        tau = times_of(dataset, "impact").values[index]
        before, after = (velocity[index] for velocity in velocities_at_impacts(dataset))
        ax.vlines(tau, before, after, color=SUPPORT_COLOURS[support], linestyle=JUMP_LINE, zorder=1)
        draw_impacts(ax, support, tau, before)


def shade_rests(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Shade the rests on a support; a rest without release lasts to the end."""
    if "rest_start" not in dataset:
        return
    for start, end in zip(dataset["rest_start"].values, dataset["rest_end"].values, strict=True):
        if start <= view[1] and end >= view[0]:
            ax.axvspan(
                max(start, view[0]),
                min(end, view[1]),
                color=REST_COLOUR,
                alpha=0.45,
                lw=0,
                zorder=0,
            )


def legend_handles(dataset: xr.Dataset, view: tuple[float, float]) -> list[Line2D | Patch]:
    """Return a legend entry for each kind of mark in the picture."""
    method = str(dataset.attrs.get("method", "")).strip()
    handles: list[Line2D | Patch] = []
    if "displacement_exact" in dataset:
        handles.append(Line2D([], [], color=BLACK, label=method or "motion"))
        handles.append(Line2D([], [], color=EXACT_COLOUR, linewidth=4.0, label="exact solution"))
    handles += portrait_handles({*events(dataset, "impact", view)})
    if events(dataset, "grazing", view):
        handles.append(Line2D([], [], label="grazing (zero velocity)", **GRAZING_STYLE))
    if "rest_start" in dataset and any(
        start <= view[1] and end >= view[0]
        for start, end in zip(dataset["rest_start"].values, dataset["rest_end"].values, strict=True)
    ):
        handles.append(Patch(color=REST_COLOUR, alpha=0.45, linewidth=0, label="rest on a support"))
    if not handles:
        handles.append(Line2D([], [], color=BLACK, label="motion"))
    return handles
