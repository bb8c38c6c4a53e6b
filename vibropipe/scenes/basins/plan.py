"""Cost of a basins scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Estimate, Sampler, Work, grid_size, steady_bytes, thinned
from vibropipe.words.outputs import OF_STEADY_STATE

if TYPE_CHECKING:
    from vibropipe.scenes.basins.keys import BasinsScene

# A start costs the transient, here some thirty forcing periods, and is stored in nine bytes.
SECONDS_PER_START, BYTES_PER_START = 3e-5, 9
# Seconds and bytes of attractors, beside the starts that look for them: of usual ones, with states at the section.
SEARCH_SECONDS, ATTRACTORS, SECTION_BYTES = 0.05, 3, 2 * 8 * 1024
# Values of each axis of a sample.
SAMPLE = 2, 64


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
        seconds=n_values * SEARCH_SECONDS + starts * SECONDS_PER_START,
        bytes=scene.row_count * BYTES_PER_START + n_values * ATTRACTORS * attractor,
        pieces=most_shards(scene),
        is_parallel=True,
    )


def most_shards(scene: BasinsScene) -> int:
    """Return the largest number of shards: each looks for attractors itself, and has as many starts of its own."""
    return max(1, scene.row_count // scene.starts)


def estimate(scene: BasinsScene, sampler: Sampler) -> Estimate:
    """Estimate a basins scene from starts spread over its grid."""
    small, larger = (_part(scene, n_values) for n_values in SAMPLE)
    again, load = sampler.warm(small, scene.kind)
    base = sampler.bytes
    elapsed = sampler.solved(larger)
    more = max(1, larger.row_count - small.row_count)
    remaining = scene.row_count - small.row_count
    seconds = again + max(0.0, elapsed - again) / more * remaining
    stored = base + (sampler.bytes - base) / more * remaining
    return Estimate(seconds, load, stored, True, plan(scene).method)


def _part(scene: BasinsScene, n_values: int) -> BasinsScene:
    """Return the scene on at most `n_values` values of each axis."""
    over = {name: thinned(grid.array(), n_values) for name, grid in scene.grids().items()}
    return scene.model_copy(update={"over": over})
