"""Bifurcation diagram of a sweep: every impact, or every state at the section, against a swept parameter.

Periodic rows show as many points as their orbit has, aperiodic rows a band. Beneath them is the Lyapunov exponent.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.canvas import zero_line
from vibropipe.figures.palette import EXACT, SUPPORT_COLOURS
from vibropipe.figures.phase_plane import draw_points
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import (
    format_number,
    parameters_text,
    plain_symbol_of,
    sentences,
    symbol_of,
    with_units,
)
from vibropipe.scenes.kind import Picture, showing
from vibropipe.scenes.sweep.captions import (
    combinations_text,
    left_out_text,
    starts_text,
    unresolved_text,
)
from vibropipe.scenes.sweep.curves import draw_above_bars
from vibropipe.scenes.sweep.figure_keys import IN_DIAGRAM
from vibropipe.scenes.sweep.laws import regions_of
from vibropipe.scenes.sweep.layout import MAX_MULTIPLES, Spot, fitting_panels
from vibropipe.scenes.sweep.neighbours import doublings_of
from vibropipe.scenes.sweep.quantities import (
    WITH_ZERO_LINE,
    Panel,
    Series,
    first_fitting,
    series_words,
)
from vibropipe.scenes.sweep.sweep_rows import axis_and_others, rows_of_impacts
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count, part_text, series, share

Floats = NDArray[np.float64]
LOW = 0.4  # of the largest impact: where none is below, the axis does not begin at zero
DEFAULT_SHOW = ("impact_velocity", "poincare_displacement", "displacement_strobe")


@dataclass(frozen=True)
class Points:
    """All points of a sweep in a diagram: flat index of the row, and value."""

    row: NDArray[np.intp]
    value: Floats


def diagram_panels(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Panel]:
    """Return the panels: impacts on each support, then states at the section, then the Lyapunov exponent."""
    wanted = [name for name in show if name in IN_DIAGRAM]
    if not wanted:
        section = "displacement_strobe" if "poincare_displacement" not in dataset else ""
        wanted = [*DEFAULT_SHOW[:2], section, "lyapunov_exponent"]
    panels: list[Panel] = []
    for name in dict.fromkeys(name for name in wanted if name in dataset):
        if name == "impact_velocity":
            panels += [Panel((Series(name, "support", n),)) for n in (0, 1)]
        else:
            panels.append(Panel((Series(name),)))
    return panels


def points_of(dataset: xr.Dataset, panel: Panel) -> Points:
    """Return the points of a panel: magnitudes of the impacts on a support, or values at the section."""
    series = panel.series[0]
    array = dataset[series.name]
    if series.name == "impact_velocity":
        kept = dataset["impact_support"].values == (series.position or 0) + 1
        return Points(rows_of_impacts(dataset)[kept], np.abs(array.values[kept]))
    dims = dataset["regime"].dims
    values = array.transpose(*dims, ...).values.reshape(dataset["regime"].size, -1)
    row, column = np.nonzero(np.isfinite(values))
    return Points(row, values[row, column])


def diagram_dims(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the abscissa, and the parameters of which each combination of values has its own diagram."""
    along, others = axis_and_others(dataset)
    return along, [*others, DIRECTION] if DIRECTION in dataset["regime"].dims else others


