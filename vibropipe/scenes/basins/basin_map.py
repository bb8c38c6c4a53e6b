"""Map of the basins over the starts, with the motions beside it, and of the periods until a start has settled."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import StrMethodFormatter
from numpy.typing import NDArray

from vibropipe.figures.canvas import axes, colour_bar, noted_canvas, panel, size_of
from vibropipe.figures.map_shapes import LEADER, frame, widest_spot
from vibropipe.figures.palette import FAILED, INK, MAGNITUDES
from vibropipe.figures.text import axis_label, is_forced, parameter_line
from vibropipe.scenes.basins.attractors import (
    colours_of,
    letters_of,
    marker_of,
    states_of,
    swept_name,
)
from vibropipe.scenes.basins.motions_beside import (
    ACROSS_CM,
    LEFT,
    LETTER_STYLE,
    LINE_CM,
    TALL_CM,
    draw_motions,
)
from vibropipe.scenes.basins.text import MAX_BORDER
from vibropipe.scenes.sweep.map_layout import Edges, edges_of

# Forcing periods from which on only powers of ten are labelled.
MANY_PERIODS = 30
LOW, GAP = 1.05, 0.25  # cm below axes, above them
MAP_CM, TITLE_CM = 9.2, 0.7
MARK_CM, DISC_CM = 0.45, 0.3  # from a mark to the middle of a letter, and the size of its disc
PAIR_CM = 6.3  # width of each of two maps beside each other
STABLE_SET: dict[str, Any] = {"color": INK, "linewidth": 0.35}
CROSSES: dict[str, Any] = {
    "linestyle": "none",
    "marker": "x",
    "markersize": 5.0,
    "markeredgewidth": 1.1,
    "color": FAILED,
    "zorder": 5,
    "path_effects": [withStroke(linewidth=2.4, foreground="white")],
}
Floats = NDArray[np.float64]


def draw_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the attractor of each start with the motions beside, the periods until it has settled, or both.

    Of attractors without a map of starts, their states at the section take its place.
    """
    show = show or ("attractor",)
    has_map, has_times = "attractor" in show, "periods_to_attractor" in show
    if has_map and has_times and "x0" in dataset.dims:
        return draw_pair(dataset)
    tall = TALL_CM if has_map else TALL_CM - 1.5
    figure = noted_canvas(LOW + tall + GAP, parameter_line(dataset), LEFT)
    if "x0" not in dataset.dims:
        draw_states(axes(figure, LEFT, LOW, MAP_CM, TALL_CM), dataset)
        draw_motions(figure, dataset, LOW)
    elif has_map:
        draw_attractor_map(axes(figure, LEFT, LOW, MAP_CM, TALL_CM), dataset)
        draw_motions(figure, dataset, LOW)
    else:
        draw_periods(
            figure, axes(figure, LEFT, LOW, 12.6, tall), dataset, (LEFT + 12.85, LOW, 0.25, tall)
        )
    return figure


def draw_pair(dataset: xr.Dataset) -> Figure:
    """Draw the attractor of each start and the periods until it has settled beside each other, the motions below."""
    low = LOW + ACROSS_CM + 0.3 + 3 * LINE_CM + LOW if dataset.sizes["attractor_id"] else LOW
    figure = noted_canvas(low + TALL_CM + TITLE_CM, parameter_line(dataset), LEFT)
    ax = axes(figure, LEFT, low, PAIR_CM, TALL_CM)
    draw_attractor_map(ax, dataset)
    panel(ax, "a", "the motion on which a start settles")
    left = LEFT + PAIR_CM + 0.75
    beside = axes(figure, left, low, PAIR_CM, TALL_CM)
    draw_periods(figure, beside, dataset, (left + PAIR_CM + 0.2, low, 0.25, TALL_CM), titled=False)
    panel(beside, "b", f"{'forcing ' * is_forced(dataset)}periods until it has settled")
    beside.set_ylabel("")
    beside.tick_params(labelleft=False)
    draw_motions(figure, dataset, LOW, across=True)
    return figure


