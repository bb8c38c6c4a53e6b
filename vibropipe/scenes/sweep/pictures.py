"""Pictures of a sweep, also of single rows, one for each law of motion: phase portraits, sections, spectra."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import WIDE, axes, legend_below, new_canvas, plain_ticks
from vibropipe.figures.motion_words import amount_text
from vibropipe.figures.phase_plane import (
    draw_points,
    draw_portrait,
    draw_spectrum,
    draw_walls,
    path,
    portrait_handles,
    spectrum_handles,
    walls_of,
)
from vibropipe.figures.style import write_centred
from vibropipe.figures.text import plain_value, sentences, value_text
from vibropipe.scenes.kind import Picture, showing
from vibropipe.scenes.sweep.bifurcation import BIFURCATION
from vibropipe.scenes.sweep.captions import describe_map, describe_quantities, describe_sweep
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.figure_keys import POINTS, SweepFigure
from vibropipe.scenes.sweep.laws import Law, chosen_rows
from vibropipe.scenes.sweep.map_layout import write_titles
from vibropipe.scenes.sweep.maps import draw_quantity_maps, draw_regime_map
from vibropipe.scenes.sweep.proofs import PROOFS
from vibropipe.scenes.sweep.quantities import ENERGY_SHOW, fitted_label
from vibropipe.scenes.sweep.sweep_rows import is_map, orbit_impacts, row_at, swept
from vibropipe.scenes.sweep.titles import energy_title, map_title, quantities_title, sweep_title
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count, series

COLUMNS, MAX_ROWS = 3, 9
LEFT, RIGHT, BETWEEN = 1.3, 0.2, 1.0  # cm left of the panels, right of them, between them
PANEL_CM, LONE_CM, TITLE_CM, LABELS_CM, BETWEEN_CM, LEGEND_CM = 3.5, 6.5, 1.05, 1.0, 0.5, 0.55


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
    labels: tuple[xr.DataArray, xr.DataArray],
    handles: Callable[[], Sequence[Artist]] = tuple,
) -> Figure:
    """Draw a panel for each row, titled by its parameters and its law, with the legend that `handles` then gives."""
    across = min(COLUMNS, max(1, len(rows)))
    down = -(-max(1, len(rows)) // across)
    height = LONE_CM if len(rows) <= 1 else PANEL_CM
    width = (WIDE - LEFT - RIGHT - (across - 1) * BETWEEN) / across
    rise = height + TITLE_CM + BETWEEN_CM
    foot = LEGEND_CM + LABELS_CM
    figure = new_canvas(foot + down * rise - BETWEEN_CM)
    for number in range(max(1, len(rows))):
        row_number, column = divmod(number, across)
        left = LEFT + column * (width + BETWEEN)
        ax = axes(figure, left, foot + (down - 1 - row_number) * rise, width, height)
        if not rows:
            ax.set_axis_off()
            write_centred(ax, "No row is solved")
            break
        row, law = rows[number]
        draw(ax, row)
        values = ", ".join(value_text(row[str(name)]) for name in dataset["regime"].dims)
        write_titles(ax, values, law.words)
        plain_ticks(ax.xaxis, 4)
        plain_ticks(ax.yaxis, 4)
        if number + across >= len(rows):
            ax.set_xlabel(fitted_label(labels[0], width + 0.8))
        if column == 0:
            ax.set_ylabel(fitted_label(labels[1], height))
    entries = handles()
    legend_below(figure, entries, len(entries), LEFT)
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
    struck: set[int] = set()

    def draw(ax: Axes, row: xr.Dataset) -> None:
        impacts = orbit_impacts(row).within(0.0, 1.0)
        time, x, v = (row[name].values for name in ("phase", "displacement", "velocity"))
        if int(row.get("period_multiple", xr.DataArray(1))) > 0:  # a closed curve
            time, x, v = np.append(time, 1.0), np.append(x, x[0]), np.append(v, v[0])
        walls = walls_of(row)
        draw_portrait(ax, *path(time, x, v, impacts, walls), impacts, walls)
        struck.update(int(support) for support in np.unique(impacts.support))

    labels = dataset["displacement"], dataset["velocity"]
    return draw_rows(
        dataset, portrait_rows(dataset), draw, labels, lambda: portrait_handles(struck)
    )


def draw_sections(dataset: xr.Dataset) -> Figure:
    """Draw the states of rows at the section, once per forcing period."""

    def draw(ax: Axes, row: xr.Dataset) -> None:
        x, v = row["poincare_displacement"].values, row["poincare_velocity"].values
        kept = np.isfinite(x) & np.isfinite(v)
        if not kept.any():
            write_centred(ax, "No values")
            return
        draw_points(ax, x[kept], v[kept])
        draw_walls(ax, float(x[kept].min()), float(x[kept].max()), walls_of(row))

    labels = dataset["poincare_displacement"], dataset["poincare_velocity"]
    return draw_rows(dataset, chosen_visits(dataset), draw, labels)


def draw_spectra(dataset: xr.Dataset, show: Collection[str] = ()) -> Figure:
    """Draw the harmonic amplitudes of a row of each law over multiples of the forcing frequency."""
    name = spectrum_name(show)
    labels = dataset["harmonic"], dataset[f"{name}_amplitude"]
    rows = spectrum_rows(dataset, show)
    return draw_rows(
        dataset,
        rows,
        lambda ax, row: draw_spectrum(ax, row, name),
        labels,
        lambda: spectrum_handles(dataset),
    )


def spectrum_name(show: Collection[str]) -> str:
    """Return the quantity of a spectrum: displacement, unless the velocity alone is to be shown."""
    names = {name.partition("_")[0] for name in show if name.endswith("_amplitude")}
    return "velocity" if names == {"velocity"} else "displacement"


def rows_title(rows: Rows, one: str, several: str) -> str:
    """Return how many rows a picture shows, and of how many laws of motion; empty of none."""
    laws = len({law for _, law in rows})
    if not rows:
        return ""
    if len(rows) == laws:
        what = one if laws == 1 else several
        return f"{what} of {amount_text(laws, 'law of motion', 'laws of motion')}"
    return f"{several} of {count(len(rows), 'aperiodic row')}"


def describe_rows(dataset: xr.Dataset, what: str, rows: Rows) -> str:
    """Return the caption of pictures of single rows: what is drawn, at which parameters."""
    dims = [str(name) for name in dataset["regime"].dims]
    found: dict[str, list[str]] = {}
    for row, law in rows:
        place = ", ".join(plain_value(row[name]) for name in dims)
        known = found.setdefault(law.words, [])
        known.append(place.partition(" = ")[2] or place if known and len(dims) == 1 else place)
    places = "; ".join(f"{words} at {series(at)}" for words, at in found.items())
    return sentences(what, f"Rows drawn: {places}" if places else "")


PORTRAIT_TEXT = (
    "Velocity against displacement over the orbit of one row of each law of motion; grey: beyond the supports; "
    "dotted: jumps of the velocity at impacts"
)
SECTION_TEXT = "States of single rows at the section, once per forcing period"
SPECTRUM_TEXT = "Amplitudes of the harmonics of one row of each law of motion"


def showing_rows(options: SweepFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the quantities to show that have one value for each row, those of maps, as a keyword."""
    return {"show": tuple(n for n in showing(options, others)["show"] if n not in POINTS)}


