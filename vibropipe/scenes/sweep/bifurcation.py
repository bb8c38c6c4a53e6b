"""Bifurcation diagram of a sweep: every impact, or every state at the section, against a swept parameter.

Periodic rows show as many points as their orbit has, aperiodic rows a band.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.map_shapes import scale_of
from vibropipe.figures.phase_plane import draw_points
from vibropipe.figures.style import (
    SUPPORT_COLOURS,
    legend,
    write_centred,
)
from vibropipe.figures.text import (
    axis_label,
    in_brackets,
    parameter_line,
    plain_symbol,
    sentences,
    symbol_of,
)
from vibropipe.scenes.sweep.captions import (
    combinations_text,
    follow_text,
    left_out_text,
    unresolved_text,
)
from vibropipe.scenes.sweep.figure_keys import IN_DIAGRAM
from vibropipe.scenes.sweep.impacts import rows_of_impacts
from vibropipe.scenes.sweep.layout import MAX_MULTIPLES, columns_of, fitting_panels, lay_out
from vibropipe.scenes.sweep.quantities import (
    LABEL_WIDTH,
    Panel,
    Series,
    abscissa_label,
    axis_and_others,
)
from vibropipe.scenes.sweep.strips import Strip, draw_strips, regime_patches
from vibropipe.solve.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

Floats = NDArray[np.float64]
DEFAULT_SHOW = ("impact_velocity", "poincare_displacement", "displacement_strobe")


@dataclass(frozen=True)
class Points:
    """All points of a sweep in a diagram: flat index of the row, and value."""

    row: NDArray[np.intp]
    value: Floats


def fits_bifurcation(dataset: xr.Dataset) -> bool:
    """Return whether a sweep has impacts of every row, or states at the section."""
    return "regime" in dataset and any(name in dataset for name in DEFAULT_SHOW)


def diagram_panels(dataset: xr.Dataset, show: Collection[str] = ()) -> list[Panel]:
    """Return the panels: impacts on each support, then states at the section."""
    wanted = [name for name in show if name in IN_DIAGRAM]
    if not wanted:
        section = "displacement_strobe" if "poincare_displacement" not in dataset else ""
        wanted = [name for name in (*DEFAULT_SHOW[:2], section) if name in dataset]
    panels = []
    for name in dict.fromkeys(name for name in wanted if name in dataset):
        text = axis_label(dataset[name], width=LABEL_WIDTH)
        if name != "impact_velocity":
            panels.append(
                Panel(
                    text,
                    (Series(name),),
                    in_brackets(symbol_of(dataset[name]), dataset[name]),
                )
            )
            continue
        for support in (1, 2):
            own = dataset[name].copy(deep=False)
            own.attrs = {**own.attrs, "long_name": f"impact velocity, support {support}",
                         "symbol": r"$|\dot{x}^-|$"}  # fmt: skip
            panels.append(
                Panel(
                    axis_label(own, width=LABEL_WIDTH),
                    (Series(name, "support", support - 1),),
                    f"{in_brackets(symbol_of(own), own)}\nsupport {support}",
                )
            )
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


def draw_bifurcation(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw a bifurcation diagram over the parameter with the finest grid.

    Parameters
    ----------
    dataset : xarray.Dataset
        A sweep with impacts or states at the section. Each combination of further parameters, and each direction
        in which rows were followed, has its own diagrams; of many, MAX_MULTIPLES are drawn.
    show : collection of str
        Quantities among `impact_velocity`, `poincare_displacement`, `poincare_velocity`, `displacement_strobe` and
        `lyapunov_exponent` (default: impacts, and displacement at the section).
    """
    along, others = axis_and_others(dataset)
    dims = [*others, DIRECTION] if DIRECTION in dataset["regime"].dims else others
    panels = diagram_panels(dataset, show)
    points = {panel: points_of(dataset, panel) for panel in panels}
    index = xr.DataArray(
        np.arange(dataset["regime"].size).reshape(dataset["regime"].shape),
        dims=dataset["regime"].dims,
    )
    names = ("regime", along, *(name for name in dims if name in dataset.coords))
    rows = columns_of(dataset[list(names)].assign(index=index), dims, panels, fold=False)
    figure, spots = lay_out(rows, 1)
    first: dict[Panel, Axes] = {}
    for row, row_spots in zip(rows, spots, strict=True):
        for number, (column, own) in enumerate(zip(row, row_spots, strict=True)):
            part = column.part.sortby(along)
            x_of = np.full(dataset["regime"].size, np.nan)
            x_of[part["index"].values] = part[along].values
            axes: list[Axes] = []
            for panel, spot in zip(column.panels, own.panels, strict=True):
                ax = figure.add_subplot(spot, sharey=first.get(panel))
                first.setdefault(panel, ax)
                axes.append(ax)
                draw_diagram(ax, points[panel], x_of, panel)
                ax.set_ylabel(panel.fitted(own.height_cm) if number == 0 else "")
                ax.tick_params(labelbottom=False, labelleft=number == 0)
            axes[0].set_title(column.title)
            bottom = figure.add_subplot(own.strip)
            strip = [Strip("", part)]
            bottom.set_xscale(scale_of(part[along].values))
            draw_strips(bottom, strip, along, "regime" if number == 0 else "", own.width_cm)
            for ax in axes:
                ax.set_xscale(scale_of(part[along].values))
                ax.set_xlim(bottom.get_xlim())
            bottom.set_xlabel(abscissa_label(dataset[along], own.width_cm))
            figure.align_ylabels(axes)
    figure.suptitle(parameter_line(dataset))
    legend(figure, regime_patches(dataset), "lower")
    return figure


