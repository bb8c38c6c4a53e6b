"""A sweep cut into shards, solved by a job each and joined, and shards into blocks that fit in memory.

To verify it, a sample of its rows is recomputed, whole chains if a parameter is followed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.scenes.rows import Recomputed, part_text, rows_of_shard, sample_indices, stored_grid
from vibropipe.scenes.sweep.keys import SweepScene, block_rows
from vibropipe.scenes.sweep.solve import solve_in_blocks, solve_rows
from vibropipe.store import Difference, compare_rows, write_grid, write_rows
from vibropipe.store import join as join_rows

if TYPE_CHECKING:
    from vibropipe.words.progress import Progress


def row_range(scene: SweepScene, shard: int, shards: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1.

    Raises PlanError if the shard does not exist, or there are more shards than chains of rows.
    """
    return rows_of_shard(scene, shard, shards, scene.row_grid().chains)


def store(
    scene: SweepScene,
    path: Path,
    attrs: Mapping[str, Any],
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> None:
    """Solve a sweep into a file, on its grid, or shard I of N over `row`; memory holds one block of rows.

    shard : shard I of N, counted from 1; None solves all rows
    progress : called as `progress(done, total)` in rows
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

    Raises StoreError if the shards are not those of this scene.
    """
    join_rows(shards, path, stored_grid(scene), dict(attrs), progress)


def recompute(
    path: Path, scene: SweepScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Recompute at least `rows` rows, or all if there are fewer."""
    grid = scene.row_grid()
    length = grid.chain_length
    chains = sample_indices(grid.chains, math.ceil(rows / length), generator)
    as_stored = stored_grid(scene)
    differences: list[Difference] = []
    for chain in chains:
        shard = solve_rows(scene, chain * length, (chain + 1) * length)
        differences += compare_rows(path, shard, as_stored)
        if any(
            item.where == "" for item in differences
        ):  # An attribute differs, and so in every row.
            break
    return Recomputed(part_text(len(chains) * length, grid.rows), differences)
