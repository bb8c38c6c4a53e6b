"""Solution of accuracy scenes: each method on each motion at several settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.lab.work_precision import solve_accuracy
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.accuracy.keys import AccuracyScene
    from vibropipe.words.progress import Progress


def solve(scene: AccuracyScene, progress: Progress | None = None) -> xr.Dataset:
    """Run all methods of a scene on its motions; times differ from run to run."""
    dataset = solve_accuracy(
        motions={name: BenchmarkMotion(*start) for name, start in scene.starts().items()},
        methods=scene.methods,
        steps=scene.steps_per_period,
        tolerances=scene.tolerances,
        accuracies=scene.accuracies,
        repeats=scene.repeats,
        progress=progress,
    )
    return stored(dataset, scene.mass_and_stiffness)
