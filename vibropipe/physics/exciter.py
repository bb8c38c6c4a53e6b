"""The exciter: every parameter of eqs. (1)-(6) of the paper, checked once, here."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from vibropipe.physics.start import start_at, start_room, support_positions
from vibropipe.words.parameters import DEFAULTS, FINITE, PARAMETERS, PHYSICAL, Range
from vibropipe.words.units import UnitError, to_si

# A support farther away than this many times the largest displacement of the linear motion is never struck. A length
# in millimetres that is taken for metres is a thousand times too large.
FAR_SUPPORT = 100.0


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


def si_value(name: str, value: Any) -> float:
    """Return a physical parameter as a number in SI, or raise a ParameterError naming it."""
    known = PHYSICAL[name]
    try:
        number = to_si(value, known.dimension, numbers=True)
    except UnitError as error:
        hint = f" ({error.hint})" if error.hint else ""
        raise ParameterError(name, value, error.allowed, got=repr(value) + hint) from None
    if not known.range.contains(number):
        raise ParameterError(name, value, known.range.text)
    return number


def non_dimensional(si: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of an exciter by eqs. (2)-(4).

    Parameters
    ----------
    si : mapping of str to float
        m and C, and any of omega, F, H, l and delta, in SI.

    Returns
    -------
    dict of str to float
        nu, f, h, l and delta, of those that are given; lengths in metres.
    """
    values = {name: si[name] for name in ("l", "delta") if name in si}
    if "omega" in si:
        values["nu"] = si["omega"] / eigenfrequency(si["m"], si["C"])
    if "F" in si:
        values["f"] = si["F"] / si["C"]
    if "H" in si:
        # Square roots first: the product m C can overflow where h does not.
        values["h"] = si["H"] / math.sqrt(si["m"]) / math.sqrt(si["C"])
    return values


def eigenfrequency(m: float, C: float) -> float:
    """Return p = sqrt(C/m), eq. (3), in rad/s."""
    return math.sqrt(C / m)


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
        m: Any,
        C: Any,
        H: Any,
        F: Any,
        omega: Any,
        l: Any,  # noqa: E741
        delta: Any = DEFAULTS["delta"],
        R1: float = DEFAULTS["R1"],
        R2: float = DEFAULTS["R2"],
    ) -> Exciter:
        """Return the exciter of a mass m, stiffness C, viscous damping H and force F sin(omega t), by eqs. (2)-(4).

        p = sqrt(C/m), h = H/sqrt(m C), f = F/C, nu = omega/p. Lengths, f included, are then in metres, and times in
        1/p; `vibropipe.to_physical` converts results back.

        Parameters
        ----------
        m, C, H, F, omega, l, delta : number, str or pint.Quantity
            Mass and stiffness, > 0; damping, >= 0; amplitude and angular frequency (> 0) of the force; half the
            distance between the supports, > 0; offset of the equilibrium. Numbers are in SI: kg, N/m, N s/m, N, rad/s,
            m. Text has a number and a unit: "8 mm", "8 N/mm", "55 rad/s"; a frequency in Hz counts cycles, "9 Hz" is
            2 pi 9 rad/s.
        R1, R2 : float
            As in `Exciter`.

        Raises
        ------
        ParameterError
            If a value is out of range, or has an unknown unit or one of another dimension.

        Warns
        -----
        UserWarning
            If l is a number and the nearer support is more than 100 times as far away as the mass swings without
            supports, as with l=8 for 8 mm: it is then never struck.
        """
        given = {"m": m, "C": C, "H": H, "F": F, "omega": omega, "l": l, "delta": delta}
        si = {name: si_value(name, value) for name, value in given.items()}
        exciter = cls(R1=R1, R2=R2, **non_dimensional(si))
        if not isinstance(l, str) and not hasattr(l, "units"):
            exciter._warn_of_far_supports()
        return exciter

    def _warn_of_far_supports(self) -> None:
        """Warn if a support is so far that l, in metres, was probably meant in millimetres."""
        linear = math.hypot(1.0 - self.nu**2, self.h * self.nu)
        reach = abs(self.f) * max(1.0, 1.0 / linear if linear else math.inf)
        distance = min(self.upper, -self.lower)
        if 0.0 < FAR_SUPPORT * reach < distance:
            warnings.warn(
                f"l: the nearer support is {distance:.3g} m away, but the mass swings by {reach:.2g} m without "
                "supports: numbers are in metres; write l='8 mm' for millimetres",
                stacklevel=3,
            )

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
