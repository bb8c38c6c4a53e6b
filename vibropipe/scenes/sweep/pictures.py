"""Pictures of a sweep."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.kind import Picture, showing
from vibropipe.scenes.sweep.bifurcation import (
    bifurcation_title,
    describe_bifurcation,
    draw_bifurcation,
    fits_bifurcation,
)
from vibropipe.scenes.sweep.captions import (
    describe_map,
    describe_quantities,
    describe_sweep,
    energy_title,
    map_title,
    quantities_title,
    sweep_title,
)
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.figure_keys import POINTS, SweepFigure
from vibropipe.scenes.sweep.maps import draw_quantity_maps, draw_regime_map
from vibropipe.scenes.sweep.orbit_pictures import (
    chosen_visits,
    describe_rows,
    draw_portraits,
    draw_sections,
    draw_spectra,
    portrait_rows,
    rows_title,
    spectrum_rows,
)
from vibropipe.scenes.sweep.quantities import ENERGY_SHOW, is_map, swept

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
    Picture(
        "bifurcation",
        draw_bifurcation,
        describe_bifurcation,
        fits_bifurcation,
        showing,
        bifurcation_title,
    ),
    Picture(
        "section",
        draw_sections,
        lambda dataset: describe_rows(dataset, SECTION_TEXT, chosen_visits(dataset)),
        lambda dataset: "poincare_displacement" in dataset,
        titled=lambda dataset: rows_title(chosen_visits(dataset), "Sections"),
    ),
    Picture(
        "portrait",
        draw_portraits,
        lambda dataset: describe_rows(dataset, PORTRAIT_TEXT, portrait_rows(dataset)),
        lambda dataset: "phase" in dataset.dims,
        titled=lambda dataset: rows_title(portrait_rows(dataset), "Phase portraits"),
    ),
    Picture(
        "spectrum",
        draw_spectra,
        lambda dataset, show: describe_rows(dataset, SPECTRUM_TEXT, spectrum_rows(dataset, show)),
        lambda dataset: "displacement_amplitude" in dataset,
        showing,
        lambda dataset, show: rows_title(spectrum_rows(dataset, show), "Spectra"),
    ),
    Picture(
        "energy",
        draw_sweep,
        describe_sweep,
        lambda dataset: "energy_input" in dataset,
        lambda options, others: {"show": ENERGY_SHOW},
        energy_title,
    ),
)
