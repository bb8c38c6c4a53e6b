"""Pictures of basins: a map of starts, or over a parameter how many starts settle on each motion, and maps at it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox, offset_copy

from vibropipe.figures.canvas import (
    CM_PER_INCH,
    TIGHT_GROUND,
    axes,
    label_region,
    noted_canvas,
    panel,
    raised,
)
from vibropipe.figures.canvas import WIDE as CANVAS
from vibropipe.figures.claims import at_most
from vibropipe.figures.map_shapes import cell_edges, with_margin
from vibropipe.figures.motion_words import number_word, way_of
from vibropipe.figures.palette import FAILED, GREY, HAIRLINE, INK
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import (
    ORDINALS,
    axis_label,
    in_brackets,
    parameter_line,
    symbol_of,
    value_text,
)
from vibropipe.scenes.basins.answers import NOT_FOUND
from vibropipe.scenes.basins.attractors import (
    changes_of,
    colours_of,
    letters_of,
    marker_of,
    ordered,
    swept_name,
)
from vibropipe.scenes.basins.basin_map import draw_attractor_map, draw_basins
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.report import (
    RARE,
    describe_share_maps,
    describe_shares,
    mapped_values,
    title_share_maps,
    title_shares,
)
from vibropipe.scenes.basins.text import describe_basins
from vibropipe.scenes.branch.curves import UNSTABLE
from vibropipe.scenes.branch.lines import pieces_of
from vibropipe.scenes.kind import Picture, showing
from vibropipe.solve.basins.attractors import shares
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

MAX_RARE = 3  # rare motions that a title names


def title_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the title of the map: what the start decides, or which motions few starts settle on."""
    if show and "attractor" not in show:
        return ""
    indices = ordered(dataset)
    shares = [float(dataset["basin_share"][index]) for index in indices]
    if not shares:
        return NOT_FOUND
    if len(shares) == 1:
        whole = shares[0] == 1.0
        return "All starts settle on one motion" if whole else "One motion was found"
    if decided := decided_text(dataset):
        return f"The start decides {decided}"
    if float(dataset["border"].mean()) > 0.5:
        return "Most starts have a neighbour that settles elsewhere"
    rare = [n for n, share in enumerate(shares) if share < RARE]
    if rare and len(rare) <= MAX_RARE:
        letters = series(letters_of(dataset)[indices[n]] for n in rare)
        most, each = at_most(100 * max(shares[n] for n in rare), 1), " on each" * (len(rare) > 1)
        return f"Few starts settle on {letters}, at most {most}\u00a0%{each}"
    return f"The start decides which of {number_word(len(shares))} motions settles"


def decided_text(dataset: xr.Dataset) -> str:
    """Write in what motions differ most: the way of a housing, whether the mass strikes, or repeats itself."""
    if "housing_velocity_mean" in dataset:
        speeds = dataset["housing_velocity_mean"].values, dataset["housing_velocity_max"].values
        if {"along x", "against x"} <= {way_of(*each) for each in zip(*speeds, strict=True)}:
            return "which way the housing progresses"
    regime = dataset["regime"].values
    strikes = dataset["impacts_per_orbit"].sum("support").values > 0
    is_quiet = regime == Regime.NO_IMPACT
    if is_quiet.any() and not is_quiet.all() and (strikes | is_quiet).all():
        return "whether the mass strikes a support"
    is_aperiodic = regime == Regime.APERIODIC
    if is_aperiodic.any() and np.any(regime < Regime.APERIODIC):
        return "whether the motion repeats itself"
    return ""


# Maps beside each other, and their sizes in cm.
COLUMNS = 3
LEFT, LOW, WIDE, HIGH, ACROSS, UP = 1.5, 1.05, 4.4, 3.6, 4.85, 4.3


