"""A backbone computed again: a sample of its amplitudes, or the curves of eq. (10) whole."""

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
    """Compute at least `rows` amplitudes again, or all if there are fewer."""
    if not scene.over_amplitude:
        return Recomputed("all of it", compare(path, solve(scene)))
    values = scene.over_arrays()["amplitude"]
    places = sample_indices(values.size, rows, generator)
    part = scene.model_copy(update={"amplitude": ValueGrid(values=values[places].tolist())})
    differences = compare(path, solve(part), ("amplitude", places))
    return Recomputed(part_text(len(places), values.size, "amplitude"), differences)
