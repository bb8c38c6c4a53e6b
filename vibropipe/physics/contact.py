"""What happens at a support: reset by eq. (6), chatter, rest and release."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.load import NEVER, constant_load

# Relative change of the push during the rest of a chatter below which the geometric series is complete.
CHATTER_TOLERANCE = 1e-14


@jit_inline
def support_position(p, support):
    """x of a support, eq. (1)."""
    return p.l + p.delta if support == 1 else p.delta - p.l


@jit
def frame(p, home: int):
    """(sigma, load, near, far) of motions written from `home`: 0 the equilibrium, 1 or 2 that support.

    x = x_ref + sigma y; near and far are the two supports in y.
    """
    sigma = -1.0 if home == 1 else 1.0
    if home == 0:
        return sigma, constant_load(sigma, 0.0), support_position(p, 2), support_position(p, 1)
    return sigma, constant_load(sigma, support_position(p, home)), 0.0, 2.0 * p.l


@jit
def to_displacement(p, home: int, y: float) -> float:
    """x of the distance y from `home`."""
    if home == 0:
        return y
    return support_position(p, home) + (-y if home == 1 else y)


@jit
def to_velocity(home: int, w: float) -> float:
    """x' of the rate w of the distance from `home`."""
    return -w if home == 1 else w


@jit
def reset(restitution: float, approach: float) -> float:
    """Speed of departure after an impact with speed `approach`, eq. (6)."""
    return restitution * approach


@jit
def chatter_duration(w, push, push_rate, restitution, h, nu) -> float:
    """Time from an impact with departure speed w to the accumulation of all further ones, or NEVER while
    the geometric series would still err.

    push < 0: acceleration at the support, push_rate its rate. To leading order the flights last
    2 w R^k / |push|; the error is the duration times the relative change of the push meanwhile, which must be
    below CHATTER_TOLERANCE of the shorter of the two time scales. A flight so short that tau cannot tell
    its ends apart counts as rest for every R, R = 1 included.
    """
    unit = CHATTER_TOLERANCE * min(1.0, 1.0 / nu)
    flight = 2.0 * w / -push
    if flight <= unit:
        return flight
    if restitution >= 1.0:
        return NEVER
    duration = flight / (1.0 - restitution)
    change = duration * (abs(push_rate / push) + h)
    return duration if duration * change <= unit else NEVER
