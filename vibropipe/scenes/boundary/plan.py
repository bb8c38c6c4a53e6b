"""Cost of a boundary scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Estimate, Sampler, Work, stored_name, stored_values

if TYPE_CHECKING:
    from vibropipe.scenes.boundary.keys import BoundaryScene

# Curves of a kind, points of a curve, and the seconds and bytes of a point, as usual.
USUAL_CURVES, USUAL_POINTS, SECONDS_PER_POINT, POINT_BYTES = 4, 300, 1e-3, 120

# Lines of the samples.
FEW_LINES = 2, 6


def plan(scene: BoundaryScene) -> Work:
    """Return the work of curves of the usual number and length, which are not known before."""
    points = len(scene.of) * USUAL_CURVES * USUAL_POINTS
    return Work(
        size=" x ".join(_range_text(scene, str(name), ends) for name, ends in scene.over.items()),
        rows=scene.row_count,
        method="exact",
        outputs=(),
        seconds=points * SECONDS_PER_POINT,
        bytes=HEAD_BYTES + points * POINT_BYTES,
    )


def _range_text(scene: BoundaryScene, name: str, ends: Sequence[float]) -> str:
    (first, last), unit = stored_values(scene, name, ends)
    return f"{stored_name(scene, name)} {first} to {last}{unit}"


def estimate(scene: BoundaryScene, sampler: Sampler) -> Estimate:
    """Estimate a scene by the curves that are found on few lines: seconds and bytes grow with the lines."""
    few, more = FEW_LINES
    if scene.lines <= more:
        seconds, load = sampler.warm(scene, scene.kind)
        return Estimate(seconds, load, sampler.bytes, False, plan(scene).method)
    seconds, load = sampler.warm(scene.model_copy(update={"lines": few}), scene.kind)
    size = sampler.bytes
    rate = max(0.0, sampler.solved(scene.model_copy(update={"lines": more})) - seconds)
    lines = (scene.lines - few) / (more - few)
    size += round(max(0, sampler.bytes - size) * lines)
    return Estimate(seconds + rate * lines, load, size, False, plan(scene).method)