def curve_options(options: SweepFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_sweep` and `describe_sweep`; raises KeyError for an unknown backbone."""
    options = options or SweepFigure()
    if options.backbone is not None and options.backbone not in others:
        known = ", ".join(sorted(others)) or "none"
        raise KeyError(
            f"figure.backbone: must be a scene of the study ({known}), got {options.backbone!r}"
        )
    backbone = None if options.backbone is None else others[options.backbone]
    return {**showing_rows(options, others), "backbone": backbone}


def draw_energies(dataset: xr.Dataset, show: Collection[str]) -> Figure:
    """Draw the energies of a sweep: curves or, of more lines than can be told apart, maps."""
    return (draw_quantity_maps if is_map(dataset) else draw_sweep)(dataset, show)


def describe_energies(dataset: xr.Dataset, show: Collection[str]) -> str:
    """Return the caption of the energies."""
    return (describe_quantities if is_map(dataset) else describe_sweep)(dataset, show)


PICTURES = (
    Picture("map", draw_regime_map, describe_map, is_map, titled=map_title),
    Picture("curves", draw_sweep, describe_sweep, keywords=curve_options, titled=sweep_title),
    Picture(
        "quantities",
        draw_quantity_maps,
        describe_quantities,
        lambda data: len(swept(data)) > 1,
        showing_rows,
        quantities_title,
    ),
    PROOFS,
    BIFURCATION,
    Picture(
        "section",
        draw_sections,
        lambda dataset: describe_rows(dataset, SECTION_TEXT, chosen_visits(dataset)),
        lambda dataset: "poincare_displacement" in dataset,
        titled=lambda dataset: rows_title(chosen_visits(dataset), "Section", "Sections"),
    ),
    Picture(
        "portrait",
        draw_portraits,
        lambda dataset: describe_rows(dataset, PORTRAIT_TEXT, portrait_rows(dataset)),
        lambda dataset: "phase" in dataset.dims,
        titled=lambda dataset: rows_title(
            portrait_rows(dataset), "Phase portrait", "Phase portraits"
        ),
    ),
    Picture(
        "spectrum",
        draw_spectra,
        lambda dataset, show: describe_rows(dataset, SPECTRUM_TEXT, spectrum_rows(dataset, show)),
        lambda dataset: "displacement_amplitude" in dataset,
        showing,
        lambda dataset, show: rows_title(spectrum_rows(dataset, show), "Spectrum", "Spectra"),
    ),
    Picture(
        "energy",
        draw_energies,
        describe_energies,
        lambda dataset: "energy_input" in dataset,
        lambda options, others: {"show": ENERGY_SHOW},
        energy_title,
    ),
)
