"""Cost of an accuracy scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Work
from vibropipe.words.measurements import PEER_METHODS
from vibropipe.words.wording import count

if TYPE_CHECKING:
    from vibropipe.scenes.accuracy.keys import AccuracyScene

# Seconds per run of an own method, and of another package, whether or not it is installed.
SECONDS_PER_RUN, SECONDS_PER_PEER_RUN = 0.05, 0.25
BYTES_PER_RUN = 89


def plan(scene: AccuracyScene) -> Work:
    """Return the work of an accuracy scene; runs of other packages take longer."""
    peers = len(scene.motions) * sum(
        len(scene.settings(method)) for method in scene.methods if method in PEER_METHODS
    )
    return Work(
        size=count(len(scene.motions), "motion"),
        rows=scene.row_count,
        method=", ".join(scene.methods),
        outputs=(),
        seconds=(scene.row_count - peers) * SECONDS_PER_RUN + peers * SECONDS_PER_PEER_RUN,
        bytes=HEAD_BYTES + scene.row_count * BYTES_PER_RUN,
    )
