"""Cost of a design scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import HEAD_BYTES, Work, slowness, steady_bytes, stored_name
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    from vibropipe.scenes.design.keys import DesignScene

# Seconds of a sample, of a search from one, of the margin of a design, of its scattered parts; searches of a front and
# samples of the sweeps that it is sought by.
SAMPLE_SECONDS, SEARCH_SECONDS, DESIGN_SECONDS, YIELD_SECONDS = 1e-4, 0.15, 0.1, 0.3
SEARCHES, FRONT_SEARCHES, FRONT_SAMPLES = 12, 20, 35_000


def plan(scene: DesignScene) -> Work:
    """Return the work of a search of usual length, which is not known before."""
    is_front = len(scene.minimise) == 2
    searches = SEARCHES + is_front * FRONT_SEARCHES
    seconds = (scene.samples + is_front * FRONT_SAMPLES) * SAMPLE_SECONDS
    seconds += searches * SEARCH_SECONDS * (1 + len(scene.minimise))
    if scene.tolerance or scene.allow:
        # Moving inside bounds takes another search for each.
        seconds += SEARCHES * (YIELD_SECONDS + SEARCH_SECONDS)
    names = ", ".join(stored_name(scene, str(name)) for name in scene.vary)
    return Work(
        size=f"{scene.samples} samples over {names}",
        rows=scene.row_count,
        method="exact",
        outputs=OF_STEADY_STATE,
        seconds=(seconds + scene.designs * DESIGN_SECONDS) * slowness(scene),
        bytes=HEAD_BYTES + scene.designs * steady_bytes(OF_STEADY_STATE, 3),
    )
