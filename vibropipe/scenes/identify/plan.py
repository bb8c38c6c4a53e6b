"""Cost of an identification scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, stored_name

if TYPE_CHECKING:
    from vibropipe.scenes.identify.keys import IdentifyScene

# Seconds of a row; sweeps of all samples that searches take as long as.
ROW_SECONDS, SWEEPS = 1e-4, 12
OUTPUTS = ("harmonics", "impacts", "stability")


def plan(scene: IdentifyScene) -> Work:
    """Return the work of a search of usual length, which is not known before."""
    names = ", ".join(stored_name(scene, str(name)) for name in scene.vary)
    return Work(
        size=f"{scene.points} measurements, {scene.samples} samples over {names}",
        rows=scene.row_count,
        method="exact",
        outputs=OUTPUTS,
        seconds=1.0 + SWEEPS * scene.row_count * ROW_SECONDS * slowness(scene),
        bytes=HEAD_BYTES + 16 * scene.points * len(scene.measured),
    )
