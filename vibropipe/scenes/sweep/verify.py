"""Verification of a sweep: a sample of its rows is recomputed, whole chains if a parameter is followed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vibropipe.scenes.recompute import Recomputed, part_text, sample_indices
from vibropipe.scenes.rows import row_grid, stored_grid
from vibropipe.scenes.sweep.keys import SweepScene
from vibropipe.scenes.sweep.solve import solve_rows
from vibropipe.store import Difference, compare_rows


def recompute(
    path: Path, scene: SweepScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Recompute at least `rows` rows, or all if there are fewer."""
    grid = row_grid(scene)
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
    return Recomputed(part_text(len(chains) * length, grid.rows, "row"), differences)
