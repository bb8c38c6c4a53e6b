"""What happens at a support: reset by eq. (6), chatter, rest and release."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.physics.forcing import TWO_PI, sincos_turns

NEVER = math.inf
# Relative change of the push during the rest of a chatter below which the geometric series is complete.
CHATTER_TOLERANCE = 1e-14


@jit
def frame(p, home: int):
    """(sigma, load, near, far) of motions written from `home`: 0 the equilibrium, 1 or 2 that support.

    x = x_ref + sigma y; near and far are the two supports in y.
    """
    if home == 1:
        return -1.0, p.l + p.delta, 0.0, 2.0 * p.l
    if home == 2:
        return 1.0, p.l - p.delta, 0.0, 2.0 * p.l
    return 1.0, 0.0, p.delta - p.l, p.l + p.delta


@jit
def to_displacement(p, home: int, y: float) -> float:
    """x of the distance y from `home`."""
    if home == 1:
        return (p.l + p.delta) - y
    if home == 2:
        return (p.delta - p.l) + y
    return y


@jit
def to_velocity(home: int, w: float) -> float:
    """x' of the rate w of the distance from `home`."""
    return -w if home == 1 else w


@jit
def reset(restitution: float, approach: float) -> float:
    """Speed of departure after an impact with speed `approach`, eq. (6)."""
    return restitution * approach


@jit
def release_turn(f: float, load: float) -> float:
    """Phase in [0, 1) turns at which the force sigma f sin + load on a resting mass turns positive.

    f: sigma f. NEVER if the force never turns positive; -1 if it always is.
    """
    size = abs(f)
    if load > size:
        return -1.0
    if -load >= size:
        return NEVER
    turn = math.asin(-load / size) / TWO_PI
    if f < 0.0:
        turn += 0.5
    turn -= math.floor(turn)
    return 0.0 if turn >= 1.0 else turn


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


@jit
def force_at(p, sigma: float, u: float):
    """(sigma f sin, sigma f cos) at the phase u in turns."""
    s, c = sincos_turns(u)
    return sigma * (p.f * s), sigma * (p.f * c)
