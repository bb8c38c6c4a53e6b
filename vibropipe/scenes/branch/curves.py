"""Branches along a parameter: stable orbits as solid lines, unstable ones dashed, bifurcations as marks.

What `vp.motor` returns has no branch: the speeds of a motor and its jumps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.canvas import arrow, axes, jump, legend_above, noted_canvas, open_mark, panel
from vibropipe.figures.palette import GREY, INK, REGIME_STYLES, readable, shades
from vibropipe.figures.regime_words import regime_name
from vibropipe.figures.text import axis_label, in_brackets, parameter_line
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.branch.jumps import Jump, arrows_of, jumps_of
from vibropipe.scenes.branch.lines import (
    Panel,
    Piece,
    cascade_of,
    colour_of,
    followed,
    kinds_present,
    panels_of,
    pieces_of,
    swept,
)
from vibropipe.scenes.branch.names import line_names, write_names
from vibropipe.scenes.branch.stretches import coexistence, stretches_of
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import held_name

LEFT, WIDTH, LOW, TOP, BETWEEN = 1.3, 14.4, 1.05, 0.4, 0.75  # cm
PANELS_CM, LEAST_CM, MOST_CM = 9.0, 2.6, 7.2  # of all panels; of one
BAR_CM, BARS_CM = 0.16, 0.75  # a bar of coexistence, and the room above the bars
MARKS = {
    "fold": "o", "flip": "s", "pitchfork": "D", "grazing": "^", "end": "X", "change": "v",
    "Neimark-Sacker bifurcation": "p",
}  # fmt: skip
REACHED: dict[str, Any] = {"linestyle": "-", "linewidth": 2.8, "solid_capstyle": "butt"}
STABLE: dict[str, Any] = {"linestyle": "-", "linewidth": 1.4}
UNSTABLE: dict[str, Any] = {"linestyle": (0, (3, 1.6)), "linewidth": 0.9}
MANY_MARKS = 16  # bifurcations beyond which their marks shrink
TICKS = 0.3  # cm for the ticks of every panel, where one is enlarged
PLAIN_FLIPS = 3  # of a cascade, that the whole range tells apart
UNSTABLE_MULTIPLES = 2  # of the shortest period: unstable orbits of a cascade that are drawn
FREE_STYLE: dict[str, Any] = {"color": GREY, "alpha": 0.45, "linewidth": 4, "zorder": 0}
# Of the speeds of a motor: a panel in cm, marks of a speed and of one that is lost.
HIGH, ABOVE = 3.6, 0.9
SPEED: dict[str, Any] = {
    "marker": "o", "markersize": 6, "linestyle": "none", "markeredgecolor": INK,
}  # fmt: skip
KEPT = {1: ("speed that is kept", INK), 0: ("not kept", "white")}
BAR: dict[str, Any] = {"marker": "|", "markersize": 9, "color": INK, "linestyle": "none"}


def draw_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> Figure:
    """Draw branches.

    show : quantities of the panels
    backbone : backbone over amplitude, drawn under the branches
    Raises ParameterError if the dataset does not tell which orbits are stable.
    """
    if "stable" not in dataset:
        must = (
            "must be a branch with the output stability, since lines show which orbits are stable"
        )
        raise ParameterError("dataset", dataset, must=must, got="")
    panels, along = panels_of(dataset, show, backbone), followed(dataset)
    stretches, pieces = stretches_of(dataset), drawn_pieces(dataset)
    bars, jumps = coexistence(stretches), jumps_of(dataset, stretches)
    limits = float(dataset[along].min()), float(dataset[along].max())
    close = enlarged(dataset)
    shown = [(each, limits) for each in panels] + [(each, close) for each in panels if close]
    number = max(len(shown), 1)
    between = BETWEEN + TICKS * bool(close)
    high = float(np.clip((PANELS_CM - between * (number - 1)) / number, LEAST_CM, MOST_CM))
    base = LOW + (BARS_CM + BAR_CM * len(bars) if bars else 0.0)
    note = parameter_line(dataset)
    figure = noted_canvas(base + number * (high + between) + TOP, note, LEFT)
    colours, drawn, names = colours_of(dataset, pieces), [], line_names(dataset, pieces)
    told = set[str]()
    for position, (each, ends) in enumerate(shown):
        bottom = base + (number - 1 - position) * (high + between)
        ax = axes(figure, LEFT, bottom, WIDTH, high)
        drawn.append(ax)
        others = arrow_lines(jumps, each.values)
        if backbone is not None and each.backbone is not None:
            others.append((backbone["eigenfrequency"].values, each.backbone))
            ax.plot(*others[-1], **FREE_STYLE)
        draw_panel(ax, dataset, each, pieces, jumps, colours)
        ax.set_xlim(*ends)
        draw_bifurcations(ax, dataset, each.values, close if ends is limits else None)
        told |= write_names(
            ax, dataset[along].values, each.values, pieces, names, colours, others, told=told
        )
        title = each.label + (", enlarged" if ends is close else "")
        panel(ax, "abcdefgh"[position % 8] if number > 1 else "", title, indent=-1.1)
        ax.tick_params(labelbottom=bool(close) or (position == number - 1 and not bars))
    if bars:
        drawn.append(draw_bars(figure, bars, colours, limits))
    if drawn:
        drawn[-1].set_xlabel(axis_label(dataset[along]))
    legend_above(figure, handles_of(dataset, backbone), LEFT)
    return figure


def draw_panel(
    ax: Axes,
    dataset: xr.Dataset,
    each: Panel,
    pieces: Sequence[Piece],
    jumps: Sequence[Jump],
    colours: Mapping[Any, str],
) -> None:
    """Draw the lines and jumps of a panel, wide where the mass settles on them from rest."""
    along, reached = dataset[followed(dataset)].values, is_reached(dataset)[:, None]
    settled = [piece for piece in pieces if reached[piece.points].any()]
    draw_pieces(ax, along, each.values, pieces, colours)
    # of a motion from rest whose mirror image has the line of the other support
    wide = np.where(reached, each.values if each.both is None else each.both, np.nan)
    draw_pieces(ax, along, wide, settled, colours, REACHED)
    for to in arrows_of(jumps, each.values):
        jump(ax, to.value, to.start, to.end, colour_of(colours, to.stretch.law, to.stretch.over))
    ax.margins(y=0.08)


def arrow_lines(jumps: Sequence[Jump], values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the lines of the arrows of jumps, from which names keep away."""
    return [(np.full(2, to.value), np.array([to.start, to.end])) for to in arrows_of(jumps, values)]


