"""Contact with a rigid support: frames, reset by eq. (6), and the duration of a chatter."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.housing import load_of_sliding
from vibropipe.physics.load import NEVER, constant_load
from vibropipe.physics.start import support_positions

# Largest error of the duration of a chatter summed as a geometric series, as a share of the shorter time scale of
# eq. (5), 1 or 1/nu: a tenth of the rounding of a phase (`TIME_TOLERANCE` of the march).
CHATTER_TOLERANCE = 1e-14
# Largest opening of a gap that counts as grazing, as a share of the lengths that the gap is computed from.
GRAZING_TOLERANCE = 2.0**-44


# Eq. (1) stands in `start`, which needs no compiler.
_support_positions = jit_inline(support_positions)


@jit_inline
def support_position(p, support):
    """Return the displacement of a support (1 or 2) from the equilibrium, which a constant load moves to x = load.

    All kernels count displacements from there: a load is an offset of the supports and nothing else.
    """
    upper, lower = _support_positions(p.l, p.delta)
    return (upper if support == 1 else lower) - p.load


@jit
def restitution_at(p, support):
    """Return the coefficient of restitution of a support (1 or 2)."""
    return p.R1 if support == 1 else p.R2


@jit_inline
def support_offset(p):
    """Return the displacement of the middle between the supports from the equilibrium."""
    return p.delta - p.load


class Frame(NamedTuple):
    """Coordinates of a motion written from `home`: x = x_ref + sigma y.

    home : 0 for the equilibrium, 1 or 2 for that support
    sigma : 1, or -1 from support 1
    load : constant load in y
    near, far : the supports in y: from the equilibrium support 2 is near and support 1 far; from a support that one is
        near
    to_near, to_far : whether the motion can reach them
    """

    home: int
    sigma: float
    load: float
    near: float
    far: float
    to_near: bool
    to_far: bool


@jit_inline
def frame_at(e, p, home: int, housing=None) -> Frame:
    """Return the `Frame` of motions written from `home`, with the load of the sliding of a housing, if there is one.

    A mass stands on no support that is out of reach.

    home : 0 for the equilibrium, 1 or 2 for that support
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
    load = constant_load(sigma, reference)
    if housing is not None:
        load += load_of_sliding(p, sigma, housing)
    return Frame(home, sigma, load, near, far, to_near, to_far)


@jit
def to_displacement(p, home: int, y: float) -> float:
    """Return x of a motion at the distance y from `home`."""
    if home == 0:
        return y
    return support_position(p, home) + (-y if home == 1 else y)


@jit
def to_velocity(home: int, w: float) -> float:
    """Return x' of a motion whose distance from `home` has the rate w."""
    return -w if home == 1 else w


@jit
def reset(restitution: float, approach: float) -> float:
    """Return the speed of departure after an impact with speed `approach`, eq. (6)."""
    return restitution * approach


@jit
def chatter_duration(w, gap_acceleration, gap_jerk, restitution, h, nu) -> float:
    """Return the time from an impact to the accumulation point of all further ones.

    To leading order the flights last 2 w R^k / |gap_acceleration|, a geometric series. Its relative error is the
    relative change of the acceleration during the chatter. A flight so short that tau cannot resolve its ends counts as
    sticking for every R, R = 1 included.

    w : departure speed, > 0
    gap_acceleration : at the support, < 0
    gap_jerk : bound of its rate

    Returns the duration in tau; NEVER while the error of the series exceeds CHATTER_TOLERANCE.

    Reference: C. Budd, F. Dux, "Chattering and related behaviour in impact oscillators", Philosophical Transactions of
    the Royal Society A 347 (1994) 365-389.
    """
    tolerance = CHATTER_TOLERANCE * min(1.0, 1.0 / nu)
    flight = 2.0 * w / -gap_acceleration
    if flight <= tolerance:
        return flight
    if restitution >= 1.0:
        return NEVER
    duration = flight / (1.0 - restitution)
    relative_change = duration * (abs(gap_jerk / gap_acceleration) + h)
    return duration if duration * relative_change <= tolerance else NEVER
