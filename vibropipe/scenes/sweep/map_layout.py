"""Where the maps of a sweep stand: one of laws over those of quantities, or small multiples, on one page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.style import PAGE_HEIGHT_CM, new_figure
from vibropipe.scenes.sweep.layout import combination_text
from vibropipe.scenes.sweep.quantities import Series, element_label

LAWS_CM, VALUES_CM, SMALL_CM = 7.0, 4.6, 4.4
LEGEND_CM = 3.0


@dataclass(frozen=True)
class Map:
    """What one map shows: a quantity, or the laws of motion if `series` is None."""

    series: Series | None
    part: xr.Dataset
    title: str


Placed = list[tuple[Any, Map]]


def figure_of_one(
    dataset: xr.Dataset, series: list[Series], indices: list[dict[str, int]]
) -> tuple[Figure, Placed]:
    """Place the map of laws over the whole width, those of quantities below in two columns."""
    rows = -(-len(series) // 2)
    heights = [LAWS_CM, *[VALUES_CM] * rows]
    figure = new_figure(min(sum(heights) + LEGEND_CM, PAGE_HEIGHT_CM))
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
    placed = [(grid[0, :], Map(None, dataset, ""))]
    for n, each in enumerate(series):
        title = element_label(dataset, each).replace("\n", " ")
        placed.append((grid[1 + n // 2, n % 2], Map(each, dataset, title)))
    return figure, placed


def figure_of_many(
    dataset: xr.Dataset, series: list[Series], indices: list[dict[str, int]]
) -> tuple[Figure, Placed]:
    """Place a band of maps for each combination, or the maps of laws alone in three columns."""
    across = 3 if not series else min(4, 1 + len(series))
    maps = [
        Map(each, dataset.isel(one), small_title(dataset, one, each, is_first=number == 0))
        for number, one in enumerate(indices)
        for each in (None, *series)
    ]
    rows = -(-len(maps) // across)
    height = min(SMALL_CM, (PAGE_HEIGHT_CM - LEGEND_CM - 1.0) / rows)
    figure = new_figure(height * rows + LEGEND_CM + 1.0)
    grid = figure.add_gridspec(rows, across)
    return figure, [(grid[n // across, n % across], each) for n, each in enumerate(maps)]


def small_title(
    dataset: xr.Dataset, one: dict[str, int], series: Series | None, is_first: bool
) -> str:
    """Return the title of a small map: further parameters over laws, the quantity once over its column."""
    if series is None:
        return combination_text(dataset, one)
    return element_label(dataset, series) if is_first else ""