def enlarged(dataset: xr.Dataset) -> tuple[float, float] | None:
    """Return the range of the later flips of a cascade, which lie close together; None without them."""
    places = cascade_of(dataset)
    if len(places) <= PLAIN_FLIPS:
        return None
    first, last = places[PLAIN_FLIPS - 1], places[-1]
    low, high = sorted((first - 0.15 * (last - first), last + 0.05 * (last - first)))
    values = dataset[followed(dataset)]
    return max(low, float(values.min())), min(high, float(values.max()))


def drawn_pieces(dataset: xr.Dataset) -> list[Piece]:
    """Return the pieces of all branches; of a cascade without unstable orbits of many periods, which lie on others."""
    pieces, multiples = list(pieces_of(dataset)), dataset["period_multiple"].values
    if not enlarged(dataset):
        return pieces
    most = UNSTABLE_MULTIPLES * int(multiples.min())
    return [each for each in pieces if each.is_stable or multiples[each.points.start] <= most]


def stabilities(dataset: xr.Dataset) -> list[str]:
    """Return which of stable and unstable orbits are drawn."""
    found = {piece.is_stable for piece in drawn_pieces(dataset)}
    return [name for name, is_it in (("stable", True), ("unstable", False)) if is_it in found]


def is_reached(dataset: xr.Dataset) -> np.ndarray:
    """Return at which points the mass is known to settle on the orbit from rest."""
    codes = dataset.get("from_rest", np.zeros(dataset.sizes["point"]))
    return np.asarray(codes) == FLAGS["settled_same"]["same"]


