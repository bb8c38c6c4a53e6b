"""Designs: parameters that give a wanted law of motion, and how tight they must be made."""

from vibropipe.scenes.design.keys import CHECKS, DesignScene
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    DesignScene,
    CHECKS,
    unit="steps",
    packages=("scipy",),
    holds=lambda data: "law_change_share" in data or "design_result" in data,
)
