"""Rows of a sweep computed again, each by itself; where a parameter is followed, whole chains."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vibropipe.scenes.recompute import Recomputed, part_text, sample_indices
from vibropipe.scenes.sweep.keys import SweepScene
from vibropipe.scenes.sweep.plan import sweep_grid
from vibropipe.scenes.sweep.solve import solve_rows
from vibropipe.store import Difference, compare_rows


def recompute(
    path: Path, scene: SweepScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Compute at least `rows` rows again, or all if there are fewer."""
    grid = sweep_grid(scene)
    length = grid.chain_length
    chains = sample_indices(grid.chains, math.ceil(rows / length), generator)
    differences: list[Difference] = []
    for chain in chains:
        shard = solve_rows(scene, chain * length, (chain + 1) * length)
        differences += compare_rows(path, shard, grid)
        if any(item.where == "" for item in differences):  # the same in every row
            break
    return Recomputed(part_text(len(chains) * length, grid.rows, "row"), differences)
