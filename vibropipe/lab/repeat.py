"""Repeated marches of one motion in a single call, so that motions of a microsecond can be timed."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.loop import march
from vibropipe.march.piece_state import start_state
from vibropipe.orbits.return_map import clear_log


@jit
def march_repeatedly(e, p, grid, x, v, end, log, c, max_events, n_calls):
    """March from (x, v) at tau = 0 to `end` `n_calls` times, for timing.

    e : Effects; p : Parameters; grid : StepGrid; end : Instant; log : must have capacity for all contacts; c : scratch
    of `march`; max_events : limit of contacts and releases. Returns the largest Status of the calls.
    """
    worst = 0
    for _ in range(n_calls):
        clear_log(log)
        state = start_state(log.pieces, e, p, grid, 0.0, x, v)
        _state, status = march(e, p, grid, state, end, log, None, c, max_events)
        worst = max(worst, status)
    return worst
