"""Pictures of a motion."""

from vibropipe.scenes.kind import Picture
from vibropipe.scenes.motion.captions import describe_impacts, describe_motion
from vibropipe.scenes.motion.impacts import draw_impacts_only
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import draw_motion

PICTURES = (
    Picture(
        "panels",
        lambda dataset: bool(dataset.sizes.get("tau")),
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
)
