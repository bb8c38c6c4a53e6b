"""Pictures of a motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.kind import Picture
from vibropipe.scenes.motion.balance import (
    describe_energy,
    describe_spectra,
    draw_energy,
    draw_spectra,
    fits_energy,
    fits_spectrum,
)
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion
from vibropipe.scenes.motion.impacts import draw_impacts_only, is_sampled
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import draw_motion
from vibropipe.scenes.motion.phase_plane import (
    describe_portrait,
    describe_section,
    draw_phase_portrait,
    draw_section,
    fits_section,
)


def keywords(options: MotionFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_motion`."""
    options = options or MotionFigure()
    return {"show": options.show, "periods": options.periods}


PICTURES = (
    Picture(
        "panels",
        draw_motion,
        lambda dataset, show, periods: describe_motion(dataset, show, periods),
        is_sampled,
        keywords,
    ),
    Picture("impacts", draw_impacts_only, describe_impacts),
    Picture(
        "portrait",
        lambda dataset, show, periods: draw_phase_portrait(dataset, periods),
        lambda dataset, show, periods: describe_portrait(dataset),
        is_sampled,
        keywords,
    ),
    Picture("section", draw_section, describe_section, fits_section),
    Picture("spectrum", draw_spectra, describe_spectra, fits_spectrum),
    Picture("energy", draw_energy, describe_energy, fits_energy),
)
