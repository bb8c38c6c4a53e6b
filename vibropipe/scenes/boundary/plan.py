"""Cost of a boundary scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, stored_name, stored_values

if TYPE_CHECKING:
    from vibropipe.scenes.boundary.keys import BoundaryScene

# Curves of a kind, points of a curve, and the seconds and bytes of a point, as usual.
USUAL_CURVES, USUAL_POINTS, SECONDS_PER_POINT, POINT_BYTES = 4, 300, 2e-4, 120


def plan(scene: BoundaryScene) -> Work:
    """Return the work of curves of the usual number and length, which are not known before."""
    points = len(scene.of) * USUAL_CURVES * USUAL_POINTS
    return Work(
        size=" x ".join(_range_text(scene, str(name), ends) for name, ends in scene.over.items()),
        rows=scene.row_count,
        method="exact",
        outputs=(),
        seconds=points * SECONDS_PER_POINT * slowness(scene),
        bytes=HEAD_BYTES + points * POINT_BYTES,
    )


def _range_text(scene: BoundaryScene, name: str, ends: Sequence[float]) -> str:
    (first, last), unit = stored_values(scene, name, ends)
    return f"{stored_name(scene, name)} {first} to {last}{unit}"
