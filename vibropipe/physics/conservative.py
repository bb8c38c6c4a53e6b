"""The conservative exciter, eqs. (7)-(10): h = f = 0, R1 = R2 = 1, in closed form.

Between impacts the motion is an arc of x = A cos(angle). Each support cuts the arc off, and the motion oscillates
between the two ends. All quantities follow from the angles of the ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibropipe.compiler import jit
from vibropipe.physics.contact import GRAZING_TOLERANCE, support_offset, support_position
from vibropipe.physics.load import largest_force

Array = NDArray[np.float64]
# Least relative excess of the amplitude over the distance of a support that presses on the mass at the equilibrium:
# a smaller arc is a difference of nearly equal angles, and such motions are marched.
SHALLOW = 1e-4


def backbone_velocity(delta_over_l: Array, tau_bar: Array) -> Array:
    """Return the velocity before the impact on support 1 over l, eq. (10).

    delta_over_l, tau_bar : relative offset, and period of the free vibration that strikes both supports; broadcast

    Returns nan where no such motion exists.
    """
    d, half = np.asarray(delta_over_l, float), 0.5 * np.asarray(tau_bar, float)
    with np.errstate(all="ignore"):
        velocity = (1 - d + (1 + d) * np.cos(half)) / np.sin(half)
        # That at support 2 is the same with the other sign of delta.
        struck = (half > 0) & (half < np.pi) & (velocity > 0) & (1 + d + (1 - d) * np.cos(half) > 0)
        return np.where(struck, velocity, np.nan)


class Arc(NamedTuple):
    """A conservative motion, mirrored to the side on which it or the equilibrium lies.

    Mirrored exciters thus give mirrored results bit for bit. The upper end belongs to support 1, or to support 2 where
    x is mirrored.

    sign : 1, or -1 if x is mirrored
    amplitude : A
    top : angle of the upper end
    half : half the period
    time_from_top : time from the upper end to the start, in [0, 2 half)
    meets_top, meets_bottom : contact at each end: 0 none, 1 impact, 2 grazing
    """

    sign: float
    amplitude: float
    top: float
    half: float
    time_from_top: float
    meets_top: int
    meets_bottom: int


@jit
def _contact_kind(reach, amplitude) -> int:
    """Return the kind of contact at a support at distance `reach`: 0 none, 1 impact, 2 grazing."""
    if abs(amplitude - reach) <= GRAZING_TOLERANCE * amplitude:
        return 2
    return 1 if amplitude > reach else 0


@jit
def is_conservative(p, x, v) -> bool:
    """Return whether a motion has the closed form of this module.

    x, v : start

    Returns True if h = f = 0, R1 = R2 = 1 and the motion is wide enough (`SHALLOW`).
    """
    if p.h != 0.0 or largest_force(p) != 0.0 or p.R1 != 1.0 or p.R2 != 1.0:
        return False
    outside_distance = max(support_position(p, 2), -support_position(p, 1))
    return math.hypot(x, v) > max(0.0, outside_distance * (1.0 + SHALLOW))


@jit
def _is_mirrored(p, x, v) -> bool:
    """Return whether `arc` mirrors x: for delta < 0 or, without offset, by the start."""
    offset = support_offset(p)
    if offset != 0.0:
        return offset < 0.0
    return x < 0.0 or (x == 0.0 and v < 0.0)


@jit
def arc(p, x, v) -> Arc:
    """Return the conservative motion from a start between the supports.

    p : of an exciter with h = f = 0, R1 = R2 = 1
    x, v : start, one that `is_conservative`
    """
    upper, lower, sign = support_position(p, 1), support_position(p, 2), 1.0
    if _is_mirrored(p, x, v):
        upper, lower, sign, x, v = -lower, -upper, -1.0, -x, -v
    amplitude = math.hypot(x, v)
    meets_top, meets_bottom = _contact_kind(upper, amplitude), _contact_kind(-lower, amplitude)
    top, bottom = 0.0, math.pi
    # Angles from the speed at the ends: an arc cosine loses half the digits near 1.
    if meets_top == 1:
        top = math.atan2(speed_at(x, v, upper), upper)
    if meets_bottom == 1:
        bottom = math.atan2(speed_at(x, v, lower), lower)
    half = bottom - top
    time_down = min(max(math.atan2(abs(v), x) - top, 0.0), half)
    if x >= upper and meets_top == 1:
        time_down = 0.0
    elif x <= lower and meets_bottom == 1:
        time_down = half
    time_from_top = time_down if v <= 0.0 or time_down == 0.0 else 2.0 * half - time_down
    return Arc(sign, amplitude, top, half, time_from_top, meets_top, meets_bottom)


@jit
def speed_at(x, v, position):
    """Return the speed at `position` of the conservative motion through (x, v), from its energy."""
    return math.sqrt(max(0.0, v * v + (x - position) * (x + position)))


@jit
def top_support(a: Arc) -> int:
    """Return the support (1 or 2) at the upper end; the other one is at the lower end."""
    return 1 if a.sign > 0.0 else 2


@jit
def arc_state(a: Arc, tau):
    """Return (x, v) of the motion a time tau after its start."""
    s = (tau + a.time_from_top) % (2.0 * a.half)
    time_down = s if s < a.half else 2.0 * a.half - s
    angle = a.top + time_down
    v = a.sign * a.amplitude * math.sin(angle)
    return a.sign * a.amplitude * math.cos(angle), -v if s < a.half else v


@jit
def arc_harmonic(a: Arc, k: int) -> complex:
    """Return the complex amplitude X_k of a harmonic.

    The motion is even about its upper end: X_k is the integral of cos(top + s) cos(k w s) over half a period, with
    sin(z)/z as one function, shifted to the start.

    Returns X_k of x = sum over all integers k of X_k exp(i k w tau), w = pi/half, tau from the start.
    """
    rate = k * math.pi / a.half
    total = 0.0
    for sign in (1.0, -1.0):
        phase = 0.5 * (1.0 + sign * rate) * a.half
        sinc = math.sin(phase) / phase if abs(phase) > 1e-8 else 1.0
        total += 0.5 * a.sign * a.amplitude * sinc * math.cos(phase + a.top)
    angle = rate * a.time_from_top
    return complex(total * math.cos(angle), total * math.sin(angle))
