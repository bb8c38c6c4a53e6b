"""A sweep over two parameters: the map of how the mass moves, its regions labelled where they are.

Each combination of further swept parameters has its own map, as small multiples that share a legend.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibropipe.figures.canvas import LEGEND_LINE, legend_below
from vibropipe.figures.map_shapes import label_regions
from vibropipe.figures.palette import INK
from vibropipe.scenes.sweep.map_layout import (
    by_combination,
    draw_hatch,
    edges_of,
    map_axes,
    map_panel,
    outline,
    places,
    write_titles,
)
from vibropipe.scenes.sweep.quantities import wrapped
from vibropipe.scenes.sweep.regions import Region, regions_of

HERO_CM, TWO_CM, SMALL_CM = 7.6, 5.6, 3.6
LABELLED = 0.003  # of the points: a smaller region has no label
MAX_MAPS = 12
LETTERS = 16  # of a line of a narrow label
LEGEND_COLUMNS = 3


def draw_regime_map(dataset: xr.Dataset) -> Figure:
    """Draw the map of how the mass moves over the two finest grids; further parameters have maps of their own."""
    x, y, _ = map_axes(dataset)
    dataset = dataset.sortby([x, y])
    codes, regions = regions_of(dataset)
    dataset = dataset[["regime"]].assign(region=codes)
    parts = list(by_combination(dataset, MAX_MAPS))
    if len(parts) == 1:
        figure, (place,) = places(1, 1, HERO_CM, lines=0)
        ax = map_panel(figure, place, parts[0][1], x, y)
        draw_regions(ax, parts[0][1], regions, x, y)
        texts = {r.code: label_texts(r) for r in regions if r.amount >= LABELLED * r.total}
        values = parts[0][1]["region"].transpose(y, x).values
        label_regions(ax, values, edges_of(parts[0][1], x, y), texts)
        return figure
    across = 2 if len(parts) in (2, 4) else 3
    rows = -(-len(regions) // LEGEND_COLUMNS)
    height = TWO_CM if across == 2 else SMALL_CM
    figure, found = places(len(parts), across, height, below=rows * LEGEND_LINE + 0.2)
    for place, (title, part) in zip(found, parts, strict=True):
        ax = map_panel(figure, place, part, x, y)
        draw_regions(ax, part, regions, x, y)
        write_titles(ax, title)
    legend_below(figure, region_patches(regions), LEGEND_COLUMNS, 1.2)
    return figure


def draw_regions(ax: Axes, part: xr.Dataset, regions: list[Region], x: str, y: str) -> None:
    """Draw every cell in the colour and hatch of its region, and outlines."""
    values = part["region"].transpose(y, x).values
    order = sorted(regions, key=lambda region: region.code)
    number = np.searchsorted([region.code for region in order], values)
    norm = BoundaryNorm(np.arange(len(order) + 1) - 0.5, len(order))
    colours = ListedColormap([region.style.colour for region in order])
    edges = edges_of(part, x, y)
    ax.pcolormesh(*edges, number, cmap=colours, norm=norm, rasterized=True)
    for region in order:
        mask, style = values == region.code, region.style
        draw_hatch(ax, part[x].values, part[y].values, mask, style.hatch, style.hatch_colour)
    outline(ax, values, edges)


def label_texts(region: Region) -> list[str]:
    """Return the label of a region in lines: as wide as it likes, narrow, and in one line beside the region."""
    narrow = "\n".join(wrapped(region.words, LETTERS))
    of = " of the map" if region.name == "no_impact" else ""
    return [
        f"{region.words}\n{region.share}{of}",
        f"{narrow}\n{region.share}",
        f"{region.words}, {region.share}",
    ]  # fmt: skip


def region_patches(regions: list[Region]) -> list[Patch]:
    """Return a legend entry for each region of maps that share a legend."""
    return [
        Patch(
            facecolor=region.style.colour, hatch=region.style.hatch * 2, linewidth=0.4,
            edgecolor=region.style.hatch_colour if region.style.hatch else INK, label=region.words,
        )
        for region in sorted(regions, key=lambda region: region.code)
    ]  # fmt: skip
