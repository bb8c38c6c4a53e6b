"""Growth of a perturbation along a motion: what distinguishes chaos from a transient, and Lyapunov exponents."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.return_map import return_map_jacobian
from vibropipe.physics.load import forcing_period

# Logarithm of the growth of a perturbation above which a motion counts as chaotic, and forcing periods before the end
# of the patience from which the growth is measured.
CHAOTIC_GROWTH, JUDGED_PERIODS = 6.0, 50
# Forcing periods after which a motion that settles is examined for chaos before, which marches it again; most motions
# have settled by then. Its transient was chaotic if a perturbation grew so much, as a logarithm, that rounding became
# visible: to 1e-4 of the motion.
EXAMINED_PERIODS, ROUNDING_GROWTH = 64, 27.0
# Forcing periods at the end of a motion without an orbit from which its Lyapunov exponent is taken, and periods of a
# block. Growth is correlated over a few periods only, so the means of blocks are independent; in the first block the
# perturbation turns into the direction that grows most.
EXPONENT_PERIODS, BLOCK_PERIODS = 75, 5


@jit_inline
def period_jacobian(e, p, log, is_complete, start, end):
    """Return the Jacobian (j11, j12, j21, j22) of the return map over one forcing period.

    log : contacts of the period
    is_complete : whether the log holds all contacts of the period; if not, the Jacobian is NaN
    start, end : states before and after the period
    """
    if not is_complete:
        return math.nan, math.nan, math.nan, math.nan
    return return_map_jacobian(e, p, log, start, end, ONE_PERIOD)


@jit
def perturbation_growth(jacobian, coupling, dx, dv, dp):
    """Propagate a perturbation over one forcing period and measure its growth [1]_.

    jacobian : result of `period_jacobian`
    coupling : its rest, where a housing may slide
    dx, dv, dp : perturbation of (x, x') and of the momentum of both bodies before the period

    Returns the perturbation (dx, dv, dp) after the period, scaled to length 1, and the logarithm of its length before
    scaling; -inf after a rest, which erases it, and NaN if it is not finite.

    .. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth
       dynamical systems, Meccanica 15 (1980) 9.
    """
    j11, j12, j21, j22 = jacobian
    k = coupling
    dq = k.j31 * dx + k.j32 * dv + k.j33 * dp
    dx, dv = j11 * dx + j12 * dv + k.j13 * dp, j21 * dx + j22 * dv + k.j23 * dp
    norm = math.hypot(dx, dv)
    if dq != 0.0:
        norm = math.hypot(norm, dq)
    if not (norm > 0.0 and norm < math.inf):
        return 1.0, 0.0, 0.0, -math.inf if norm == 0.0 else math.nan
    return dx / norm, dv / norm, dq / norm, math.log(norm)


class Divergence(NamedTuple):
    """A perturbation, and its growth since it began or a rest erased the one before.

    dx, dv, dp : perturbation of (x, x') and of the momentum of both bodies, of length 1
    growth : logarithm of its growth
    """

    dx: float
    dv: float
    dp: float
    growth: float


@jit
def no_divergence():
    """Return a perturbation that has not grown yet."""
    return Divergence(1.0, 0.0, 0.0, 0.0)


@jit
def add_divergence(divergence, jacobian, coupling):
    """Return the divergence a forcing period later; it begins anew after a rest and where the Jacobian is unknown."""
    dx, dv, dp, growth = perturbation_growth(
        jacobian, coupling, divergence.dx, divergence.dv, divergence.dp
    )
    if not growth > -math.inf:
        return no_divergence()
    return Divergence(dx, dv, dp, divergence.growth + growth)


@jit
def is_chaotic(divergence) -> bool:
    """Return whether a perturbation has grown as it only does along a chaotic motion."""
    return divergence.growth > CHAOTIC_GROWTH


@jit_inline
def count_on_support_1(log) -> int:
    """Return the number of logged impacts on support 1."""
    n = 0
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        n += abs(log.support[i]) == 1
    return n


@jit
def contraction(p, periods, on_1, on_2):
    """Return the logarithm of the factor by which areas of the section shrink, per forcing period.

    Damping shrinks them by exp(-h tau), each impact by R^2, the determinants of flow and saltation matrices.

    periods, on_1, on_2 : forcing periods, and impacts on each support in them
    """
    total = p.h * forcing_period(p) * periods
    for n, restitution in ((on_1, p.R1), (on_2, p.R2)):
        if n > 0:
            total -= 2.0 * n * math.log(restitution) if restitution > 0.0 else -math.inf
    return total / periods


class GrowthSums(NamedTuple):
    """A perturbation, and sums of the logarithms of its growth over blocks of forcing periods.

    dx, dv, dp : perturbation of (x, x') and of the momentum of both bodies, of length 1
    periods : forcing periods
    block : sum over the block that is not complete
    total, squares : sum of the complete blocks but the first, and of their squares
    """

    dx: float
    dv: float
    dp: float
    periods: int
    block: float
    total: float
    squares: float


@jit
def no_growth():
    """Return sums over no periods."""
    return GrowthSums(1.0, 0.0, 0.0, 0, 0.0, 0.0, 0.0)


@jit
def add_growth(sums, jacobian, coupling):
    """Return the sums with a forcing period more, given by the Jacobian of its return map."""
    dx, dv, dp, log_growth = perturbation_growth(jacobian, coupling, sums.dx, sums.dv, sums.dp)
    periods, block = sums.periods + 1, sums.block + log_growth
    if periods % BLOCK_PERIODS > 0:
        return GrowthSums(dx, dv, dp, periods, block, sums.total, sums.squares)
    if periods == BLOCK_PERIODS:
        block = 0.0
    return GrowthSums(dx, dv, dp, periods, 0.0, sums.total + block, sums.squares + block * block)


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
