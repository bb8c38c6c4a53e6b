"""A housing that carries the supports, slides on the ground and is held by dry friction there.

With X its displacement, kappa = m/M and x relative to it,

    x'' = -X'' + F,    X'' = kappa (load + housing_load - F - r),    F = force + load - x - h x' - contact - friction,

r = housing_friction_1 while X' > 0 and -housing_friction_2 while X' < 0. The momentum of both bodies, P = X' + c x'
with c = kappa/(1 + kappa), has the rate c (load + housing_load - r): it is linear in time while the housing slides, and
no impact changes it. Then x'' = (1 + kappa) (F - P'): eq. (5) with all terms times 1 + kappa, and a constant load more.
Held, P = c x'.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import types
from numba.extending import overload

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.load import Force

STANDS = 0
# Power of time with which the velocity of a housing leaves zero: 0 where it is not zero, and where a housing is held
# within a step in which rounding decides whether it is.
MOVES, BY_ACCELERATION, BY_JERK, UNWATCHED = 0, 1, 2, -1
# Duration, in tau, of what is left of a chatter that is rounding (`contact.CHATTER_TOLERANCE`).
SHORTEST_CHATTER = 1e-14


class Housing(NamedTuple):
    """State of a housing.

    way : sign of its velocity, or of the one that it is about to have; STANDS
    power : MOVES, BY_ACCELERATION or BY_JERK; where it is held 0 or UNWATCHED
    momentum : P, in the direction of x
    displacement : X
    """

    way: int
    power: int
    momentum: float
    displacement: float


@jit_inline
def momentum_share(p):
    """Return c = kappa/(1 + kappa), the share of the mass in both bodies."""
    return p.mass_ratio / (1.0 + p.mass_ratio)


@jit_inline
def total_load(p):
    """Return the constant force on both bodies, friction apart."""
    return p.load + p.housing_load


@jit
def runs_away(p) -> bool:
    """Return whether the constant force exceeds the friction of the ground: the momentum of both bodies then grows."""
    force = total_load(p)
    return p.mass_ratio > 0.0 and (force > p.housing_friction_1 or force < -p.housing_friction_2)


@jit
def ground_friction(p, way) -> float:
    """Return the friction of the ground against a housing that slides this way."""
    if way == STANDS:
        return 0.0
    return p.housing_friction_1 if way > 0 else -p.housing_friction_2


@jit
def momentum_rate(p, way) -> float:
    """Return P' of a housing that slides this way; 0 of one that is held, whose P follows the mass."""
    if way == STANDS:
        return 0.0
    return momentum_share(p) * (total_load(p) - ground_friction(p, way))


@jit
def load_of_sliding(p, sigma, housing=None) -> float:
    """Return the constant load that sliding adds in a frame: 0 without a housing or where it is held."""
    if housing is None:
        return 0.0
    return -sigma * momentum_rate(p, housing.way)


@jit
def inertia_factor(p, housing=None) -> float:
    """Return the factor of all forces on the mass: 1 + kappa where the housing slides, else 1."""
    if housing is None:
        return 1.0
    return 1.0 if housing.way == STANDS else 1.0 + p.mass_ratio


@jit
def kinetic_change(p, before, after) -> float:
    """Return the kinetic energy of both bodies gained between two momenta, but for that of x'; 0 without a housing.

    It is the energy of the centre of mass. That of x' is x'^2/2 over 1 + kappa.
    """
    if p.mass_ratio == 0.0:
        return 0.0
    return 0.5 * (after - before) * (after + before) / momentum_share(p)


@jit
def times_force(factor, force) -> Force:
    """Return a `Force` times a factor."""
    return Force(
        factor * force.sine, factor * force.cosine, factor * force.sine_2, factor * force.cosine_2
    )


@jit
def velocity_of(p, housing, v) -> float:
    """Return X' at the velocity v of x."""
    return 0.0 if housing.way == STANDS else housing.momentum - momentum_share(p) * v


@jit
def housing_with(p, v, velocity):
    """Return a housing with a velocity, X = 0, at the velocity v of x."""
    way = 1 if velocity > 0.0 else -1 if velocity < 0.0 else STANDS
    return Housing(way, MOVES, velocity + momentum_share(p) * v, 0.0)


def start_of_housing(effect, p, v, velocity):
    """Return `housing_with`; None without the effect."""
    return None if effect is None else housing_with(p, v, velocity)


@overload(start_of_housing)
def _compiled_start(effect, p, v, velocity):
    # a compiled function returns one type: which of both is known from that of the effect
    if isinstance(effect, types.NoneType):
        return lambda effect, p, v, velocity: None
    return lambda effect, p, v, velocity: housing_with(p, v, velocity)


@jit
def moved(p, housing, span, dx, v):
    """Return the housing after a time `span` in which x has changed by dx, to the velocity v; None without one."""
    if housing is None:
        return housing
    if housing.way == STANDS:
        return Housing(STANDS, MOVES, momentum_share(p) * v, housing.displacement)
    change = momentum_rate(p, housing.way) * span
    drift = (housing.momentum + 0.5 * change) * span - momentum_share(p) * dx
    power = housing.power if span == 0.0 else MOVES
    return Housing(housing.way, power, housing.momentum + change, housing.displacement + drift)


@jit
def stays_on_its_way(p, housing, w, span) -> bool:
    """Return whether a housing neither stops nor is held over a chatter of speeds up to w, or the time is no more.

    Without one it does. Hops that are shorter than the rounding of a phase count as none.
    """
    if housing is None or span <= SHORTEST_CHATTER:
        return True
    if housing.way == STANDS:
        return False
    slowest = housing.way * housing.momentum - momentum_share(p) * w
    return slowest > abs(momentum_rate(p, housing.way)) * span


@jit
def before_chatter(before, after):
    """Return the housing of a mass that rests after the tail of a chatter, as it was before; None without one."""
    if before is None:
        return before
    return Housing(after.way, after.power, before.momentum, before.displacement)


@jit
def stopped(p, housing, v):
    """Return a housing without velocity, at the velocity v of x."""
    return Housing(STANDS, MOVES, momentum_share(p) * v, housing.displacement)


@jit
def struck(p, housing, before, after):
    """Return the housing after an impact that changes the velocity of x; None without one.

    Its momentum stays, so that a held housing is pushed off.
    """
    if housing is None:
        return housing
    share = momentum_share(p)
    momentum = share * before if housing.way == STANDS else housing.momentum
    velocity = momentum - share * after
    way = 1 if velocity > 0.0 else -1 if velocity < 0.0 else STANDS
    return Housing(way, MOVES, momentum, housing.displacement)
