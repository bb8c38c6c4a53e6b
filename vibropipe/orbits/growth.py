"""Growth of a perturbation along a motion: what distinguishes chaos from a transient, and Lyapunov exponents."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import return_map_jacobian

# Forcing periods at the end of the patience over which the growth of a perturbation is measured, and the logarithm of
# the growth above which the motion counts as chaotic: a Lyapunov exponent of 0.12 per period. Of 20,000 random rows
# above it after 300 periods, 7 settled later.
LYAPUNOV_PERIODS, LYAPUNOV_THRESHOLD = 50, 6.0
# Forcing periods at the end of a motion without an orbit from which its Lyapunov exponent is taken, and periods of a
# block. Growth is correlated over a few periods only, so the means of blocks are independent; in the first block the
# perturbation turns into the direction that grows most.
EXPONENT_PERIODS, BLOCK_PERIODS = 75, 5


@jit_inline
def period_jacobian(e, p, log, is_complete, start, end):
    """Return the Jacobian (j11, j12, j21, j22) of the return map over one forcing period.

    Parameters
    ----------
    e : Effects
    p : Parameters
    log : Log
        Contacts of the period.
    is_complete : bool
        Whether the log holds all contacts of the period; if not, the Jacobian is NaN.
    start, end : State
        States before and after the period.
    """
    if not is_complete:
        return math.nan, math.nan, math.nan, math.nan
    return return_map_jacobian(e, p, log, start, end, ONE_PERIOD)


@jit
def perturbation_growth(jacobian, dx, dv):
    """Propagate a perturbation over one forcing period and measure its growth [1]_.

    Parameters
    ----------
    jacobian : tuple of float
        Result of `period_jacobian`.
    dx, dv : float
        Perturbation of (x, x') before the period.

    Returns
    -------
    dx, dv : float
        Perturbation after the period, scaled to length 1.
    log_growth : float
        Logarithm of its length before scaling; -inf after a rest, which erases it, and NaN if it is not finite.

    References
    ----------
    .. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth
       dynamical systems, Meccanica 15 (1980) 9.
    """
    j11, j12, j21, j22 = jacobian
    dx, dv = j11 * dx + j12 * dv, j21 * dx + j22 * dv
    norm = math.hypot(dx, dv)
    if not (norm > 0.0 and norm < math.inf):
        return 1.0, 0.0, -math.inf if norm == 0.0 else math.nan
    return dx / norm, dv / norm, math.log(norm)


class GrowthSums(NamedTuple):
    """A perturbation, and sums of the logarithms of its growth over blocks of forcing periods.

    Attributes
    ----------
    dx, dv : float
        Perturbation of (x, x'), of length 1.
    periods : int
        Forcing periods.
    block : float
        Sum over the block that is not complete.
    total, squares : float
        Sum of the complete blocks but the first, and of their squares.
    """

    dx: float
    dv: float
    periods: int
    block: float
    total: float
    squares: float


@jit
def no_growth():
    """Return sums over no periods."""
    return GrowthSums(1.0, 0.0, 0, 0.0, 0.0, 0.0)


@jit
def add_growth(sums, jacobian):
    """Return the sums with a forcing period more, given by the Jacobian of its return map."""
    dx, dv, log_growth = perturbation_growth(jacobian, sums.dx, sums.dv)
    periods, block = sums.periods + 1, sums.block + log_growth
    if periods % BLOCK_PERIODS > 0:
        return GrowthSums(dx, dv, periods, block, sums.total, sums.squares)
    if periods == BLOCK_PERIODS:
        block = 0.0
    return GrowthSums(dx, dv, periods, 0.0, sums.total + block, sums.squares + block * block)


@jit
def mean_growth(sums):
    """Return the mean growth per forcing period and its standard error, that of the means of the blocks.

    They are (-inf, 0) if a rest erased the perturbation, and NaN with fewer than three blocks.
    """
    blocks = sums.periods // BLOCK_PERIODS - 1
    if blocks < 2:
        return math.nan, math.nan
    mean = sums.total / blocks
    if mean == -math.inf:
        return mean, 0.0
    variance = max(0.0, sums.squares - sums.total * mean) / (blocks - 1)
    return mean / BLOCK_PERIODS, math.sqrt(variance / blocks) / BLOCK_PERIODS
