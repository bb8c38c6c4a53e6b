"""Parameters found again: the search is deterministic."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.identify.keys import IdentifyScene
from vibropipe.scenes.identify.solve import solve
from vibropipe.scenes.recompute import Recomputed
from vibropipe.store import compare


def recompute(
    path: Path, scene: IdentifyScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Find the parameters again."""
    return Recomputed("all of it", compare(path, solve(scene)))
