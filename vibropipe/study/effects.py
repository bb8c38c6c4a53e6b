"""What of the physics a scene calls for: derived from its keys, or stated by `effects`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from vibropipe.physics.effects import NAMES, absent_supports, contradiction, effects_of, names_of
from vibropipe.physics.start import largest_start
from vibropipe.study.accuracy import AccuracyScene
from vibropipe.study.base import BaseScene
from vibropipe.study.effect_costs import EffectsScene
from vibropipe.study.models import HardCasesScene, MotionScene, SweepScene
from vibropipe.study.problems import Problem

OF_FREE_MOTION = ("support_1", "support_2")
STEADY_OUTPUTS = {"harmonics", "stability", "energy"}


def scene_effects(scene: BaseScene) -> tuple[str, ...]:
    """Return the effects of a scene by name: those it states, else those its keys call for."""
    if isinstance(scene, HardCasesScene | AccuracyScene | EffectsScene):
        return NAMES
    if not isinstance(scene, MotionScene | SweepScene):
        return OF_FREE_MOTION
    if scene.effects is not None:
        return tuple(scene.effects)
    at, how = grounds(scene)
    return names_of(effects_of(*at, **how))


def grounds(scene: MotionScene | SweepScene) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return what effects follow from, as arguments of `physics.effects.effects_of`."""
    values: dict[str, Any] = {**scene.resolved_exciter(), **scene.over_arrays()}
    start = (largest_start(values, scene.start.x0), scene.start.v0)
    if isinstance(scene, SweepScene):
        return (values, *start, math.inf), {"followed": scene.follow is not None}
    # the steady state of a motion is found beyond its end
    span = math.inf if STEADY_OUTPUTS & set(scene.outputs) else scene.tau_span()[1]
    return (values, *start, span), {"exact": scene.solver.arguments().get("method") == "exact"}


def check_effects(scene: MotionScene | SweepScene) -> Iterator[Problem]:
    """See that a scene does not leave out what its parameters have."""
    if scene.effects is None:
        return
    at, how = grounds(scene)
    missing = contradiction(scene.effects, *at, **how)
    if missing is not None:
        yield Problem(("effects",), *missing)
    for support in absent_supports(scene.effects):
        name = f"R{support[-1]}"
        if name in scene.exciter.given() or name in scene.grids():
            key = "over" if name in scene.grids() else "exciter"
            found = repr(scene.resolved_exciter()[name])
            yield Problem((key, name), found, f"it with {support} among the effects only")
