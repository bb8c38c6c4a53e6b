"""Cost of an effects scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Work
from vibropipe.words.wording import count

if TYPE_CHECKING:
    from vibropipe.scenes.effects.keys import EffectsScene

SECONDS_PER_TRIAL, SECONDS_PER_ROUND = 0.1, 0.012
TRIAL_BYTES = 400


def plan(scene: EffectsScene) -> Work:
    """Return the work of an effects scene, from its motions and timing rounds."""
    return Work(
        size=count(scene.row_count, "motion"),
        rows=scene.row_count,
        method="exact",
        outputs=(),
        seconds=scene.row_count * (SECONDS_PER_TRIAL + scene.repeats * SECONDS_PER_ROUND),
        bytes=HEAD_BYTES + scene.row_count * TRIAL_BYTES,
    )
