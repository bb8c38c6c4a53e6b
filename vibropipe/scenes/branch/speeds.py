"""Picture of what `vp.motor` returns: the speeds of a motor and its jumps, without the branch on which they lie."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.canvas import arrow, axes, legend_above, noted_canvas, panel
from vibropipe.figures.palette import INK
from vibropipe.figures.text import axis_label, in_brackets, parameter_line
from vibropipe.scenes.branch.curves import LEFT, LOW, TOP, WIDTH
from vibropipe.words.vocabulary import held_name

HIGH, ABOVE = 3.6, 0.9  # cm
SPEED: dict[str, Any] = {
    "marker": "o",
    "markersize": 6,
    "linestyle": "none",
    "markeredgecolor": INK,
}
KEPT = {1: ("speed that is kept", INK), 0: ("not kept", "white")}
BAR: dict[str, Any] = {"marker": "|", "markersize": 9, "color": INK, "linestyle": "none"}


def draw_speeds(dataset: xr.Dataset) -> Figure:
    """Draw the torque at each speed where motor and load have the same, and the torque added at each jump."""
    note, speeds = parameter_line(dataset), dataset[held_name(dataset, "nu")]
    has_jumps = bool(dataset.sizes["jump"])
    figure = noted_canvas(LOW + HIGH + ABOVE + TOP + has_jumps * (HIGH + ABOVE), note, LEFT)
    top = axes(figure, LEFT, LOW + has_jumps * (HIGH + ABOVE), WIDTH, HIGH)
    is_kept, handles = dataset["speed_is_stable"].values, []
    for kept, (text, colour) in KEPT.items():
        own = is_kept == kept
        if own.any():
            torques = dataset["motor_torque"].values[own]
            top.plot(speeds.values[own], torques, markerfacecolor=colour, **SPEED)
            handles.append(Line2D([], [], markerfacecolor=colour, label=text, **SPEED))
    title = in_brackets("torque of load and motor", dataset["motor_torque"])
    panel(top, "a" if has_jumps else "", title, indent=-1.1)
    last = top
    if has_jumps:
        last = axes(figure, LEFT, LOW, WIDTH, HIGH, sharex=top)
        lost, reached = (dataset[f"jump_{way}{speeds.name}"].values for way in ("", "to_"))
        added = dataset["jump_torque"].values
        last.plot(lost, added, **BAR)
        last.plot(reached, added, linestyle="none")  # the axes hold the ends of the arrows
        for n in np.flatnonzero(np.isfinite(reached)):
            arrow(
                last, (lost[n], added[n]), (reached[n], added[n]), linestyle=(0, (2, 1.2)), lw=0.8
            )
        panel(last, "b", in_brackets("torque added at a jump", dataset["jump_torque"]), indent=-1.1)
        handles.append(Line2D([], [], label="speed that is lost", **BAR))
        top.tick_params(labelbottom=False)
    for ax in {top, last}:
        ax.margins(0.08, 0.15)
    last.set_xlabel(axis_label(speeds))
    legend_above(figure, handles, LEFT)
    return figure
