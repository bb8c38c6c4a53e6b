"""Branches along a parameter: stable orbits as solid lines, unstable ones dotted, bifurcations as marks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.style import (
    BLACK,
    BLUE,
    DOTTED,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    SMALL_FONT_SIZE,
    VERMILLION,
    legend,
    new_figure,
)
from vibropipe.figures.text import (
    ORDINALS,
    axis_label,
    flag_texts,
    format_number,
    in_brackets,
    orbit_texts,
    parameter_line,
    parameter_names,
    symbol_of,
    value_text,
)
from vibropipe.words.vocabulary import quantity

PANEL_HEIGHT_CM, MIN_HEIGHT_CM, MARGINS_CM = 4.6, 7.5, 3.2
MARKS = {"fold": "o", "flip": "s", "pitchfork": "D", "grazing": "^", "end": "X", "change": "v"}
# The first ones differ most in lightness; dots are for unstable motions, so that lines cannot be dashed.
COLOURS = (BLACK, BLUE, ORANGE, VERMILLION, SKY, GREEN, PURPLE)
UNSTABLE: dict[str, Any] = {"linestyle": (0, (3, 1.6)), "linewidth": 0.9}
VALUE = "value of a line"
VALUE_STYLE: dict[str, Any] = {
    "fontsize": SMALL_FONT_SIZE, "ha": "center", "va": "center", "zorder": 4,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85},
}  # fmt: skip
# Bifurcations beyond which their marks shrink.
MANY_MARKS = 16
FREE_STYLE: dict[str, Any] = {"color": GREY, "alpha": 0.45, "linewidth": 4, "zorder": 0}
SHORT_TEXT = {
    "impact_velocity_max": "impact velocity",
    "support_force_max": "largest force",
    "support_depth_max": "largest depth",
    "contact_duration_max": "longest contact",
    "impacts_per_period": "impacts per period",
}


class Panel(NamedTuple):
    """A panel: its label, and the values of each line, (points, lines); `backbone` is the line of the free motion."""

    label: str
    values: np.ndarray
    backbone: np.ndarray | None = None


class Piece(NamedTuple):
    """Consecutive points of a branch of one stability and one law of motion."""

    points: slice
    law: str
    is_stable: bool
    value: float


def followed(dataset: xr.Dataset) -> str:
    """Return the parameter along which the branches were followed."""
    return str(dataset.attrs["follow"]).split()[0]


def swept(dataset: xr.Dataset) -> str | None:
    """Return the further parameter with several values, or None."""
    along = followed(dataset)
    names = (name for name in parameter_names(dataset) if dataset[name].dims == ("point",))
    return next((name for name in names if name != along), None)


def panels_of(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> list[Panel]:
    """Return the panels of the quantities to show, of harmonics the first, without supports that are not struck."""
    panels: list[Panel] = []
    for name in show:
        entry, array = quantity(name), dataset[name]
        if name == "impact_velocity":
            text = in_brackets("impact velocity\nof each impact", array)
            panels.append(Panel(text, velocities_of(dataset)))
        elif "harmonic" in entry.dims:
            free = free_values(backbone, name, harmonic=1)
            values = array.sel(harmonic=1).values[:, None]
            text = in_brackets(f"{ORDINALS[0]} harmonic {symbol_of(array, 1)}", array)
            panels.append(Panel(text, values, free))
        elif "support" in entry.dims:
            text = SHORT_TEXT.get(name, entry.long_name)
            for support in dataset["support"].values.tolist():
                values = array.sel(support=support).values[:, None]
                if np.isfinite(values).any():
                    free = free_values(backbone, name, support=support)
                    label = in_brackets(f"{text}\non support {support}", array)
                    panels.append(Panel(label, values, free))
        else:
            free = free_values(backbone, name)
            text = in_brackets(f"{entry.long_name}\n{symbol_of(array)}", array)
            panels.append(Panel(text, array.values[:, None], free))
    return panels


def free_values(backbone: xr.Dataset | None, name: str, **index: int) -> np.ndarray | None:
    """Return a quantity of the free motion over its amplitude; None without a backbone that has it."""
    if backbone is None or name not in backbone:
        return None
    return np.asarray(backbone[name].sel(index).values)


def velocities_of(dataset: xr.Dataset) -> np.ndarray:
    """Return the velocity of each impact of each point, NaN beyond the last: (points, impacts).

    Whichever impact comes first in an orbit, a column follows one impact along a branch while their number is the same.
    """
    sizes, branches = dataset["row_size"].values, dataset["branch_id"].values
    velocities = np.full((sizes.size, max(int(sizes.max(initial=0)), 1)), np.nan)
    velocities[np.arange(velocities.shape[1]) < sizes[:, None]] = np.abs(dataset["impact_velocity"])
    follows = (np.diff(branches, prepend=-1) == 0) & (np.diff(sizes, prepend=-1) == 0)
    for point in np.flatnonzero(follows & (sizes > 0)):
        own, before = velocities[point, : sizes[point]], velocities[point - 1, : sizes[point]]
        expected = before
        if follows[point - 1]:  # tells two lines apart where they cross
            expected = 2.0 * before - velocities[point - 2, : sizes[point]]
        turned = np.stack([np.roll(own, shift) for shift in range(own.size)])
        own[:] = turned[np.abs(turned - expected).sum(axis=1).argmin()]
    return velocities


def pieces_of(dataset: xr.Dataset) -> Iterator[Piece]:
    """Yield the pieces of all branches; each ends at the first point of the next one of its branch."""
    branches, stable = dataset["branch_id"].values, dataset["stable"].values
    laws, over = orbit_texts(dataset, "point"), swept(dataset)
    values = dataset[over].values if over else np.zeros(branches.size)
    keys = list(zip(branches, stable, laws, strict=True))
    cuts = [0, *(n + 1 for n in range(len(keys) - 1) if keys[n] != keys[n + 1]), len(keys)]
    for start, stop in pairwise(cuts):
        joined = stop < len(keys) and branches[stop] == branches[start]
        yield Piece(
            slice(start, stop + joined), laws[start], bool(stable[start]), float(values[start])
        )


def draw_branches(
    dataset: xr.Dataset, show: Sequence[str], backbone: xr.Dataset | None = None
) -> Figure:
    """Draw branches.

    Parameters
    ----------
    dataset : xarray.Dataset
        Data of a branch scene.
    show : sequence of str
        Quantities of the panels.
    backbone : xarray.Dataset, optional
        Backbone over amplitude, drawn under the branches.
    """
    panels, along = panels_of(dataset, show, backbone), followed(dataset)
    figure = new_figure(MARGINS_CM + max(PANEL_HEIGHT_CM * len(panels), MIN_HEIGHT_CM))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    pieces = list(pieces_of(dataset))
    colours = colours_of(dataset, pieces)
    for ax, panel in zip(axes, panels, strict=True):
        if backbone is not None and panel.backbone is not None:
            ax.plot(backbone["eigenfrequency"], panel.backbone, **FREE_STYLE)
        draw_pieces(ax, dataset[along].values, panel.values, pieces, colours, swept(dataset))
        draw_bifurcations(ax, dataset, panel.values)
        if swept(dataset):
            draw_values(ax, dataset[along].values, panel.values, pieces)
        ax.set_ylabel(panel.label)
        ax.margins(x=0.01)
    low, high = float(dataset[along].min()), float(dataset[along].max())
    axes[-1].set_xlim(low, high)
    axes[-1].set_xlabel(axis_label(dataset[along]))
    figure.align_ylabels(axes)
    legend(figure, line_handles(dataset, colours, backbone), "upper", parameter_line(dataset))
    legend(figure, mark_handles(dataset), "lower")
    return figure


def colours_of(dataset: xr.Dataset, pieces: Sequence[Piece]) -> dict[Any, str]:
    """Return a colour for each value of the further parameter or, without one, for each law of motion."""
    over = swept(dataset)
    names = dict.fromkeys(piece.value if over else piece.law for piece in pieces)
    return {name: COLOURS[n % len(COLOURS)] for n, name in enumerate(names)}


def draw_pieces(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    pieces: Sequence[Piece],
    colours: dict[Any, str],
    over: str | None,
) -> None:
    """Draw the pieces, stable ones solid and unstable ones dotted."""
    for piece in pieces:
        style: dict[str, Any] = (
            {"linestyle": "-", "linewidth": 1.5}
            if piece.is_stable
            else {"linestyle": DOTTED, "linewidth": 1.0}
        )
        colour, heights = colours[piece.value if over else piece.law], y[piece.points].copy()
        if len(heights) > 1 and (np.isfinite(heights[-1]) != np.isfinite(heights[-2])).any():
            heights[-1] = np.nan  # of other impacts
        ax.plot(x[piece.points], heights, color=colour, **style)


def draw_values(ax: Axes, x: np.ndarray, y: np.ndarray, pieces: Sequence[Piece]) -> None:
    """Write the value of the further parameter on the widest stable piece of each, to be told apart in grey, too."""
    values = list(dict.fromkeys(piece.value for piece in pieces))
    for position, value in enumerate(values, 1):
        drawn = [
            piece.points
            for piece in pieces
            if piece.value == value and piece.is_stable and np.isfinite(y[piece.points]).any()
        ]
        if not drawn:
            continue
        widest = max(drawn, key=lambda points: np.ptp(x[points]))
        at = x[widest].min() + position / (len(values) + 1) * np.ptp(x[widest])
        index = widest.start + int(np.abs(x[widest] - at).argmin())
        height = y[index][np.isfinite(y[index])]
        if height.size:
            ax.text(x[index], height[0], format_number(value), gid=VALUE, **VALUE_STYLE)


def kinds_present(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Return the mask of each kind of bifurcation that occurs."""
    codes = dataset["bifurcation_kind"].values
    masks = {name: codes == code for code, name in flag_texts("bifurcation_kind").items()}
    return {name: mask for name, mask in masks.items() if mask.any()}


