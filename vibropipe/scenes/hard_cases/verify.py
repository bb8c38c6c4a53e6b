"""Verification of hard cases: a sample of them is recomputed, and what common methods are asked."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vibropipe.lab.hard_cases import CASES
from vibropipe.scenes.hard_cases.keys import HardCasesScene
from vibropipe.scenes.hard_cases.solve import solve
from vibropipe.scenes.recompute import Recomputed, part_text, sample_indices
from vibropipe.store import compare


def recompute(
    path: Path, scene: HardCasesScene, rows: int, generator: np.random.Generator
) -> Recomputed:
    """Recompute `rows` cases, or all if there are fewer."""
    names = [case.name for case in CASES if case.name in scene.cases or not scene.cases]
    indices = sample_indices(len(names), rows, generator)
    part = scene.model_copy(update={"cases": [names[index] for index in indices]})
    differences = compare(path, solve(part), ("case", indices), of_groups)
    return Recomputed(part_text(len(indices), len(names), "case"), differences)


def of_groups(name: str) -> bool:
    """Return whether a quantity is of groups of cases, of which a sample has fewer."""
    return name in ("group", "group_known")
