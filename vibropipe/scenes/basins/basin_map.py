"""Map of the basins over the starts, with the motions beside it, and of the periods until a start has settled."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import StrMethodFormatter
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from vibropipe.figures.canvas import (
    CM_PER_INCH,
    LETTER,
    SMALL,
    axes,
    colour_bar,
    noted_canvas,
    size_of,
    support_bands,
)
from vibropipe.figures.map_shapes import cell_edges, frame, widest_spot
from vibropipe.figures.palette import FAILED, INK, MAGNITUDES
from vibropipe.figures.text import axis_label, in_brackets, is_forced, parameter_line
from vibropipe.scenes.basins.attractors import (
    attractor_words,
    colours_of,
    letters_of,
    marker_of,
    ordered,
    states_of,
    swept_name,
)
from vibropipe.scenes.basins.text import MAX_BORDER, percent
from vibropipe.solve.rebuild import Motion, motion_of
from vibropipe.words.parameters import PARAMETERS, PHYSICAL

# Forcing periods from which on only powers of ten are labelled.
MANY_PERIODS = 30
MAX_MOTIONS = 4  # that stand beside the map
LEFT, LOW, GAP = 1.25, 1.05, 0.25  # cm: left of the axes, below them, above them
MAP_CM, TALL_CM, TIMES_CM = 9.2, 7.2, 4.2
# Left of the motions, their width, most height of one.
BESIDE, MOTION_CM, SLOT_CM = 11.95, 3.85, 3.1
FLAT_CM = 1.1  # height of a panel with one tick
MARK_CM = 0.4  # from a mark to a letter beside it
LINE_CM, LETTERS, LEAST_PERIODS, MOST_PERIODS = 0.34, 36, 2, 6
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
DISC = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": INK, "linewidth": 0.5}
LETTER_STYLE: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "weight": "bold",
    "fontsize": LETTER,
    "bbox": DISC,
    "zorder": 7,
}
Edges = tuple[NDArray[np.float64], NDArray[np.float64]]


def draw_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the attractor of each start with the motions beside, the periods until it has settled, or both.

    Of attractors without a map of starts, their states at the section take its place.
    """
    show = show or ("attractor",)
    has_map, has_times = "attractor" in show, "periods_to_attractor" in show
    lower = TIMES_CM + LOW if has_map and has_times else 0.0
    tall = TALL_CM if has_map else TALL_CM - 1.5
    figure = noted_canvas(LOW + lower + tall + GAP, parameter_line(dataset), LEFT)
    if "x0" not in dataset.dims:
        draw_states(axes(figure, LEFT, LOW, MAP_CM, TALL_CM), dataset)
        draw_motions(figure, dataset, LOW)
        return figure
    edges = cell_edges(dataset["x0"].values), cell_edges(dataset["v0"].values)
    if has_map:
        ax = axes(figure, LEFT, LOW + lower, MAP_CM, TALL_CM)
        draw_attractor_map(ax, dataset, edges)
        name_axes(ax, dataset, edges)
        draw_motions(figure, dataset, LOW + lower)
    if has_times:
        wide, high = (MAP_CM, TIMES_CM) if has_map else (12.6, tall)
        ax = axes(figure, LEFT, LOW, wide, high)
        draw_periods(figure, ax, dataset, edges, (LEFT + wide + 0.25, LOW, 0.25, high))
        name_axes(ax, dataset, edges)
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


