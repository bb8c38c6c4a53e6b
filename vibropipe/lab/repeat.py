"""A march done many times in one call, so that a motion of a microsecond can be timed."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.loop import march
from vibropipe.march.state import begin
from vibropipe.orbits.return_map import clear


@jit
def march_often(e, p, grid, x, v, end, log, c, max_events, often):
    """March from (x, v) at tau = 0 to the end so many times; returns the last status.

    The log must have room for all contacts of the motion.
    """
    worst = 0
    for _ in range(often):
        clear(log)
        state = begin(e, p, grid, 0.0, x, v)
        _state, status = march(e, p, grid, state, end, log, None, c, max_events)
        worst = max(worst, status)
    return worst
