"""The exciter: every parameter of eqs. (1)-(6) of the paper, checked once, here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from vibropipe.physics.start import start_at, start_room, support_positions
from vibropipe.words.parameters import DEFAULTS, FINITE, PARAMETERS, POSITIVE, Range


class ParameterError(ValueError):
    """A parameter or an argument has a value that is not allowed.

    Its text reads "nu: must be a finite number > 0, got -1.0".

    Parameters
    ----------
    name : str
        Name of the parameter or argument.
    value : Any
        Its value.
    allowed : str
        What it takes, a noun phrase ("a finite number > 0"); `must` if left out.
    must : str
        What must hold, a full predicate; "must be <allowed>" if left out.
    got : str or None
        The value as the text shows it, "" for not at all; `repr(value)` if left out.
    """

    def __init__(
        self, name: str, value: Any, allowed: str = "", must: str = "", got: str | None = None
    ) -> None:
        # All arguments go to the base class: a copy sent to another process is built from them.
        super().__init__(name, value, allowed, must, got)
        self.name, self.value, self.allowed = name, value, allowed or must
        self.must = must or f"must be {allowed}"
        self.got = repr(value) if got is None else got

    def __str__(self) -> str:
        return f"{self.name}: {self.must}" + (f", got {self.got}" if self.got else "")


class Parameters(NamedTuple):
    """Parameters of one row as kernels read them, in the order of `PARAMETERS`; one compiled kernel serves all rows."""

    nu: float
    f: float
    h: float
    l: float  # noqa: E741 - the paper's symbol
    delta: float
    R1: float
    R2: float


def as_float(name: str, value: Any, allowed: str) -> float:
    """Return `value` as a float, or raise a ParameterError naming it; text and booleans are not numbers."""
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise ParameterError(name, value, allowed) from None


def number_within(name: str, value: Any, within: Range) -> float:
    """Return `value` as a float that lies in a range, or raise a ParameterError naming it."""
    number = as_float(name, value, within.text)
    if not within.contains(number):
        raise ParameterError(name, number, within.text)
    return number


@dataclass(frozen=True)
class Exciter:
    """One set of parameters of eqs. (5), (6), all non-dimensional; the defaults mean "effect absent".

    Parameters
    ----------
    l : float
        Half the distance between the supports, > 0.
    nu : float
        Frequency of excitation over the eigenfrequency, > 0.
    f : float
        Amplitude of excitation.
    h : float
        Damping, >= 0.
    delta : float
        Offset of the equilibrium: support 1 stands at x = l + delta and support 2 at x = -(l - delta).
    R1, R2 : float
        Coefficients of restitution of the supports, from 0 to 1.

    Raises
    ------
    ParameterError
        If a value is out of range (`vibropipe.words.parameters`), or the supports coincide in floating point.
    """

    l: float  # noqa: E741 - the paper's symbol
    nu: float = DEFAULTS["nu"]
    f: float = DEFAULTS["f"]
    h: float = DEFAULTS["h"]
    delta: float = DEFAULTS["delta"]
    R1: float = DEFAULTS["R1"]
    R2: float = DEFAULTS["R2"]

    def __post_init__(self) -> None:
        for name, known in PARAMETERS.items():
            object.__setattr__(self, name, number_within(name, getattr(self, name), known.range))
        if not self.lower < self.upper:
            allowed = (
                "at least 1e-15 |delta| so that the supports are distinct floating-point numbers"
            )
            got = f"l = {self.l!r}, delta = {self.delta!r}"
            raise ParameterError("l", self.l, allowed, got=got)

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
        delta: float = DEFAULTS["delta"],
        R1: float = DEFAULTS["R1"],
        R2: float = DEFAULTS["R2"],
    ) -> Exciter:
        """Return the exciter of a mass m, stiffness C, viscous damping H and force F sin(omega t), by eqs. (2)-(4).

        p = sqrt(C/m), h = H/sqrt(m C), f = F/C, nu = omega/p. Lengths stay in the unit of l and delta.

        Parameters
        ----------
        m, C : float
            Mass and stiffness, > 0.
        H, F, omega : float
            Damping, amplitude and angular frequency of the force, in units consistent with m and C.
        l, delta, R1, R2 : float
            As in `Exciter`.

        Raises
        ------
        ParameterError
            If a value is out of range.
        """
        for name, value in (("m", m), ("C", C)):
            number_within(name, value, POSITIVE)
        for name, value in (("H", H), ("F", F), ("omega", omega)):
            number_within(name, value, FINITE)
        # Square roots first: the product m C can overflow where h does not.
        h = H / math.sqrt(m) / math.sqrt(C)
        return cls(l=l, nu=omega / math.sqrt(C / m), f=F / C, h=h, delta=delta, R1=R1, R2=R2)

    @property
    def upper(self) -> float:
        """Position of support 1, x = l + delta, eq. (1)."""
        return support_positions(self.l, self.delta)[0]

    @property
    def lower(self) -> float:
        """Position of support 2, x = -(l - delta), eq. (1)."""
        return support_positions(self.l, self.delta)[1]

    @property
    def period(self) -> float:
        """Forcing period 2 pi / nu in tau."""
        return 2 * math.pi / self.nu

    def mirrored(self) -> Exciter:
        """Return the mirrored exciter, x -> -x: f and delta change sign, R1 and R2 are exchanged."""
        return Exciter(
            l=self.l, nu=self.nu, f=-self.f, h=self.h, delta=-self.delta, R1=self.R2, R2=self.R1
        )

    def parameters(self) -> Parameters:
        """Return the parameters as kernels read them."""
        return Parameters(**vars(self))

    def check_start(self, x0: float | None, v0: float) -> tuple[float, float]:
        """Return a start as floats, on a support that it is within rounding of (`start_at`).

        Parameters
        ----------
        x0 : float or None
            Displacement; None is the equilibrium, or the support nearest to it where that lies beyond.
        v0 : float
            Velocity.

        Raises
        ------
        ParameterError
            If the start is not finite or lies outside the supports.
        """
        v = number_within("v0", v0, FINITE)
        x = None
        if x0 is not None:
            allowed = (
                f"a finite number from {self.lower!r} to {self.upper!r} (between the supports)"
            )
            x = as_float("x0", x0, allowed)
            least, most = start_room(self.l, self.delta)
            if not least <= x <= most:
                raise ParameterError("x0", x, allowed)
        return float(start_at(self.l, self.delta, x, v)), v
