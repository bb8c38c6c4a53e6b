"""Samples of closed orbits."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.march.grid import exact_grid, grid_time
from vibropipe.march.log import SAMPLES, Samples, allow_work, clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_state import start_state
from vibropipe.physics.limits import MAX_ROW_WORK


@jit_allocating
def sample_row(e, p, x, v, housing_velocity, m, log, c, motion, row) -> None:
    """Sample a closed orbit at equal fractions of its length.

    e, p, log, c : as for `march`
    x, v, housing_velocity : stroboscopic section, and the velocity of a housing there
    motion : (rows, 2, samples), output: displacement and velocity; NaN if the march fails
    """
    grid = exact_grid(e, p)
    # An integer of one width, whichever array it comes from: marches are compiled once for all.
    samples = Samples(motion[row, 0], motion[row, 1], int(m), motion.shape[2], 0, 0.0, None)
    clear_log(log)
    log.counts[SAMPLES] = 0
    state = start_state(log.pieces, e, p, grid, 0.0, x, v, housing_velocity)
    allow_work(log, MAX_ROW_WORK)
    _end, status = march(
        e, p, grid, state, grid_time(float(m), grid.steps), log, samples, c, 10_000_000
    )
    if status != OK:
        motion[row] = math.nan


@jit_allocating
def sample_sections(e, p, x, v, housing_velocity, m, log, c, poincare, row) -> None:
    """Write the sections of a closed orbit once each forcing period, over and over.

    e, p, x, v, housing_velocity, m, log, c : as for `sample_row`
    poincare : (rows, 2, visits), output: displacement and velocity, from (x, v) on; NaN if the march fails
    """
    sections = np.empty((1, 2, m))
    if m > 1:
        sample_row(e, p, x, v, housing_velocity, m, log, c, sections, 0)
    if m == 1 or not math.isnan(sections[0, 0, 0]):
        sections[0, 0, 0], sections[0, 1, 0] = x, v
    for i in range(poincare.shape[2]):
        for part in range(2):
            poincare[row, part, i] = sections[0, part, i % m]
