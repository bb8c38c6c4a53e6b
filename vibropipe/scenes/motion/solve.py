"""Solution of motion scenes: one motion after its transient, and its steady state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import xarray as xr

from vibropipe.physics.effects import resolve_effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import start_text
from vibropipe.scenes.certificate import with_certificate
from vibropipe.solve.accuracy.request import settle_to_accuracy
from vibropipe.solve.checks import span_in_turns
from vibropipe.solve.motion.after_ramp import settled_after_ramp
from vibropipe.solve.motion.run import MotionRequest
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.physical import stored
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.outputs import OF_ORBIT, OF_STEADY_STATE
from vibropipe.words.progress import Progress, WorkCount, part_of
from vibropipe.words.quantities import QUANTITIES
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import ERROR_SUFFIX

if TYPE_CHECKING:
    from vibropipe.scenes.motion.keys import MotionScene

# Names that a motion and its steady state share -> their names for the steady state.
OF_THE_ORBIT = {
    name + suffix: f"orbit_{name}{suffix}"
    for name in QUANTITIES
    for suffix in ("", ERROR_SUFFIX)
    if f"orbit_{name}" in QUANTITIES
}


def solve(scene: MotionScene, progress: Progress | None = None) -> xr.Dataset:
    """Record one motion after its transient, with the further outputs of the scene."""
    exciter = Exciter(**scene.resolved_exciter())
    solver = scene.solver.arguments()
    own, total = periods_to_march(scene)
    motion = simulate_scene(scene, exciter, solver, part_of(progress, 0, total))
    if solver.get("method") == "newmark" and "displacement" in motion:
        on_exact = part_of(progress, own, total)
        exact = simulate_scene(scene, exciter, {"method": "exact"}, on_exact)
        motion["displacement_exact"] = exact["displacement"]
        motion["velocity_exact"] = exact["velocity"]
    if "impacts" not in scene.outputs:
        motion = motion.drop_dims(["impact", "grazing"], errors="ignore")
    if scene.ramp_ends is not None:
        motion = motion.merge(settled_after_ramp(exciter, motion, *scene.tau_span()))
    if OF_ORBIT & set(scene.outputs):
        motion = with_steady_state(motion, scene, exciter)
    # The start of the transient, not of the record.
    start = exciter.check_start(scene.start.x0, scene.start.v0)
    motion = motion.assign_attrs(start=start_text(exciter.parameters()._asdict(), *start))
    whole = stored(motion, scene.mass_and_stiffness)
    return whole if scene.prove is None else with_certificate(whole, scene, exciter)


def periods_to_march(scene: MotionScene) -> tuple[int, int]:
    """Return the forcing periods that the method of a scene marches, and those of all motions to solve.

    Both are 0 if trials of methods decide them.
    """
    solver = scene.solver.arguments()
    if "accuracy" in solver:
        return 0, 0
    begin, end = forcing_periods(scene)
    if solver["method"] == "exact" or "motion" not in scene.outputs:
        return end, end
    # Newmark's energy balance marches the record once more, and the exact motion is solved for comparison.
    own = end + ("energy" in scene.outputs) * (end - begin)
    return own, own + end


def forcing_periods(scene: MotionScene) -> tuple[int, int]:
    """Return the forcing periods from tau = 0 to the start and to the end of the record."""
    exciter = Exciter(**scene.resolved_exciter())
    begin, end = span_in_turns(exciter, *scene.tau_span())
    if (ends := scene.ramp_ends) is not None:
        end = begin + (end - begin) * (1.0 + ends.to / exciter.nu) / 2.0
    return int(begin), int(end)


def simulate_scene(
    scene: MotionScene, exciter: Exciter, solver: dict[str, Any], progress: Progress | None = None
) -> xr.Dataset:
    """Simulate the transient and the record of a scene with one solver and return the record."""
    x0, v0 = exciter.check_start(scene.start.x0, scene.start.v0)
    begin, end = scene.tau_span()
    effects = scene.called_effects()
    samples = scene.samples_per_period if "motion" in scene.outputs else 0
    energy = "energy" in scene.outputs
    if "accuracy" in solver:
        arguments, keywords = scene.effect_arguments()
        with_effects = resolve_effects(effects, *arguments, **keywords)
        marched = None if progress is None else WorkCount(0, progress)
        request = MotionRequest(
            begin, end, x0, v0, samples, effects=with_effects, energy=energy, marched=marched
        )
        return settle_to_accuracy(exciter, request, solver["accuracy"])
    (before, total), housing_v0 = forcing_periods(scene), 0.0
    if scene.settle_periods:
        settled = simulate(
            exciter,
            tau_end=begin,
            x0=x0,
            v0=v0,
            samples_per_period=0,
            effects=effects,
            progress=part_of(progress, 0, total),
            **solver,
        )
        x0, v0 = float(settled["displacement_end"]), float(settled["velocity_end"])
        housing_v0 = float(settled.get("housing_velocity_end", 0.0))
    ends = scene.ramp_ends
    how = {"effects": effects, "energy": energy, **solver} if ends is None else {"nu_end": ends.to}
    return simulate(
        exciter,
        tau_start=begin,
        tau_end=end,
        x0=x0,
        v0=v0,
        samples_per_period=samples,
        housing_v0=housing_v0,
        progress=part_of(progress, before, total),
        **how,
    )


def with_steady_state(motion: xr.Dataset, scene: MotionScene, exciter: Exciter) -> xr.Dataset:
    """Add the steady state to a motion; the status is that of the motion unless it is OK."""
    steady = steady_state(
        exciter,
        x0=scene.start.x0,
        v0=scene.start.v0,
        harmonics=scene.harmonics,
        accuracy=scene.solver.arguments().get("accuracy"),
        effects=scene.called_effects(),
        outputs=(*OF_STEADY_STATE, *sorted(OF_ORBIT & {*scene.outputs})),
    )
    names = {*steady.variables, *steady.dims}
    steady = steady.rename({old: new for old, new in OF_THE_ORBIT.items() if old in names})
    dropped = motion if int(motion["status"]) == Status.OK else steady
    parts = [item.drop_vars("status") if item is dropped else item for item in (motion, steady)]
    return xr.merge(parts, compat="no_conflicts", join="exact")
