"""Verification of a backbone: a sample of its amplitudes, or all curves of eq. (10), is recomputed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.backbone.keys import BackboneScene
from vibropipe.scenes.backbone.solve import solve
from vibropipe.scenes.keys.grids import ValueGrid
from vibropipe.scenes.recompute import Recomputed, part_text, sample_indices
from vibropipe.store import compare


def recompute(
    path: Path, scene: BackboneScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Recompute `rows` amplitudes, or all if there are fewer."""
    if not scene.over_amplitude:
        return Recomputed("all of it", compare(path, solve(scene)))
    values = scene.over_arrays()["amplitude"]
    indices = sample_indices(values.size, rows, generator)
    part = scene.model_copy(update={"amplitude": ValueGrid(values=values[indices].tolist())})
    differences = compare(path, solve(part), ("amplitude", indices))
    return Recomputed(part_text(len(indices), values.size, "amplitude"), differences)
