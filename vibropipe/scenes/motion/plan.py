"""Cost of a motion scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import (
    IMPACT_BYTES,
    USUAL_IMPACTS,
    Work,
    slowness,
    steady_bytes,
    stored_name,
    stored_values,
)
from vibropipe.words.outputs import OF_ORBIT

if TYPE_CHECKING:
    from vibropipe.scenes.motion.keys import MotionScene

SECONDS_PER_STEP = 10e-9
SECONDS_PER_PERIOD = 1e-6


def plan(scene: MotionScene) -> Work:
    """Return the work of a motion, from its periods and the steps of Newmark's method."""
    recorded = scene.tau_end * scene.resolved_exciter()["nu"] / (2 * math.pi)
    periods = scene.settle_periods + recorded
    steps = scene.solver.arguments().get("steps_per_period", 0)
    stored = USUAL_IMPACTS * recorded * IMPACT_BYTES
    if "motion" in scene.outputs:
        # Variables of a sample: tau, displacement, velocity, force; with newmark also the two of the exact motion.
        stored += scene.samples_per_period * recorded * 8 * (6 if steps else 4)
    if OF_ORBIT & set(scene.outputs):
        stored += steady_bytes(scene.outputs, scene.harmonics, effects=scene.all_effects())
    return Work(
        size=_length_text(scene),
        rows=1,
        method=_method(scene),
        outputs=tuple(scene.outputs),
        seconds=periods * (SECONDS_PER_PERIOD + steps * SECONDS_PER_STEP) * slowness(scene),
        bytes=stored,
    )


def _length_text(scene: MotionScene) -> str:
    (end,), unit = stored_values(scene, "tau", [scene.tau_end])
    return f"{stored_name(scene, 'tau')} {end}{unit}"


def _method(scene: MotionScene) -> str:
    solver = scene.solver.arguments()
    if "accuracy" in solver:
        return f"accuracy {solver['accuracy']:g}"
    steps = solver.get("steps_per_period")
    return f"{solver['method']}, {steps} steps" if steps else str(solver["method"])
