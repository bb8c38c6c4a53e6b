"""Solution of effects scenes: each motion timed beside the one it is compared with."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.lab.effect_costs import TimingCase, solve_effects
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.effects.keys import EffectsScene
    from vibropipe.words.progress import Progress


def solve(scene: EffectsScene, progress: Progress | None = None) -> xr.Dataset:
    """Time the motions of a scene; times differ from run to run."""
    starts, group, cases = scene.starts(), "", {}
    for name, timed in scene.motions.items():
        group, reference = timed.group or group, scene.reference_of(name)
        cases[name] = TimingCase(
            BenchmarkMotion(*starts[name]),
            timed.of == "row",
            tuple(timed.outputs),
            timed.kernel,
            "" if reference == name else reference,
            group,
            timed.title,
        )
    return stored(solve_effects(cases, scene.repeats, progress), scene.mass_and_stiffness)
