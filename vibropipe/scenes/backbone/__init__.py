"""Free motion without force and losses, in closed form."""

from vibropipe.scenes.backbone.keys import CHECKS, BackboneScene, check_scenes_together
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    BackboneScene,
    CHECKS,
    unit="points",
    holds=lambda data: "eigenfrequency" in data or "velocity_over_l" in data,
    check_among=check_scenes_together,
)
