"""Newmark's method with impacts applied at the end of the step, a common simple scheme kept as a reference.

A step that ends beyond a support is set back onto it, and its velocity is reset there. No event is located and no
sticking is detected, so the error is of first order in the step.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.grid import force_at_step
from vibropipe.march.log import STEPS, log_impact
from vibropipe.orbits.return_map import clear_log
from vibropipe.physics.contact import support_position


@jit
def crude(p, grid, periods, x, v, log, samples):
    """March whole forcing periods from phase 0 with impacts at the ends of steps.

    p : Parameters; grid : StepGrid of `newmark_grid`; periods : int; x, v : state at tau = 0; log : receives each
    impact at the end of its step; samples : (n,) receives the displacement at n equal fractions of the last period.
    Returns (x, v) at the end.
    """
    upper, lower = support_position(p, 1), support_position(p, 2)
    for period in range(periods):
        n_sampled = 0 if period == periods - 1 else samples.size
        for step in range(grid.steps):
            force_x, force_v = force_at_step(grid, step)
            x1 = grid.a11 * x + grid.a12 * v + force_x
            v1 = grid.a21 * x + grid.a22 * v + force_v
            while n_sampled < samples.size and n_sampled * grid.steps < (step + 1) * samples.size:
                theta = n_sampled * grid.steps / samples.size - step
                samples[n_sampled] = x + theta * grid.dt * (v + 0.5 * theta * (v1 - v))
                n_sampled += 1
            support = 1 if x1 >= upper else 2 if x1 <= lower else 0
            if support > 0:
                x1 = upper if support == 1 else lower
                if (v1 > 0.0) if support == 1 else (v1 < 0.0):
                    restitution = p.R1 if support == 1 else p.R2
                    position = period + (step + 1) / grid.steps
                    log_impact(log, position, support, v1, -(1.0 + restitution) * v1)
                    v1 = -restitution * v1
            x, v = x1, v1
    log.counts[STEPS] += periods * grid.steps
    return x, v


@jit
def crude_repeatedly(p, grid, periods, x, v, log, samples, n_calls):
    """March the same motion `n_calls` times, for timing; arguments as of `crude`. Returns the last x."""
    last = x
    for _ in range(n_calls):
        clear_log(log)
        last, _v = crude(p, grid, periods, x, v, log, samples)
    return last
