"""Coexisting motions, and which of them each start of a grid settles on."""

from vibropipe.scenes.basins.keys import CHECKS, BasinsScene, check_branches
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    BasinsScene,
    CHECKS,
    unit="starts",
    check_among=check_branches,
    can_be_cut=True,
    packages=("scipy",),
    holds=lambda data: "basin_share" in data,
)
