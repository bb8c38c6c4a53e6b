"""Cost of a motion scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import (
    IMPACT_BYTES,
    USUAL_IMPACTS,
    Estimate,
    Sampler,
    Work,
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
        seconds=periods * (SECONDS_PER_PERIOD + steps * SECONDS_PER_STEP),
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


def estimate(scene: MotionScene, sampler: Sampler) -> Estimate:
    """Estimate a motion from its leading part, or from all of it if it is short."""
    _, load = sampler.warm(miniature(scene), _kernels(scene))
    part, share = leading_part(scene, sampler.budget)
    core = sampler.solved(part) / share
    return Estimate(core, load, sampler.bytes / share, False, _chosen_method(scene))


def leading_part(scene: MotionScene, budget: float) -> tuple[MotionScene, float]:
    """Return a scene that is solved in about `budget` seconds, and its share of the whole."""
    rough = plan(scene).seconds
    if rough <= budget:
        return scene, 1.0
    share = budget / rough
    short = {
        "tau_end": scene.tau_end * share,
        "settle_periods": int(scene.settle_periods * share),
        "effects": list(scene.called_effects()),
    }
    return scene.model_copy(update=short), share


def miniature(scene: MotionScene) -> MotionScene:
    """Return a short motion that uses the same kernels."""
    short = {"settle_periods": min(scene.settle_periods, 1), "tau_end": min(scene.tau_end, 6)}
    return scene.model_copy(update={**short, "effects": list(scene.called_effects())})


def _chosen_method(scene: MotionScene) -> str:
    """Return the method as text, selected on this exciter if the scene requests an accuracy."""
    solver = scene.solver.arguments()
    if "accuracy" not in solver:
        return _method(scene)
    from vibropipe.physics.exciter import Exciter
    from vibropipe.solve.accuracy.method_choice import choose

    _, end = scene.tau_span()
    exciter = Exciter(**scene.resolved_exciter())
    choice = choose(exciter, end, scene.start.x0, scene.start.v0, solver["accuracy"])
    steps = f", {choice.steps_per_period} steps" if choice.steps_per_period is not None else ""
    return f"{choice.method}{steps} for {scene.solver.accuracy:g}"


def _kernels(scene: MotionScene) -> str:
    sampled = ["sampled"] if scene.samples_per_period else []
    settled = ["settled"] if scene.settle_periods else []
    method = str(scene.solver.arguments().get("method", "accuracy"))
    parts = [method, *sampled, *settled, *sorted(scene.outputs), *sorted(scene.called_effects())]
    return " ".join([scene.kind, *parts])