def draw_attractor_map(ax: Axes, dataset: xr.Dataset, edges: Edges, at: int | None = None) -> None:
    """Draw the attractor of each start, with letters and states at the section; `at` a value of the swept parameter."""
    own, letters, n = colours_of(dataset), letters_of(dataset), dataset.sizes["attractor_id"]
    markers = {index: marker_of(dataset, index) for index in range(n)}
    if at is not None:
        dataset = dataset.isel({swept_name(dataset): at})
    attractor = dataset["attractor"].transpose("v0", "x0").values
    colours = ListedColormap([FAILED, *(own[index] for index in range(n))])
    norm = BoundaryNorm(np.arange(n + 2) - 1.5, n + 1)
    ax.pcolormesh(*edges, attractor, cmap=colours, norm=norm, rasterized=True)
    away = distance_to_marks(ax, dataset)
    for index, letter in letters.items():
        spot = widest_spot((attractor == index) & (away > MARK_CM))
        spot = spot or spot_beside_mark(attractor == index, away)
        if spot is not None:
            place = dataset["x0"].values[spot[1]], dataset["v0"].values[spot[0]]
            ax.text(*place, letter, **LETTER_STYLE)
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


def spot_beside_mark(basin: NDArray[np.bool_], away: NDArray[np.float64]) -> tuple[int, int] | None:
    """Return where the letter of a motion stands with a narrow basin: beside a mark, on a start of its own."""
    near = basin & (away > 0.75 * MARK_CM) & (away < 1.5 * MARK_CM)
    share = np.where(near, uniform_filter(basin.astype(float), max(3, basin.shape[0] // 20)), 0.0)
    row, column = np.unravel_index(int(share.argmax()), share.shape)
    return (int(row), int(column)) if share[row, column] > 0.0 else None


def distance_to_marks(ax: Axes, dataset: xr.Dataset) -> NDArray[np.float64]:
    """Return how far (cm) each start (v0, x0) is from the next mark of a state of an orbit."""
    wide, high = size_of(ax)
    x0, v0 = dataset["x0"].values, dataset["v0"].values
    marks = [
        states_of(dataset, index)
        for index in range(dataset.sizes["attractor_id"])
        if marker_of(dataset, index)["marker"] != "."
    ]
    nearest = np.full((v0.size, x0.size), np.inf)
    for x, v in np.concatenate([np.empty((0, 2)), *marks]):
        across, up = (x0 - x) * wide / np.ptp(x0), (v0 - v) * high / np.ptp(v0)
        nearest = np.fmin(nearest, np.hypot(across, up[:, None]))
    return nearest


def draw_motions(figure: Figure, dataset: xr.Dataset, bottom: float) -> None:
    """Draw the displacement of the motions of the largest basins between the supports, one below the other."""
    drawn = [(index, row_motion(dataset, index)) for index in ordered(dataset)[:MAX_MOTIONS]]
    if not drawn:
        return
    periods = periods_of([motion for _, motion in drawn if motion is not None])
    slot = min(SLOT_CM, TALL_CM / len(drawn))
    letters, shares = letters_of(dataset), dataset["basin_share"]
    limits = limits_of([motion for _, motion in drawn if motion is not None])
    words = {
        index: textwrap.wrap(attractor_words(dataset, index), LETTERS)[:2] for index, _ in drawn
    }
    text_cm = 0.3 + LINE_CM * (1 + max(map(len, words.values())))
    for position, (index, motion) in enumerate(drawn):
        low, high = bottom + TALL_CM - (position + 1) * slot, slot - text_cm
        ax = axes(figure, BESIDE, low, MOTION_CM, high)
        if motion is not None:
            ax.plot(*displacement_over(motion, periods), color=INK, linewidth=0.9)
            ax.set(xlim=(0, periods), ylim=limits)
            support_bands(ax, motion.walls[2], motion.walls[1])
        heading = f"{percent(float(shares[index]))} of the starts"
        for line, text in enumerate(reversed([heading, *words[index]])):
            y = 1 + (0.2 + line * LINE_CM) / high
            style: dict[str, Any] = {
                "weight": "bold" if text is heading else "normal",
                "va": "center",
            }
            ax.text(-0.05, y, text, transform=ax.transAxes, fontsize=SMALL, **style)
        top = 1 + (0.2 + LINE_CM * len(words[index])) / high
        ax.text(-0.17, top, letters[index], transform=ax.transAxes, **LETTER_STYLE)
        is_last = position == len(drawn) - 1
        ax.tick_params(labelsize=SMALL, labelbottom=is_last)
        if high > FLAT_CM:
            ax.locator_params(axis="y", nbins=3)
        else:
            ax.set_yticks([0.0])
        ax.locator_params(axis="x", integer=True)
        if is_last:
            ax.set_xlabel(f"time, in {'forcing ' if is_forced(dataset) else ''}periods")
    middle = bottom + TALL_CM - slot * len(drawn) / 2
    place = (BESIDE - 1.28) / 16.0, middle / (figure.get_figheight() * CM_PER_INCH)
    text = in_brackets("displacement", dataset["displacement_strobe"])
    figure.text(*place, text, rotation=90, ha="center", va="center")


def row_motion(dataset: xr.Dataset, index: int) -> Motion | None:
    """Return the motion of an attractor, marched on from its section."""
    row = dataset.sel(attractor_id=index)
    needed = ("displacement_strobe", "velocity_strobe", "base_frequency", "period_multiple")
    names = [name for name in (*PARAMETERS, *PHYSICAL, *needed) if name in row.variables]
    return motion_of(row[names])


def periods_of(motions: Sequence[Motion]) -> int:
    """Return how many forcing periods are drawn: the longest orbit, within limits; all if there is none."""
    longest = max((int(motion.row["period_multiple"]) for motion in motions), default=1)
    has_chaos = any(not motion.is_orbit for motion in motions)
    return min(max(longest, MOST_PERIODS if has_chaos else LEAST_PERIODS), MOST_PERIODS)


def limits_of(motions: Sequence[Motion]) -> tuple[float, float]:
    """Return the limits of the displacement: a little beyond the supports."""
    if not motions:
        return -1.0, 1.0
    ends = [motions[0].walls[support] for support in (2, 1)]
    seen = [motion.curves["displacement"].values for motion in motions]
    low, high = min(ends[0], *map(np.nanmin, seen)), max(ends[1], *map(np.nanmax, seen))
    return float(low - 0.15 * (high - low)), float(high + 0.15 * (high - low))


def displacement_over(motion: Motion, periods: int) -> tuple[np.ndarray, np.ndarray]:
    """Return time in forcing periods and displacement of a motion, with its impacts; an orbit is repeated."""
    plain, period = motion.plain, motion.exciter.period
    wall = np.where(plain["impact_support"].values == 1, motion.walls[1], motion.walls[2])
    hard = ~np.isin(plain["impact_support"].values, motion.soft)
    t = np.concatenate([plain["tau"].values, plain["impact_tau"].values[hard]])
    x = np.concatenate([motion.curves["displacement"].values, wall[hard]])
    order = np.argsort(t, kind="stable")
    t, x = t[order] / period, x[order]
    times = -(-periods * period // motion.length) if motion.is_orbit else 1
    shifts = np.arange(max(int(times), 1)) * motion.length / period
    return (t + shifts[:, None]).ravel(), np.tile(x, shifts.size)


def draw_periods(
    figure: Figure,
    ax: Axes,
    dataset: xr.Dataset,
    edges: Edges,
    bar_at: tuple[float, float, float, float],
) -> None:
    """Draw the forcing periods until each start has settled, on a logarithmic scale."""
    shown = np.maximum(dataset["periods_to_attractor"].transpose("v0", "x0").values, 1)
    norm = LogNorm(int(shown.min()), max(2, int(shown.max())) + int(shown.min() == shown.max()))
    drawn = ax.pcolormesh(*edges, shown, cmap=MAGNITUDES, norm=norm, rasterized=True)
    bar = colour_bar(figure, drawn, *bar_at, title="periods until settled")
    # Whole numbers of periods, not powers of ten with one digit.
    bar.ax.yaxis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    if (norm.vmax or 1.0) < MANY_PERIODS:
        bar.ax.yaxis.set_minor_formatter(StrMethodFormatter("{x:g}"))
