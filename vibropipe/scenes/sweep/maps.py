"""Maps of a sweep over two parameters: how the mass moves, with regions labelled where they are, and quantities.

Each combination of further swept parameters has its own map, as small multiples; those of regions share a legend.
Magnitudes go from dark to light, signed quantities away from white.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from string import ascii_lowercase
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibropipe.figures.canvas import LEGEND_LINE, colour_bar, legend_below, plain_ticks
from vibropipe.figures.canvas import panel as write_title
from vibropipe.figures.map_shapes import borders, label_regions
from vibropipe.figures.palette import HAIRLINE, INK, MAGNITUDES, SIGNED, shaded
from vibropipe.report.findings import largest
from vibropipe.scenes.sweep.laws import Region, regions_of, share_text
from vibropipe.scenes.sweep.map_layout import (
    as_steps,
    by_combination,
    draw_hatch,
    edges_of,
    map_axes,
    map_panel,
    outline,
    places,
    write_titles,
)
from vibropipe.scenes.sweep.quantities import DEFAULT_SHOW as USUAL
from vibropipe.scenes.sweep.quantities import SIGNED as WITH_SIGN
from vibropipe.scenes.sweep.quantities import (
    Series,
    family_size,
    fitted_title,
    is_shown,
    series_of,
    without_rounding,
    wrapped,
)
from vibropipe.scenes.sweep.sweep_rows import with_impacts_per_period
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series as series_text

HERO_CM, TWO_CM, SMALL_CM = 7.6, 5.6, 3.6
LABELLED = 0.003  # of the points: a smaller region has no label
MAX_MAPS = 12
LETTERS = 16  # of a line of a narrow label
LEGEND_COLUMNS = 3
DEFAULT_SHOW = (
    "housing_velocity_mean",
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
MISSING = -1
# A line round negative values from this share of the scale on, so that grey tells them from positive ones.
CONTOUR = 0.2
NEGATIVE: dict[str, Any] = {"colors": INK, "linewidths": 0.5, "linestyles": [(0, (3, 2))]}
ROUNDING = 1e-9  # of the largest value
NEGLIGIBLE = 1e-6  # of the largest displacement: harmonics of a mass that rests are off by 1e-8
VANISHING = 0.05


def draw_regime_map(dataset: xr.Dataset) -> Figure:
    """Draw the map of how the mass moves over the two finest grids; further parameters have maps of their own."""
    return draw_region_map(dataset, *regions_of(dataset))


def draw_region_map(dataset: xr.Dataset, codes: xr.DataArray, regions: list[Region]) -> Figure:
    """Draw the map of regions over the two finest grids, from the code of each row."""
    x, y, _ = map_axes(dataset)
    dataset = dataset[["regime"]].assign(region=codes).sortby([x, y])
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


def draw_regions(
    ax: Axes, part: xr.Dataset, regions: list[Region], x: str, y: str, faded: float = 0.0
) -> None:
    """Draw every cell in the colour and hatch of its region, and outlines; without these if mixed with white."""
    values = part["region"].transpose(y, x).values
    order = sorted(regions, key=lambda region: region.code)
    number = np.searchsorted([region.code for region in order], values)
    norm = BoundaryNorm(np.arange(len(order) + 1) - 0.5, len(order))
    colours = ListedColormap([shaded(region.style.colour, faded) for region in order])
    edges = edges_of(part, x, y)
    ax.pcolormesh(*edges, number, cmap=colours, norm=norm, rasterized=True)
    for region in order:
        mask, colour = values == region.code, shaded(region.style.hatch_colour, faded)
        draw_hatch(ax, edges, mask, region.style.hatch, colour)
    if not faded:
        outline(ax, values, edges)


def label_texts(region: Region) -> list[str]:
    """Return the label of a region in lines: as wide as it likes, narrow, and in one line beside the region."""
    narrow = "\n".join(wrapped(region.words, LETTERS))
    of = " of the map" if region.name == "no_impact" and "%" in region.share else ""
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


def map_series(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Series]:
    """Return the quantities of the maps; of harmonics the first one.

    Without `show` they are the progression of a housing, the largest velocity of impacts on either support, the
    mean displacement and the first harmonic, DEFAULT_AMOUNT of those that the data have; the others where these are the
    same everywhere.
    """
    found: list[Series] = []
    held = [name for name in show or DEFAULT_SHOW if name in dataset]
    held = [name for name in held if is_shown(dataset, name)] or held
    told = [name for name in held if not is_uniform(dataset, name)]
    is_told = show or not told or not {*told}.isdisjoint(held[:DEFAULT_AMOUNT])
    for name in held if is_told else told:
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

    dataset : a sweep over two or more parameters
    show : quantities (default: those of `map_series`)
    """
    x, y, _ = map_axes(dataset)
    dataset = with_impacts_per_period(dataset.sortby([x, y]))
    series, most = drawn_panels(dataset, show)
    dataset = without_rounding(dataset, {each.name for each in series})
    norms = {each.name: value_norm(dataset, each.name) for each in series}
    parts = list(by_combination(dataset, most))
    panels = [(title, part, each) for title, part in parts for each in series]
    has_rows = any(title for title, _ in parts)
    height = PANEL_CM if len(panels) <= MANY_PANELS else LOW_PANEL_CM
    lines = 2 if has_rows else 1
    figure, found = places(len(panels), 2, height, lines, beside=BAR_CM)
    for letter, place, (title, part, each) in zip(ascii_lowercase, found, panels, strict=False):
        ax, norm = map_panel(figure, place, part, x, y), norms[each.name]
        drawn = draw_values(ax, part, each, norm, x, y, is_blank(dataset, each))
        right = place.left + place.width
        if not is_blank(dataset, each):
            bar = colour_bar(figure, drawn, right + 0.15, place.bottom, 0.18, place.height)
            plain_ticks(bar.ax.yaxis, 5)
            extend(bar.ax, each.of(part).values, norm)
            if has_both_signs(norm):
                bar.ax.axhline(-CONTOUR * (norm.vmax or 1.0), color=INK, lw=0.5, ls=(0, (3, 2)))
        words = fitted_title(dataset, each, place.width + BAR_CM - 0.5)
        if title:
            write_titles(ax, words, title)
        else:
            write_title(ax, letter if len(panels) > 1 else "", words)
    return figure


