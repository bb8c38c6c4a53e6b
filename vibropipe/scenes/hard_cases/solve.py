"""Solution of hard_cases scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.lab.hard_cases import CASES, solve_hard_cases

if TYPE_CHECKING:
    from vibropipe.scenes.hard_cases.keys import HardCasesScene
    from vibropipe.words.progress import Progress


def solve(scene: HardCasesScene, progress: Progress | None = None) -> xr.Dataset:
    """Measure the cases of a scene, or all if it names none, by every method."""
    named = [case for case in CASES if case.name in scene.cases]
    return solve_hard_cases(named or CASES, questions=scene.compare, progress=progress)
