"""Stored bytes of a sweep row and of a forcing period of a motion."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from vibropipe.lab.effect_work import samples_of
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.sweep.sweep import sweep
from vibropipe.store.encoding import encode

# Rows of the larger of two encoded sweeps: their difference excludes what does not grow with rows (parameters, grids).
MANY_ROWS = 64
# Relative half width of the interval of f (of nu, without force) that the rows sample, so that no two are equal.
WIDTH = 0.01


@cache
def stored_bytes(motion: BenchmarkMotion, row: bool, outputs: tuple[str, ...]) -> float:
    """Return the bytes of a row or of a forcing period, encoded for the disk before compression.

    Parameters
    ----------
    motion : BenchmarkMotion
        Motion, or centre of the swept exciters.
    row : bool
        Whether a row of a sweep is measured, not a forcing period of the motion.
    outputs : tuple of str
        Outputs that are stored.

    Returns
    -------
    float
        Bytes per row or per forcing period.
    """
    solve, few, many = (sweep_rows, 1, MANY_ROWS) if row else (march_periods, 0, motion.periods)
    sizes = [
        sum(np.asarray(stored.values).nbytes for stored in encode(solve(motion, outputs, count))[0])
        for count in (few, many)
    ]
    return (sizes[1] - sizes[0]) / (many - few)


def sweep_rows(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return a sweep of `count` rows about the exciter of a motion."""
    name = "f" if motion.exciter.f else "nu"
    centre = getattr(motion.exciter, name)
    over = {name: centre * (1 + WIDTH * np.linspace(-1, 1, count))}
    return sweep(motion.exciter, over, x0=motion.x0, v0=motion.v0, outputs=outputs)


def march_periods(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return the first `count` forcing periods of a motion."""
    end = count * motion.exciter.period
    dataset = simulate(
        motion.exciter, end, motion.x0, motion.v0, samples_per_period=samples_of(outputs)
    )
    return dataset if "impacts" in outputs else dataset.drop_dims(["impact", "grazing"])
