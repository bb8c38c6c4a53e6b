"""The parameters of the exciter, eqs. (1)-(6): names, ranges, and defaults, which mean "effect absent".

Stored numbers depend on this module; symbols and long names are in `quantities.toml`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple


@dataclass(frozen=True)
class Range:
    """Finite numbers from `low` to `high`: without `low` itself if `above`, without fractions if `whole`."""

    low: float = -math.inf
    high: float = math.inf
    above: bool = False
    whole: bool = False

    def contains(self, value: float) -> bool:
        """Return whether a number lies in the range; nan and infinities lie in none."""
        reaches = value > self.low if self.above else value >= self.low
        fits = math.isfinite(value) and reaches and value <= self.high
        return fits and not (self.whole and value != math.floor(value))

    @property
    def text(self) -> str:
        """The range as a noun phrase: "a finite number > 0", "a whole number from 1 to 1e8"."""
        low, high = (
            f"{end:g}".replace("e+0", "e").replace("e-0", "e-") for end in (self.low, self.high)
        )
        if math.isfinite(self.high):
            kind = "a whole number" if self.whole else "a number"
            return (
                f"{kind} above {low} up to {high}" if self.above else f"{kind} from {low} to {high}"
            )
        kind = "a whole number" if self.whole else "a finite number"
        return f"{kind} {'>' if self.above else '>='} {low}" if math.isfinite(self.low) else kind


class Parameter(NamedTuple):
    """Range of a parameter and its default (None: the parameter is required)."""

    range: Range
    default: float | None


FINITE, NOT_NEGATIVE, POSITIVE = Range(), Range(0), Range(0, above=True)
FRACTION = Range(0, 1)

STARTS = ("x0", "v0")
"""Parts of a start, which a sweep takes like parameters."""

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
"""The order of parameters in rows of numbers, tables and files."""

DEFAULTS: Mapping[str, float] = {
    name: entry.default for name, entry in PARAMETERS.items() if entry.default is not None
}


class PhysicalParameter(NamedTuple):
    """A parameter with units: its dimension (`words.units`), its range in SI, and its name by eqs. (2)-(4), if any."""

    dimension: str
    range: Range
    non_dimensional: str = ""


PHYSICAL: Mapping[str, PhysicalParameter] = {
    "m": PhysicalParameter("mass", POSITIVE),
    "C": PhysicalParameter("stiffness", POSITIVE),
    "H": PhysicalParameter("damping", NOT_NEGATIVE, "h"),
    "F": PhysicalParameter("force", FINITE, "f"),
    "omega": PhysicalParameter("frequency", POSITIVE, "nu"),
    "l": PhysicalParameter("length", POSITIVE, "l"),
    "delta": PhysicalParameter("length", FINITE, "delta"),
}
"""Parameters of the exciter with units, from which eqs. (2)-(4) make the others."""
