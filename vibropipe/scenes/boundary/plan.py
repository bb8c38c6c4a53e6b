"""Cost of a boundary scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Estimate, Sampler, Work

if TYPE_CHECKING:
    from vibropipe.scenes.boundary.keys import BoundaryScene

# Curves of a kind, points of a curve, and the seconds and bytes of a point, as usual.
USUAL_CURVES, USUAL_POINTS, SECONDS_PER_POINT, POINT_BYTES = 4, 300, 1e-3, 120


def plan(scene: BoundaryScene) -> Work:
    """Return the work of curves of the usual number and length, which are not known before."""
    points = len(scene.of) * USUAL_CURVES * USUAL_POINTS
    size = " x ".join(f"{name} {a:g} to {b:g}" for name, (a, b) in scene.over.items())
    return Work(
        size=size,
        rows=scene.row_count,
        method="exact",
        outputs=(),
        seconds=points * SECONDS_PER_POINT,
        bytes=HEAD_BYTES + points * POINT_BYTES,
    )


def estimate(scene: BoundaryScene, sampler: Sampler) -> Estimate:
    """Estimate a scene by following its curves."""
    seconds, load = sampler.warm(scene, scene.kind)
    return Estimate(seconds, load, sampler.bytes, False, plan(scene).method)
