"""One motion from a given start, and its steady state."""

from vibropipe.scenes.kind import Kind
from vibropipe.scenes.motion.keys import CHECKS, MotionScene, check_motions_together

KIND = Kind(
    __name__,
    MotionScene,
    CHECKS,
    unit="periods",
    holds=lambda data: "displacement_end" in data,
    check_among=check_motions_together,
)
