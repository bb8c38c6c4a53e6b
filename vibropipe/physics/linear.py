"""The exciter where no impact can occur: the steady state of eq. (5) in closed form, under a certificate."""

from __future__ import annotations

import math

from vibropipe.jit import jit
from vibropipe.physics.forcing import sincos_turns


@jit
def linear_amplitude(p) -> complex:
    """X of the steady motion x = 2 Re(X exp(i nu tau)) of eq. (5) without supports: -i f/2 / (1 - nu^2 + i h nu);
    infinite at resonance without damping."""
    d = complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu)
    if p.f == 0.0:
        return complex(0.0, 0.0)
    if d == 0.0:
        return complex(math.inf, 0.0)
    return complex(0.0, -0.5 * p.f) / d


@jit
def steady_at(p, turn):
    """(x, x') of the steady motion at the phase `turn`, in turns."""
    return turned_by(p, linear_amplitude(p), turn)


@jit
def turned_by(p, amplitude, turn):
    """(x, x') of the steady motion of a complex amplitude at the phase `turn`."""
    s, c = sincos_turns(turn)
    at = 2.0 * amplitude * complex(c, s)
    return at.real, -p.nu * at.imag


@jit
def keeps_off(p, x, v, turn) -> bool:
    """Certificate that the motion from (x, v) at the phase `turn` reaches no support, ever.

    The motion is the steady one, of amplitude 2 |X|, plus a free one z with (z^2 + z'^2)' = -2 h z'^2 <= 0:
    |x| never exceeds 2 |X| + sqrt(z0^2 + z0'^2).
    """
    amplitude = linear_amplitude(p)
    steady_x, steady_v = turned_by(p, amplitude, turn)
    bound = (2.0 * abs(amplitude) + math.hypot(x - steady_x, v - steady_v)) * (1.0 + 1e-12)
    return bound < p.l + p.delta and bound < p.l - p.delta


@jit
def never_strikes(p, x, v) -> bool:
    """Whether the motion from (x, v) at tau = 0 surely reaches no support and settles: h > 0."""
    return p.h > 0.0 and keeps_off(p, x, v, 0.0)
