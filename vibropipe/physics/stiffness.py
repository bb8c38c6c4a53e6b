"""Soft supports: while the mass is beyond support i, k_i (x - b_i) + h_i x' acts on it.

With y = sigma (x - b_i), the gap, a contact is the linear motion y'' + (h + h_i) y' + (1 + k_i) y = load + sigma F at
y < 0. It begins and ends at y = 0, where the spring is at rest, so velocity and displacement are continuous.
One that only pushes acts while k_i y + h_i y' < 0: the mass is free between the zeros of that force, which is
continuous there.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, TAYLOR_FACTORS, free_flow
from vibropipe.physics.load import first_terms, first_terms_of_second, next_term


@jit_inline
def stiffness_of(p, support):
    """Return k_i of support 1 or 2; 0 where it is rigid."""
    return p.k1 if support == 1 else p.k2


@jit_inline
def damping_of(p, support):
    """Return h_i of support 1 or 2."""
    return p.h1 if support == 1 else p.h2


@jit_inline
def is_soft(e, p, support) -> bool:
    """Return whether `support`, 1 or 2, is soft; 0, the equilibrium, is none."""
    if e.soft is None:
        return False
    return support > 0 and stiffness_of(p, support) > 0.0


def lets_go(p, support) -> bool:
    """Return whether a soft support lets go of the mass before it would pull: one without damping never would."""
    contact, damping = (p.contact_1, p.h1) if support == 1 else (p.contact_2, p.h2)
    return contact > 0.0 and damping > 0.0


_lets_go = jit_inline(lets_go)


@jit_inline
def only_pushes(e, p, support) -> bool:
    """Return `lets_go`; compiled only with the effect."""
    if e.no_pull is None:
        return False
    return _lets_go(p, support)


@jit_inline
def pull_of_support(p, support, y, w):
    """Return the force of a soft support towards itself on a mass at the gap y: it pulls where that is > 0."""
    return stiffness_of(p, support) * y + damping_of(p, support) * w


@jit
def energy_in_supports(e, p, x):
    """Return the energy stored in soft supports at the displacement x from the equilibrium."""
    energy = 0.0
    if e.soft is not None:
        above, below = max(0.0, x - support_position(p, 1)), max(0.0, support_position(p, 2) - x)
        energy = 0.5 * (stiffness_of(p, 1) * above * above + stiffness_of(p, 2) * below * below)
    return energy


@jit
def piece_rate(stiffness: float, damping: float) -> float:
    """Return the largest rate of y'' + damping y' + stiffness y = 0: the root of s^2 = |damping| s + stiffness."""
    return 0.5 * (abs(damping) + math.sqrt(damping * damping + 4.0 * stiffness))


@jit
def piece_taylor(c, y, w, force, load, stiffness, damping, nu, dt, second=None) -> None:
    """Fill c so that y(t0 + theta dt) = sum(c[n] theta**n) for y'' + damping y' + stiffness y = load + force.

    Arguments are those of `flow.taylor`, which is the case of stiffness 1.
    """
    d2 = dt * dt
    stiffness_d2, hd = stiffness * d2, damping * dt
    term, term_next = first_terms(force, nu * dt)
    c[0] = y
    c[1] = w * dt
    c[2] = 0.5 * (d2 * (term + load) - hd * c[1] - stiffness_d2 * y)
    if second is not None:
        other, other_next = first_terms_of_second(force, 2.0 * nu * dt)
        c[2] += 0.5 * d2 * other
    for n in range(1, DEGREE - 1):
        c[n + 2] = (
            d2 * term_next - stiffness_d2 * c[n] - hd * (n + 1) * c[n + 1]
        ) * TAYLOR_FACTORS[n]
        term, term_next = term_next, next_term(term, nu * dt, TAYLOR_FACTORS[n - 1])
        if second is not None:
            c[n + 2] += d2 * other_next * TAYLOR_FACTORS[n]
            other, other_next = other_next, next_term(other, 2.0 * nu * dt, TAYLOR_FACTORS[n - 1])


@jit
def piece_flow(stiffness: float, damping: float, t: float):
    """Return the matrix (e11, e12, e21, e22) of y'' + damping y' + stiffness y = 0 over the time t."""
    root = math.sqrt(stiffness)
    e11, e12, e21, e22 = free_flow(damping / root, root * t)
    return e11, e12 / root, e21 * root, e22


@jit
def piece_mean_acceleration(y, w, force_mean, stiffness, damping, dt):
    """Return the mean acceleration of a step of Newmark's method: `newmark.mean_acceleration` at any stiffness."""
    return (force_mean - (damping + 0.5 * stiffness * dt) * w - stiffness * y) / (
        1.0 + 0.5 * damping * dt + 0.25 * stiffness * dt * dt
    )
