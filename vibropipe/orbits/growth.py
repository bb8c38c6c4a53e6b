"""Growth of a perturbation along a motion, which distinguishes chaos from a transient."""

from __future__ import annotations

import math

from vibropipe.compiler import jit_inline
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import return_map_jacobian

# Forcing periods at the end of the patience over which the growth of a perturbation is measured, and the logarithm of
# the growth above which the motion counts as chaotic: a Lyapunov exponent of 0.12 per period. Of 20,000 random rows
# above it after 300 periods, 7 settled later.
LYAPUNOV_PERIODS, LYAPUNOV_THRESHOLD = 50, 6.0


@jit_inline
def perturbation_growth(e, p, log, is_complete, start, end, dx, dv):
    """Propagate a perturbation over one forcing period and measure its growth [1]_.

    Parameters
    ----------
    e : Effects
    p : Parameters
    log : Log
        Contacts of the period.
    is_complete : bool
        Whether the log holds all contacts of the period. If not, nothing is propagated.
    start, end : State
        States before and after the period.
    dx, dv : float
        Perturbation of (x, x') at `start`.

    Returns
    -------
    dx, dv : float
        Perturbation at `end`, scaled to length 1.
    log_growth : float
        Logarithm of its length before scaling; -inf after a rest, which erases it, and with an incomplete log.

    References
    ----------
    .. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth
       dynamical systems, Meccanica 15 (1980) 9.
    """
    if not is_complete:
        return dx, dv, -math.inf
    j11, j12, j21, j22 = return_map_jacobian(e, p, log, start, end, ONE_PERIOD)
    dx, dv = j11 * dx + j12 * dv, j21 * dx + j22 * dv
    norm = math.hypot(dx, dv)
    if not (norm > 0.0 and norm < math.inf):
        return 1.0, 0.0, -math.inf
    return dx / norm, dv / norm, math.log(norm)