def draw_bifurcations(ax: Axes, dataset: xr.Dataset, y: np.ndarray) -> None:
    """Draw a mark at each bifurcation, on every line."""
    at = dataset[f"bifurcation_{followed(dataset)}"].values
    height = y[dataset["bifurcation_point"].values]
    size = 4.5 if at.size <= MANY_MARKS else 3.0
    for name, mask in kinds_present(dataset).items():
        ax.plot(at[mask], height[mask], **mark_style(name, size), clip_on=False)


def mark_style(name: str, size: float = 4.5) -> dict[str, Any]:
    """Return the style of the mark of a kind of bifurcation."""
    return {
        "linestyle": "none", "marker": MARKS[name], "markersize": size, "markerfacecolor": "white",
        "markeredgecolor": BLACK, "markeredgewidth": 0.7, "zorder": 5,
    }  # fmt: skip


def line_handles(
    dataset: xr.Dataset, colours: dict[Any, str], backbone: xr.Dataset | None
) -> list[Line2D]:
    """Return legend entries of the lines."""
    over = swept(dataset)
    handles = [
        Line2D(
            [], [], color=colour, linewidth=1.5,
            label=value_text(dataset[over], name) if over else f"$(m; p_1, p_2)$ = {name}",
        )
        for name, colour in colours.items()
    ]  # fmt: skip
    if backbone is not None:
        handles.append(Line2D([], [], **FREE_STYLE, label="free motion"))
    return handles


def mark_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of stability and of the bifurcations."""
    stability = [
        Line2D([], [], color=BLACK, linewidth=1.5, label="stable"),
        Line2D([], [], color=BLACK, linewidth=1.0, linestyle=DOTTED, label="unstable"),
    ]
    return stability + [
        Line2D([], [], **mark_style(name), label=name) for name in kinds_present(dataset)
    ]
