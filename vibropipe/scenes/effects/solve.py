"""Scenes of what effects and outputs cost: their motions, and the bytes that their results take on disk."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numba
import numpy as np
import xarray as xr

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab.effect_costs import SAMPLES, Trial, kernel_calls, measure_effects
from vibropipe.lab.work_precision_methods import Motion
from vibropipe.solve.motion import simulate
from vibropipe.solve.sweep import sweep
from vibropipe.store.encoding import encode

if TYPE_CHECKING:
    from vibropipe.scenes.effects.keys import EffectsScene
    from vibropipe.scenes.kind import Progress

# Rows of the sweep that is encoded; what a shorter one needs too (parameters, grids) is left out.
MANY_ROWS = 64
# Rows lie about the exciter's f (or its nu, without force) by this share, so that no two are the same.
WIDTH = 0.01


def trials_of(scene: EffectsScene, motions: dict[str, Motion]) -> dict[str, Trial]:
    """Return what is timed of each motion of a scene."""
    return {
        name: Trial(
            motions[name],
            timed.of == "row",
            tuple(timed.outputs),
            timed.against or "",
            math.nan if timed.at_most is None else timed.at_most,
        )
        for name, timed in scene.motions.items()
    }


def solve(scene: EffectsScene, progress: Progress | None = None) -> xr.Dataset:
    """Measure the motions of a scene; the times are of this run alone. progress is told the times taken and all."""
    motions = {name: Motion(*start) for name, start in scene.starts().items()}
    trials = trials_of(scene, motions)
    calls = [call for trial in trials.values() for call in kernel_calls(trial)]
    compile_side_by_side(calls, numba.get_num_threads())
    return measure_effects(trials, motions[scene.full], Sizes().bytes_of, scene.repeats, progress)


class Sizes:
    """Bytes of results as they are encoded for the disk, before compression; each kind is solved once."""

    def __init__(self) -> None:
        self.known: dict[tuple[Motion, bool, tuple[str, ...]], float] = {}

    def bytes_of(self, trial: Trial, motion: Motion) -> float:
        """Return the bytes that a trial stores in a row, or in a forcing period of a motion, if it is about
        the motion given."""
        key = (motion, trial.row, trial.outputs)
        if key not in self.known:
            few, many = (1, MANY_ROWS) if trial.row else (0, motion.periods)
            made = rows if trial.row else record
            sizes = [size(made(motion, trial.outputs, count)) for count in (few, many)]
            self.known[key] = (sizes[1] - sizes[0]) / (many - few)
        return self.known[key]


def rows(motion: Motion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return so many rows of a sweep about a motion's exciter."""
    name = "f" if motion.exciter.f else "nu"
    middle = getattr(motion.exciter, name)
    over = {name: middle * (1 + WIDTH * np.linspace(-1, 1, count))}
    return sweep(motion.exciter, over, x0=motion.x0, v0=motion.v0, outputs=outputs)


def record(motion: Motion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return the first so many forcing periods of a motion."""
    samples = SAMPLES if "motion" in outputs else 0
    end = count * motion.exciter.period
    found = simulate(motion.exciter, end, motion.x0, motion.v0, samples_per_period=samples)
    return found if "impacts" in outputs else found.drop_dims(["impact", "grazing"])


def size(dataset: xr.Dataset) -> int:
    """Return the bytes of all values of a dataset, in the types that they have on disk."""
    return sum(np.asarray(stored.values).nbytes for stored in encode(dataset)[0])
