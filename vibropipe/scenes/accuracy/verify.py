"""A sample of the runs of an accuracy scene repeated; times are not compared."""

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
    """Repeat at least `rows` runs, those of whole motions."""
    each = scene.row_count // len(scene.motions)
    places = sample_indices(len(scene.motions), math.ceil(rows / each), generator)
    motions = list(scene.motions.items())
    part = {"motions": dict(motions[place] for place in places), "repeats": 1}
    again = solve(scene.model_copy(update=part))
    checked = part_text(len(places) * each, scene.row_count, "run")
    differences = compare(path, again, ("motion", places), is_timing)
    return Recomputed(checked, differences, TIMES_NOT_COMPARED)