def name_axes(ax: Axes, dataset: xr.Dataset, edges: Edges) -> None:
    """Set limits and labels of a map of starts."""
    ax.set(xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    ax.set(xlabel=axis_label(dataset["x0"]), ylabel=axis_label(dataset["v0"]))
    frame(ax)


def draw_states(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the states of attractors at the section with their letters."""
    for index, letter in letters_of(dataset).items():
        states = states_of(dataset, index)
        ax.plot(*states.T, **marker_of(dataset, index), zorder=4)
        ax.annotate(letter, states[0], (11, 11), textcoords="offset points", **LETTER_STYLE)
    ax.margins(0.15)
    ax.set(xlabel=axis_label(dataset["poincare_displacement"]))
    ax.set(ylabel=axis_label(dataset["poincare_velocity"]))


def draw_attractor_map(ax: Axes, dataset: xr.Dataset, at: int | None = None) -> None:
    """Draw the attractor of each start, with letters and states at the section; `at` a value of the swept parameter."""
    own, letters, n = colours_of(dataset), letters_of(dataset), dataset.sizes["attractor_id"]
    markers = {index: marker_of(dataset, index) for index in range(n)}
    if at is not None:
        dataset = dataset.isel({swept_name(dataset): at})
    attractor = dataset["attractor"].transpose("v0", "x0").values
    colours = ListedColormap([FAILED, *(own[index] for index in range(n))])
    norm = BoundaryNorm(np.arange(n + 2) - 1.5, n + 1)
    edges = edges_of(dataset, "x0", "v0")
    ax.pcolormesh(*edges, attractor, cmap=colours, norm=norm, rasterized=True)
    name_axes(ax, dataset, edges)
    write_letters(ax, dataset, letters)
    if float(dataset["start_phase"]) != 0.0:
        return
    if float(dataset["border"].mean()) <= MAX_BORDER and dataset.sizes.get("stable_set_point"):
        curves = (dataset[f"stable_set_{name}"] for name in ("displacement", "velocity"))
        ax.plot(*curves, **STABLE_SET)
    if "border_orbit" in dataset.dims:
        points = [dataset[f"border_point_{name}"].values for name in ("displacement", "velocity")]
        ax.plot(*points, **CROSSES)
    for index, style in markers.items():
        ax.plot(*states_of(dataset, index).T, **style, zorder=4 if style["marker"] == "." else 6)


def write_letters(ax: Axes, dataset: xr.Dataset, letters: Mapping[int, str]) -> None:
    """Write the letter of each motion in its basin, or where this is narrow beside a mark, with a line to it.

    Letters keep off marks, the frame and each other.
    """
    attractor = dataset["attractor"].transpose("v0", "x0").values
    starts = dataset["x0"].values, dataset["v0"].values
    off_centre = (np.abs(values - values.mean()) for values in starts)
    x_gap, v_gap = (
        size * (0.5 - gap / span)
        for gap, span, size in zip(off_centre, spans_of(ax), size_of(ax), strict=True)
    )
    away = np.minimum(x_gap, v_gap[:, None]) + MARK_CM - DISC_CM
    for x, v in marks_of(dataset):
        away = np.fmin(away, distance_to(ax, starts, x, v))
    for index, letter in letters.items():
        spot, end = widest_spot((attractor == index) & (away > MARK_CM)), None
        if spot is None:
            spot, end = spot_beside_mark(ax, dataset, index, away)
        if spot is None:
            continue
        place = starts[0][spot[1]], starts[1][spot[0]]
        if end is not None:
            ax.plot(*zip(end, place, strict=True), **LEADER)
        ax.text(*place, letter, **LETTER_STYLE)
        away = np.fmin(away, distance_to(ax, starts, *place) - DISC_CM)


def spot_beside_mark(
    ax: Axes, dataset: xr.Dataset, index: int, away: Floats
) -> tuple[tuple[int, int] | None, Floats | None]:
    """Return where the letter of a motion with a narrow basin stands: beside one of its marks, and this mark.

    Without a mark on the map it stands beside a start of its own.
    """
    starts = dataset["x0"].values, dataset["v0"].values
    own = np.argwhere(dataset["attractor"].transpose("v0", "x0").values == index)
    ends = states_of(dataset, index) if float(dataset["start_phase"]) == 0.0 else np.empty((0, 2))
    inside = [
        end
        for end in ends
        if all(a.min() <= c <= a.max() for a, c in zip(starts, end, strict=True))
    ]
    if not inside and len(own):
        row, column = own[len(own) // 2]
        inside = [(starts[0][column], starts[1][row])]
    found = [
        (np.where(away > MARK_CM, distance_to(ax, starts, *end), np.inf), end) for end in inside
    ]
    if not found or not np.isfinite(min(gap.min() for gap, _ in found)):
        return None, None
    gap, end = min(found, key=lambda pair: float(pair[0].min()))
    row, column = np.unravel_index(int(gap.argmin()), gap.shape)
    return (int(row), int(column)), np.array(end)


def marks_of(dataset: xr.Dataset) -> list[Floats]:
    """Return the states of orbits that are marked on a map, and the points of unstable ones on the borders."""
    if float(dataset["start_phase"]) != 0.0:
        return []
    marks = [
        states_of(dataset, index)
        for index in range(dataset.sizes["attractor_id"])
        if marker_of(dataset, index)["marker"] != "."
    ]
    if "border_orbit" in dataset.dims:
        points = [dataset[f"border_point_{name}"].values for name in ("displacement", "velocity")]
        crosses = np.stack([each.ravel() for each in points], axis=1)
        marks.append(crosses[np.isfinite(crosses).all(axis=1)])
    return [point for each in marks for point in each]


def distance_to(ax: Axes, starts: tuple[Floats, Floats], x: float, v: float) -> Floats:
    """Return how far (cm) each start (v0, x0) is from a point."""
    (x0, v0), (wide, high), (span_x, span_v) = starts, size_of(ax), spans_of(ax)
    return np.hypot((x0 - x) * wide / span_x, ((v0 - v) * high / span_v)[:, None])


def spans_of(ax: Axes) -> tuple[float, float]:
    """Return the lengths of both axes in data, above zero for one row of starts, too."""
    return float(np.ptp(ax.get_xlim())), float(np.ptp(ax.get_ylim()))


def draw_periods(
    figure: Figure,
    ax: Axes,
    dataset: xr.Dataset,
    bar_at: tuple[float, float, float, float],
    titled: bool = True,
) -> None:
    """Draw the forcing periods until each start has settled, on a logarithmic scale."""
    shown = np.maximum(dataset["periods_to_attractor"].transpose("v0", "x0").values, 1)
    norm = LogNorm(int(shown.min()), max(2, int(shown.max())) + int(shown.min() == shown.max()))
    edges = edges_of(dataset, "x0", "v0")
    drawn = ax.pcolormesh(*edges, shown, cmap=MAGNITUDES, norm=norm, rasterized=True)
    name_axes(ax, dataset, edges)
    bar = colour_bar(figure, drawn, *bar_at, title="periods until settled" if titled else "")
    # Whole numbers of periods, not powers of ten with one digit.
    bar.ax.yaxis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    if (norm.vmax or 1.0) < MANY_PERIODS:
        bar.ax.yaxis.set_minor_formatter(StrMethodFormatter("{x:g}"))
