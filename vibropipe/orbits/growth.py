"""The growth of a small difference along a motion, by which chaos is told from a transient."""

from __future__ import annotations

import math

from vibropipe.compiler import jit_inline
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import return_map_jacobian

# A small difference that grows by this exponent over so many periods, the last of its patience, is that of a
# chaotic motion, or of one that will settle late: of 20,000 random rows 7 did after 300 periods.
LYAPUNOV_PERIODS, LYAPUNOV_THRESHOLD = 50, 6.0


@jit_inline
def perturbation_growth(e, p, log, is_whole, start, end, a, b):
    """Carry a small difference over a forcing period.

    Parameters
    ----------
    log : Log
        Contacts of the period; they count only where it `is_whole`.
    start, end : State
        Before and after the period.
    a, b : float
        The difference (x, x').

    Returns
    -------
    a, b : float
        The difference after the period, scaled to size 1.
    growth : float
        Logarithm of its size before it was scaled; -inf where a rest forgets it, or the log is not whole.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems, Meccanica 15 (1980) 9.
    """
    if not is_whole:
        return a, b, -math.inf
    j11, j12, j21, j22 = return_map_jacobian(e, p, log, start, end, ONE_PERIOD)
    a, b = j11 * a + j12 * b, j21 * a + j22 * b
    size = math.hypot(a, b)
    if not (size > 0.0 and size < math.inf):
        return 1.0, 0.0, -math.inf
    return a / size, b / size, math.log(size)
