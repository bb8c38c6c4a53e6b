"""Verification of a basins scene: all of it is solved again, since the attractors follow from all starts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.basins.keys import BasinsScene
from vibropipe.scenes.basins.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(
    path: Path, scene: BasinsScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Solve the scene again."""
    return Recomputed("all of it", compare(path, solve(scene)))
