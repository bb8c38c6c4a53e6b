"""Solution of basins scenes: the attractors, and that of each start."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.scenes.certificate import with_knock_proofs
from vibropipe.solve.basins.basin_rows import Assigned, BasinRows
from vibropipe.solve.basins.basins import solve_basins
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.basins.keys import BasinsScene
    from vibropipe.words.progress import Progress


def solve(scene: BasinsScene, progress: Progress | None = None) -> xr.Dataset:
    """Find the attractors of a scene and the one that each start settles on."""
    return solve_rows(scene, progress, None)


def solve_rows(
    scene: BasinsScene, progress: Progress | None, assigned: Assigned | None
) -> xr.Dataset:
    """Solve a scene; `assigned` is what shards know of its starts."""
    dataset = solve_basins(rows_of(scene), scene.harmonics, progress, assigned)
    dataset = with_knock_proofs(dataset) if scene.prove else dataset
    return stored(dataset, scene.mass_and_stiffness)


def rows_of(scene: BasinsScene) -> BasinRows:
    """Return the starts of a scene."""
    exciter = Exciter(**scene.resolved_exciter())
    return BasinRows(exciter, scene.row_grid(), scene.phase % 1.0, scene.starts)
