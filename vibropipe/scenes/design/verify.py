"""Designs found again, all of them: the search is deterministic."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.design.keys import DesignScene
from vibropipe.scenes.design.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(
    path: Path, scene: DesignScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Find the designs again."""
    return Recomputed("all of it", compare(path, solve(scene)))