def draw_diagram(ax: Axes, points: Points, x_of: Floats, panel: Panel) -> None:
    """Draw the points whose rows are drawn, at the abscissae of their rows."""
    x = x_of[points.row]
    kept = np.isfinite(x)
    if not kept.any():
        series = panel.series[0]
        is_impact = series.name == "impact_velocity"
        write_centred(
            ax, f"Support {(series.position or 0) + 1} is not struck" if is_impact else "No values"
        )
        return
    position = panel.series[0].position
    colour = "#000000" if position is None else SUPPORT_COLOURS[position + 1]
    draw_points(ax, x[kept], points.value[kept], colour)
    if panel.series[0].name == "impact_velocity":
        # Of all columns, which share the ordinate.
        ax.set_ylim(0.0, 1.05 * float(points.value.max()))


def describe_bifurcation(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of a bifurcation diagram: what is drawn, and the numbers of rows by period multiple."""
    along, others = axis_and_others(dataset)
    dims = [*others, DIRECTION] if DIRECTION in dataset["regime"].dims else others
    wanted = diagram_panels(dataset, show)
    panels = fitting_panels(dataset, dims, wanted)
    names = [panel.series[0].name for panel in panels]
    impacts = "the velocity of each impact of a row" if "impact_velocity" in names else ""
    at_section = any(name not in ("impact_velocity", "lyapunov_exponent") for name in names)
    section = "its states at the section, once per forcing period" if at_section else ""
    exponent = "its Lyapunov exponent" if "lyapunov_exponent" in names else ""
    aperiodic = int((dataset["regime"] == Regime.APERIODIC).sum())
    strobe = (
        ", of which an orbit of m > 1 periods has one drawn"
        if "displacement_strobe" in names
        else ""
    )
    drawn = series(filter(None, [impacts, section + strobe, exponent]))
    return sentences(
        f"Bifurcation diagram over {plain_symbol(along)}: {drawn}",
        f"Aperiodic rows ({aperiodic} of {dataset['regime'].size}) show a band"
        if aperiodic and (impacts or section)
        else "",
        combinations_text(dataset, dims, MAX_MULTIPLES),
        left_out_text(dataset, dims, wanted),
        follow_text(dataset),
        unresolved_text(dataset),
    )
