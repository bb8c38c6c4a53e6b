"""Cost of a basins scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Work, grid_size, slowness, steady_bytes
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    from vibropipe.scenes.basins.keys import BasinsScene

# A start costs the transient, here some thirty forcing periods, and is stored in nine bytes.
SECONDS_PER_START, BYTES_PER_START = 3e-5, 9
# Seconds and bytes of attractors, beside the starts that look for them: of usual ones, with states at the section.
SEARCH_SECONDS, ATTRACTORS, SECTION_BYTES = 0.05, 3, 2 * 8 * 1024


def plan(scene: BasinsScene) -> Work:
    """Return the work of a basins scene, from its number of starts."""
    attractor = steady_bytes(OF_STEADY_STATE, scene.harmonics) + SECTION_BYTES
    n_values = next((grid.size for name, grid in scene.grids().items() if name == scene.swept), 1)
    starts = scene.row_count + n_values * scene.starts
    return Work(
        size=grid_size(scene),
        rows=scene.row_count,
        method="exact",
        outputs=OF_STEADY_STATE,
        seconds=(n_values * SEARCH_SECONDS + starts * SECONDS_PER_START) * slowness(scene),
        bytes=scene.row_count * BYTES_PER_START + n_values * ATTRACTORS * attractor,
        pieces=most_shards(scene),
        is_parallel=True,
    )


def most_shards(scene: BasinsScene) -> int:
    """Return the largest number of shards: each looks for attractors itself, and has as many starts of its own."""
    return max(1, scene.row_count // scene.starts)
