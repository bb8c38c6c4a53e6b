"""A sweep cut into shards, solved by a job each and joined, and shards into blocks that fit in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibropipe.scenes.rows import row_grid, rows_of_shard, stored_grid
from vibropipe.scenes.sweep.keys import block_rows
from vibropipe.scenes.sweep.solve import solve_in_blocks
from vibropipe.store import join as join_rows
from vibropipe.store import write_grid, write_rows

if TYPE_CHECKING:
    from vibropipe.scenes.sweep.keys import SweepScene
    from vibropipe.words.progress import Progress


def row_range(scene: SweepScene, shard: int, shards: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1.

    Raises
    ------
    PlanError
        If the shard does not exist, or there are more shards than chains of rows.
    """
    return rows_of_shard(scene, shard, shards, row_grid(scene).chains)


def store(
    scene: SweepScene,
    path: Path,
    attrs: Mapping[str, Any],
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> None:
    """Solve a sweep into a file, on its grid, or shard I of N over `row`; memory holds one block of rows.

    Parameters
    ----------
    scene : SweepScene
        The sweep.
    path : Path
        File to write.
    attrs : mapping
        Attributes of the dataset.
    shard : (int, int), optional
        Shard I of N, counted from 1; None solves all rows.
    progress : callable, optional
        Called as `progress(done, total)` in rows.
    """
    start, stop = (0, scene.row_count) if shard is None else row_range(scene, *shard)
    with closing(solve_in_blocks(scene, start, stop, block_rows(scene), progress)) as solved:
        blocks = (block.assign_attrs({**attrs, **block.attrs}) for block in solved)
        if shard is not None:
            write_rows(blocks, path, stop - start)
        else:
            write_grid(blocks, path, stored_grid(scene))


def join(
    scene: SweepScene,
    shards: Sequence[Path],
    path: Path,
    attrs: Mapping[str, Any],
    progress: Progress | None = None,
) -> None:
    """Join all shards of a sweep, in any order, into one file on its grid.

    Raises
    ------
    StoreError
        If the shards are not those of this scene.
    """
    join_rows(shards, path, stored_grid(scene), dict(attrs), progress)