def draw_values(
    ax: Axes, part: xr.Dataset, series: Series, norm: Normalize, x: str, y: str, blank: bool = False
) -> object:
    """Draw a quantity, hatched and named where it has no value, with the outlines of these rows and of chaos.

    blank : whether it is 0 wherever it has a value, which then has no colour
    """
    edges = edges_of(part, x, y)
    values = series.of(part).transpose(y, x).values
    is_signed = has_both_signs(norm)
    colours = SIGNED if is_signed else MAGNITUDES
    shown = np.ma.masked_invalid(np.full_like(values, np.nan) if blank else values)
    drawn = ax.pcolormesh(*edges, shown, cmap=colours, norm=norm, rasterized=True)
    if is_signed and min(values.shape) > 1:  # which only their hue tells from positive ones
        level = -CONTOUR * (norm.vmax or 1.0)
        ax.contour(*as_steps(edges, values), levels=[level], **NEGATIVE)
    codes = outlined(part, series, x, y)
    missing, regime = codes == MISSING, part["regime"].transpose(y, x).values
    draw_hatch(ax, edges, missing, "////", HAIRLINE)
    outline(ax, codes, edges, 0.3)
    is_quiet = bool((regime[missing] == Regime.NO_IMPACT).all())
    texts = {0: ["0"]} if blank and not missing.all() else {}
    if missing.mean() > 0.05:
        texts[NO_VALUE] = ["no impact" if is_quiet else "no value"]
    label_regions(ax, missing.astype(int), edges, texts)
    return drawn


def outlined(part: xr.Dataset, series: Series, x: str, y: str) -> np.ndarray:
    """Return what the lines on a map of a quantity tell apart: MISSING values, aperiodic motion, and all else."""
    is_aperiodic = (part["regime"] == Regime.APERIODIC).astype(int)
    return is_aperiodic.where(series.of(part).notnull(), MISSING).transpose(y, x).values


