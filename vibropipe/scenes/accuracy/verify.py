"""Verification of an accuracy scene: a sample of its runs is repeated; times are not compared."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vibropipe.scenes.accuracy.keys import AccuracyScene
from vibropipe.scenes.accuracy.solve import solve
from vibropipe.scenes.recompute import (
    TIMES_NOT_COMPARED,
    Recomputed,
    is_timing,
    part_text,
    sample_indices,
)
from vibropipe.store import compare


def recompute(
    path: Path, scene: AccuracyScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Repeat all runs of enough motions for at least `rows` runs."""
    each = scene.row_count // len(scene.motions)
    indices = sample_indices(len(scene.motions), math.ceil(rows / each), generator)
    motions = list(scene.motions.items())
    part = {"motions": dict(motions[index] for index in indices), "repeats": 1}
    again = solve(scene.model_copy(update=part))
    checked = part_text(len(indices) * each, scene.row_count, "run")
    differences = compare(path, again, ("motion", indices), is_timing)
    return Recomputed(checked, differences, TIMES_NOT_COMPARED)
