"""A sweep over two parameters: map of regimes, and maps of the largest impact velocity on each support."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from vibropipe.figures.style import (
    BLACK,
    NEUTRAL,
    REGIME_STYLES,
    SMALL_FONT_SIZE,
    legend,
    new_figure,
)
from vibropipe.figures.text import REGIME_TEXT, parameter_line, regime_name
from vibropipe.scenes.sweep.curves import stack_columns, swept
from vibropipe.scenes.sweep.strips import cell_edges, regime_patches, scale_of
from vibropipe.words.vocabulary import REGIMES, label, quantity

VELOCITY_COLOURS = "cividis"
HIGHEST_SHARE = (
    0.995  # quantile where the colour bar ends, so that a few large values do not darken the others
)
REGIMES_CM, VELOCITIES_CM, LEGEND_CM = 7.6, 6.0, 1.4
REGION = "region"
LABEL_MARGIN = 0.03  # of the grid that a labelled region must extend around its label


def map_axes(dataset: xr.Dataset) -> tuple[str, str, list[str]]:
    """Return (abscissa, ordinate, further parameters): the two finest grids, in study order."""
    dims = swept(dataset)
    finest = sorted(dims, key=lambda name: -dataset.sizes[name])[:2]
    x, y = (name for name in dims if name in finest)
    return x, y, [name for name in dims if name not in finest]


def draw_regime_map(dataset: xr.Dataset) -> Figure:
    """Draw the map of regimes and, if the data have impacts, velocity maps of both supports.

    Each combination of further swept parameters has its own band of maps.
    """
    x, y, further = map_axes(dataset)
    dataset = dataset.sortby([x, y])
    bands = stack_columns(dataset, further)
    struck = "impact_velocity_max" in dataset
    heights = [REGIMES_CM, VELOCITIES_CM] if struck else [REGIMES_CM]
    figure = new_figure(sum(heights) * len(bands) + LEGEND_CM)
    grid = figure.add_gridspec(len(heights) * len(bands), 2, height_ratios=heights * len(bands))
    norm = velocity_norm(dataset) if struck else None
    for band, (title, part) in enumerate(bands):
        top = band * len(heights)
        ax = figure.add_subplot(grid[top, :])
        scale(ax, part, x, y)
        draw_regimes(ax, part, x, y)
        ax.set(xlabel=label(x), ylabel=label(y))
        ax.set_title(",  ".join(filter(None, [title, parameter_line(dataset)])))
        if norm is not None:
            left = figure.add_subplot(grid[top + 1, 0])
            pair = [left, figure.add_subplot(grid[top + 1, 1], sharey=left)]
            draw_velocities(figure, pair, part, x, y, norm)
    legend(figure, legend_handles(dataset), "lower")
    thin_labels(figure)
    return figure


def thin_labels(figure: Figure) -> None:
    """Remove labels of regions that would overlap; the larger region keeps its label."""
    figure.draw_without_rendering()
    for ax in figure.axes:
        kept: list[Bbox] = []
        for text in [artist for artist in ax.texts if artist.get_gid() == REGION]:
            box = text.get_window_extent().padded(3.0)
            if any(box.overlaps(other) for other in kept):
                text.remove()
            else:
                kept.append(box)


def draw_regimes(ax: Axes, part: xr.Dataset, x: str, y: str) -> None:
    """Draw every cell in the colour of its regime, dots where m > 1, and a label in each large region."""
    regime = part["regime"].transpose(y, x).values
    colours = ListedColormap([REGIME_STYLES[name].colour for name in REGIMES])
    norm = BoundaryNorm(np.arange(len(REGIMES) + 1) - 0.5, len(REGIMES))
    grid = cell_edges(part[x].values), cell_edges(part[y].values)
    ax.pcolormesh(*grid, regime, cmap=colours, norm=norm, rasterized=True)
    multiple = multiples(part).transpose(y, x).values > 1
    at_y, at_x = np.nonzero(multiple)
    ax.plot(
        part[x].values[at_x], part[y].values[at_y], linestyle="none", marker=".", markersize=1.6,
        markeredgewidth=0.0, color=BLACK, rasterized=True,
    )  # fmt: skip
    codes, areas = np.unique(regime, return_counts=True)
    for code in codes[np.argsort(-areas, kind="stable")]:
        spot = widest_spot(regime == code)
        if spot is not None:
            name = regime_name(int(code))
            ax.text(
                part[x].values[spot[1]], part[y].values[spot[0]], REGIME_TEXT[name].replace(", support", ""),
                ha="center", va="center", fontsize=SMALL_FONT_SIZE, gid=REGION,
                bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none",
                      "alpha": 0.85},
            )  # fmt: skip
    frame(ax)


def multiples(part: xr.Dataset) -> xr.DataArray:
    """Return the period multiples, 1 everywhere if the data have none."""
    return part.get("period_multiple", xr.ones_like(part["regime"]))


def widest_spot(mask: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return the cell deepest inside a mask, if deep enough; the border of the map is outside.

    The mask is eroded layer by layer until nothing would remain.
    """
    remaining = mask
    for depth in range(max(mask.shape)):
        eroded = np.zeros_like(remaining)
        eroded[1:-1, 1:-1] = remaining[1:-1, 1:-1]
        eroded[1:-1, 1:-1] &= remaining[:-2, 1:-1] & remaining[2:, 1:-1]
        eroded[1:-1, 1:-1] &= remaining[1:-1, :-2] & remaining[1:-1, 2:]
        if not eroded.any():
            if depth < LABEL_MARGIN * min(mask.shape):
                return None
            rows, columns = np.nonzero(remaining)
            middle = rows.size // 2
            return int(rows[middle]), int(columns[middle])
        remaining = eroded
    return None


