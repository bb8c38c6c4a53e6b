"""Work-precision data: error and time of several methods on several motions."""

from vibropipe.scenes.accuracy.keys import CHECKS, AccuracyScene
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    AccuracyScene,
    CHECKS,
    unit="runs",
    is_timed=True,
    packages=("scipy", "heyoka", "solve_nivp"),
)
