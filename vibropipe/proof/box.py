"""Boxes of exciters, about a nominal one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from vibropipe.proof.balls import ZERO, Jet, Number, hull, total


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
