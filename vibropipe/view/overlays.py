"""Boundaries and branches of the other scenes of a study, drawn over a map or over curves, where they belong to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource, HoverTool
from bokeh.plotting import figure

from vibropipe.figures.text import parameter_names
from vibropipe.scenes.boundary.text import curves_of, kinds_present, shown_levels
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.view.plane import Plane, sign_line, stroke_line
from vibropipe.view.results import is_basins
from vibropipe.view.words import symbol, value_of
from vibropipe.words.bifurcations import Bifurcation

# Dashes and marks of the kinds of bifurcations, which tell them apart in grey.
DASHES = {
    "grazing": "solid", "fold": "dashed", "flip": "dashdot", "pitchfork": "dotted", "level": "solid",
}  # fmt: skip
MARKS = {
    "fold": "circle",
    "flip": "square",
    "pitchfork": "diamond",
    "grazing": "triangle",
    "end": "x",
    "change": "inverted_triangle",
    "neimark_sacker": "star",
}
BOUNDARY_COLOUR, LEVEL_COLOUR = "#CC0066", "#0B2A5B"
# Colour, dashes and width of the pieces of a branch.
STABLE, UNSTABLE = ("#003B5C", "solid", 2.0), ("#D55E00", "dashed", 1.2)
CURVE = ("xs", "ys", "colour", "dash", "width", "text")
SAME = 1e-9  # relative difference of equal parameters


def is_boundary(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has curves of bifurcations over two parameters."""
    return "boundary" in dataset.attrs and "curve_id" in dataset


