"""Pictures of single rows of a sweep, one for each law of motion: phase portraits, sections, spectra."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.phase_plane import (
    draw_points,
    draw_portrait,
    draw_walls,
    path,
    portrait_handles,
    walls_of,
)
from vibropipe.figures.spectrum import draw_spectrum, spectrum_handles
from vibropipe.figures.style import legend, new_figure, write_centred
from vibropipe.figures.text import axis_label, parameter_line, plain_value, sentences, value_text
from vibropipe.scenes.sweep.impacts import orbit_impacts, row_at
from vibropipe.scenes.sweep.laws import Law, chosen_rows
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

COLUMNS = 3
MAX_ROWS = 9
PANEL_CM = 5.2
LEGEND_CM = 2.4


def chosen_orbits(dataset: xr.Dataset) -> list[tuple[xr.Dataset, Law]]:
    """Return a row for each of the most frequent laws, from the middle of its longest run."""
    return [(row_at(dataset, index), law) for index, law in chosen_rows(dataset, MAX_ROWS)]


def chosen_visits(dataset: xr.Dataset) -> list[tuple[xr.Dataset, Law]]:
    """Return rows for sections: aperiodic ones, evenly spaced, or one of each law if there are none."""
    aperiodic = np.flatnonzero(dataset["regime"].values == Regime.APERIODIC)
    if not aperiodic.size:
        return chosen_orbits(dataset)
    at = np.unique(np.linspace(0, aperiodic.size - 1, MAX_ROWS).round().astype(int))
    law = Law(int(Regime.APERIODIC), 0, 0, 0)
    return [(row_at(dataset, int(aperiodic[n])), law) for n in at]


Rows = list[tuple[xr.Dataset, Law]]


def draw_rows(
    dataset: xr.Dataset,
    rows: Rows,
    draw: Callable[[Axes, xr.Dataset], None],
    labels: tuple[str, str],
) -> Figure:
    """Draw a panel for each row, titled by its parameters and its law."""
    across = min(COLUMNS, max(1, len(rows)))
    down = -(-len(rows) // across)
    figure = new_figure(PANEL_CM * max(1, down) + LEGEND_CM)
    axes = figure.subplots(max(1, down), across, squeeze=False)
    for ax in axes.ravel()[len(rows) :]:
        ax.set_visible(False)
    for number, (ax, (row, law)) in enumerate(zip(axes.ravel(), rows, strict=False)):
        values = ", ".join(value_text(row[str(name)]) for name in dataset["regime"].dims)
        ax.set_title(f"{values}\n{law.short}")
        draw(ax, row)
        is_low = number + across >= len(rows)
        ax.set(xlabel=labels[0] if is_low else "", ylabel=labels[1] if number % across == 0 else "")
    if not rows:
        axes[0, 0].set_axis_off()
        write_centred(axes[0, 0], "No row is solved")
    figure.suptitle(parameter_line(dataset))
    return figure


def portrait_rows(dataset: xr.Dataset) -> Rows:
    """Return the rows of portraits: those of `chosen_orbits` whose orbit is stored."""
    return [pair for pair in chosen_orbits(dataset) if np.isfinite(pair[0]["displacement"]).all()]


def spectrum_rows(dataset: xr.Dataset, show: Collection[str] = ()) -> Rows:
    """Return the rows of spectra: those of `chosen_orbits` that have harmonics."""
    name = f"{spectrum_name(show)}_amplitude"
    return [pair for pair in chosen_orbits(dataset) if np.isfinite(pair[0][name]).any()]


def draw_portraits(dataset: xr.Dataset) -> Figure:
    """Draw the orbit of a row of each law in the plane of displacement and velocity."""
    rows = portrait_rows(dataset)
    struck: set[int] = set()

    def draw(ax: Axes, row: xr.Dataset) -> None:
        impacts = orbit_impacts(row)
        impacts = impacts.within(0.0, 1.0)
        time, x, v = (row[name].values for name in ("phase", "displacement", "velocity"))
        if int(row.get("period_multiple", xr.DataArray(1))) > 0:  # a closed curve
            time, x, v = np.append(time, 1.0), np.append(x, x[0]), np.append(v, v[0])
        walls = walls_of(row)
        draw_portrait(ax, *path(time, x, v, impacts, walls), impacts, walls)
        struck.update(int(support) for support in np.unique(impacts.support))

    labels = axis_label(dataset["displacement"]), axis_label(dataset["velocity"])
    figure = draw_rows(dataset, rows, draw, labels)
    legend(figure, portrait_handles(struck), "lower")
    return figure


def draw_sections(dataset: xr.Dataset) -> Figure:
    """Draw the states of rows at the section, once per forcing period."""
    rows = chosen_visits(dataset)

    def draw(ax: Axes, row: xr.Dataset) -> None:
        x, v = row["poincare_displacement"].values, row["poincare_velocity"].values
        kept = np.isfinite(x) & np.isfinite(v)
        if not kept.any():
            write_centred(ax, "No values")
            return
        draw_points(ax, x[kept], v[kept])
        draw_walls(ax, float(x[kept].min()), float(x[kept].max()), walls_of(row))

    names = ("poincare_displacement", "poincare_velocity")
    labels = axis_label(dataset[names[0]], width=30), axis_label(dataset[names[1]], width=30)
    return draw_rows(dataset, rows, draw, labels)


def draw_spectra(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the harmonic amplitudes of a row of each law over multiples of the forcing frequency."""
    name = spectrum_name(show)
    rows = spectrum_rows(dataset, show)
    labels = (
        axis_label(dataset["harmonic"], width=20),
        axis_label(dataset[f"{name}_amplitude"], width=22),
    )
    figure = draw_rows(dataset, rows, lambda ax, row: draw_spectrum(ax, row, name), labels)
    legend(figure, spectrum_handles(dataset), "lower")
    return figure


def spectrum_name(show: Collection[str]) -> str:
    """Return the quantity of a spectrum: displacement, unless the velocity alone is to be shown."""
    names = {name.partition("_")[0] for name in show if name.endswith("_amplitude")}
    return "velocity" if names == {"velocity"} else "displacement"


def describe_rows(dataset: xr.Dataset, what: str, rows: Rows) -> str:
    """Return the caption of pictures of single rows: what is drawn, at which parameters."""
    places = series(
        f"{law.short} at " + ", ".join(plain_value(row[str(n)]) for n in dataset["regime"].dims)
        for row, law in rows
    )
    return sentences(what, f"Rows drawn: {places}" if places else "")
