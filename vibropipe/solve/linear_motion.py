"""A motion that strikes nothing, transient included, in closed form: the steady one plus a free one."""

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
    turn: float,
    after: np.ndarray,
    xs: np.ndarray,
    vs: np.ndarray,
) -> None:
    steady_x, steady_v = steady_at(p, turn)
    dx, dv = x - steady_x, v - steady_v
    for i in range(after.size):
        e11, e12, e21, e22 = free_flow(p.h, after[i] * forcing_period(p))
        steady_x, steady_v = steady_at(p, turn + after[i] % 1.0)
        xs[i] = steady_x + (e11 * dx + e12 * dv)
        vs[i] = steady_v + (e21 * dx + e22 * dv)


def positions(
    p: Parameters, x: float, v: float, turn: float, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(x, v), each (n,), of the motion without supports from (x, v) at the phase `turn` (in turns), at the
    times `after` (n,) from its start, in forcing periods."""
    xs, vs = np.empty(after.size), np.empty(after.size)
    _sample(p, x, v, turn, after, xs, vs)
    return xs, vs
