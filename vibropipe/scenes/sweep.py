"""A sweep of a study: its rows as a dataset, or as a file that is written while they are solved."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import xarray as xr

from vibropipe.jobs.progress import Progress
from vibropipe.jobs.sharding import block_rows, row_range
from vibropipe.scenes.motion import exciter_of
from vibropipe.solve.sweep import assemble, solve_blocks
from vibropipe.store import write_grid, write_rows
from vibropipe.study import SweepScene, scene_effects

Shard = tuple[int, int] | None


def store_sweep(
    scene: SweepScene,
    path: Path,
    attrs: Mapping[str, Any],
    shard: Shard = None,
    progress: Progress | None = None,
) -> None:
    """Solve a sweep into the file `path` on its grid, or shard I of N over `row`, with these attributes.

    Memory holds a block of rows, however many there are.
    """
    start, stop = _rows_of(scene, shard)
    with closing(sweep_blocks(scene, start, stop, block_rows(scene), progress)) as solved:
        blocks = (block.assign_attrs({**attrs, **block.attrs}) for block in solved)
        if shard is not None:
            write_rows(blocks, path, stop - start)
        else:
            followed = scene.follow_pair()
            write_grid(blocks, path, scene.over_arrays(), followed[0] if followed else None)


def solve_sweep(
    scene: SweepScene, shard: Shard = None, progress: Progress | None = None
) -> xr.Dataset:
    """Solve all rows of a sweep on its grid, or the rows of shard I of N over `row`, in memory."""
    rows = solve_part(scene, *_rows_of(scene, shard), progress)
    if shard is not None:
        return rows
    return assemble([rows], scene.over_arrays(), scene.follow_pair())


def solve_part(
    scene: SweepScene, start: int, stop: int, progress: Progress | None = None
) -> xr.Dataset:
    """Solve the rows [start, stop) of a sweep, over `row`; cuts fall between chains."""
    (rows,) = sweep_blocks(scene, start, stop, stop - start, progress)
    return rows


def _rows_of(scene: SweepScene, shard: Shard) -> tuple[int, int]:
    return (0, scene.row_count) if shard is None else row_range(scene, *shard)


def sweep_blocks(
    scene: SweepScene, start: int, stop: int, size: int, progress: Progress | None = None
) -> Generator[xr.Dataset]:
    """Solve the rows [start, stop) of a sweep in blocks over `row` of at least `size` rows."""
    told: Callable[[int], None] | None = None
    if progress is not None:

        def told(done: int) -> None:
            progress(done, stop - start)

    return solve_blocks(
        exciter_of(scene),
        scene.over_arrays(),
        start,
        stop,
        size,
        x0=scene.start.x0,
        v0=scene.start.v0,
        harmonics=scene.harmonics,
        follow=scene.follow_pair(),
        outputs=tuple(scene.outputs),
        progress=told,
        accuracy=scene.solver.arguments().get("accuracy"),
        effects=scene_effects(scene),
        patience=scene.patience,
    )
