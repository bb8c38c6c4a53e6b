"""A motion scene: one motion after its settling, and the orbit that it settles on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import xarray as xr

from vibropipe.physics.effects import resolve_effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import start_text
from vibropipe.solve.accuracy.request import settle_to_accuracy
from vibropipe.solve.energy import TERMS
from vibropipe.solve.motion import simulate
from vibropipe.solve.run import MotionRequest
from vibropipe.solve.steady import steady_state
from vibropipe.words.outputs import OF_ORBIT
from vibropipe.words.status import Status

if TYPE_CHECKING:
    from vibropipe.scenes.kind import Progress
    from vibropipe.scenes.motion.keys import MotionScene

# Names that a motion and its steady state share, and what they are called in the latter.
OF_THE_ORBIT = {
    name: f"orbit_{name}"
    for name in (
        "impact", "impact_phase", "impact_period", "impact_support", "impact_velocity", "error",
        *TERMS, *(f"{term}_error" for term in TERMS),
    )
}  # fmt: skip


def solve(scene: MotionScene, progress: Progress | None = None) -> xr.Dataset:
    """Record one motion, after its settling, with what else its outputs ask for."""
    exciter = Exciter(**scene.resolved_exciter())
    chosen = scene.solver.arguments()
    told = None if progress is None else accumulate_progress(progress, periods_to_march(scene))
    motion = simulate_scene(scene, exciter, chosen, told)
    if chosen.get("method") == "newmark" and "displacement" in motion:
        exact = simulate_scene(scene, exciter, {"method": "exact"}, told)
        motion["displacement_exact"] = exact["displacement"]
        motion["velocity_exact"] = exact["velocity"]
    if "impacts" not in scene.outputs:
        motion = motion.drop_dims(["impact", "grazing"], errors="ignore")
    if OF_ORBIT & set(scene.outputs):
        motion = with_steady_state(motion, scene, exciter)
    # where the settling began, not the record
    start = exciter.check_start(scene.start.x0, scene.start.v0)
    return motion.assign_attrs(start=start_text(exciter.parameters()._asdict(), *start))


def periods_to_march(scene: MotionScene) -> int:
    """Return the forcing periods that a motion is marched over in all, 0 where trials of methods decide it."""
    solver, period = scene.solver.arguments(), Exciter(**scene.resolved_exciter()).period
    begin, end = (int(tau / period) for tau in scene.tau_span())
    if "accuracy" in solver:
        return 0
    if solver["method"] == "exact":
        return end
    # newmark's balance of energy takes the record once more, and the exact motion stands beside it
    return end + ("energy" in scene.outputs) * (end - begin) + ("motion" in scene.outputs) * end


def accumulate_progress(progress: Progress, total: int) -> Callable[[int], None]:
    """Return what to tell each piece of a work of `total`, 0 if that is not known."""
    done = 0

    def on_progress(more: int) -> None:
        nonlocal done
        done += more
        progress(min(done, total) if total else done, total)

    return on_progress


def simulate_scene(
    scene: MotionScene,
    exciter: Exciter,
    solver: dict[str, Any],
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """Return the motion of a scene as one solver sees it, the settling included."""
    x0, v0 = exciter.check_start(scene.start.x0, scene.start.v0)
    begin, end = scene.tau_span()
    effects = scene.called_effects()
    samples = scene.samples_per_period if "motion" in scene.outputs else 0
    energy = "energy" in scene.outputs
    if "accuracy" in solver:
        at, how = scene.effect_arguments()
        with_effects = resolve_effects(effects, *at, **how)
        task = MotionRequest(
            begin, end, x0, v0, samples, effects=with_effects, energy=energy, progress=progress
        )
        return settle_to_accuracy(exciter, task, solver["accuracy"])
    if scene.settle_periods:
        settled = simulate(
            exciter,
            tau_end=begin,
            x0=x0,
            v0=v0,
            samples_per_period=0,
            effects=effects,
            progress=progress,
            **solver,
        )
        x0, v0 = float(settled["displacement_end"]), float(settled["velocity_end"])
    return simulate(
        exciter,
        tau_start=begin,
        tau_end=end,
        x0=x0,
        v0=v0,
        samples_per_period=samples,
        effects=effects,
        energy=energy,
        progress=progress,
        **solver,
    )


def with_steady_state(motion: xr.Dataset, scene: MotionScene, exciter: Exciter) -> xr.Dataset:
    """Add the orbit that the motion settles on; its own status stands unless the motion has one."""
    steady = steady_state(
        exciter,
        x0=scene.start.x0,
        v0=scene.start.v0,
        harmonics=scene.harmonics,
        accuracy=scene.solver.arguments().get("accuracy"),
        effects=scene.called_effects(),
    )
    names = {*steady.variables, *steady.dims}
    steady = steady.rename({old: new for old, new in OF_THE_ORBIT.items() if old in names})
    weaker = motion if int(motion["status"]) == Status.OK else steady
    parts = [item.drop_vars("status") if item is weaker else item for item in (motion, steady)]
    return xr.merge(parts, compat="no_conflicts", join="exact")
