"""One motion from a given start, and its steady state."""

from vibropipe.scenes.kind import Kind
from vibropipe.scenes.motion.keys import CHECKS, MotionScene

KIND = Kind(
    __name__, MotionScene, CHECKS, unit="periods", holds=lambda data: "displacement_end" in data
)
