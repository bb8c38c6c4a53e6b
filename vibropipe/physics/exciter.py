"""The exciter: every parameter of eqs. (1)-(6) of the paper, checked once, here."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from vibropipe.physics.start import start_at, start_room


class ParameterError(ValueError):
    """A parameter is outside what the model allows; the message names it, its value and what is allowed."""


class Parameters(NamedTuple):
    """The row of numbers that kernels read; one compiled kernel serves every set."""

    nu: float
    f: float
    h: float
    l: float  # noqa: E741 - the paper's symbol
    delta: float
    R1: float
    R2: float


ALLOWED = {
    "nu": "a finite number > 0",
    "f": "a finite number",
    "h": "a finite number >= 0",
    "l": "a finite number > 0",
    "delta": "a finite number",
    "R1": "a number from 0 to 1",
    "R2": "a number from 0 to 1",
}


def _in_range(name: str, value: float) -> bool:
    if not math.isfinite(value):
        return False
    if name in ("nu", "l"):
        return value > 0
    if name in ("R1", "R2"):
        return 0 <= value <= 1
    return name != "h" or value >= 0


def number(name: str, value: Any, allowed: str) -> float:
    """`value` as a float, or a ParameterError naming it; text and booleans are not numbers."""
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise ParameterError(f"{name} = {value!r}: allowed is {allowed}") from None


@dataclass(frozen=True)
class Exciter:
    """One set of parameters of eqs. (5), (6), all non-dimensional; the defaults mean "effect absent".

    nu: frequency of excitation over the eigenfrequency; f: amplitude of excitation; h: damping;
    l: half the distance between the supports; delta: offset of the equilibrium, so that support 1 stands
    at x = l + delta and support 2 at x = -(l - delta); R1, R2: restitution of the supports.
    Raises ParameterError for a value outside `ALLOWED`.
    """

    l: float  # noqa: E741 - the paper's symbol
    nu: float = 1.0
    f: float = 0.0
    h: float = 0.0
    delta: float = 0.0
    R1: float = 1.0
    R2: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            allowed = ALLOWED[field.name]
            value = number(field.name, getattr(self, field.name), allowed)
            if not _in_range(field.name, value):
                raise ParameterError(f"{field.name} = {value!r}: allowed is {allowed}")
            object.__setattr__(self, field.name, value)
        if not self.lower < self.upper:
            raise ParameterError(
                f"l = {self.l!r}: with delta = {self.delta!r} the supports fall on one floating-point number; "
                "allowed is an l of at least 1e-15 |delta|"
            )

    @classmethod
    def from_physical(
        cls,
        *,
        m: float,
        C: float,
        H: float,
        F: float,
        omega: float,
        l: float,  # noqa: E741
        delta: float = 0.0,
        R1: float = 1.0,
        R2: float = 1.0,
    ) -> Exciter:
        """The exciter of mass m, stiffness C, viscous damping H, force F sin(omega t), by eqs. (2)-(4):
        p = sqrt(C/m), h = H/sqrt(m C), f = F/C, nu = omega/p; lengths stay in the unit of l and delta."""
        for name, value in (("m", m), ("C", C)):
            if not (math.isfinite(number(name, value, "a finite number > 0")) and value > 0):
                raise ParameterError(f"{name} = {value!r}: allowed is a finite number > 0")
        for name, value in (("H", H), ("F", F), ("omega", omega)):
            if not math.isfinite(number(name, value, "a finite number")):
                raise ParameterError(f"{name} = {value!r}: allowed is a finite number")
        # sqrt of each first: the product m C can overflow where h does not.
        h = H / math.sqrt(m) / math.sqrt(C)
        return cls(l=l, nu=omega / math.sqrt(C / m), f=F / C, h=h, delta=delta, R1=R1, R2=R2)

    @property
    def upper(self) -> float:
        """Position of support 1, x = l + delta, eq. (1)."""
        return self.l + self.delta

    @property
    def lower(self) -> float:
        """Position of support 2, x = -(l - delta), eq. (1)."""
        return self.delta - self.l

    @property
    def period(self) -> float:
        """Forcing period 2 pi / nu in tau."""
        return 2 * math.pi / self.nu

    def mirrored(self) -> Exciter:
        """The exciter seen in the mirror x -> -x: f and delta change sign, R1 and R2 change places."""
        return Exciter(
            l=self.l, nu=self.nu, f=-self.f, h=self.h, delta=-self.delta, R1=self.R2, R2=self.R1
        )

    def parameters(self) -> Parameters:
        """The same numbers as kernels read them."""
        return Parameters(**vars(self))

    def check_start(self, x0: float | None, v0: float) -> tuple[float, float]:
        """A start (x0, v0) as floats, x0 on a support that it is within rounding of
        (`start_at`); x0 left out (None) is the
        equilibrium, or the support nearest to it. ParameterError if it is not finite or lies outside the supports."""
        allowed = f"a finite number from {self.lower!r} to {self.upper!r} (between the supports)"
        v = number("v0", v0, "a finite number")
        x = 0.0 if x0 is None else number("x0", x0, allowed)
        least, most = start_room(self.l, self.delta)
        if x0 is not None and not least <= x <= most:
            raise ParameterError(f"x0 = {x!r}: allowed is {allowed}")
        if not math.isfinite(v):
            raise ParameterError(f"v0 = {v!r}: allowed is a finite number")
        return float(start_at(self.l, self.delta, None if x0 is None else x, v)), v