def draw_bifurcation(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw a bifurcation diagram over the parameter with the finest grid.

    dataset : a sweep with impacts or states at the section. Each combination of further parameters, and each
        direction in which rows were followed, has its own diagrams; of many, MAX_MULTIPLES are drawn
    show : quantities among `impact_velocity`, `poincare_displacement`, `poincare_velocity`, `displacement_strobe` and
        `lyapunov_exponent` (default: impacts, displacement at the section, and the exponent)
    """
    along, dims = diagram_dims(dataset)
    panels = fitting_panels(dataset, dims, diagram_panels(dataset, show))
    points = {each: points_of(dataset, each) for each in panels}
    index = np.arange(dataset["regime"].size).reshape(dataset["regime"].shape)
    rows = dataset[["regime", along, *(name for name in dims if name in dataset.coords)]]
    rows = rows.assign(index=(dataset["regime"].dims, index)).sortby(along)
    codes, regions = regions_of(dataset)
    rows = rows.assign(region=codes)

    def draw(ax: Axes, spot: Spot) -> str:
        x_of = np.full(dataset["regime"].size, np.nan)
        x_of[spot.part["index"].values] = spot.part[along].values
        draw_diagram(ax, points[spot.panel], x_of, spot.panel)
        return title_of(dataset, spot.panel, spot.words_cm)

    return draw_above_bars(rows, regions, dims, panels, draw)[0]


def title_of(dataset: xr.Dataset, panel: Panel, width: float) -> str:
    """Return the title of a panel; impacts have no dimension of supports, but one of impacts."""
    own = panel.series[0]
    if own.name != "impact_velocity":
        return panel.title(dataset, width)
    array, support = dataset[own.name], f"support {(own.position or 0) + 1}"
    names = (series_words(dataset, Series(own.name)), symbol_of(array))
    return first_fitting([f"{name}, {support}" for name in names], array, width)


def draw_diagram(ax: Axes, points: Points, x_of: Floats, panel: Panel) -> None:
    """Draw the points whose rows are drawn, at the abscissae of their rows."""
    x = x_of[points.row]
    kept = np.isfinite(x)
    series = panel.series[0]
    is_impact = series.name == "impact_velocity"
    if series.name in WITH_ZERO_LINE:
        zero_line(ax)
    if not kept.any():
        unstruck = f"Support {(series.position or 0) + 1} is not struck"
        write_centred(ax, unstruck if is_impact else "No values")
        return
    colour = EXACT if series.position is None else SUPPORT_COLOURS[series.position + 1]
    draw_points(ax, x[kept], points.value[kept], colour)
    if is_impact:
        # Of all columns, which share the ordinate.
        low, high = float(points.value.min()), float(points.value.max())
        margin = 0.05 * max(high - low, low)
        ax.set_ylim(low - margin if low > LOW * high else 0.0, high + margin)


def bifurcation_title(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return where doublings of the period lead to aperiodic motion, else after how many periods motions repeat."""
    along, _ = axis_and_others(dataset)
    if found := doublings_of(dataset, along):
        way, symbol = "falls" if found.is_falling else "rises", plain_symbol_of(dataset[along])
        end = with_units(dataset[along], format_number(found.end, 5))
        return f"As {symbol} {way}, the period doubles until the motion is aperiodic, at {symbol} = {end}"
    regime = dataset["regime"]
    left = int((regime > Regime.APERIODIC).sum())
    if left == regime.size or "period_multiple" not in dataset:
        return ""
    longest = int(dataset["period_multiple"].where(regime < Regime.APERIODIC, 0).max())
    aperiodic = int((regime == Regime.APERIODIC).sum())
    if longest == 0:
        return "" if left else "No motion repeats itself"
    within = "in each forcing period"
    if longest > 1:
        within = f"after up to {count(longest, 'forcing period')}"
    if aperiodic:
        return f"Orbits repeat {within}; {share(aperiodic, regime.size, 'row')} aperiodic"
    if left:
        return f"In all but {count(left, 'row')} the motion repeats {within}"
    return f"The motion repeats itself {within}"


def describe_bifurcation(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of a bifurcation diagram: what is drawn, and the numbers of rows by period multiple."""
    along, dims = diagram_dims(dataset)
    wanted = diagram_panels(dataset, show)
    own = [panel.series[0] for panel in fitting_panels(dataset, dims, wanted)]
    names = [each.name for each in own]
    struck = [1 + (each.position or 0) for each in own if each.name == "impact_velocity"]
    alone = f" on support {struck[0]}" if len(struck) == 1 else ""
    impacts = f"the velocity of each impact of a row{alone}" if struck else ""
    at_section = any(name not in ("impact_velocity", "lyapunov_exponent") for name in names)
    section = "its states at the section, once per forcing period" if at_section else ""
    exponent = "its largest Lyapunov exponent" if "lyapunov_exponent" in names else ""
    aperiodic = int((dataset["regime"] == Regime.APERIODIC).sum())
    if "displacement_strobe" in names:
        section += ", of which an orbit of several periods has one drawn"
    drawn = series(filter(None, [impacts, section, exponent]))
    return sentences(
        f"Bifurcation diagram over {plain_symbol_of(dataset[along])}: {drawn}",
        f"Aperiodic rows ({part_text(aperiodic, dataset['regime'].size, 'row')}) show a band"
        if aperiodic and (impacts or section)
        else "",
        combinations_text(dataset, dims, MAX_MULTIPLES),
        left_out_text(dataset, dims, wanted),
        starts_text(dataset),
        unresolved_text(dataset),
        parameters_text(dataset),
    )


BIFURCATION = Picture(
    "bifurcation",
    draw_bifurcation,
    describe_bifurcation,
    lambda dataset: "regime" in dataset and any(name in dataset for name in DEFAULT_SHOW),
    showing,
    bifurcation_title,
)
