"""The exciter where no impact can occur: the steady state of eq. (5) in closed form, under a certificate."""

from __future__ import annotations

import math

from vibropipe.jit import jit


@jit
def linear_amplitude(p) -> complex:
    """X of the steady motion x = 2 Re(X exp(i nu tau)) of eq. (5) without supports: -i f/2 / (1 - nu^2 + i h nu)."""
    d = complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu)
    if p.f == 0.0:
        return complex(0.0, 0.0)
    return complex(0.0, -0.5 * p.f) / d


@jit
def never_strikes(p, x, v) -> bool:
    """Certificate that the damped motion from (x, v) reaches no support, ever.

    The motion is the steady one, of amplitude 2 |X|, plus a free one z with (z^2 + z'^2)' = -2 h z'^2 <= 0:
    |x| never exceeds 2 |X| + sqrt(z0^2 + z0'^2). Needs h > 0, so that z dies out.
    """
    if not p.h > 0.0:
        return False
    amplitude = linear_amplitude(p)
    free = math.hypot(x - 2.0 * amplitude.real, v + 2.0 * p.nu * amplitude.imag)
    bound = (2.0 * abs(amplitude) + free) * (1.0 + 1e-12)
    return bound < p.l + p.delta and bound < p.l - p.delta
