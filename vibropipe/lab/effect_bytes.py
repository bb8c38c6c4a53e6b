"""Bytes that results take on disk: of a row of a sweep, and of a forcing period of a motion."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from vibropipe.lab.effect_work import SAMPLES
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.motion import simulate
from vibropipe.solve.sweep import sweep
from vibropipe.store.encoding import encode

# Rows of the sweep that is encoded; what a shorter one needs too (parameters, grids) is left out.
MANY_ROWS = 64
# Rows lie about the exciter's f (or its nu, without force) by this share, so that no two are the same.
WIDTH = 0.01


@cache
def bytes_of(motion: BenchmarkMotion, row: bool, outputs: tuple[str, ...]) -> float:
    """Return the bytes, encoded for the disk before compression, of a row about a motion's exciter with some
    outputs, or of a forcing period of the motion."""
    solve, few, many = (rows, 1, MANY_ROWS) if row else (periods, 0, motion.periods)
    sizes = [
        sum(np.asarray(stored.values).nbytes for stored in encode(solve(motion, outputs, count))[0])
        for count in (few, many)
    ]
    return (sizes[1] - sizes[0]) / (many - few)


def rows(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return so many rows of a sweep about a motion's exciter."""
    name = "f" if motion.exciter.f else "nu"
    middle = getattr(motion.exciter, name)
    over = {name: middle * (1 + WIDTH * np.linspace(-1, 1, count))}
    return sweep(motion.exciter, over, x0=motion.x0, v0=motion.v0, outputs=outputs)


def periods(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return the first so many forcing periods of a motion."""
    samples = SAMPLES if "motion" in outputs else 0
    end = count * motion.exciter.period
    found = simulate(motion.exciter, end, motion.x0, motion.v0, samples_per_period=samples)
    return found if "impacts" in outputs else found.drop_dims(["impact", "grazing"])
