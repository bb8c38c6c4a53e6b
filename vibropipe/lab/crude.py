"""Newmark's method with the impact taken at the end of the step: the common crude way, kept to be compared.

A step that ends beyond a support is set back onto it, and its velocity is reset there and then. Nothing
is located and nothing rests, so the error falls with the first power of the step only.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.grid import force_at_step
from vibropipe.march.log import STEPS, log_impact
from vibropipe.orbits.return_map import clear_log
from vibropipe.physics.contact import support_position


@jit
def crude(p, grid, periods, x, v, log, samples):
    """(x, v) after whole forcing periods from phase 0, on a grid of `newmark_grid`.

    Impacts are logged at the ends of steps; samples (n,) takes the displacement at n equal fractions of the
    last period.
    """
    upper, lower = support_position(p, 1), support_position(p, 2)
    for period in range(periods):
        done = 0 if period == periods - 1 else samples.size
        for step in range(grid.steps):
            p_x, p_v = force_at_step(grid, step)
            x1 = grid.a11 * x + grid.a12 * v + p_x
            v1 = grid.a21 * x + grid.a22 * v + p_v
            while done < samples.size and done * grid.steps < (step + 1) * samples.size:
                theta = done * grid.steps / samples.size - step
                samples[done] = x + theta * grid.dt * (v + 0.5 * theta * (v1 - v))
                done += 1
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
    """The same motion so many times over, to be timed."""
    last = x
    for _ in range(n_calls):
        clear_log(log)
        last, _v = crude(p, grid, periods, x, v, log, samples)
    return last