def draw_share_maps(dataset: xr.Dataset) -> Figure:
    """Draw the attractor of each start at some values of the parameter."""
    name, chosen = str(swept_name(dataset)), mapped_values(dataset)
    rows = -(-len(chosen) // COLUMNS)
    figure = noted_canvas(LOW + rows * UP, parameter_line(dataset), LEFT)
    height, low = float(figure.get_figheight()) * CM_PER_INCH, raised(figure)
    for position, index in enumerate(chosen):
        row, column = divmod(position, COLUMNS)
        ax = axes(figure, LEFT + column * ACROSS, LOW + (rows - 1 - row) * UP, WIDE, HIGH)
        draw_attractor_map(ax, dataset, index)
        ax.set(xlabel="", ylabel="")
        panel(ax, title=value_text(dataset[name].isel({name: index})))
        ax.xaxis.set_major_locator(MaxNLocator(4))
        is_lowest = position + COLUMNS >= len(chosen)
        ax.tick_params(which="both", labelbottom=is_lowest, labelleft=column == 0)
    centre = LEFT + 0.5 * ((min(len(chosen), COLUMNS) - 1) * ACROSS + WIDE)
    middle = LOW + 0.5 * ((rows - 1) * UP + HIGH)
    figure.text(centre / CANVAS, (0.15 + low) / height, axis_label(dataset["x0"]), ha="center")
    figure.text(
        0.1 / CANVAS, (middle + low) / height, axis_label(dataset["v0"]), rotation=90, va="center"
    )
    return figure


# Share of the height that a band needs for its letter.
MIN_HEIGHT = 0.07
HEIGHTS = (0.5, 0.35, 0.65, 0.2, 0.8, 0.5)  # of a letter in its band, as they are tried
MARKS = 6  # of an attractor along its curve
LETTER_GAP, POINTS_PER_INCH = 7.5, 72.0  # pt from a letter to marks and others
NEAR = 0.1  # share of the height at which a letter cannot tell two curves apart
CHANGE_STYLE: dict[str, Any] = {"color": HAIRLINE, "linewidth": 0.6, "zorder": 0.5}


def draw_shares(dataset: xr.Dataset, branches: xr.Dataset | None = None) -> Figure:
    """Draw the shares of basins over a parameter.

    branches : data of a branch scene along the same parameter, drawn under the amplitudes
    """
    name = str(swept_name(dataset))
    figure = noted_canvas(10.2, parameter_line(dataset), 1.4)
    upper = axes(figure, 1.4, 5.8, 14.3, 3.8)
    lower = axes(figure, 1.4, 1.05, 14.3, 4.0, sharex=upper)
    values = dataset[name].values
    lower.set_xlim(with_margin(band_edges(values)))  # before letters look for a place
    if branches is not None:
        draw_branches(upper, branches, name)
    if dataset.sizes["attractor_id"]:
        draw_amplitudes(upper, dataset, name)
    else:
        write_centred(upper, "No motion was found")
    lower.set_ylim(0, 1)
    draw_bands(lower, dataset, name)
    for ax in (upper, lower):
        for change in changes_of(dataset):
            ax.axvline(change.value, **CHANGE_STYLE)
    lower.set(ylabel="share of the starts", xlabel=axis_label(dataset[name]))
    upper.tick_params(which="both", labelbottom=False)
    panel(upper, "a", "amplitude of the motions", indent=-1.2)
    panel(lower, "b", "how many starts settle on each", indent=-1.2)
    return figure


def draw_amplitudes(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the first harmonic of each attractor, solid for orbits and dotted without one."""
    values, colours, letters = dataset[name].values, colours_of(dataset), letters_of(dataset)
    array = dataset["displacement_amplitude"]
    ax.set_ylabel(in_brackets(f"{ORDINALS[0]} harmonic {symbol_of(array, 1)}", array))
    amplitude = array.sel(harmonic=1).transpose(name, "attractor_id")
    known = amplitude.values[np.isfinite(amplitude.values)]
    least, most = known.min(initial=np.inf), known.max(initial=-np.inf)
    has_orbit = dataset["period_multiple"].transpose(name, "attractor_id").values > 0
    beside: list[tuple[str, tuple[float, float], list[tuple[float, float]]]] = []
    for rank, index in enumerate(ordered(dataset)):
        own = amplitude.values[:, index]
        present = np.flatnonzero(np.isfinite(own))
        if present.size == 0:
            continue
        ax.plot(values, np.where(has_orbit[:, index], own, np.nan), color=INK, linewidth=0.9)
        chaotic = present[~has_orbit[present, index]]
        ax.plot(values[chaotic], own[chaotic], ".", color=INK, markersize=1.8)
        # Those of mirrored attractors coincide: their marks lie at different places.
        every = max(1, present.size // MARKS)
        marked = present[(rank * every // 3) % every :: every]
        style = {**marker_of(dataset, index), "markersize": 4.0, "markerfacecolor": colours[index]}
        ax.plot(values[marked], own[marked], zorder=3, clip_on=False, **style)
        middle = present[(present.size * (1 + rank % 3)) // 4]
        others = np.abs(np.delete(amplitude.values, index, axis=1) - own[:, None])
        room = np.fmin.reduce(others, axis=1, initial=np.inf)  # to the nearest other curve
        if room[middle] < NEAR * (most - least):
            middle = present[np.argmax(room[present])]
        at = values[middle], own[middle]
        if marked.size == present.size:  # no place without a mark
            height = (at[1] - least) / (most - least or 1.0)
            is_below = height > 0.9 or (height > 0.1 and rank % 2 == 1)
            inwards = 4.0 * (middle == 0) - 4.0 * (middle == values.size - 1)
            sides = [(inwards, -10.0), (inwards, 9.0)][:: 1 if is_below else -1]
            beside.append((letters[index], at, [*sides, (-9.0, 0.0), (9.0, 0.0)]))
        else:
            label_region(ax, *at, letters[index], weight="bold")
    x, y = np.broadcast_to(values[:, None], amplitude.shape), amplitude.values
    write_beside(ax, np.stack([x[np.isfinite(y)], y[np.isfinite(y)]], axis=1), beside)


def write_beside(
    ax: Axes,
    points: np.ndarray,
    letters: Sequence[tuple[str, tuple[float, float], Sequence[tuple[float, float]]]],
) -> None:
    """Write letters beside their points, on the first side where they keep off all points and each other.

    points : (n, 2) of all curves
    letters : each with its point, and the sides (pt) that are tried
    """
    ax.autoscale_view()
    in_points = POINTS_PER_INCH / ax.figure.dpi
    taken = ax.transData.transform(points) * in_points
    inside = Bbox(ax.get_window_extent().get_points() * in_points).padded(-2.0)
    for letter, at, sides in letters:
        own = ax.transData.transform(at) * in_points
        gaps = [
            np.hypot(*(taken - own - side).T).min() if inside.contains(*(own + side)) else 0.0
            for side in sides
        ]
        side = next((n for n, gap in enumerate(gaps) if gap >= LETTER_GAP), int(np.argmax(gaps)))
        moved = offset_copy(ax.transData, ax.get_figure(root=True), *sides[side], units="points")
        ax.text(*at, letter, transform=moved, weight="bold", ha="center", va="center")
        taken = np.vstack([taken, own + sides[side]])


def draw_branches(ax: Axes, branches: xr.Dataset, name: str) -> None:
    """Draw branches of orbits, stable ones wide and unstable ones dashed."""
    amplitude = branches["displacement_amplitude"].sel(harmonic=1).values
    for piece in pieces_of(branches):
        line: dict[str, Any] = {"linewidth": 3.0, "alpha": 0.4} if piece.is_stable else UNSTABLE
        x, y = branches[name].values[piece.points], amplitude[piece.points]
        ax.plot(x, y, **line, color=GREY, zorder=1)


def draw_bands(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the shares as bands one upon the other, with the 95 % intervals of the lines between them."""
    values, colours, letters = dataset[name].values, colours_of(dataset), letters_of(dataset)
    share = dataset["basin_share"].transpose(name, "attractor_id").fillna(0.0).values
    n_starts = dataset.sizes["x0"] * dataset.sizes["v0"]
    top = np.zeros(values.size)
    edges = band_edges(values)
    for index in ordered(dataset):
        bottom, top = top, top + share[:, index]
        ax.stairs(
            top, edges, baseline=bottom, fill=True, facecolor=colours[index], edgecolor=INK, linewidth=0.4,
        )  # fmt: skip
        counts = np.rint(top * n_starts).astype(int)
        _share, low, high = shares(np.minimum(counts, n_starts), n_starts)
        is_border = (top > 0) & (top < 1) & (share[:, index] > 0)
        ax.vlines(values[is_border], low[is_border], high[is_border], color=INK, linewidth=0.7)
        write_letter(ax, values, bottom, top, letters[index])
    none = (dataset["attractor"] < 0).mean(["x0", "v0"]).values
    ax.stairs(top + none, edges, baseline=top, fill=True, facecolor=FAILED)


def band_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders of the steps of bands: half-way between values, and the first and last values themselves."""
    if values.size == 1:
        return cell_edges(values)
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([values[:1], middle, values[-1:]])


def write_letter(
    ax: Axes, values: np.ndarray, bottom: np.ndarray, top: np.ndarray, letter: str
) -> None:
    """Write the letter of an attractor where its band is high, in the middle of the widest such place.

    Those of narrow bands stand at different heights, so that none covers another.
    """
    high = top - bottom > MIN_HEIGHT
    if not high.any():
        return
    tall = top - bottom >= 0.8 * (top - bottom).max()
    places = np.flatnonzero(high & tall)
    inner = places[(places > 0) & (places < values.size - 1)]
    places = inner if inner.size else places
    at = places[places.size // 2]
    edges = band_edges(values)
    others = [text.get_window_extent() for text in ax.texts]
    middle = 0.5 * (edges[at] + edges[at + 1])
    text = label_region(ax, middle, 0.0, letter, weight="bold", bbox=TIGHT_GROUND)
    for share in HEIGHTS:
        text.set_y(bottom[at] + share * (top - bottom)[at])
        box = text.get_window_extent()
        if not any(box.padded(4.0).overlaps(other) for other in others):
            return


def is_swept(dataset: xr.Dataset) -> bool:
    """Return whether the starts are those at several values of a parameter."""
    return swept_name(dataset) is not None


def branches(options: BasinsFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the data of the scene that `branches` names, as a keyword of the pictures of shares."""
    named = None if options is None or options.branches is None else others[options.branches]
    return {"branches": named}


PICTURES = (
    Picture(
        "basins",
        draw_basins,
        describe_basins,
        lambda dataset: not is_swept(dataset),
        showing,
        title_basins,
    ),
    Picture("shares", draw_shares, describe_shares, is_swept, branches, title_shares),
    Picture(
        "maps",
        draw_share_maps,
        describe_share_maps,
        is_swept,
        titled=title_share_maps,
        heading="Which starts settle on which motion?",
    ),
)
