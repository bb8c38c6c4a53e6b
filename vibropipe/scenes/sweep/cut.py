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

from vibropipe.scenes.rows import Recomputed, rows_of_shard, sample_indices, stored_grid
from vibropipe.scenes.sweep.keys import SweepScene, block_rows
from vibropipe.scenes.sweep.solve import solve_in_blocks, solve_rows
from vibropipe.solve.sweep.blocks import effects_of_grid
from vibropipe.store import (
    Difference,
    EarlierRows,
    NotTakenError,
    compare_rows,
    write_grid,
    write_rows,
)
from vibropipe.store import join as join_rows
from vibropipe.store.encoding import encode
from vibropipe.store.shards import ROWS_AT_ONCE
from vibropipe.words.wording import part_text

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
    earlier: EarlierRows | None = None,
) -> None:
    """Solve a sweep into a file, on its grid, or shard I of N over `row`; memory holds one block of rows.

    shard : shard I of N, counted from 1; None solves all rows
    progress : called as `progress(done, total)` in rows
    earlier : rows of it, as of `earlier_rows`, that are taken and not solved
    Raises NotTakenError if they cannot be read; nothing is written then.
    """
    start, stop = _rows(scene, shard)
    size = block_rows(scene)
    rows: range | np.ndarray = range(start, stop)
    if earlier is not None:
        rows = start + np.flatnonzero(earlier.rows < 0)
    with closing(solve_in_blocks(scene, rows, size, progress)) as solved:
        blocks: Any = (block.assign_attrs({**attrs, **block.attrs}) for block in solved)
        if earlier is not None:
            blocks = earlier.merge(map(encode, blocks), stored_grid(scene), start, size)
        if shard is not None:
            write_rows(blocks, path, stop - start)
        else:
            write_grid(blocks, path, stored_grid(scene))


def earlier_rows(
    scene: SweepScene, other: SweepScene, path: Path, shard: tuple[int, int] | None = None
) -> EarlierRows:
    """Return the rows of a sweep, or of shard I of N, that the dataset of another one has.

    other : the sweep from which the dataset was made, by this version of the program
    path : the dataset
    At least one row is not taken: how rows are stored is known from one that is solved. The two sweeps have the same
    `row_keys`. Raises NotTakenError if they differ in what the values of their grids call for.
    """
    grid, old = scene.row_grid(), other.row_grid()
    if _kernel(scene) != _kernel(other) or grid.of_restitution != old.of_restitution:
        raise NotTakenError(f"{path}: other effects are computed with the values of its grids now")
    start, stop = _rows(scene, shard)
    firsts = range(start, stop, ROWS_AT_ONCE)
    rows = np.concatenate([grid.rows_in(old, a, min(a + ROWS_AT_ONCE, stop)) for a in firsts])
    if rows.min() >= 0:
        rows[0] = -1
    return EarlierRows(path, old.shape, rows)


def _rows(scene: SweepScene, shard: tuple[int, int] | None) -> tuple[int, int]:
    return (0, scene.row_count) if shard is None else row_range(scene, *shard)


def _kernel(scene: SweepScene) -> tuple[Any, bool]:
    """Return what the kernel of a sweep is compiled for, which follows from all values of its grids."""
    start = scene.start.x0, scene.start.v0
    return effects_of_grid(scene.row_grid(), start, scene.called_effects())


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
        if any(item.where == "" for item in differences):
            break  # an attribute differs, and so in every row
    return Recomputed(part_text(len(chains) * length, grid.rows, "row"), differences)
