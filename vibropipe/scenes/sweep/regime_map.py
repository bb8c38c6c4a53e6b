"""A sweep over two parameters: map of the laws of motion, and maps of quantities.

Each combination of further swept parameters has its own maps, as small multiples on one page.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.transforms import Bbox

from vibropipe.figures.map_shapes import borders, cell_edges, frame, scale_of, widest_spot
from vibropipe.figures.style import (
    BLACK,
    GREY,
    REGION_LABEL,
    freeze_layout,
    legend,
    rasterise_many,
)
from vibropipe.figures.text import axis_label, parameter_line
from vibropipe.scenes.sweep.laws import Law, laws_of
from vibropipe.scenes.sweep.map_layout import Map, Placed, figure_of_many, figure_of_one
from vibropipe.scenes.sweep.quantities import (
    SIGNED,
    Series,
    combinations,
    evenly,
    series_of,
    swept,
    with_impacts_per_period,
)
from vibropipe.solve.sweep_grid import DIRECTION
from vibropipe.words.contacts import OF_SOFT

VALUE_COLOURS = "cividis"  # as bright in grey as the value is large
HIGHEST_SHARE = (
    0.995  # quantile where the colour bar ends, so that a few large values do not darken the others
)
REGION = "region"
# Told from every value in grey too.
NO_VALUE: dict[str, Any] = {"facecolor": "white", "edgecolor": "#B0B0B0", "hatch": "////"}
# Letters of a line of a label under a panel of half a page, and beside one.
ABSCISSA_LETTERS, ORDINATE_LETTERS = 34, 26
MAX_MAPS = 12
MAX_BANDS = 4  # combinations whose impact velocities are drawn too
ORBIT_TEXT = "$(m;\\ p_1, p_2)$: $p_1$ and $p_2$ impacts on supports 1 and 2 in $m$ forcing periods"
DEFAULT_SHOW = ("impact_velocity_max", "displacement_mean", "displacement_amplitude")


def map_axes(dataset: xr.Dataset) -> tuple[str, str, list[str]]:
    """Return (abscissa, ordinate, further parameters): the two finest grids, in study order."""
    dims = swept(dataset)
    finest = sorted(dims, key=lambda name: -dataset.sizes[name])[:2]
    x, y = (name for name in dims if name in finest)
    further = [name for name in dims if name not in finest]
    return x, y, [*further, DIRECTION] if DIRECTION in dataset["regime"].dims else further


def map_series(dataset: xr.Dataset, show: Collection[str]) -> list[Series]:
    """Return the quantities of the maps beside that of laws; of harmonics the first one."""
    found = []
    for name in show or DEFAULT_SHOW:
        if name in dataset:
            series = series_of(dataset, name)
            found += series[:1] if series[0].dim not in ("support", None) else series
    return found


def drawn_combinations(dataset: xr.Dataset, show: Collection[str] = ()) -> list[dict[str, int]]:
    """Return the combinations of further parameters that are drawn: as many as are legible on a page."""
    found = combinations(dataset, map_axes(dataset)[2])
    return evenly(found, MAX_MAPS // (1 + len(map_series(dataset, show) if show else [])) or 1)


def draw_regime_map(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the map of the laws of motion and maps of quantities.

    Parameters
    ----------
    dataset : xarray.Dataset
        A sweep over two or more parameters.
    show : collection of str
        Quantities of the further maps (default: impact velocities, constant part and first harmonic; over more
        than two parameters the impact velocities, or none for more than MAX_BANDS combinations).
    """
    x, y, further = map_axes(dataset)
    dataset = with_impacts_per_period(dataset.sortby([x, y]))
    codes, laws = laws_of(dataset)
    dataset = dataset.assign(law=codes)
    indices = drawn_combinations(dataset, show)
    if further and not show:
        series = map_series(dataset, ["impact_velocity_max"]) if len(indices) <= MAX_BANDS else []
    else:
        series = map_series(dataset, show)
    norms = {each.name: value_norm(dataset, each.name) for each in series}
    drawing = figure_of_one if not further else figure_of_many
    figure, placed = drawing(dataset, series, indices)
    draw_maps(figure, placed, laws, norms, x, y)
    title = ORBIT_TEXT if any(law.m > 0 for law in laws) else ""
    legend(figure, legend_handles(dataset, laws, series), "lower", title)
    figure.suptitle(parameter_line(dataset))
    thin_labels(figure)
    return figure


