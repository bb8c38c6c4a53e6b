"""Pictures of a sweep."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.kind import Picture, shown
from vibropipe.scenes.sweep.bifurcation import (
    describe_bifurcation,
    draw_bifurcation,
    fits_bifurcation,
)
from vibropipe.scenes.sweep.captions import describe_map, describe_sweep
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.figure_keys import MAX_LINES, POINTS, SweepFigure
from vibropipe.scenes.sweep.orbit_pictures import (
    chosen_visits,
    describe_rows,
    draw_portraits,
    draw_sections,
    draw_spectra,
    portrait_rows,
    spectrum_rows,
)
from vibropipe.scenes.sweep.quantities import ENERGY_SHOW, axis_and_others
from vibropipe.scenes.sweep.regime_map import draw_regime_map

PORTRAIT_TEXT = (
    "Velocity against displacement over the orbit of one row of each law of motion; grey: beyond the supports; "
    "dotted: jumps of the velocity at impacts"
)
SECTION_TEXT = "States of single rows at the section, once per forcing period"
SPECTRUM_TEXT = "Amplitudes of the harmonics of one row of each law of motion"


def is_map(dataset: xr.Dataset) -> bool:
    """Return whether a sweep has more lines than can be distinguished."""
    _, others = axis_and_others(dataset)
    return any(dataset.sizes[name] > MAX_LINES for name in others)


def shown_of_rows(options: SweepFigure | None) -> tuple[str, ...]:
    """Return the quantities to show that have one value for each row: those of curves and maps."""
    return tuple(name for name in shown(options) if name not in POINTS)


def curve_options(options: SweepFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_sweep` and `describe_sweep`; raises KeyError for an unknown backbone."""
    options = options or SweepFigure()
    if options.backbone is not None and options.backbone not in others:
        known = ", ".join(sorted(others)) or "none"
        raise KeyError(
            f"figure.backbone: must be a scene of the study ({known}), got {options.backbone!r}"
        )
    backbone = None if options.backbone is None else others[options.backbone]
    return {"show": shown_of_rows(options), "backbone": backbone}


PICTURES = (
    Picture(
        "map",
        is_map,
        lambda dataset, options, others: draw_regime_map(dataset, shown_of_rows(options)),
        lambda dataset, options, others: describe_map(dataset, shown_of_rows(options)),
    ),
    Picture(
        "curves",
        lambda dataset: True,
        lambda dataset, options, others: draw_sweep(dataset, **curve_options(options, others)),
        lambda dataset, options, others: describe_sweep(dataset, **curve_options(options, others)),
    ),
    Picture(
        "bifurcation",
        fits_bifurcation,
        lambda dataset, options, others: draw_bifurcation(dataset, shown(options)),
        lambda dataset, options, others: describe_bifurcation(dataset, shown(options)),
    ),
    Picture(
        "section",
        lambda dataset: "poincare_displacement" in dataset,
        lambda dataset, options, others: draw_sections(dataset),
        lambda dataset, options, others: describe_rows(
            dataset, SECTION_TEXT, chosen_visits(dataset)
        ),
    ),
    Picture(
        "portrait",
        lambda dataset: "phase" in dataset.dims,
        lambda dataset, options, others: draw_portraits(dataset),
        lambda dataset, options, others: describe_rows(
            dataset, PORTRAIT_TEXT, portrait_rows(dataset)
        ),
    ),
    Picture(
        "spectrum",
        lambda dataset: "displacement_amplitude" in dataset,
        lambda dataset, options, others: draw_spectra(dataset, shown(options)),
        lambda dataset, options, others: describe_rows(
            dataset, SPECTRUM_TEXT, spectrum_rows(dataset, shown(options))
        ),
    ),
    Picture(
        "energy",
        lambda dataset: "energy_input" in dataset,
        lambda dataset, options, others: draw_sweep(dataset, ENERGY_SHOW),
        lambda dataset, options, others: describe_sweep(dataset, ENERGY_SHOW),
    ),
)
