"""The return map backward in time."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.march.log import allow_work, clear_log
from vibropipe.march.loop import OK
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import march_periods, state_xv
from vibropipe.physics.limits import MAX_ROW_WORK

# Largest number of impacts in a forcing period. Backward each impact is faster than the one before, up to infinitely
# many in a finite time.
MAX_IMPACTS = np.int64(1000)


@jit_allocating
def map_back(e, p, grid, states, log, c, before) -> None:
    """March states at the section to the section before.

    e, grid, log, c : as for `march`
    p : those of the motion x(-tau), `SectionMap.preimages`
    states : (n, 2)
    before : (n, 2), output: the states a forcing period before; NaN where the march failed
    """
    allow_work(log, MAX_ROW_WORK)
    for i in range(states.shape[0]):
        clear_log(log)
        state = start_state(log.pieces, e, p, grid, 0.0, states[i, 0], -states[i, 1], 0.0)
        state, status = march_periods(e, p, grid, state, ONE_PERIOD, log, c, MAX_IMPACTS)
        x, v = state_xv(p, state)
        before[i, 0], before[i, 1] = x, -v
        if status != OK:
            before[i, 0] = before[i, 1] = math.nan