def draw_bars(
    figure: Figure,
    bars: Mapping[float, list[tuple[float, float]]],
    colours: Mapping[Any, str],
    limits: tuple[float, float],
) -> Axes:
    """Draw where at least two motions are stable, a row of bars for each value of the further parameter."""
    ax = axes(figure, LEFT, LOW, WIDTH, BAR_CM * len(bars))
    for row, (value, intervals) in enumerate(bars.items()):
        spans = [
            (low, max(high - low, 0.0015 * (limits[1] - limits[0]))) for low, high in intervals
        ]
        ax.broken_barh(spans, (row + 0.1, 0.8), facecolor=colours.get(value, INK), linewidth=0)
    ax.set(ylim=(0, len(bars)), yticks=[], xlim=limits)
    ax.spines["left"].set_visible(False)
    panel(ax, title="where at least two of these motions are stable")
    return ax


def colours_of(dataset: xr.Dataset, pieces: Sequence[Piece]) -> dict[Any, str]:
    """Return a colour for each value of the further parameter, or the colour of its regime for each law."""
    if swept(dataset):
        values = sorted({piece.value for piece in pieces})
        return dict(zip(values, shades(len(values)), strict=True))
    return {piece.law: regime_colour(dataset, piece.points.start) for piece in pieces}


def regime_colour(dataset: xr.Dataset, point: int) -> str:
    """Return the colour of the regime of a point, legible as a line on white."""
    name = regime_name(int(dataset["regime"][point]))
    return INK if name == "no_impact" else readable(REGIME_STYLES[name].colour)


def draw_pieces(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    pieces: Sequence[Piece],
    colours: Mapping[Any, str],
    of_stable: Mapping[str, Any] = STABLE,
) -> None:
    """Draw the pieces, stable ones solid and unstable ones dashed."""
    for piece in pieces:
        style = of_stable if piece.is_stable else UNSTABLE
        colour, heights = colour_of(colours, piece.law, piece.value), y[piece.points].copy()
        if len(heights) > 1 and (np.isfinite(heights[-1]) != np.isfinite(heights[-2])).any():
            heights[-1] = np.nan  # of other impacts
        ax.plot(x[piece.points], heights, color=colour, **style)


def draw_bifurcations(
    ax: Axes, dataset: xr.Dataset, y: np.ndarray, close: tuple[float, float] | None = None
) -> None:
    """Draw a mark at each bifurcation in the range of the axes, on every line, but those enlarged elsewhere."""
    at = dataset[f"bifurcation_{followed(dataset)}"].values
    height = y[dataset["bifurcation_point"].values]
    size = 4.5 if at.size <= MANY_MARKS else 3.0
    low, high = ax.get_xlim()
    is_here = (at >= low) & (at <= high)
    if close:
        is_here &= (at < close[0]) | (at > close[1])
    for name, mask in kinds_present(dataset).items():
        shown = mask & is_here
        ax.plot(at[shown], height[shown], **mark_style(name, size), clip_on=False)


def mark_style(name: str, size: float = 4.5) -> dict[str, Any]:
    """Return the style of the mark of a kind of bifurcation."""
    return open_mark(MARKS[name], size, zorder=5)


def handles_of(dataset: xr.Dataset, backbone: xr.Dataset | None) -> list[Line2D]:
    """Return legend entries of stability, of the bifurcations and of the free motion."""
    styles = {"stable": STABLE, "unstable": UNSTABLE}
    handles = [
        Line2D([], [], color=INK, **styles[name], label=name) for name in stabilities(dataset)
    ]
    if is_reached(dataset).any():
        handles.insert(0, Line2D([], [], color=INK, **REACHED, label="reached from rest"))
    handles += [Line2D([], [], **mark_style(name), label=name) for name in kinds_present(dataset)]
    if backbone is not None:
        handles.append(Line2D([], [], **FREE_STYLE, label="free motion"))
    return handles


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