def value_norm(dataset: xr.Dataset, name: str) -> Normalize:
    """Return the scale of a quantity, up to the HIGHEST_SHARE quantile: from 0, or symmetric about it if some is below.

    What rounding leaves below 0 does not count; of what is rounding throughout the scale is VANISHING of its family.
    """
    series = series_of(dataset, name)
    kept = series if series[0].dim in ("support", None) else series[:1]
    found = np.concatenate([each.of(dataset).values.ravel() for each in kept])
    found = found[np.isfinite(found)]
    values = np.abs(found)
    # "higher": of few values the largest, beyond which there is none
    high = float(np.quantile(values, HIGHEST_SHARE, method="higher")) if values.size else 0.0
    high = high or float(values.max(initial=0.0)) or 1.0
    is_signed = name in WITH_SIGN and found.min(initial=0.0) < -ROUNDING * high
    if is_rounding(dataset, name, float(values.max(initial=0.0))):
        high = VANISHING * family_size(dataset, name, USUAL) or 1.0
    return Normalize(-high if is_signed else 0.0, high)


def is_rounding(dataset: xr.Dataset, name: str, top: float) -> bool:
    """Return whether the largest value of a quantity is 0, or nothing beside the usual ones of its family."""
    return abs(top) <= NEGLIGIBLE * family_size(dataset, name, USUAL)


def is_uniform(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a map of a quantity has one colour: it has one value, or none, or is 0 but for rounding."""
    values = dataset[name].values
    return bool((values == values.flat[0]).all()) or is_blank(dataset, Series(name))


def is_blank(dataset: xr.Dataset, series: Series) -> bool:
    """Return whether a quantity has no value in any row, or is 0 in all that have one."""
    top = largest(series.of(dataset))
    return top is None or is_rounding(dataset, series.name, float(top))


def has_both_signs(norm: Normalize) -> bool:
    """Return whether a scale has a negative part."""
    return (norm.vmin or 0.0) < 0.0


def has_negative(dataset: xr.Dataset, name: str) -> bool:
    """Return whether the scale of a quantity has a negative part."""
    return has_both_signs(value_norm(dataset, name))


def extend(ax: Axes, values: np.ndarray, norm: Normalize) -> None:
    """Mark with a triangle the ends of a scale beyond which there are values."""
    found = values[np.isfinite(values)]
    ends = {1.0: (found > norm.vmax).any(), 0.0: (found < norm.vmin).any()}
    for at, is_open in ends.items():
        if is_open:
            marker = 6 if at else 7  # carets that stand on the end of the scale
            ax.plot(
                0.5,
                at,
                marker=marker,
                color=INK,
                markersize=3.5,
                clip_on=False,
                transform=ax.transAxes,
            )


def without_orbit_texts(dataset: xr.Dataset, shown: Sequence[Series]) -> tuple[str, str]:
    """Write what the lines on maps of quantities border, and what is shown of a motion without an orbit."""
    x, y, _ = map_axes(dataset)
    regime = dataset["regime"]
    chaos = int((regime == Regime.APERIODIC).sum())
    of_code = {
        1: f"aperiodic motion ({share_text(chaos, regime.size)})",
        MISSING: "hatched points without a value",
    }
    maps = [
        (outlined(part, each, x, y), edges_of(part, x, y))
        for _, part in by_combination(dataset.sortby([x, y]), MAX_PANELS // max(1, len(shown)))
        for each in shown
    ]
    # points that lie alone have no outline
    lines = [
        text
        for code, text in of_code.items()
        if any(borders((codes == code).astype(int), *edges) is not None for codes, edges in maps)
    ]
    in_window = any(
        bool(each.of(dataset).where(regime >= Regime.APERIODIC).notnull().any()) for each in shown
    )
    of_largest = {"impact_velocity_max": "largest impact"}
    what = {
        of_largest.get(each.name, "largest value" if each.name.endswith("_max") else "average")
        for each in shown
    }
    told = series_text(f"the {each}" for each in sorted(what, reverse=True))
    return (
        f"Lines: borders of {' and of '.join(lines)}" if lines else "",
        f"Without an orbit: {told} in a window" if in_window else "",
    )
