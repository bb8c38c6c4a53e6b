"""The picture of a boundary scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise
from typing import Any

import matplotlib.patheffects as effects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from numpy.typing import NDArray

from vibropipe.figures.canvas import axes, legend_above, noted_canvas, open_mark
from vibropipe.figures.map_shapes import frame, label_regions
from vibropipe.figures.palette import EXACT, INK
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import axis_label, parameter_line
from vibropipe.scenes.boundary.keys import BoundaryFigure
from vibropipe.scenes.boundary.text import (
    curves_of,
    describe_boundaries,
    kinds_present,
    label_levels,
    marks,
    of_kinds,
    plane,
    title_boundaries,
)
from vibropipe.scenes.kind import Picture
from vibropipe.scenes.sweep.laws import regions_of
from vibropipe.scenes.sweep.map_layout import Edges, edges_of
from vibropipe.scenes.sweep.maps import draw_regions
from vibropipe.solve.shown_units import shown_factor

LEFT, LOW, WIDTH, HIGH, TOP = 1.3, 1.05, 14.4, 7.6, 0.65  # cm
# Code of cells with a curve; points of a curve between two that are stored.
CROSSED, BETWEEN = -1, 20
MARK_STYLE = open_mark("o", 3.2, zorder=6)
LABELLED = 0.005  # of the map: a smaller region has no words
# Styles of the kinds of boundaries: dashes tell them apart in grey.
CURVES: Mapping[str, Any] = {
    "grazing": "-",
    "fold": (0, (4, 1.5)),
    "flip": (0, (4, 1.2, 1, 1.2)),
    "pitchfork": (0, (1, 1)),
    "level": (0, (9, 1.5)),
}
STABLE_WIDTH, UNSTABLE_WIDTH, HALO_WIDTH = 1.3, 0.5, 1.1
# Colours of regimes under curves are mixed with this share of white.
FADED = 0.45


def draw_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> Figure:
    """Draw boundaries.

    regimes : sweep over the same two parameters, drawn under the curves
    show : kinds of bifurcations whose curves are drawn (default: all)
    """
    whole, dataset = dataset, of_kinds(dataset, show)
    x, y = plane(dataset)
    note = parameter_line(whole)
    figure = noted_canvas(LOW + HIGH + TOP, note, LEFT)
    ax = axes(figure, LEFT, LOW, WIDTH, HIGH)
    of_axes = regimes if regimes is not None else whole
    for name, set_limits in ((x, ax.set_xlim), (y, ax.set_ylim)):
        if ends := ends_of_axis(of_axes[name]):
            set_limits(*ends)
    labels = label_levels(ax, dataset, x, y)
    if regimes is not None:
        draw_regimes(ax, dataset, regimes, labels)
    # Folds may lie a hair beside grazings: what is broken is drawn over what is solid.
    for name, code in kinds_present(dataset).items():
        for points in curves_of(dataset, code):
            draw_curve(ax, dataset, points, name)
    marked = marks(dataset)
    ax.plot(
        dataset[f"meeting_{x}"].values[marked], dataset[f"meeting_{y}"].values[marked],
        **MARK_STYLE, clip_on=False,
    )  # fmt: skip
    ax.set(xlabel=axis_label(dataset[x]), ylabel=axis_label(dataset[y]))
    frame(ax)
    if not dataset.sizes["point"] and regimes is None:
        write_centred(ax, f"No {'such ' * bool(whole.sizes['point'])}curve is found")
    legend_above(figure, curve_handles(dataset), LEFT)
    return figure


def ends_of_axis(array: xr.DataArray) -> tuple[float, float] | None:
    """Return the ends of an axis: of the box in which curves were sought, else of the values, if there are any."""
    if "box" in array.attrs:
        factor = shown_factor(str(array.attrs.get("units", "1")))
        low, high = (factor * float(end) for end in array.attrs["box"])
        return low, high
    return (float(array.min()), float(array.max())) if array.size else None


def draw_curve(ax: Axes, dataset: xr.Dataset, points: np.ndarray, name: str) -> None:
    """Draw one curve, thin where the orbit is unstable."""
    x, y = plane(dataset)
    stable = dataset["stable"].values[points]
    cuts = [0, *(np.flatnonzero(np.diff(stable)) + 1), points.size]
    for start, stop in pairwise(cuts):
        part = points[start : min(stop + 1, points.size)]
        width = STABLE_WIDTH if stable[start] else UNSTABLE_WIDTH
        (line,) = ax.plot(
            dataset[x].values[part], dataset[y].values[part], color=colour_of(name), linestyle=CURVES[name],
            linewidth=width, zorder=3 + (name != "grazing"),
        )  # fmt: skip
        halo = effects.Stroke(linewidth=width + HALO_WIDTH, foreground="white")
        line.set_path_effects([halo, effects.Normal()])


def colour_of(name: str) -> str:
    """Return the colour of a kind of curves."""
    return EXACT if name == "level" else INK


def draw_regimes(
    ax: Axes, dataset: xr.Dataset, regimes: xr.Dataset, labels: Sequence[Text] = ()
) -> None:
    """Draw the cells of a sweep in faded colours of how the mass moves, with its words beside curves and labels."""
    x, y = plane(dataset)
    codes, regions = regions_of(regimes)
    for dim in codes.dims:
        if dim not in (x, y):
            codes = codes.isel({dim: 0})
    part = codes.sortby([x, y]).to_dataset(name="region")
    draw_regions(ax, part, regions, x, y, FADED)
    values, edges = part["region"].transpose(y, x).values, edges_of(part, x, y)
    present = {r.code: [r.words] for r in regions if (values == r.code).mean() >= LABELLED}
    columns, rows = cells_of(dataset, edges)
    values = values.copy()
    values[rows, columns] = CROSSED
    for label in labels:
        corners = ax.transData.inverted().transform(label.get_window_extent().get_points())
        (first, last), (low, high) = (
            np.searchsorted(border, ends) for border, ends in zip(edges, corners.T, strict=True)
        )
        values[max(low - 1, 0) : high, max(first - 1, 0) : last] = CROSSED
    label_regions(ax, values, edges, present)


def cells_of(dataset: xr.Dataset, edges: Edges) -> list[NDArray[np.intp]]:
    """Return the cells of a map, as columns and rows, through which curves go."""
    ids = dataset["curve_id"].values
    steps = np.linspace(0.0, 1.0, BETWEEN, endpoint=False)
    found = []
    for name, borders in zip(plane(dataset), edges, strict=True):
        values = dataset[name].values
        along = values[:-1, None] + steps * np.diff(values)[:, None]
        points = along[np.diff(ids) == 0].ravel()
        found.append(np.clip(np.searchsorted(borders, points) - 1, 0, borders.size - 2))
    return found


def curve_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of the kinds of curves, of thin lines and of the marks."""
    handles = []
    for name in kinds_present(dataset):
        style: dict[str, Any] = {"color": colour_of(name), "linestyle": CURVES[name]}
        handles.append(Line2D([], [], linewidth=STABLE_WIDTH, label=name, **style))
    if (dataset["stable"] == 0).any():
        text = "of an unstable orbit"
        handles.append(Line2D([], [], color=INK, linewidth=UNSTABLE_WIDTH, label=text))
    if marks(dataset).any():
        handles.append(Line2D([], [], **MARK_STYLE, label="curves meet"))
    return handles


def keywords(options: BoundaryFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_boundaries` and `describe_boundaries`."""
    options = options or BoundaryFigure()
    regimes = None if options.map is None else others[options.map]
    return {"regimes": regimes, "show": options.show}


PICTURES = (
    Picture(
        "boundaries",
        draw_boundaries,
        describe_boundaries,
        keywords=keywords,
        titled=title_boundaries,
    ),
)
