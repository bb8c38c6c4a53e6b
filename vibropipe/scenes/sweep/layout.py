"""Where the panels of a sweep stand: columns of panels over bars of regimes, or small multiples, on one page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from vibropipe.figures.style import PAGE_HEIGHT_CM, PRINT_WIDTH_CM, new_figure
from vibropipe.figures.text import value_text
from vibropipe.scenes.sweep.quantities import Panel, combinations, evenly

PANEL_HEIGHT_CM = 2.9
STRIP_CM = 0.42
STRIP_MARGIN_CM = 0.3
MARGINS_CM = 3.4  # legends and titles
AXIS_CM = 1.1  # labels of the abscissa and title of a row of columns
LABELS_CM = 1.9  # labels of the ordinates
MAX_COLUMNS = 3
MAX_MULTIPLES = 12


@dataclass(frozen=True)
class Column:
    """Panels one above the other, with the bars of their rows below."""

    title: str
    part: xr.Dataset
    panels: tuple[Panel, ...]


def columns_of(
    dataset: xr.Dataset, dims: list[str], panels: Sequence[Panel], fold: bool
) -> list[list[Column]]:
    """Return the columns of a picture, in rows.

    Parameters
    ----------
    dataset : xarray.Dataset
        A sweep.
    dims : list of str
        Swept parameters beyond those of abscissa and lines; each combination of values has its column. More than
        MAX_COLUMNS are small multiples, of `fitting_panels`, at MAX_MULTIPLES evenly spaced combinations.
    panels : sequence of Panel
        Panels of a column.
    fold : bool
        Whether a single column is folded into two.
    """
    found = combinations(dataset, dims)
    if len(found) == 1:
        half = -(-len(panels) // 2)
        parts = [panels[:half], panels[half:]] if fold and len(panels) > 2 else [panels]
        return [[Column("", dataset, tuple(part)) for part in parts]]
    panels = fitting_panels(dataset, dims, panels)
    if len(found) > MAX_COLUMNS:
        found = evenly(found, MAX_MULTIPLES)
    columns = [
        Column(combination_text(dataset, one), dataset.isel(one), tuple(panels)) for one in found
    ]
    across = 2 if len(found) == 4 else MAX_COLUMNS
    return [columns[n : n + across] for n in range(0, len(columns), across)]


def fitting_panels(
    dataset: xr.Dataset, dims: list[str], panels: Sequence[Panel]
) -> Sequence[Panel]:
    """Return the panels of a column that are drawn: all, or of small multiples as many as fit on a page."""
    columns = min(len(combinations(dataset, dims)), MAX_MULTIPLES)
    return panels if columns <= MAX_COLUMNS else panels[: max(1, MAX_MULTIPLES // columns)]


def combination_text(dataset: xr.Dataset, indices: dict[str, int]) -> str:
    """Write the values at some indices of parameters as mathtext."""
    return ", ".join(
        value_text(dataset[name], dataset[name].values[n].item()) for name, n in indices.items()
    )


@dataclass(frozen=True)
class Spots:
    """Cells of one column, of its panels and of the bars below, with the printed size of a panel."""

    panels: list[SubplotSpec]
    strip: SubplotSpec
    width_cm: float
    height_cm: float


def lay_out(rows: list[list[Column]], lines: int) -> tuple[Figure, list[list[Spots]]]:
    """Return the figure, at most a page, and the cells of each column.

    Columns of a row have as many cells as the longest of them; a shorter one leaves the upper cells free.
    """
    depth = max(len(column.panels) for row in rows for column in row)
    strip = STRIP_CM * lines + STRIP_MARGIN_CM
    beside = MARGINS_CM + len(rows) * (strip + AXIS_CM)
    height = min(PANEL_HEIGHT_CM, (PAGE_HEIGHT_CM - beside) / max(1, depth * len(rows)))
    figure = new_figure(height * depth * len(rows) + beside)
    across = max(map(len, rows))
    ratios = [*[height] * depth, strip] * len(rows)
    grid = figure.add_gridspec(len(ratios), across, height_ratios=ratios)
    width = PRINT_WIDTH_CM / across - LABELS_CM
    spots = []
    for r, row in enumerate(rows):
        top = r * (depth + 1)
        spots.append(
            [
                Spots(
                    [grid[top + n, c] for n in range(depth - len(column.panels), depth)],
                    grid[top + depth, c],
                    width,
                    height,
                )
                for c, column in enumerate(row)
            ]
        )
    return figure, spots
