"""A march done many times in one call, so that a motion of a microsecond can be timed."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.loop import march
from vibropipe.march.state import initial_state
from vibropipe.orbits.return_map import clear_log


@jit
def march_repeatedly(e, p, grid, x, v, end, log, c, max_events, n_calls):
    """March from (x, v) at tau = 0 to the end so many times; returns the last status.

    The log must have room for all contacts of the motion.
    """
    worst = 0
    for _ in range(n_calls):
        clear_log(log)
        state = initial_state(e, p, grid, 0.0, x, v)
        _state, status = march(e, p, grid, state, end, log, None, c, max_events)
        worst = max(worst, status)
    return worst
