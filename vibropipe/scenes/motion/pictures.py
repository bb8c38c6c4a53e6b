"""Pictures of a motion."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.scenes.kind import Picture
from vibropipe.scenes.motion.balance import (
    describe_energy,
    describe_spectra,
    draw_energy,
    draw_spectra,
    energy_title,
    fits_energy,
    fits_spectrum,
    spectrum_title,
)
from vibropipe.scenes.motion.captions import (
    describe_impacts,
    describe_motion,
    describe_together,
    seen_text,
)
from vibropipe.scenes.motion.impacts import draw_impacts_only, is_sampled
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import draw_motion
from vibropipe.scenes.motion.phase_plane import (
    describe_portrait,
    describe_section,
    draw_phase_portrait,
    draw_section,
    fits_section,
    portrait_title,
    section_title,
)
from vibropipe.scenes.motion.together import draw_together


def keywords(options: MotionFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_motion`."""
    options = options or MotionFigure()
    together = {name: others[name] for name in options.together}
    names = ("show", "periods", "heads")
    return {name: getattr(options, name) for name in names} | {"together": together}


def own_name(dataset: xr.Dataset) -> str:
    """Return the name of the scene of a dataset, as its title has it after that of the study."""
    return str(dataset.attrs.get("title", "motion")).rpartition(": ")[2]


def draw_panels(
    dataset: xr.Dataset,
    show: Collection[str],
    periods: float | None,
    heads: Sequence[str],
    together: Mapping[str, xr.Dataset],
) -> Figure:
    """Draw one motion, or several on common axes."""
    if not together:
        return draw_motion(dataset, show, periods)
    names = [own_name(dataset).replace("_", " "), *(name.replace("_", " ") for name in together)]
    names[: len(heads)] = heads
    return draw_together([dataset, *together.values()], names, periods)


def describe_panels(
    dataset: xr.Dataset,
    show: Collection[str],
    periods: float | None,
    heads: Sequence[str],
    together: Mapping[str, xr.Dataset],
) -> str:
    """Return the caption of one motion, or of several on common axes."""
    if not together:
        return describe_motion(dataset, show, periods)
    return describe_together([dataset, *together.values()])


PICTURES = (
    Picture(
        "panels",
        draw_panels,
        describe_panels,
        is_sampled,
        keywords,
        lambda dataset, together, **others: "" if together else seen_text(dataset),
    ),
    Picture("impacts", draw_impacts_only, describe_impacts, titled=seen_text),
    Picture(
        "portrait",
        lambda dataset, periods, **others: draw_phase_portrait(dataset, periods),
        lambda dataset, **others: describe_portrait(dataset),
        is_sampled,
        keywords,
        lambda dataset, **others: portrait_title(dataset),
    ),
    Picture("section", draw_section, describe_section, fits_section, titled=section_title),
    Picture("spectrum", draw_spectra, describe_spectra, fits_spectrum, titled=spectrum_title),
    Picture("energy", draw_energy, describe_energy, fits_energy, titled=energy_title),
)
