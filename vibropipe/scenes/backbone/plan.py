"""Cost of a backbone scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Estimate, Sampler, Work, grid_size, thinned

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


def estimate(scene: BackboneScene, sampler: Sampler) -> Estimate:
    """Estimate a backbone by solving it."""
    # For eq. (10), some values must have impacts on both supports.
    n_values = 2 if scene.over_amplitude else 50
    grids = {name: thinned(grid.array(), n_values) for name, grid in scene.grids().items()}
    form = "amplitude" if scene.over_amplitude else "period"
    _, load = sampler.warm(scene.model_copy(update=grids), f"{scene.kind} over {form}")
    core = sampler.solved(scene)
    return Estimate(core, load, sampler.bytes, False, plan(scene).method)
