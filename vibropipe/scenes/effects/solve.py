"""Solution of effects scenes: each motion timed by several kernels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.lab.effect_costs import solve_effects
from vibropipe.lab.effect_work import TimingCase
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.effects.keys import EffectsScene
    from vibropipe.words.progress import Progress


def solve(scene: EffectsScene, progress: Progress | None = None) -> xr.Dataset:
    """Time the motions of a scene; times differ from run to run."""
    motions = {name: BenchmarkMotion(*start) for name, start in scene.starts().items()}
    trials = {
        name: TimingCase(
            motions[name],
            timed.of == "row",
            tuple(timed.outputs),
            timed.against or "",
            math.nan if timed.at_most is None else timed.at_most,
        )
        for name, timed in scene.motions.items()
    }
    dataset = solve_effects(trials, motions[scene.full], scene.repeats, progress)
    return stored(dataset, scene.mass_and_stiffness)
