"""Boundaries in the plane of two parameters, over the regimes of a sweep."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from typing import Any

import matplotlib.patheffects as effects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vibropipe.figures.style import BLACK, REGIME_STYLES, legend, new_figure, write_centred
from vibropipe.figures.text import REGIME_TEXT, axis_label, parameter_line, regime_name
from vibropipe.solve.shown_units import shown_factor
from vibropipe.words.vocabulary import FLAGS, REGIMES

HEIGHT_CM = 12.0
# Styles of the kinds of boundaries: dashes tell them apart in grey.
CURVES: Mapping[str, Any] = {
    "grazing": "-",
    "fold": (0, (4, 1.5)),
    "flip": (0, (4, 1.2, 1, 1.2)),
    "pitchfork": (0, (1, 1)),
}
STABLE_WIDTH, UNSTABLE_WIDTH, HALO_WIDTH = 1.3, 0.5, 1.1
# Colours of regimes under curves are mixed with this share of white.
FADED = 0.45
# Meetings that are no meeting of bifurcations.
UNMARKED = ("box", "lost", "points")


def plane(dataset: xr.Dataset) -> tuple[str, str]:
    """Return both parameters of boundaries, abscissa first."""
    x, y = str(dataset.attrs["boundary"]).split()
    return x, y


def kinds_present(dataset: xr.Dataset) -> dict[str, int]:
    """Return the integer of each kind of boundary that occurs, in the order of the legend."""
    codes = FLAGS["boundary_kind"]
    return {name: codes[name] for name in CURVES if (dataset["boundary_kind"] == codes[name]).any()}


def curves_of(dataset: xr.Dataset, code: int) -> Iterator[np.ndarray]:
    """Yield the indices of the points of each curve of a kind."""
    ids, kinds = dataset["curve_id"].values, dataset["boundary_kind"].values
    for number in np.unique(ids[kinds == code]):
        yield np.flatnonzero(ids == number)


def of_kinds(dataset: xr.Dataset, show: Collection[str]) -> xr.Dataset:
    """Return the curves of the kinds to show (default: all), with what they meet."""
    if not show:
        return dataset
    codes = [FLAGS["boundary_kind"][name] for name in show]
    is_kept = np.isin(dataset["boundary_kind"].values, codes)
    met = is_kept[dataset["meeting_point"].values]
    return dataset.isel(point=is_kept, meeting=met)


def draw_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> Figure:
    """Draw boundaries.

    Parameters
    ----------
    dataset : xarray.Dataset
        Data of a boundary scene.
    regimes : xarray.Dataset, optional
        Sweep over the same two parameters, drawn under the curves.
    show : collection of str
        Kinds of bifurcations whose curves are drawn (default: all).
    """
    whole, dataset = dataset, of_kinds(dataset, show)
    x, y = plane(dataset)
    figure = new_figure(HEIGHT_CM)
    ax = figure.add_subplot()
    present = draw_regimes(ax, regimes, x, y) if regimes is not None else []
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
    if not dataset.sizes["point"] and regimes is None:
        write_centred(ax, "No curve is found")
    of_axes = regimes if regimes is not None else whole
    for name, set_limits in ((x, ax.set_xlim), (y, ax.set_ylim)):
        if ends := ends_of_axis(of_axes[name]):
            set_limits(*ends)
    legend(figure, curve_handles(dataset), "upper", parameter_line(dataset))
    legend(figure, [regime_patch(name) for name in present], "lower")
    return figure


def ends_of_axis(array: xr.DataArray) -> tuple[float, float] | None:
    """Return the ends of an axis: of the box in which curves were sought, else of the values, if there are any."""
    if "box" in array.attrs:
        low, high = box_of(array)
        return low, high
    return (float(array.min()), float(array.max())) if array.size else None


def box_of(array: xr.DataArray) -> tuple[float, float]:
    """Return the ends of a parameter in which curves were sought, in the units shown."""
    factor = shown_factor(str(array.attrs.get("units", "1")))
    low, high = (factor * float(end) for end in array.attrs["box"])
    return low, high


MARK_STYLE: Mapping[str, Any] = {
    "linestyle": "none", "marker": "o", "markersize": 3.2, "markerfacecolor": "white",
    "markeredgecolor": BLACK, "markeredgewidth": 0.7, "zorder": 6,
}  # fmt: skip


def draw_curve(ax: Axes, dataset: xr.Dataset, points: np.ndarray, name: str) -> None:
    """Draw one curve, thin where the orbit is unstable."""
    x, y = plane(dataset)
    stable = dataset["stable"].values[points]
    cuts = [0, *(np.flatnonzero(np.diff(stable)) + 1), points.size]
    for start, stop in pairwise(cuts):
        part = points[start : min(stop + 1, points.size)]
        width = STABLE_WIDTH if stable[start] else UNSTABLE_WIDTH
        (line,) = ax.plot(
            dataset[x].values[part], dataset[y].values[part], color=BLACK, linestyle=CURVES[name],
            linewidth=width, zorder=3 + (name != "grazing"),
        )  # fmt: skip
        halo = effects.Stroke(linewidth=width + HALO_WIDTH, foreground="white")
        line.set_path_effects([halo, effects.Normal()])


def faded(name: str) -> tuple[float, float, float]:
    """Return the colour of a regime mixed with white."""
    red, green, blue = to_rgb(REGIME_STYLES[name].colour)
    share = 1.0 - FADED
    return FADED + share * red, FADED + share * green, FADED + share * blue


def draw_regimes(ax: Axes, regimes: xr.Dataset, x: str, y: str) -> list[str]:
    """Draw the cells of a sweep in faded colours of their regimes; return the regimes that occur."""
    for dim in regimes["regime"].dims:
        if dim not in (x, y):
            regimes = regimes.isel({dim: 0})
    ordered = regimes.sortby([x, y])
    codes = ordered["regime"].transpose(y, x).values
    colours = ListedColormap([faded(name) for name in REGIMES])
    ax.pcolormesh(
        ordered[x].values, ordered[y].values, codes, cmap=colours, shading="nearest",
        norm=BoundaryNorm(np.arange(len(REGIMES) + 1) - 0.5, len(REGIMES)), rasterized=True,
    )  # fmt: skip
    return [regime_name(int(code)) for code in np.unique(codes)]


def marks(dataset: xr.Dataset) -> np.ndarray:
    """Return the mask of the meetings that are marked."""
    unmarked = [FLAGS["meeting_kind"][name] for name in UNMARKED]
    return ~np.isin(dataset["meeting_kind"].values, unmarked)


def regime_patch(name: str) -> Patch:
    """Return the legend entry of a regime."""
    return Patch(facecolor=faded(name), edgecolor=BLACK, linewidth=0.3, label=REGIME_TEXT[name])


def curve_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of the kinds of curves, of thin lines and of the marks."""
    handles = [
        Line2D([], [], color=BLACK, linestyle=CURVES[name], linewidth=STABLE_WIDTH, label=name)
        for name in kinds_present(dataset)
    ]
    if (dataset["stable"] == 0).any():
        handles.append(
            Line2D([], [], color=BLACK, linewidth=UNSTABLE_WIDTH, label="of an unstable orbit")
        )
    if marks(dataset).any():
        handles.append(Line2D([], [], **MARK_STYLE, label="curves meet"))
    return handles
