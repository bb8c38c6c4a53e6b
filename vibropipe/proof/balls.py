"""Balls, which certainly contain a number, their derivatives, and boxes of exciters; all roundings are outwards.

Arb [1]_ computes with midpoints and radii: what holds of a result holds of the exact number. A `Jet` adds the balls of
the derivatives by a few variables (forward differentiation).

References
----------
.. [1] F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE Transactions on
   Computers 66 (2017) 1281-1292.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from vibropipe.words.proofs import MISSING

try:
    from flint import acb, arb, arb_mat, ctx
except ModuleNotFoundError:
    raise ModuleNotFoundError(f"{MISSING}: pip install 'vibropipe[proof]'") from None

__all__ = ["acb", "arb", "arb_mat", "ctx"]

# Of midpoints: orbits of long laws lose up to a third of them, and 53 do not prove all.
BITS = 128
# A ball or a jet, real or complex.
Number = Any
ZERO, ONE = arb(0), arb(1)
with ctx.workprec(BITS):
    TURN = 2 * arb.pi()
# Beyond this |z| the exponentials of sinh(z)/z give the narrower ball, below it the series.
MAX_SERIES = 2.0


class Jet:
    """A ball and the balls of its derivatives by a few variables."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: Sequence[Any]) -> None:
        self.value, self.slopes = value, slopes

    def __add__(self, other: Number) -> Jet:
        if type(other) is Jet:
            pairs = zip(self.slopes, other.slopes, strict=True)
            return Jet(self.value + other.value, [a + b for a, b in pairs])
        return Jet(self.value + other, self.slopes)

    def __mul__(self, other: Number) -> Jet:
        if type(other) is Jet:
            x, y = self.value, other.value
            pairs = zip(self.slopes, other.slopes, strict=True)
            return Jet(x * y, [a * y + x * b for a, b in pairs])
        return Jet(self.value * other, [a * other for a in self.slopes])

    def __truediv__(self, other: Number) -> Jet:
        if type(other) is Jet:
            ratio = self.value / other.value
            pairs = zip(self.slopes, other.slopes, strict=True)
            return Jet(ratio, [(a - ratio * b) / other.value for a, b in pairs])
        return Jet(self.value / other, [a / other for a in self.slopes])

    def __neg__(self) -> Jet:
        return Jet(-self.value, [-a for a in self.slopes])

    def __sub__(self, other: Number) -> Jet:
        return self + (-other)

    def __rsub__(self, other: Number) -> Jet:
        return -self + other

    def __rtruediv__(self, other: Number) -> Jet:
        return Jet(other, [ZERO] * len(self.slopes)) / self

    __radd__, __rmul__ = __add__, __mul__

    def through(self, value: Any, slope: Any) -> Jet:
        """Return a function of this number from its value and its derivative here."""
        return Jet(value, [slope * a for a in self.slopes])


def seed(value: Any, index: int, n: int) -> Jet:
    """Return the variable of this index among n."""
    return Jet(value, [ONE if i == index else ZERO for i in range(n)])


def ball_of(number: Number) -> Any:
    """Return a number without its derivatives."""
    return number.value if type(number) is Jet else number


def sin_cos(a: Number) -> tuple[Number, Number]:
    """Return sine and cosine."""
    sine, cosine = ball_of(a).sin_cos()
    return (a.through(sine, cosine), a.through(cosine, -sine)) if type(a) is Jet else (sine, cosine)


def exp(a: Number) -> Number:
    """Return the exponential."""
    value = ball_of(a).exp()
    return a.through(value, value) if type(a) is Jet else value


def sqrt(a: Number) -> Number:
    """Return the square root."""
    root = ball_of(a).sqrt()
    return a.through(root, 1 / (2 * root)) if type(a) is Jet else root


def complex_of(real: Number, imag: Number) -> Number:
    """Return real + i imag."""
    if type(real) is not Jet and type(imag) is not Jet:
        return acb(real, imag)
    flat = [ZERO] * len((real if type(real) is Jet else imag).slopes)
    x, y = (a if type(a) is Jet else Jet(a, flat) for a in (real, imag))
    slopes = [acb(a, b) for a, b in zip(x.slopes, y.slopes, strict=True)]
    return Jet(acb(x.value, y.value), slopes)


