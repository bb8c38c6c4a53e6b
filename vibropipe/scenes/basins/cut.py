"""Basins cut into shards of starts: each assigns its own to attractors that scattered starts find, a join completes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibropipe.scenes.basins.keys import most_shards
from vibropipe.scenes.basins.solve import rows_of, solve, solve_rows
from vibropipe.scenes.rows import rows_of_shard, stored_grid, with_origin
from vibropipe.solve.physical import stored
from vibropipe.store import read_shards, save, write_rows

if TYPE_CHECKING:
    from vibropipe.scenes.basins.keys import BasinsScene
    from vibropipe.words.progress import Progress


def row_range(scene: BasinsScene, shard: int, shards: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1; PlanError if there is none."""
    return rows_of_shard(scene, shard, shards, most_shards(scene))


def store(
    scene: BasinsScene,
    path: Path,
    attrs: Mapping[str, Any],
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> None:
    """Solve a scene into a file, or assign the starts of shard I of N.

    shard : shard I of N, counted from 1; None solves the scene
    progress : called as `progress(done, total)` in starts
    """
    if shard is None:
        save(with_origin(solve(scene, progress), scene, attrs), path)
        return
    start, stop = row_range(scene, *shard)
    rows = stored(rows_of(scene).shard(start, stop, progress), scene.mass_and_stiffness)
    write_rows([with_origin(rows, scene, attrs)], path, stop - start)


def join(
    scene: BasinsScene,
    shards: Sequence[Path],
    path: Path,
    attrs: Mapping[str, Any],
    progress: Progress | None = None,
) -> None:
    """Complete the basins from all shards, in any order; the data are those of one job, to the last bit.

    Raises StoreError if the shards are not those of this scene.
    """
    values, common = read_shards(shards, stored_grid(scene), attrs)
    assigned = values["attractor_assigned"], values["periods_to_attractor"]
    save(with_origin(solve_rows(scene, progress, assigned), scene, {**common, **attrs}), path)
