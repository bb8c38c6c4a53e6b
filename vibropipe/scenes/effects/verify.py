"""Verification of an effects scene: it is measured again; times are not compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.scenes.effects.keys import EffectsScene
from vibropipe.scenes.effects.solve import solve
from vibropipe.scenes.recompute import TIMES_NOT_COMPARED, Recomputed, is_timing, part_text
from vibropipe.store import compare


def recompute(
    path: Path, scene: EffectsScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Measure all motions again, since their ratios involve each other."""
    again = solve(scene.model_copy(update={"repeats": 1}))
    checked = part_text(scene.row_count, scene.row_count, "motion")
    return Recomputed(checked, compare(path, again, skip=is_timing), TIMES_NOT_COMPARED)
