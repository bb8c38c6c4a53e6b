"""Compile what the scenes of some studies need, once, before any job needs it.

Each scene is solved in miniature: the same kernels in the same specialisations, next to no work.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vibropipe.physics.effects import NAMES
from vibropipe.study import (
    AccuracyScene,
    BackboneScene,
    EffectsScene,
    HardCasesScene,
    MotionScene,
    Scene,
    SweepScene,
    fingerprint,
    load_study,
    scene_effects,
)
from vibropipe.study.accuracy import METHODS
from vibropipe.study.grids import ValueGrid
from vibropipe.warmed import done_before

Task = tuple[Path, str, str | None]
# Beginnings of works.
ORDER = (
    "sweep",
    "motion of effects",
    "row of effects",
    "hard_cases",
    "effects",
    "accuracy",
    "motion",
    "backbone",
)


def not_compiled(files: Sequence[Path]) -> dict[str, Task]:
    """Return what the scenes of the studies need and nothing has compiled here before: tasks by work, in order.

    Raises StudyError when a study cannot be taken.
    """
    tasks: dict[str, Task] = {}
    for file in files:
        for name, scene in load_study(file).scenes.items():
            for work, motion in parts_of(scene):
                tasks.setdefault(work, (file, name, motion))
    before = done_before()
    return {work: tasks[work] for work in sorted(tasks, key=place_of) if work not in before}


def not_calibrated(files: Sequence[Path]) -> list[Path]:
    """Return the studies with a scene of which nothing has found out before how long it takes here."""
    before = done_before()
    studies = {file: load_study(file) for file in files}
    return [
        file
        for file, study in studies.items()
        if not before.issuperset(fingerprint(study, name) for name in study.scenes)
    ]


def parts_of(scene: Scene) -> Iterator[tuple[str, str | None]]:
    """Yield what is compiled for a scene, as (work, motion): the kernels of some effects alone that one of its
    motions calls for, then all of it (no motion)."""
    if isinstance(scene, EffectsScene):
        for name, timed in scene.motions.items():
            effects = scene.effects_of(name)
            if set(effects) != set(NAMES):
                yield f"{timed.of} of effects {' '.join(effects)}", name
    yield work_of(scene), None


def place_of(work: str) -> int:
    """Return the place of a work in the order of all: the longest begin first, and those that share pieces do
    not begin together, or each would make them."""
    return next(place for place, kind in enumerate(ORDER) if work.startswith(kind))


def work_of(scene: Scene) -> str:
    """Name what is compiled for a scene; scenes of one name need the same kernels."""
    if isinstance(scene, SweepScene):
        return " ".join([scene.kind, *sorted(scene.outputs), *sorted(scene_effects(scene))])
    if isinstance(scene, AccuracyScene):
        return scene.kind
    if isinstance(scene, EffectsScene):
        sets = {"+".join(scene.effects_of(motion)) for motion in scene.motions}
        return " ".join([scene.kind, *sorted(sets)])
    if isinstance(scene, BackboneScene):
        return f"{scene.kind} over {'amplitude' if scene.over_amplitude else 'period'}"
    if isinstance(scene, HardCasesScene):
        return scene.kind
    sampled = ["sampled"] if scene.samples_per_period else []
    settled = ["settled"] if scene.settle_periods else []
    solver = scene.solver.arguments()
    words = [str(solver.get("method", "accuracy")), *sampled, *settled]
    words += [*sorted(scene.outputs), *sorted(scene_effects(scene))]
    return " ".join([scene.kind, *words])


def solve_in_miniature(file: Path, name: str, motion: str | None) -> None:
    """Solve the smallest part of a scene that calls all its kernels, or those of one of its motions."""
    scene = load_study(file).scene(name)
    if motion is not None and isinstance(scene, EffectsScene):
        from vibropipe.effect_costs import solve_once

        solve_once(scene, motion)
        return
    from vibropipe.scenes import solve

    solve(miniature(scene))


def miniature(scene: Scene) -> Scene:
    """Return a scene of the same work with grids of a few values and a short motion."""
    if isinstance(scene, MotionScene):
        settle = min(scene.settle_periods, 1)
        short = {"settle_periods": settle, "tau_end": min(scene.tau_end, 6)}
        return scene.model_copy(update={**short, "effects": list(scene_effects(scene))})
    if isinstance(scene, HardCasesScene):
        # sampled motions, plain ones, steady states
        few = ["chatter_interrupted", "plastic_for_ever", "coexisting"]
        return scene.model_copy(update={"cases": few})
    if isinstance(scene, AccuracyScene):
        return quick_race(scene)
    if isinstance(scene, EffectsScene):
        return scene.model_copy(update={"repeats": 1})
    # along eq. (10) some values must lie where both supports are struck
    most = 2 if isinstance(scene, SweepScene) or scene.over_amplitude else 50
    grids = {name: thinned(grid.array(), most) for name, grid in scene.grids().items()}
    if isinstance(scene, SweepScene):
        # a small part of a grid may call for less than the whole of it
        return scene.model_copy(update={"over": grids, "effects": list(scene_effects(scene))})
    return scene.model_copy(update=grids)


def quick_race(scene: AccuracyScene) -> AccuracyScene:
    """Return a scene with one short motion and the methods that are compiled."""
    name, motion = next(iter(scene.motions.items()))
    short = motion.model_copy(update={"periods": 1})
    own = [method for method in METHODS[:3] if method in scene.methods] or ["exact"]
    least = {"steps_per_period": [8], "repeats": 1}
    return scene.model_copy(update={"motions": {name: short}, "methods": own, **least})


def thinned(values: NDArray[np.float64], most: int) -> ValueGrid:
    """Return at most `most` of the values, the first and the last among them."""
    places = np.unique(np.linspace(0, values.size - 1, most).round().astype(int))
    return ValueGrid(values=values[places].tolist())
