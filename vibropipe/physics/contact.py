"""What happens at a support: reset by eq. (6), chatter, rest and release."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.load import NEVER, constant_load

# Relative change of the push during the rest of a chatter below which the geometric series is complete.
CHATTER_TOLERANCE = 1e-14


@jit_inline
def support_position(p, support):
    """x of a support, eq. (1)."""
    return p.l + p.delta if support == 1 else p.delta - p.l


class Frame(NamedTuple):
    """How a motion is written from `home`, 0 the equilibrium, 1 or 2 that support: x = x_ref + sigma y.

    load: the constant part of its load; near, far: the supports in y; to_near, to_far: whether it can reach them.
    From the equilibrium support 2 is near and support 1 far; from a support that one is near.
    """

    home: int
    sigma: float
    load: float
    near: float
    far: float
    to_near: bool
    to_far: bool


@jit
def frame_at(e, p, home: int) -> Frame:
    """The `Frame` of motions written from `home`; a mass stands on no support that is out of reach.

    Parameters
    ----------
    e, p : Effects, Parameters
    home : int
        0 for the equilibrium, 1 or 2 for that support.
    """
    to_near, to_far = True, True
    if e.support_1 is None:
        to_near, to_far = e.support_2 is not None, False
    elif e.support_2 is None:
        to_near, to_far = home != 0, home == 0
    sigma = -1.0 if home == 1 else 1.0
    reference, near, far = 0.0, support_position(p, 2), support_position(p, 1)
    if home != 0:
        reference, near, far = support_position(p, home), 0.0, 2.0 * p.l
    return Frame(home, sigma, constant_load(sigma, reference), near, far, to_near, to_far)


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
def chatter_duration(w, gap_acceleration, push_rate, restitution, h, nu) -> float:
    """Time from an impact with departure speed w to the accumulation of all further ones, or NEVER while
    the geometric series would still err.

    push < 0: acceleration at the support, push_rate its rate. To leading order the flights last
    2 w R^k / |push|; the error is the duration times the relative change of the push meanwhile, which must be
    below CHATTER_TOLERANCE of the shorter of the two time scales. A flight so short that tau cannot tell
    its ends apart counts as rest for every R, R = 1 included.

    References
    ----------
    C. Budd, F. Dux, "Chattering and related behaviour in impact oscillators", Philosophical Transactions of the
    Royal Society A 347 (1994) 365-389.
    """
    unit = CHATTER_TOLERANCE * min(1.0, 1.0 / nu)
    flight = 2.0 * w / -gap_acceleration
    if flight <= unit:
        return flight
    if restitution >= 1.0:
        return NEVER
    duration = flight / (1.0 - restitution)
    change = duration * (abs(push_rate / gap_acceleration) + h)
    return duration if duration * change <= unit else NEVER
