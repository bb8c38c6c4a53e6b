"""The parameters of the exciter, eqs. (1)-(6): names, ranges, and defaults, which mean "effect absent".

Numbers depend on all that stands here; symbols and long names are in `quantities.toml`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple


class Range(NamedTuple):
    """Finite numbers from `low` to `high`; without `low` itself if `above`."""

    low: float = -math.inf
    high: float = math.inf
    above: bool = False

    def contains(self, value: float) -> bool:
        """Return whether a number lies in the range; nan and infinities lie in none."""
        reaches = value > self.low if self.above else value >= self.low
        return math.isfinite(value) and reaches and value <= self.high

    @property
    def text(self) -> str:
        """What is allowed, in words: "a finite number > 0"."""
        if math.isfinite(self.high):
            ends = "above {:g} up to {:g}" if self.above else "from {:g} to {:g}"
            return f"a number {ends.format(self.low, self.high)}"
        end = f" {'>' if self.above else '>='} {self.low:g}" if math.isfinite(self.low) else ""
        return f"a finite number{end}"


class Parameter(NamedTuple):
    """What a parameter may be, and what it is where nothing is said of it (None: it must be given)."""

    range: Range
    default: float | None


FINITE, NOT_NEGATIVE, POSITIVE = Range(), Range(0), Range(0, above=True)
FRACTION = Range(0, 1)

ParameterName = Literal["nu", "f", "h", "l", "delta", "R1", "R2"]
PARAMETERS: Mapping[str, Parameter] = {
    "nu": Parameter(POSITIVE, 1.0),
    "f": Parameter(FINITE, 0.0),
    "h": Parameter(NOT_NEGATIVE, 0.0),
    "l": Parameter(POSITIVE, None),
    "delta": Parameter(FINITE, 0.0),
    "R1": Parameter(FRACTION, 1.0),
    "R2": Parameter(FRACTION, 1.0),
}
"""In the order in which rows of numbers, tables and files hold them."""

DEFAULTS: Mapping[str, float] = {
    name: known.default for name, known in PARAMETERS.items() if known.default is not None
}