def real_of(z: Number) -> Number:
    """Return the real part."""
    return Jet(z.value.real, [acb(a).real for a in z.slopes]) if type(z) is Jet else z.real


def imag_of(z: Number) -> Number:
    """Return the imaginary part."""
    return Jet(z.value.imag, [acb(a).imag for a in z.slopes]) if type(z) is Jet else z.imag


def sinhc(z: Number) -> Number:
    """Return sinh(z)/z, an entire function, of a complex number."""
    at = ball_of(z)
    is_jet = type(z) is Jet
    if abs(at) > MAX_SERIES:
        up, down = at.exp(), (-at).exp()
        value = (up - down) / (2 * at)
        slope = ((up + down) / 2 - value) / at if is_jet else None
    else:
        square = at * at / 4
        value = square.hypgeom_0f1(acb(1.5))
        slope = at * square.hypgeom_0f1(acb(2.5)) / 3 if is_jet else None
    return z.through(value, slope) if is_jet else value


def entire(q: Number) -> tuple[Number, Number]:
    """Return sinh(r)/r and cosh(r) with r^2 = q, entire functions of a real q."""
    at = ball_of(q) / 4
    sine, cosine = (at.hypgeom_0f1(arb(half)) for half in (1.5, 0.5))
    if type(q) is not Jet:
        return sine, cosine
    return q.through(sine, at.hypgeom_0f1(arb(2.5)) / 6), q.through(cosine, sine / 2)


def hull(low: Any, high: Any) -> Any:
    """Return a ball that contains two balls and all between them."""
    return arb(low).union(arb(high))


def magnitude(a: Any) -> Any:
    """Return an upper bound of |a|, exact."""
    return abs(a).upper()


def total(terms: Iterable[Any]) -> Any:
    """Return the sum of balls."""
    return sum(terms, ZERO)


def round_down(a: Any) -> float:
    """Return a double that is not above any number of a ball; NaN of one that is not finite."""
    if not a.is_finite():
        return math.nan
    least = a.lower()
    near = float(least)
    return near if arb(near) <= least else math.nextafter(near, -math.inf)


def round_up(a: Any) -> float:
    """Return a double that is not below any number of a ball; NaN of one that is not finite."""
    return -round_down(-a)


class Box:
    """Exciters p0 + sum D_j c_j: the offsets c_j from `low` to `high`, within -1 to 1.

    nominal : p0, by parameter, balls that are exact numbers
    directions : D_j, balls by parameter; none of an exciter alone
    low, high : exact in few bits, as halves of halves of the box are
    """

    def __init__(
        self,
        nominal: Mapping[str, Any],
        directions: Sequence[Mapping[str, Any]] = (),
        low: Sequence[float] = (),
        high: Sequence[float] = (),
    ) -> None:
        self.nominal, self.directions, self.low, self.high = nominal, directions, low, high
        self.middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        self.offsets = [hull(a, b) - c for a, b, c in zip(low, high, self.middle, strict=True)]
        self.centre = self.at(self.middle)
        self.balls = self.at([hull(a, b) for a, b in zip(low, high, strict=True)])

    @property
    def share(self) -> float:
        """Its share of the box with all offsets from -1 to 1."""
        return math.prod((b - a) / 2 for a, b in zip(self.low, self.high, strict=True))

    def at(self, c: Sequence[Any]) -> dict[str, Any]:
        """Return the parameters at an offset."""
        moves = list(zip(self.directions, c, strict=True))
        return {
            name: value + total(d[name] * x for d, x in moves if name in d)
            for name, value in self.nominal.items()
        }

    def jets(self, n: int) -> dict[str, Number]:
        """Return the parameters over the box as functions of the offsets, the first of n variables."""
        k = len(self.directions)
        return {
            name: Jet(ball, [*(d.get(name, ZERO) for d in self.directions), *[ZERO] * (n - k)])
            if any(name in d for d in self.directions)
            else ball
            for name, ball in self.balls.items()
        }
