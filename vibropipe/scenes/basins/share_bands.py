"""Shares of the starts over a parameter as bands, under the amplitudes of the attractors and of branches of orbits."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vibropipe.figures.map_shapes import cell_edges
from vibropipe.figures.style import (
    BLACK,
    DOTTED,
    GREY,
    LINE_MARKERS,
    REGION_LABEL,
    legend,
    new_figure,
    write_centred,
)
from vibropipe.figures.text import ORDINALS, axis_label, in_brackets, parameter_line, symbol_of
from vibropipe.scenes.basins.basin_map import COLOURS, none_handle
from vibropipe.scenes.basins.laws import changes_of, laws_text, swept_name
from vibropipe.scenes.branch.curves import pieces_of
from vibropipe.solve.attractors import shares

HEIGHT_CM, LEGEND_CM = 13.0, 0.5
# Attractors that the legend lists: those with the largest shares.
MAX_LISTED = 10
# Share of the height and of the values that a band needs for its number.
MIN_HEIGHT = 0.07
# Marks of an attractor along its curve.
MARKS = 6
CHANGE_STYLE: dict[str, Any] = {
    "color": GREY,
    "linewidth": 0.6,
    "linestyle": (0, (4, 2)),
    "zorder": 0.5,
}
BRANCH_STYLE: dict[str, Any] = {"color": GREY, "zorder": 1}


def draw_shares(dataset: xr.Dataset, branches: xr.Dataset | None = None) -> Figure:
    """Draw the shares of basins over a parameter.

    Parameters
    ----------
    dataset : xarray.Dataset
        Data of a basins scene over a parameter.
    branches : xarray.Dataset, optional
        Data of a branch scene along the same parameter, drawn under the amplitudes.
    """
    name = str(swept_name(dataset))
    listed = min(dataset.sizes["attractor_id"], MAX_LISTED)
    figure = new_figure(HEIGHT_CM + LEGEND_CM * listed)
    upper, lower = figure.subplots(2, 1, sharex=True)
    if branches is not None:
        draw_branches(upper, branches, name)
    if listed:
        draw_amplitudes(upper, dataset, name)
    else:
        write_centred(upper, "No attractor was found")
    draw_bands(lower, dataset, name)
    for ax in (upper, lower):
        for change in changes_of(dataset):
            ax.axvline(change.value, **CHANGE_STYLE)
    values = dataset[name].values
    if values.size > 1:
        lower.set_xlim(values[0], values[-1])
    lower.set(ylim=(0, 1), ylabel="share of the starts")
    lower.set_xlabel(axis_label(dataset[name]))
    figure.align_ylabels([upper, lower])
    upper.set_title(parameter_line(dataset))
    legend(figure, handles_of(dataset, branches), "lower")
    return figure


def style_of(index: int) -> dict[str, Any]:
    """Return the marks of an attractor: they differ in grey as well."""
    return {
        "marker": LINE_MARKERS[index % len(LINE_MARKERS)], "markersize": 4.5, "markeredgecolor": BLACK,
        "markeredgewidth": 0.6, "markerfacecolor": COLOURS[index % len(COLOURS)], "color": BLACK,
    }  # fmt: skip


def draw_amplitudes(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the first harmonic of each attractor, solid for orbits and dotted without one."""
    values = dataset[name].values
    array = dataset["displacement_amplitude"]
    ax.set_ylabel(in_brackets(f"{ORDINALS[0]} harmonic {symbol_of(array, 1)}", array))
    amplitude = array.sel(harmonic=1).transpose(name, "attractor_id")
    has_orbit = dataset["period_multiple"].transpose(name, "attractor_id").values > 0
    for index in range(dataset.sizes["attractor_id"]):
        own = amplitude.values[:, index]
        present = np.flatnonzero(np.isfinite(own))
        if present.size == 0:
            continue
        ax.plot(values, np.where(has_orbit[:, index], own, np.nan), color=BLACK, linewidth=0.9)
        chaotic = present[~has_orbit[present, index]]
        ax.plot(values[chaotic], own[chaotic], "k.", markersize=1.8)
        # Those of mirrored attractors coincide: their marks lie at different places.
        every = max(1, present.size // MARKS)
        marked = present[(index * every // 3) % every :: every]
        ax.plot(values[marked], own[marked], linestyle="none", zorder=3, **style_of(index))


def draw_branches(ax: Axes, branches: xr.Dataset, name: str) -> None:
    """Draw branches of orbits, stable ones wide and unstable ones dotted."""
    amplitude = branches["displacement_amplitude"].sel(harmonic=1).values
    for piece in pieces_of(branches):
        line: dict[str, Any] = (
            {"linewidth": 3.0, "alpha": 0.5}
            if piece.is_stable
            else {"linewidth": 1.2, "linestyle": DOTTED}
        )
        ax.plot(
            branches[name].values[piece.points], amplitude[piece.points], **line, **BRANCH_STYLE
        )


def draw_bands(ax: Axes, dataset: xr.Dataset, name: str) -> None:
    """Draw the shares as bands one upon the other, with the 95 % intervals of the lines between them."""
    values = dataset[name].values
    share = dataset["basin_share"].transpose(name, "attractor_id").fillna(0.0).values
    n_starts = dataset.sizes["x0"] * dataset.sizes["v0"]
    top = np.zeros(values.size)
    edges = band_edges(values)
    for index in range(share.shape[1]):
        bottom, top = top, top + share[:, index]
        ax.stairs(
            top, edges, baseline=bottom, fill=True, facecolor=COLOURS[index % len(COLOURS)],
            edgecolor=BLACK, linewidth=0.4,
        )  # fmt: skip
        counts = np.rint(top * n_starts).astype(int)
        _share, low, high = shares(np.minimum(counts, n_starts), n_starts)
        is_border = (top > 0) & (top < 1) & (share[:, index] > 0)
        ax.vlines(values[is_border], low[is_border], high[is_border], color=BLACK, linewidth=0.7)
        write_number(ax, values, bottom, top, index)


def band_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders of the steps of bands: half-way between values, and the first and last values themselves."""
    if values.size == 1:
        return cell_edges(values)
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([values[:1], middle, values[-1:]])


def write_number(
    ax: Axes, values: np.ndarray, bottom: np.ndarray, top: np.ndarray, index: int
) -> None:
    """Write the number of an attractor where its band is high, in the middle of the widest such place."""
    high = top - bottom > MIN_HEIGHT
    if not high.any():
        return
    tall = top - bottom >= 0.8 * (top - bottom).max()
    places = np.flatnonzero(high & tall)
    at = places[places.size // 2]
    ends = {0: "left", values.size - 1: "right"}
    style = {**REGION_LABEL, "ha": ends.get(int(at), "center")}
    ax.text(values[at], 0.5 * (bottom + top)[at], str(index), **style)


def handles_of(
    dataset: xr.Dataset, branches: xr.Dataset | None, shown: np.ndarray | None = None
) -> list[Artist]:
    """Return legend entries: of the attractors (or those of `shown`) the largest, and the lines of branches."""
    mean = dataset["basin_share"].fillna(0.0).mean(str(swept_name(dataset))).values
    own = np.arange(mean.size) if shown is None else shown
    listed = np.sort(own[np.argsort(-mean[own], kind="stable")[:MAX_LISTED]])
    handles: list[Artist] = []
    for index in listed.tolist():
        laws = laws_text(dataset, index).replace("m = ", "$m$ = ")
        style = {**style_of(index), "markersize": 7.0, "linestyle": "none"}
        handles.append(Line2D([], [], label=f"{index}: {laws}", **style))
    if listed.size < own.size:
        text = f"{own.size - listed.size} more with smaller shares"
        handles.append(Patch(facecolor="none", edgecolor="none", label=text))
    if bool((dataset["attractor"] < 0).any()):
        handles.append(none_handle())
    if branches is not None:
        handles.append(Line2D([], [], linewidth=3.0, alpha=0.5, label="stable orbit", color=GREY))
        handles.append(Line2D([], [], linestyle=DOTTED, label="unstable orbit", color=GREY))
    return handles
