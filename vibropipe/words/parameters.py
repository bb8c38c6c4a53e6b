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

ParameterName = Literal[
    "nu",
    "f",
    "h",
    "l",
    "delta",
    "R1",
    "R2",
    "k1",
    "k2",
    "h1",
    "h2",
    "load",
    "friction",
    "f2",
    "phi2",
]
PARAMETERS: Mapping[str, Parameter] = {
    "nu": Parameter(POSITIVE, 1.0),
    "f": Parameter(FINITE, 0.0),
    "h": Parameter(NOT_NEGATIVE, 0.0),
    "l": Parameter(POSITIVE, None),
    "delta": Parameter(FINITE, 0.0),
    "R1": Parameter(FRACTION, 1.0),
    "R2": Parameter(FRACTION, 1.0),
    "k1": Parameter(NOT_NEGATIVE, 0.0),
    "k2": Parameter(NOT_NEGATIVE, 0.0),
    "h1": Parameter(NOT_NEGATIVE, 0.0),
    "h2": Parameter(NOT_NEGATIVE, 0.0),
    "load": Parameter(FINITE, 0.0),
    "friction": Parameter(NOT_NEGATIVE, 0.0),
    "f2": Parameter(FINITE, 0.0),
    "phi2": Parameter(FINITE, 0.0),
}
"""The order of parameters in rows of numbers, tables and files."""

DEFAULTS: Mapping[str, float] = {
    name: entry.default for name, entry in PARAMETERS.items() if entry.default is not None
}


FURTHER = ("k1", "k2", "h1", "h2", "load", "friction", "f2", "phi2")
"""Parameters of effects beyond eqs. (5), (6): datasets and fingerprints have them only where they differ from 0."""


def without_absent(values: Mapping[str, float]) -> dict[str, float]:
    """Return parameters without those of `FURTHER` that are 0."""
    return {name: value for name, value in values.items() if name not in FURTHER or value != 0}


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
    "C1": PhysicalParameter("stiffness", NOT_NEGATIVE, "k1"),
    "C2": PhysicalParameter("stiffness", NOT_NEGATIVE, "k2"),
    "H1": PhysicalParameter("damping", NOT_NEGATIVE, "h1"),
    "H2": PhysicalParameter("damping", NOT_NEGATIVE, "h2"),
    "load": PhysicalParameter("force", FINITE, "load"),
    "friction": PhysicalParameter("force", NOT_NEGATIVE, "friction"),
    "F2": PhysicalParameter("force", FINITE, "f2"),
    "phi2": PhysicalParameter("angle", FINITE, "phi2"),
    "slope": PhysicalParameter("angle", FINITE),
    "gravity": PhysicalParameter("acceleration", NOT_NEGATIVE),
}
"""Parameters of the exciter with units, from which eqs. (2)-(4) make the others.

x rises at the angle `slope`, so that gravity adds -m gravity sin(slope) to `load`.
"""

STANDARD_GRAVITY = 9.80665  # m/s^2

RIGID_AT_ZERO = ("k1", "k2")
"""Stiffnesses of supports: 0 stands for a rigid one, which is the limit of large values."""
SOFT_ALONG = "must be above 0 where it varies, since 0 stands for a rigid support"