def velocity_norm(dataset: xr.Dataset) -> Normalize:
    """Return the colour scale of both supports, from 0 to the HIGHEST_SHARE quantile of impact velocities."""
    struck = dataset["impact_velocity_max"].values
    struck = struck[np.isfinite(struck)]
    highest = float(np.quantile(struck, HIGHEST_SHARE)) if struck.size else 1.0
    return Normalize(0.0, highest or 1.0)


def draw_velocities(
    figure: Figure, pair: list[Axes], part: xr.Dataset, x: str, y: str, norm: Normalize
) -> None:
    """Draw impact_velocity_max of each support on one colour scale, grey where it is not struck."""
    grid = cell_edges(part[x].values), cell_edges(part[y].values)
    for ax, support in zip(pair, part["support"].values, strict=True):
        values = part["impact_velocity_max"].sel(support=support).transpose(y, x).values
        scale(ax, part, x, y)
        ax.set_facecolor(NEUTRAL)
        ax.pcolormesh(
            *grid, np.ma.masked_invalid(values), cmap=VELOCITY_COLOURS, norm=norm, rasterized=True
        )
        ax.set_title(f"support {support}")
        ax.set_xlabel(label(x))
        frame(ax)
    pair[0].set_ylabel(label(y))
    pair[1].tick_params(labelleft=False)
    highest = np.nanmax(part["impact_velocity_max"].values, initial=0.0)
    entry = quantity("impact_velocity_max")
    figure.colorbar(
        ScalarMappable(norm, VELOCITY_COLOURS), ax=pair, aspect=30, pad=0.02,
        extend="max" if highest > (norm.vmax or 0.0) else "neither",
        label=f"{entry.long_name}\n{entry.symbol}",
    )  # fmt: skip


def scale(ax: Axes, part: xr.Dataset, x: str, y: str) -> None:
    """Set the scale of both axes, linear or log as their grids."""
    ax.set_xscale(scale_of(part[x].values))
    ax.set_yscale(scale_of(part[y].values))


def frame(ax: Axes) -> None:
    """Draw all four sides of the frame."""
    for side in ("top", "right"):
        ax.spines[side].set_visible(True)


def legend_handles(dataset: xr.Dataset) -> list[Patch | Line2D]:
    """Return legend entries of the regimes present, of m > 1 and of supports not struck."""
    handles: list[Patch | Line2D] = []
    for patch in regime_patches(dataset):
        patch.set_hatch("")
        handles.append(patch)
    largest = int(multiples(dataset).max())
    if largest > 1:
        handles.append(
            Line2D([], [], linestyle="none", marker=".", markersize=4, color=BLACK,
                   label=f"$m>1$ (up to {largest})")
        )  # fmt: skip
    if "impact_velocity_max" in dataset:
        text = "support not struck"
        handles.append(Patch(facecolor=NEUTRAL, edgecolor=BLACK, linewidth=0.4, label=text))
    return handles
