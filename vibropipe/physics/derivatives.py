"""Derivatives by the parameters: of supports, restitution, force, and the acceleration of a gap.

A further parameter adds its name to `DIFFERENTIATED` and its part to these functions; one of the force also its source
to `physics.variation`.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import constant_load, force_at, force_value
from vibropipe.physics.turns import sincos_turns

DIFFERENTIATED = ("nu", "f", "h", "l", "delta", "R1", "R2", "load")
"""The parameters by which motions are differentiated, in the order of derivatives."""
NU, F, H, L, DELTA, R1, R2, LOAD = range(8)
N_PARAMETERS = len(DIFFERENTIATED)
DIFFERENTIATED_PIECES = (*DIFFERENTIATED, "k1", "k2", "h1", "h2", "friction")
"""The same of motions with soft supports or friction."""
K1, K2, H1, H2, FRICTION = range(8, 13)
N_OF_PIECES = len(DIFFERENTIATED_PIECES)


@jit
def support_derivative(support, k):
    """Return the derivative of `support_position` by parameter k."""
    if k == DELTA:
        return 1.0
    if k == L:
        return 1.0 if support == 1 else -1.0
    return -1.0 if k == LOAD else 0.0


@jit
def restitution_derivative(support, k):
    """Return the derivative of the restitution of a support (1 or 2) by parameter k."""
    return 1.0 if k == (R1 if support == 1 else R2) else 0.0


@jit
def distance_derivative(k):
    """Return the derivative of the distance 2l of the supports by parameter k."""
    return 2.0 if k == L else 0.0


@jit
def load_derivative(support, k):
    """Return the derivative of the constant load in the frame of a support by parameter k."""
    return constant_load(-1.0 if support == 1 else 1.0, support_derivative(support, k))


@jit
def force_derivative(turn, k):
    """Return the derivative of the force of eq. (5) by parameter k at a phase, in turns."""
    return sincos_turns(turn)[0] if k == F else 0.0


@jit
def gap_acceleration(p, support, turn, y, w, second=None):
    """Return y'' at the distance y from a support, with the rate w, at a phase in turns."""
    sigma = -1.0 if support == 1 else 1.0
    load = constant_load(sigma, support_position(p, support))
    return force_value(force_at(p, sigma, turn, second), second) + load - p.h * w - y


@jit
def gap_acceleration_derivative(support, turn, w, k):
    """Return the derivative of `gap_acceleration` by parameter k at fixed phase, y and w."""
    sigma = -1.0 if support == 1 else 1.0
    return load_derivative(support, k) + sigma * force_derivative(turn, k) - (w if k == H else 0.0)
