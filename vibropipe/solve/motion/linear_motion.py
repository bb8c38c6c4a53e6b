"""A motion that reaches no support, transient included, in closed form: steady state plus decaying free motion."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import free_flow
from vibropipe.physics.linear import steady_at
from vibropipe.physics.load import forcing_period


@jit
def _sample(
    p: Parameters,
    x: float,
    v: float,
    phase: float,
    after: np.ndarray,
    xs: np.ndarray,
    vs: np.ndarray,
) -> None:
    """Fill xs and vs with the motion from (x, v) at a phase, in turns, at the times `after` (n,) in forcing periods."""
    steady_x, steady_v = steady_at(p, phase)
    dx, dv = x - steady_x, v - steady_v
    for i in range(after.size):
        e11, e12, e21, e22 = free_flow(p.h, after[i] * forcing_period(p))
        steady_x, steady_v = steady_at(p, phase + after[i] % 1.0)
        xs[i] = steady_x + (e11 * dx + e12 * dv)
        vs[i] = steady_v + (e21 * dx + e22 * dv)


def positions(
    p: Parameters, x: float, v: float, phase: float, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return displacement and velocity, each (n,), of the motion without supports.

    Parameters
    ----------
    p : Parameters
    x, v : float
        Start of the motion.
    phase : float
        Phase of the force at the start, in turns.
    after : (n,) array
        Times after the start, in forcing periods.
    """
    xs, vs = np.empty(after.size), np.empty(after.size)
    _sample(p, x, v, phase, after, xs, vs)
    return xs, vs
