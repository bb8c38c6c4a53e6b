"""Cost of a backbone scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Work, grid_size

if TYPE_CHECKING:
    from vibropipe.scenes.backbone.keys import BackboneScene

SECONDS_PER_POINT = 20e-6


def plan(scene: BackboneScene) -> Work:
    """Return the work of a backbone, from its number of points."""
    each = 8 + 1 + 2 * 8 + 4 * 8 * scene.harmonics if scene.over_amplitude else 8
    return Work(
        size=grid_size(scene),
        rows=scene.row_count,
        method="exact",
        outputs=("harmonics",) if scene.over_amplitude else (),
        seconds=scene.row_count * SECONDS_PER_POINT,
        bytes=scene.row_count * each,
    )
