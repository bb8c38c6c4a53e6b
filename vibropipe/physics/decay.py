"""Contacts that are slow although they are stiff or strongly damped: what remains once fast exponents have decayed.

The motion y'' + damping y' + stiffness y = load + force is its forced motion and two exponentials. Of real exponents
the faster one decays first: the mass then creeps, a motion of first order. Once both have decayed the mass follows the
force. Either motion is smooth on the scale of what is left, and is stepped on that scale: a contact with the damping
1e9 lasts as long as others and has 1e9 fast time scales.

With s the faster exponent the creep is y' + (stiffness/s) y = G, where G' + s G = load + force is the slow solution.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.physics.flow import DEGREE, TAYLOR_FACTORS
from vibropipe.physics.load import (
    Force,
    fastest_forcing,
    first_terms,
    first_terms_of_second,
    force_slope,
    force_value,
    next_term,
    no_force,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.stiffness import piece_rate

# What is left of a contact: both exponentials, the slower one, neither.
ALIVE, CREEPING, FOLLOWING = range(3)
# Size of an exponential that counts as decayed, as a share of the motion: some roundings of it.
DECAYED = 2.0**-46


class Decay(NamedTuple):
    """What is left of a contact.

    kind : ALIVE, CREEPING or FOLLOWING
    rate : fastest rate of what is left: a polynomial is exact to rounding over REACH / rate
    slow : exponent of the creep
    load : constant part of G (CREEPING), or of the forced motion (FOLLOWING)
    force : their part that follows the force
    """

    kind: int
    rate: float
    slow: float
    load: float
    force: Force


@jit
def _response(sine, cosine, denominator: complex):
    """Return sine and cosine of the response to the force Im[(cosine + i sine) exp(i w t)]."""
    response = divide(complex(cosine, sine), denominator)
    return response.imag, response.real


@jit
def _forced(force, nu, second, zero, first, squared):
    """Return the `Force` of the response to a force through zero + first (i w) + squared (i w)^2."""
    w = nu
    sine, cosine = _response(force.sine, force.cosine, complex(zero - squared * w * w, first * w))
    sine_2, cosine_2 = 0.0, 0.0
    if second is not None:
        w = 2.0 * nu
        sine_2, cosine_2 = _response(
            force.sine_2, force.cosine_2, complex(zero - squared * w * w, first * w)
        )
    return Force(sine, cosine, sine_2, cosine_2)


@jit
def decay_of_kind(kind, force, load, stiffness, damping, p, second):
    """Return the `Decay` of a contact of which it is known what is left; arguments as for `decay_of`."""
    forcing = fastest_forcing(p, second)
    if kind == FOLLOWING:
        forced = _forced(force, p.nu, second, stiffness, damping, 1.0)
        return Decay(FOLLOWING, forcing, 0.0, load / stiffness, forced)
    if kind == CREEPING:
        half, root = 0.5 * damping, math.sqrt(stiffness)
        fast = half + math.sqrt((half - root) * (half + root))
        slow = stiffness / fast
        driven = _forced(force, p.nu, second, fast, 1.0, 0.0)
        return Decay(CREEPING, max(slow, forcing), slow, load / fast, driven)
    return Decay(ALIVE, max(piece_rate(stiffness, damping), forcing), 0.0, 0.0, no_force())


@jit
def decay_of(y, w, force, load, stiffness, damping, p, second):
    """Return the `Decay` of a contact in the state (y, w).

    y, w : displacement and velocity in the frame of the contact
    force : at the time of the state
    load, stiffness, damping : of the piece
    second : the effect `second_harmonic`
    """
    alive = decay_of_kind(ALIVE, force, load, stiffness, damping, p, second)
    if not damping > 0.0:
        return alive
    largest = abs(load) + math.hypot(force.sine, force.cosine)
    if second is not None:
        largest += math.hypot(force.sine_2, force.cosine_2)
    following = decay_of_kind(FOLLOWING, force, load, stiffness, damping, p, second)
    off_y = abs(y - following.load - force_value(following.force, second))
    off_w = abs(w - p.nu * force_slope(following.force, second))
    fast = piece_rate(stiffness, damping)
    if off_y <= DECAYED * (largest / stiffness) and off_w <= DECAYED * (largest / fast):
        return following
    if not 0.5 * damping > math.sqrt(stiffness):
        return alive
    creeping = decay_of_kind(CREEPING, force, load, stiffness, damping, p, second)
    slow = creeping.slow
    off_w = abs(w - (creeping.load + force_value(creeping.force, second) - slow * y))
    return creeping if off_w <= DECAYED * (largest / fast + slow * abs(y)) else alive


@jit
def decayed_taylor(c, y, decay, nu, dt, second) -> None:
    """Fill c, (DEGREE + 1,), so that y(t0 + theta dt) = sum(c[n] theta**n), for a `Decay` that is not ALIVE."""
    term, term_next = first_terms(decay.force, nu * dt)
    other, other_next = 0.0, 0.0
    if second is not None:
        other, other_next = first_terms_of_second(decay.force, 2.0 * nu * dt)
    creeps, share = decay.kind == CREEPING, decay.slow * dt
    c[0] = y
    for n in range(DEGREE):
        if creeps:
            driving = term + other
            if n == 0:
                driving += decay.load
            c[n + 1] = (dt * driving - share * c[n]) / (n + 1)
        else:
            c[n + 1] = term_next + other_next
        if n < DEGREE - 1:
            term, term_next = term_next, next_term(term, nu * dt, TAYLOR_FACTORS[n])
            if second is not None:
                other, other_next = other_next, next_term(other, 2.0 * nu * dt, TAYLOR_FACTORS[n])