def draw_maps(
    figure: Figure, placed: Placed, laws: list[Law], norms: dict[str, Normalize], x: str, y: str
) -> None:
    """Draw the maps at their places; labels of axes at the left and the lower edge, a colour bar for each row."""
    first: Axes | None = None
    cells = {(spot.rowspan.start, spot.colspan.start) for spot, _ in placed}
    bars: dict[tuple[int, str], list[Axes]] = {}
    for spot, each in placed:
        row, column = spot.rowspan.start, spot.colspan.start
        ax = figure.add_subplot(spot, sharex=first, sharey=first)
        first = first or ax
        ax.set_xscale(scale_of(each.part[x].values))
        ax.set_yscale(scale_of(each.part[y].values))
        if each.series is None:
            draw_laws(ax, each.part, laws, x, y)
        else:
            draw_values(ax, each, norms[each.series.name], x, y)
            bars.setdefault((row, each.series.name), []).append(ax)
        is_left = column == 0 or (row, column - 1) not in cells
        is_wide = spot.colspan.stop - spot.colspan.start > 1
        ax.set_title(each.title if is_wide else fitted_title(each.title))
        is_low = is_wide or (row + 1, column) not in cells
        # Beside another panel a label has the room of half a page, and as little below each other.
        letters = (0 if is_wide else ABSCISSA_LETTERS, ORDINATE_LETTERS)
        ax.set_ylabel(axis_label(each.part[y], width=letters[1]) if is_left else "")
        ax.set_xlabel(axis_label(each.part[x], width=letters[0]) if is_low else "")
        ax.tick_params(labelleft=is_left, labelbottom=is_low)
    for (_, name), axes in bars.items():
        drawn: list[Any] = [np.ma.asarray(ax.collections[0].get_array()) for ax in axes]
        values = np.concatenate([array.compressed() for array in drawn])
        figure.colorbar(
            ScalarMappable(norms[name], VALUE_COLOURS), ax=axes, aspect=24, pad=0.02,
            extend=beyond(values, norms[name]),
        )  # fmt: skip


def fitted_title(title: str) -> str:
    """Return the title of a panel of half a page: long words with a unit have their symbol on a line of its own."""
    words, dollar, symbol = title.partition("$")
    is_long = len(words) > ABSCISSA_LETTERS and symbol.endswith(")")
    return f"{words.rstrip()}\n{dollar}{symbol}" if is_long else title


def beyond(values: np.ndarray, norm: Normalize) -> str:
    """Return at which ends of its scale a colour bar has to be open, as `Figure.colorbar` takes it."""
    low = norm.vmin is not None and bool((values < norm.vmin).any())
    high = norm.vmax is not None and bool((values > norm.vmax).any())
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get(
        (low, high), "neither"
    )


def thin_labels(figure: Figure) -> None:
    """Remove labels of regions that would overlap or leave the map; the larger region keeps its label.

    The layout is final from then on: it does not depend on these labels.
    """
    freeze_layout(figure)
    for ax in figure.axes:
        kept: list[Bbox] = []
        inside = ax.get_window_extent()
        for text in [artist for artist in ax.texts if artist.get_gid() == REGION]:
            box = text.get_window_extent().padded(3.0)
            if any(box.overlaps(other) for other in kept) or not (
                inside.x0 < box.x0 and box.x1 < inside.x1
            ):
                text.remove()
            else:
                kept.append(box)


