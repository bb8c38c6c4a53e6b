"""Cost of a branch scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import (
    HEAD_BYTES,
    Work,
    slowness,
    steady_bytes,
    stored_name,
    stored_values,
)
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    from vibropipe.scenes.branch.keys import BranchScene

# Points of a branch that its steps usually need, and seconds per point.
USUAL_POINTS, SECONDS_PER_POINT = 400, 1e-4


def plan(scene: BranchScene) -> Work:
    """Return the work of branches of the usual length; how many follow from their bifurcations is not known before."""
    ends, at = len(scene.ends.to), 0 if scene.at is None else scene.at.size
    points = scene.row_count * (ends * USUAL_POINTS + at) * (1 + len(scene.switch))
    return Work(
        size=_size_text(scene),
        rows=scene.row_count,
        method="exact",
        outputs=OF_STEADY_STATE,
        seconds=points * SECONDS_PER_POINT * slowness(scene),
        bytes=HEAD_BYTES + points * steady_bytes(OF_STEADY_STATE, scene.harmonics),
    )


def _size_text(scene: BranchScene) -> str:
    """Write how far branches are followed and at how many values of a further parameter."""
    name = scene.followed
    (begin, *ends), unit = stored_values(scene, name, [scene.ends.begin, *scene.ends.to])
    swept = [f"{grid.size} {stored_name(scene, str(other))}" for other, grid in scene.over.items()]
    followed = f"{stored_name(scene, name)} from {begin} to {', '.join(ends)}{unit}"
    return ", ".join([followed, *swept])
