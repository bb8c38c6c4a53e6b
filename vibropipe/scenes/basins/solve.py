"""Solution of basins scenes: the attractors, and that of each start."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.basins import basins
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.basins.keys import BasinsScene
    from vibropipe.words.progress import Progress


def solve(scene: BasinsScene, progress: Progress | None = None) -> xr.Dataset:
    """Find the attractors of a scene and the one that each start settles on."""
    on_starts: Callable[[int], None] | None = None
    if progress is not None:

        def on_starts(done: int) -> None:
            progress(done, scene.row_count)

    grids = scene.over_arrays()
    dataset = basins(
        Exciter(**scene.resolved_exciter()),
        x0=grids.pop("x0"),
        v0=grids.pop("v0"),
        phase=scene.phase,
        harmonics=scene.harmonics,
        starts=scene.starts,
        progress=on_starts,
        over=grids or None,
    )
    return stored(dataset, scene.mass_and_stiffness)
