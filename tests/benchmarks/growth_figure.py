"""Time per point and memory against the number of points of a study."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.figures.style import GREY, LINE_MARKERS, LINES, NEUTRAL

HEIGHT_CM = 7.0
# Half width of the band around the mean time per point, relative; limit on the memory of a job, in MB.
BAND = 0.1
MAX_MEMORY = 350.0
MEMORIES = {
    "solving_memory": "a job that solves",
    "joining_memory": "the join",
    "query_memory": "a query",
}


def draw_growth(dataset: xr.Dataset) -> Figure:
    """Draw the growth of time and memory that `growth.py` measures, with bands and limit."""
    figure = new_canvas(HEIGHT_CM)
    time, memory = (axes(figure, left, 1.2, 6.2, HEIGHT_CM - 1.5) for left in (1.6, 9.6))
    points = dataset["points"].values
    for index, threads in enumerate(dataset["threads"].values):
        values = dataset["time_per_point"].sel(threads=threads).values
        style = {**LINES[index], "marker": LINE_MARKERS[index]}
        middle = np.exp(np.log(values).mean())
        time.fill_between(points, middle * (1 - BAND), middle * (1 + BAND), color=NEUTRAL, lw=0)
        time.plot(
            points, values, **style, label=f"{threads} thread{'s' if threads > 1 else ''}, solving"
        )
    index = dataset.sizes["threads"]
    style = {**LINES[index], "marker": LINE_MARKERS[index]}
    stored = dataset["storing_per_point"].isel(threads=-1).values
    time.plot(points, stored, **style, label=f"{threads} threads, including writing")
    for index, (name, job) in enumerate(MEMORIES.items()):
        style = {**LINES[index], "marker": LINE_MARKERS[index]}
        memory.plot(points, dataset[name].values, **style, label=job)
    limit = f"limit per job: {MAX_MEMORY:g} MB"
    memory.axhline(MAX_MEMORY, color=GREY, linestyle=(0, (2, 2)), label=limit)
    labels = "time per point by the clock $t/N$ (ms)", "largest memory of a process $M$ (MB)"
    for ax, text in zip((time, memory), labels, strict=True):
        ax.set(xscale="log", yscale="log", xlabel="number of points $N$", ylabel=text)
        ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter(NullFormatter())
        ax.legend(loc="lower left")
    values = dataset["time_per_point"].values
    time.set_ylim(values.min() / 6, values.max() * 3)
    memory.set_ylim(10, 1000)
    return figure
