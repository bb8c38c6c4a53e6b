"""Solution of boundary scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.boundary import boundary
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.boundary.keys import BoundaryScene
    from vibropipe.words.progress import Progress


def solve(scene: BoundaryScene, progress: Progress | None = None) -> xr.Dataset:
    """Follow the boundaries of a scene in memory."""
    exciter = Exciter(**scene.resolved_exciter())
    dataset = boundary(exciter, sorted(scene.of), scene.along, scene.within, scene.lines)
    if progress is not None:
        progress(scene.row_count, scene.row_count)
    return stored(dataset, scene.mass_and_stiffness)
