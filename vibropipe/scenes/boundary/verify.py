"""Boundaries followed again, whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.boundary.keys import BoundaryScene
from vibropipe.scenes.boundary.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(
    path: Path, scene: BoundaryScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Follow the curves again; a point depends on those before it."""
    return Recomputed("all of it", compare(path, solve(scene)))