def draw_laws(ax: Axes, part: xr.Dataset, laws: list[Law], x: str, y: str) -> None:
    """Draw every cell in the colour and hatch of its law, outlines, and a label in each large region."""
    codes = part["law"].transpose(y, x).values
    colours = ListedColormap([law.colour for law in laws])
    norm = BoundaryNorm(np.arange(len(laws) + 1) - 0.5, len(laws))
    grid = cell_edges(part[x].values), cell_edges(part[y].values)
    ax.pcolormesh(*grid, codes, cmap=colours, norm=norm, rasterized=True)
    numbers, areas = np.unique(codes, return_counts=True)
    for number in numbers[np.argsort(-areas, kind="stable")]:
        law, mask = laws[number], codes == number
        if law.hatch and min(codes.shape) > 1:
            draw_hatch(ax, part[x].values, part[y].values, mask, law.hatch)
        spot = widest_spot(mask)
        if spot is not None:
            ax.text(
                part[x].values[spot[1]], part[y].values[spot[0]], law.short, gid=REGION, **REGION_LABEL
            ).set_in_layout(False)  # fmt: skip
    draw_borders(ax, codes, grid, BLACK)
    frame(ax)


MANY_CELLS = 62_500  # hatches of a larger map are stored as pixels
HATCH_CELLS = 250  # cells of a side that are enough for the shape of a hatched region


def draw_hatch(ax: Axes, x: Any, y: Any, mask: Any, hatch: str) -> None:
    """Hatch a region; of a fine grid, every n-th cell gives the shape."""
    rows, columns = (max(1, size // HATCH_CELLS) for size in mask.shape)
    shape = mask[::rows, ::columns]
    hatched = ax.contourf(
        x[::columns], y[::rows], shape, levels=[0.5, 1.5], colors="none", hatches=[hatch]
    )
    hatched.set_rasterized(mask.size > MANY_CELLS)


def draw_borders(ax: Axes, codes: Any, grid: tuple[Any, Any], colour: str) -> None:
    """Draw the outlines of regions."""
    lines = borders(codes, *grid)
    if lines is not None:
        drawn = ax.plot(*lines, color=colour, linewidth=0.5, scalex=False, scaley=False)
        rasterise_many(drawn, lines[0].size)


def draw_values(ax: Axes, each: Map, norm: Normalize, x: str, y: str) -> None:
    """Draw a quantity, hatched where it has no value, with the outlines of the laws."""
    assert each.series is not None
    grid = cell_edges(each.part[x].values), cell_edges(each.part[y].values)
    values = each.series.of(each.part).transpose(y, x).values
    ax.patch.set(**NO_VALUE)
    masked = np.ma.masked_invalid(values)
    ax.pcolormesh(*grid, masked, cmap=VALUE_COLOURS, norm=norm, rasterized=True)
    draw_borders(ax, each.part["law"].transpose(y, x).values, grid, GREY)
    frame(ax)


def value_norm(dataset: xr.Dataset, name: str) -> Normalize:
    """Return the colour scale of a quantity, up to the HIGHEST_SHARE quantile; from 0 unless it has both signs."""
    values = np.concatenate(
        [each.of(dataset).values.ravel() for each in map_series(dataset, [name])]
    )
    values = values[np.isfinite(values)]
    if not values.size:
        return Normalize(0.0, 1.0)
    low = float(np.quantile(values, 1 - HIGHEST_SHARE)) if name in SIGNED else 0.0
    high = float(np.quantile(values, HIGHEST_SHARE))
    return Normalize(low, high if high > low else low + 1.0)


def legend_handles(dataset: xr.Dataset, laws: list[Law], series: list[Series]) -> list[Patch]:
    """Return legend entries of the laws, and of supports not struck."""
    handles = [
        Patch(
            facecolor=law.colour,
            hatch=law.hatch * 2,
            edgecolor=BLACK,
            linewidth=0.4,
            label=law.text,
        )
        for law in sorted(laws, key=lambda law: law.regime)
    ]
    if any(each.name in ("impact_velocity_max", *OF_SOFT) for each in series):
        text = "support not struck"
        handles.append(Patch(**NO_VALUE, linewidth=0.4, label=text))
    return handles
