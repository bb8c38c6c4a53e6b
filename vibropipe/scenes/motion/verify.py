"""A motion computed again, whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.motion.keys import MotionScene
from vibropipe.scenes.motion.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(
    path: Path, scene: MotionScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Compute the motion again; it has no rows to choose from."""
    return Recomputed("all of it", compare(path, solve(scene)))
