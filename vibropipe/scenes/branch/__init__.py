"""Orbits followed along a parameter, stable or not."""

from vibropipe.scenes.branch.checks import CHECKS
from vibropipe.scenes.branch.keys import BranchScene
from vibropipe.scenes.keys.checks import check_backbone
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    BranchScene,
    CHECKS,
    unit="branches",
    check_among=check_backbone,
    holds=lambda data: "branch_id" in data,
)
