"""What a housing that slides adds to the pieces of a law, and the derivatives of that.

Beside a sliding housing the momentum of both bodies over c = kappa/(1 + kappa), q = X'/c + x', has the rate `pull_of`;
q = x' where the housing is held or stops, and no impact changes it. Written so, no equation has 1/kappa.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import HOME
from vibropipe.orbits.law.law import WAY
from vibropipe.physics.derivatives import (
    HOUSING_FRICTION_1,
    HOUSING_FRICTION_2,
    HOUSING_LOAD,
    LOAD,
    MASS_RATIO,
)
from vibropipe.physics.housing import ground_friction, momentum_share, total_load


@jit
def way_of(law, i):
    """Return in which direction of x the housing slides during piece i; 0 if it is held."""
    way = law.codes[i, WAY]
    return -way if law.codes[i, HOME] == 1 else way


@jit
def pull_of(p, way) -> float:
    """Return the force on both bodies of a housing that slides this way: the rate of q."""
    return total_load(p) - ground_friction(p, way)


@jit
def pull_by(way, k) -> float:
    """Return the derivative of `pull_of` by parameter k."""
    return 1.0 if k in (LOAD, HOUSING_LOAD) else 0.0 - friction_by(way, k)


@jit
def friction_by(way, k) -> float:
    """Return the derivative of `ground_friction` by parameter k, of a housing that slides."""
    if way > 0:
        return 1.0 if k == HOUSING_FRICTION_1 else 0.0
    return -1.0 if way < 0 and k == HOUSING_FRICTION_2 else 0.0


@jit
def carried(p, sigma, way) -> float:
    """Return the load in a frame that moves a mass along with its housing: 0 where that is held."""
    return 0.0 if way == 0 else -sigma * momentum_share(p) * pull_of(p, way)


@jit
def carried_by(p, sigma, way, k) -> float:
    """Return the derivative of `carried` by parameter k."""
    if way == 0:
        return 0.0
    change = -sigma * momentum_share(p) * pull_by(way, k)
    if k == MASS_RATIO:
        change -= sigma * pull_of(p, way) / ((1.0 + p.mass_ratio) * (1.0 + p.mass_ratio))
    return change
