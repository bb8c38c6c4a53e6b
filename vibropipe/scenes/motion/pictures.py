"""Pictures of a motion."""

from vibropipe.figures.text import clock
from vibropipe.scenes.kind import Picture, only_picture
from vibropipe.scenes.motion.balance import (
    describe_energy,
    describe_spectra,
    draw_energy,
    draw_spectra,
    fits_energy,
    fits_spectrum,
)
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import draw_motion
from vibropipe.scenes.motion.phase_plane import (
    describe_portrait,
    describe_section,
    draw_phase_portrait,
    draw_section,
    fits_section,
)

PICTURES = (
    Picture(
        "panels",
        lambda dataset: bool(dataset.sizes.get(clock(dataset))),
        lambda dataset, options, _: draw_motion(
            dataset, (options or MotionFigure()).show, (options or MotionFigure()).periods
        ),
        lambda dataset, options, _: describe_motion(dataset, (options or MotionFigure()).show),
    ),
    Picture(
        "impacts",
        lambda dataset: True,
        lambda dataset, options, _: draw_impacts_only(dataset),
        lambda dataset, options, _: describe_impacts(dataset),
    ),
    Picture(
        "portrait",
        lambda dataset: bool(dataset.sizes.get(clock(dataset))),
        lambda dataset, options, _: draw_phase_portrait(
            dataset, (options or MotionFigure()).periods
        ),
        lambda dataset, options, _: describe_portrait(dataset),
    ),
    only_picture("section", draw_section, describe_section, fits_section),
    only_picture("spectrum", draw_spectra, describe_spectra, fits_spectrum),
    only_picture("energy", draw_energy, describe_energy, fits_energy),
)
