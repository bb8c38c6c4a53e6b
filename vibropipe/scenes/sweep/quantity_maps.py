"""Maps of quantities of a sweep over two parameters: magnitudes from dark to light, signed ones away from white."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from vibropipe.figures.canvas import colour_bar, plain_ticks
from vibropipe.figures.map_shapes import label_regions
from vibropipe.figures.palette import HAIRLINE, MAGNITUDES, SIGNED
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
from vibropipe.scenes.sweep.quantities import SIGNED as WITH_SIGN
from vibropipe.scenes.sweep.quantities import (
    Series,
    fitted_title,
    series_of,
    with_impacts_per_period,
)
from vibropipe.words.regimes import Regime

DEFAULT_SHOW = (
    "impact_velocity_max",
    "displacement_mean",
    "displacement_amplitude",
    "period_multiple",
)
DEFAULT_AMOUNT = 2
# Quantile where the scale ends, so that a few large values do not darken the others.
HIGHEST_SHARE = 0.995
PANEL_CM, LOW_PANEL_CM, BAR_CM = 3.2, 2.5, 1.15
MAX_PANELS, MANY_PANELS = 12, 8
NO_VALUE = 1
# Negative values from this share of the scale on are striped, so that grey tells them from positive ones.
STRIPED_FROM = 0.2


def map_series(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Series]:
    """Return the quantities of the maps; of harmonics the first one.

    Without `show` they are the largest velocity of impacts on either support, the constant part and the first
    harmonic, DEFAULT_AMOUNT of those that the data have.
    """
    found: list[Series] = []
    for name in show or DEFAULT_SHOW:
        if name not in dataset:
            continue
        series = series_of(dataset, name)
        if not show and series[0].dim == "support":
            series = [Series(name, "support", None)]
        found += series if series[0].dim in ("support", None) else series[:1]
    return found if show else found[:DEFAULT_AMOUNT]


def drawn_panels(dataset: xr.Dataset, show: Collection[str]) -> tuple[list[Series], int]:
    """Return the quantities that are drawn, and of how many combinations of further parameters."""
    series = map_series(dataset, show)[:MAX_PANELS]
    return series, MAX_PANELS // max(1, len(series))


def draw_quantity_maps(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw maps of quantities over the two finest grids, each combination of further parameters in a row of its own.

    Parameters
    ----------
    dataset : xarray.Dataset
        A sweep over two or more parameters.
    show : collection of str
        Quantities (default: those of `map_series`).
    """
    x, y, _ = map_axes(dataset)
    dataset = with_impacts_per_period(dataset.sortby([x, y]))
    series, most = drawn_panels(dataset, show)
    norms = {each.name: value_norm(dataset, each.name) for each in series}
    parts = list(by_combination(dataset, most))
    panels = [(title, part, each) for title, part in parts for each in series]
    has_rows = any(title for title, _ in parts)
    height = PANEL_CM if len(panels) <= MANY_PANELS else LOW_PANEL_CM
    lines = 2 if has_rows else 1
    figure, found = places(len(panels), 2, height, lines, beside=BAR_CM)
    for place, (title, part, each) in zip(found, panels, strict=True):
        ax = map_panel(figure, place, part, x, y)
        drawn = draw_values(ax, part, each, norms[each.name], x, y)
        values = each.of(part).values
        bar = colour_bar(
            figure, drawn, place.left + place.width + 0.15, place.bottom, 0.18, place.height
        )
        plain_ticks(bar.ax.yaxis, 5)
        extend(bar.ax, values, norms[each.name])
        if each.name in WITH_SIGN:
            stripe(bar.ax, norms[each.name])
        write_titles(ax, fitted_title(dataset, each, place.width + BAR_CM - 0.2), title)
    return figure


def draw_values(
    ax: Axes, part: xr.Dataset, series: Series, norm: Normalize, x: str, y: str
) -> object:
    """Draw a quantity, hatched and named where it has no value, with the outlines of these rows and of chaos."""
    edges = edges_of(part, x, y)
    values = series.of(part).transpose(y, x).values
    colours = SIGNED if series.name in WITH_SIGN else MAGNITUDES
    drawn = ax.pcolormesh(
        *edges, np.ma.masked_invalid(values), cmap=colours, norm=norm, rasterized=True
    )
    if series.name in WITH_SIGN:  # which only their hue tells from positive ones
        striped = values < -STRIPED_FROM * (norm.vmax or 1.0)
        draw_hatch(ax, part[x].values, part[y].values, striped, "-----", HAIRLINE)
    missing = ~np.isfinite(values)
    regime = part["regime"].transpose(y, x).values
    draw_hatch(ax, part[x].values, part[y].values, missing, "////", HAIRLINE)
    outline(ax, np.where(missing, -1, (regime == Regime.APERIODIC).astype(int)), edges, 0.3)
    if missing.any() and missing.mean() > 0.05:
        is_quiet = bool((regime[missing] == Regime.NO_IMPACT).all())
        text = "no impact" if is_quiet else "no value"
        label_regions(ax, missing.astype(int), edges, {NO_VALUE: [text]})
    return drawn


def value_norm(dataset: xr.Dataset, name: str) -> Normalize:
    """Return the scale of a quantity, up to the HIGHEST_SHARE quantile: from 0, or symmetric about it if signed."""
    series = series_of(dataset, name)
    kept = series if series[0].dim in ("support", None) else series[:1]
    values = np.concatenate([np.abs(each.of(dataset).values.ravel()) for each in kept])
    values = values[np.isfinite(values)]
    high = float(np.quantile(values, HIGHEST_SHARE)) if values.size else 0.0
    high = high or float(values.max(initial=0.0)) or 1.0
    return Normalize(-high if name in WITH_SIGN else 0.0, high)


def stripe(ax: Axes, norm: Normalize) -> None:
    """Hatch the negative part of a scale as on its map."""
    high = norm.vmax or 1.0
    ends = (np.array([0.0, 1.0]), np.array([-high, -STRIPED_FROM * high]))
    draw_hatch(ax, *ends, np.ones((2, 2), bool), "-----", HAIRLINE)


def extend(ax: Axes, values: np.ndarray, norm: Normalize) -> None:
    """Mark with a triangle the ends of a scale beyond which there are values."""
    found = values[np.isfinite(values)]
    ends = {1.0: (found > norm.vmax).any(), 0.0: (found < norm.vmin).any()}
    for at, is_open in ends.items():
        if is_open:
            marker = 6 if at else 7  # carets that stand on the end of the scale
            ax.plot(0.5, at, marker=marker, color="#1A1A1A", markersize=3.5, clip_on=False,
                    transform=ax.transAxes)  # fmt: skip
