"""Curves of bifurcations in two parameters."""

from vibropipe.scenes.boundary.keys import CHECKS, BoundaryScene, check_map
from vibropipe.scenes.kind import Kind

KIND = Kind(
    __name__,
    BoundaryScene,
    CHECKS,
    unit="curves",
    check_among=check_map,
    holds=lambda data: "boundary" in data.attrs,
)
