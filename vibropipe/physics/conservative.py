"""The conservative exciter, eqs. (7)-(10): h = f = 0, R1 = R2 = 1, in closed form.

Between impacts the motion is an arc of x = A cos(angle); each support cuts the arc off, and the motion runs
to and fro between the two ends. Everything follows from the angles of the ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibropipe.compiler import jit
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import largest_force

Array = NDArray[np.float64]
# A motion whose highest point is within this share of a support grazes it (as in the search for impacts).
GRAZING_TOLERANCE = 2.0**-44
# Motions that leave a support they are pressed to by less than this share of their size are marched instead:
# their arc is a small difference of angles.
SHALLOW = 1e-4


def backbone_velocity(delta_over_l: Array, tau_bar: Array) -> Array:
    """Velocity before impact on support 1 over l, eq. (10), of a motion of period tau_bar that strikes both
    supports; nan where such a motion does not exist."""
    d, half = np.asarray(delta_over_l, float), 0.5 * np.asarray(tau_bar, float)
    with np.errstate(all="ignore"):
        velocity = (1 - d + (1 + d) * np.cos(half)) / np.sin(half)
        # Energy: the square of the velocity at support 2 exceeds that at support 1 by 4 delta/l.
        struck = (half > 0) & (half < np.pi) & (velocity > 0) & (velocity**2 + 4 * d > 0)
        return np.where(struck, velocity, np.nan)


class Arc(NamedTuple):
    """A free motion, seen from the side on which it or the equilibrium lies, so that mirrored exciters give
    mirrored results to the last bit.

    sign: 1, or -1 if x is mirrored; amplitude A; angle `top` of the upper end; half its period; time `time_from_top`
    the upper end at the start (0 <= since < 2 half); how each end meets its support: 0 not, 1 by impact, 2 by
    grazing. The upper end belongs to support 1, or to support 2 where x is mirrored.
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
    if abs(amplitude - reach) <= GRAZING_TOLERANCE * amplitude:
        return 2
    return 1 if amplitude > reach else 0


@jit
def is_conservative(p, x, v) -> bool:
    """Whether a motion from (x, v) is conservative and wide enough for its closed form."""
    if p.h != 0.0 or largest_force(p) != 0.0 or p.R1 != 1.0 or p.R2 != 1.0:
        return False
    least = max(support_position(p, 2), -support_position(p, 1))
    return math.hypot(x, v) > max(0.0, least * (1.0 + SHALLOW))


@jit
def _is_mirrored(p, x, v) -> bool:
    if p.delta != 0.0:
        return p.delta < 0.0
    return x < 0.0 or (x == 0.0 and v < 0.0)


@jit
def arc(p, x, v) -> Arc:
    """The free motion from (x, v) between the supports of p."""
    upper, lower, sign = support_position(p, 1), support_position(p, 2), 1.0
    if _is_mirrored(p, x, v):
        upper, lower, sign, x, v = -lower, -upper, -1.0, -x, -v
    amplitude = math.hypot(x, v)
    meets_top, meets_bottom = _contact_kind(upper, amplitude), _contact_kind(-lower, amplitude)
    top, bottom = 0.0, math.pi
    # The angle of an end by the speed there, which keeps its digits where the arc cosine is blind.
    if meets_top == 1:
        top = math.atan2(speed_at(x, v, upper), upper)
    if meets_bottom == 1:
        bottom = math.atan2(speed_at(x, v, lower), lower)
    half = bottom - top
    down = min(max(math.atan2(abs(v), x) - top, 0.0), half)
    if x >= upper and meets_top == 1:
        down = 0.0
    elif x <= lower and meets_bottom == 1:
        down = half
    time_from_top = down if v <= 0.0 or down == 0.0 else 2.0 * half - down
    return Arc(sign, amplitude, top, half, time_from_top, meets_top, meets_bottom)


@jit
def speed_at(x, v, position):
    """Speed at `position` of the free motion through (x, v), by its energy."""
    return math.sqrt(max(0.0, v * v + (x - position) * (x + position)))


@jit
def top_support(a: Arc) -> int:
    """The support at the upper end; the other one stands at the lower."""
    return 1 if a.sign > 0.0 else 2


@jit
def arc_state(a: Arc, tau):
    """(x, v) of the motion a time tau after its start."""
    s = (tau + a.time_from_top) % (2.0 * a.half)
    down = s if s < a.half else 2.0 * a.half - s
    angle = a.top + down
    v = a.sign * a.amplitude * math.sin(angle)
    return a.sign * a.amplitude * math.cos(angle), -v if s < a.half else v


@jit
def arc_harmonic(a: Arc, k: int) -> complex:
    """X_k of x = sum over all k of X_k exp(i k w tau), w = pi/half, tau from the start.

    About its upper end the motion is even: the integral of cos(top + s) cos(k w s) over half a period, with
    sin(z)/z as one function, then shifted to the start.
    """
    rate = k * math.pi / a.half
    total = 0.0
    for sign in (1.0, -1.0):
        phase = 0.5 * (1.0 + sign * rate) * a.half
        sinc = math.sin(phase) / phase if abs(phase) > 1e-8 else 1.0
        total += 0.5 * a.sign * a.amplitude * sinc * math.cos(phase + a.top)
    angle = rate * a.time_from_top
    return complex(total * math.cos(angle), total * math.sin(angle))