def is_branch(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has branches of orbits."""
    return "branch_id" in dataset and "bifurcation_kind" in dataset


def belongs(other: xr.Dataset, plane: Plane, axes: tuple[str, ...]) -> bool:
    """Return whether all parameters of a dataset but some axes are those of a plane."""
    for name in parameter_names(other):
        if name in axes:
            continue
        if name not in plane.dataset.variables or other[name].ndim or name in plane.axes:
            return False
        own = plane.dataset[name]
        if own.ndim:
            own = own.isel({name: plane.further.get(name, 0)})
        if not np.isclose(float(own), float(other[name]), rtol=SAME, atol=0.0):
            return False
    return True


def boundaries(datasets: Mapping[str, xr.Dataset], plane: Plane) -> Iterator[dict[str, Any]]:
    """Yield the boundaries over the axes of a map: coordinates, kind and scene of each curve."""
    for scene, data in datasets.items():
        is_over = is_boundary(data) and set(str(data.attrs["boundary"]).split()) == set(plane.axes)
        if not is_over or not belongs(data, plane, plane.axes):
            continue
        for kind, code in kinds_present(data).items():
            for points in curves_of(data, code):
                x, y = (data[name].values[points] for name in plane.axes)
                number = int(data["level_of"].values[points[0]]) if kind == "level" else -1
                words = shown_levels(data)[number].text if number >= 0 else kind
                yield {"x": x, "y": y, "kind": kind, "words": words, "scene": scene}


def branches(
    datasets: Mapping[str, xr.Dataset], plane: Plane, series: Series | None
) -> Iterator[dict[str, Any]]:
    """Yield the branches that lie in a map, or of curves those of a quantity: pieces, stable or not.

    Of branches at several values of a parameter that the plane chooses, those at the chosen value are drawn.
    """
    for scene, data in datasets.items():
        along = plane.axes[0]
        if not is_branch(data):
            continue
        own = data
        for name in plane.further_dims:
            if name in data.variables and data[name].dims == ("point",):
                chosen = float(plane.dataset[name].values[plane.further[name]])
                own = own.isel(point=np.isclose(own[name].values, chosen, rtol=SAME, atol=0.0))
                own = own.assign_coords({name: chosen}).drop_dims("bifurcation")
        if len(plane.axes) == 2:
            values = _on_map(own, plane)
        elif series is None or series.name not in own or along not in own.variables:
            continue
        else:
            values = own[along].values, series.of(own).values
            if own[along].dims != ("point",) or not belongs(own, plane, (along,)):
                continue
        if values is not None:
            yield from _pieces(own, *values, scene)


def _on_map(data: xr.Dataset, plane: Plane) -> tuple[np.ndarray, np.ndarray] | None:
    """Return where the points of branches lie on a map; None if they do not belong to it."""
    if any(name not in data.variables for name in plane.axes):
        return None
    if not belongs(data, plane, plane.axes):
        return None
    n = data.sizes["point"]
    x, y = (np.broadcast_to(data[name].values, (n,)) for name in plane.axes)
    return x, y


def _pieces(data: xr.Dataset, x: np.ndarray, y: np.ndarray, scene: str) -> Iterator[dict[str, Any]]:
    """Yield the runs of points of one branch and one stability."""
    ids, stable = data["branch_id"].values, data["stable"].values != 0
    ends = np.flatnonzero((np.diff(ids) != 0) | (np.diff(stable.astype(int)) != 0)) + 1
    for points in np.split(np.arange(ids.size), ends):
        if points.size:
            # A stable piece goes on to the first point of what follows it on the same branch.
            last = points[-1] + 1
            if last < ids.size and ids[last] == ids[points[0]]:
                points = np.append(points, last)
            yield {
                "x": x[points],
                "y": y[points],
                "stable": bool(stable[points[0]]),
                "scene": scene,
            }


def bifurcations(
    datasets: Mapping[str, xr.Dataset], plane: Plane
) -> Iterator[tuple[float, float, str, str]]:
    """Yield the bifurcations of the branches that lie in a map: place, kind, scene."""
    for scene, data in datasets.items():
        if not is_branch(data) or len(plane.axes) < 2 or (at := _on_map(data, plane)) is None:
            continue
        for point, kind in zip(
            data["bifurcation_point"].values, data["bifurcation_kind"].values, strict=True
        ):
            yield (
                float(at[0][point]),
                float(at[1][point]),
                Bifurcation(int(kind)).name.lower(),
                scene,
            )


class Starts(NamedTuple):
    """A point of a plane at which basins are known: its values, the scene, and the index of the point in that."""

    point: tuple[float, ...]
    scene: str
    at: dict[str, int]


def starts_on(datasets: Mapping[str, xr.Dataset], plane: Plane) -> Iterator[Starts]:
    """Yield the points of a plane at which basins are known."""
    for scene, data in datasets.items():
        if plane.of_starts or not is_basins(data) or not belongs(data, plane, plane.axes):
            continue
        others = [str(name) for name in data["attractor"].dims if name not in ("x0", "v0")]
        if any(name not in plane.axes for name in others):
            continue
        for at in np.ndindex(*(data.sizes[name] for name in others)):
            index = dict(zip(others, at, strict=True))
            one = data.isel(index)
            yield Starts(tuple(float(one[name]) for name in plane.axes), scene, index)


def _starts_lines(plane: Plane, starts: list[Starts]) -> list[str]:
    """Return a line of the legend of curves for each scene of basins: where they are known."""
    axis, lines = plane.dataset[plane.axes[0]], []
    for scene in dict.fromkeys(each.scene for each in starts):
        places = [value_of(axis, each.point[0]) for each in starts if each.scene == scene]
        lines.append(sign_line(f"basins at {symbol(axis)} = {', '.join(places)}: {scene}", "star"))
    return lines


class Overlays:
    """The curves of other scenes on one figure."""

    def __init__(self, plot: figure) -> None:
        self.curves = ColumnDataSource({name: [] for name in CURVE})
        self.marks = ColumnDataSource({"x": [], "y": [], "marker": [], "text": []})
        lines = plot.multi_line(
            "xs",
            "ys",
            source=self.curves,
            line_color="colour",
            line_dash="dash",
            line_width="width",
        )
        points = plot.scatter("x", "y", source=self.marks, marker="marker", size=8, fill_color="white",
                              line_color="black")  # fmt: skip
        plot.add_tools(
            HoverTool(renderers=[lines, points], tooltips="@text", attachment="vertical")
        )
        self.renderers = [lines, points]
        self.lines: list[str] = []

    def show(self, datasets: Mapping[str, xr.Dataset], plane: Plane, series: Series | None) -> None:
        """Show what belongs to a plane; `series` is the quantity of curves."""
        drawn: list[tuple[Any, ...]] = []
        if len(plane.axes) == 2:
            drawn += [
                (
                    each["x"],
                    each["y"],
                    LEVEL_COLOUR if each["kind"] == "level" else BOUNDARY_COLOUR,
                    DASHES[each["kind"]],
                    2.0,
                    f"{each['words']} ({each['scene']})",
                )
                for each in boundaries(datasets, plane)
            ]
        for each in branches(datasets, plane, series):
            colour, dash, width = STABLE if each["stable"] else UNSTABLE
            words = "stable" if each["stable"] else "unstable"
            text = f"{words} branch ({each['scene']})"
            drawn.append((each["x"], each["y"], colour, dash, width, text))
        self.curves.data = {name: [each[n] for each in drawn] for n, name in enumerate(CURVE)}
        self.lines = list(dict.fromkeys(stroke_line(text, *look) for _x, _y, *look, text in drawn))
        marks = [
            (x, y, MARKS[kind], f"{kind} ({scene})")
            for x, y, kind, scene in bifurcations(datasets, plane)
        ]
        starts = list(starts_on(datasets, plane))
        if len(plane.axes) == 2:
            marks += [
                (each.point[0], each.point[1], "star", f"basins: {each.scene}") for each in starts
            ]
        self.lines += dict.fromkeys(sign_line(text, marker) for _x, _y, marker, text in marks)
        if len(plane.axes) == 1:
            self.lines += _starts_lines(plane, starts)
        self.marks.data = {
            name: [each[n] for each in marks] for n, name in enumerate(("x", "y", "marker", "text"))
        }
