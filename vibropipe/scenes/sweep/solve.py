"""Solution of sweep scenes: the steady state of each row."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.scenes.certificate import with_row_proofs
from vibropipe.solve.physical import stored
from vibropipe.solve.sweep.blocks import LIMITS, assemble, solve_blocks

if TYPE_CHECKING:
    import numpy as np

    from vibropipe.scenes.keys.proofs import Prove
    from vibropipe.scenes.sweep.keys import SweepScene
    from vibropipe.words.progress import Progress


def solve(scene: SweepScene, progress: Progress | None = None) -> xr.Dataset:
    """Solve all rows of a sweep in memory and return them on its grid."""
    (rows,) = _solve_plain(scene, range(scene.row_count), scene.row_count, progress)
    return stored(assemble([rows], scene.row_grid()), scene.mass_and_stiffness)


def solve_rows(
    scene: SweepScene, start: int, stop: int, progress: Progress | None = None
) -> xr.Dataset:
    """Solve the rows [start, stop) of a sweep, over `row`; both ends must lie between chains."""
    (rows,) = solve_in_blocks(scene, range(start, stop), stop - start, progress)
    return rows


def solve_in_blocks(
    scene: SweepScene, rows: range | np.ndarray, size: int, progress: Progress | None = None
) -> Generator[xr.Dataset]:
    """Solve rows of a sweep, as of `solve_blocks`, in blocks over `row` of at least `size` rows."""
    with closing(_solve_plain(scene, rows, size, progress)) as blocks:
        for block in blocks:
            yield stored(block, scene.mass_and_stiffness)


def _solve_plain(
    scene: SweepScene, rows: range | np.ndarray, size: int, progress: Progress | None
) -> Generator[xr.Dataset]:
    """Solve rows without units, and prove them if the scene asks for it."""
    blocks = solve_blocks(
        scene.row_grid(),
        rows,
        size,
        start=(scene.start.x0, scene.start.v0),
        harmonics=scene.harmonics,
        outputs=tuple(scene.outputs),
        progress=progress,
        accuracy=scene.solver.arguments().get("accuracy"),
        effects=scene.called_effects(),
        limits=LIMITS._replace(patience=scene.patience),
    )
    return proved(blocks, scene.prove) if scene.prove else blocks


def proved(blocks: Generator[xr.Dataset], prove: Prove) -> Generator[xr.Dataset]:
    """Add to each block of rows whether their orbits are proved."""
    with closing(blocks):
        for block in blocks:
            yield with_row_proofs(block, prove)
