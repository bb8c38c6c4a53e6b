"""The textbook solution of x'' + h x' + x = f sin(nu tau), in any precision.

The arithmetic is an mpmath context: `digits(p)` for many digits (the default), `mpmath.fp` for
plain doubles.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import mpmath


class Parameters(NamedTuple):
    """An exciter as doubles; the supports lie where doubles put l + delta and -(l - delta)."""

    nu: float = 1.0
    f: float = 0.0
    h: float = 0.0
    l: float = 1.0  # noqa: E741 - the name in the equations
    delta: float = 0.0
    R1: float = 1.0
    R2: float = 1.0

    @property
    def upper(self) -> float:
        return self.l + self.delta

    @property
    def lower(self) -> float:
        return -(self.l - self.delta)


def digits(p: Parameters, wanted: int = 50) -> Any:
    """Return a context of `wanted` digits, and as many more as large near-resonant amplitudes cancel."""
    context = mpmath.MPContext()
    context.dps = 800
    nu, h = context.mpf(p.nu), context.mpf(p.h)
    denominator = (1 - nu**2) ** 2 + (h * nu) ** 2
    cancelled = 0 if denominator == 0 else max(0, -int(context.log10(denominator)))
    context.dps = wanted + cancelled
    return context


class Flight:
    """Solution of x'' + h x' + x = f sin(nu tau) from (tau0, x0, v0): particular solution plus transient.

    Constants are computed once.
    """

    def __init__(self, c: Any, nu: Any, f: Any, h: Any, start: tuple[Any, Any, Any]) -> None:
        self.c, self.nu, self.f, self.h = c, nu, f, h
        denominator = (1 - nu**2) ** 2 + (h * nu) ** 2
        self.resonant = denominator == 0
        if self.resonant:
            self.most_forced = c.inf
        else:
            self.of_sin, self.of_cos = f * (1 - nu**2) / denominator, -f * h * nu / denominator
            self.most_forced = nu**2 * abs(f) / c.sqrt(denominator)
        self.tau0, x0, v0 = start
        xp, vp = self.particular(self.tau0)
        self.y0, self.w0 = y, w = x0 - xp, v0 - vp
        if h < 2:
            self.rate = c.sqrt(1 - h**2 / 4)
            self.b = (w + h / 2 * y) / self.rate
        elif h > 2:
            self.fast = -h / 2 - c.sqrt(h**2 / 4 - 1)
            self.slow = 1 / self.fast
            self.of_fast = (w - self.slow * y) / (self.fast - self.slow)

    def particular(self, tau: Any) -> tuple[Any, Any]:
        nu, f = self.nu, self.f
        cos, sin = self.c.cos_sin(nu * tau)
        if self.resonant:  # h = 0, nu = 1: -(f/2) tau cos(tau)
            return -f / 2 * tau * cos, -f / 2 * (cos - tau * sin)
        of_sin, of_cos = self.of_sin, self.of_cos
        return of_sin * sin + of_cos * cos, nu * (of_sin * cos - of_cos * sin)

    def transient(self, s: Any) -> tuple[Any, Any]:
        c, h, y, w = self.c, self.h, self.y0, self.w0
        if h < 2:
            rate, b = self.rate, self.b
            decay, (cos, sin) = c.exp(-h * s / 2), c.cos_sin(rate * s)
            x = decay * (y * cos + b * sin)
            return x, decay * rate * (b * cos - y * sin) - h / 2 * x
        if h == 2:
            decay, b = c.exp(-s), w + y
            return decay * (y + b * s), decay * (b - y - b * s)
        one = self.of_fast * c.exp(self.fast * s)
        two = (y - self.of_fast) * c.exp(self.slow * s)
        return one + two, self.fast * one + self.slow * two

    def __call__(self, tau: Any) -> tuple[Any, Any]:
        x, v, _ = self.look(tau)
        return x, v

    def look(self, tau: Any) -> tuple[Any, Any, Any]:
        """Displacement, velocity, and a bound of |x''| from tau on."""
        xp, vp = self.particular(tau)
        y, w = self.transient(tau - self.tau0)
        second = -self.h * w - y
        third = -self.h * second - w
        size = self.c.sqrt(second * second + third * third)
        return xp + y, vp + w, self.most_forced + size
