"""The exciter, eqs. (1)-(6): each parameter and each effect once, as a record that all other modules read.

Stored numbers depend on `facts` of these records alone; their texts may change without a new result.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


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


FINITE, NOT_NEGATIVE, POSITIVE = Range(), Range(0), Range(0, above=True)
FRACTION = Range(0, 1)


@dataclass(frozen=True)
class Effect:
    """A physical effect that an exciter can have or lack.

    Attributes
    ----------
    unless : str
        Where it is absent: "h = 0".
    shown : tuple of str
        The parameters whose values a message shows beside `unless`.
    is_common : bool
        Whether kernels have it unless effects are stated, as all of eqs. (5), (6); others only if parameters call for
        it.
    calls : tuple of str
        The parameters that call for it by being other than 0; without any, whether it occurs is a question of which
        supports are reached (`physics.effects`).
    is_marched : bool
        Whether kernels have code for it; a load is an offset of the supports, and has none.
    refusal : str
        Why calls that do not compute it refuse its parameters: "dry friction is"; "" where all compute it.
    sentence : str
        What a report says of it in the line on the model; "" if the equation says it.
    occurs : str
        Of one with quantities of its own, where these are: "a support is soft".
    name : str
        As in studies and files, the name that the record is assigned to.
    """

    unless: str = ""
    shown: tuple[str, ...] = ()
    is_common: bool = False
    calls: tuple[str, ...] = ()
    is_marched: bool = True
    refusal: str = ""
    sentence: str = ""
    occurs: str = ""
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)


@dataclass(frozen=True)
class Physical:
    """The counterpart of a parameter with units; what is left out is as of the parameter."""

    name: str
    symbol: str = ""
    plain: str = ""
    long_name: str = ""
    key: str = ""


@dataclass(frozen=True)
class Parameter:
    """A parameter of the exciter.

    Attributes
    ----------
    range, default : Range, float or None
        Its values; the default means "effect absent". None: it is required.
    symbol, plain : str
        As matplotlib mathtext and as plain text.
    long_name : str
        As in datasets, on axes, and in the help of commands.
    words : str
        As beside the drawing of the exciter: two or three words.
    key : str
        What a study's key of this name means, a sentence without its full stop.
    dimension : str
        One of `words.units.DIMENSIONS`; "" for a pure number.
    physical : Physical, optional
        Its counterpart with units, by eqs. (2)-(4).
    effect : str
        The effect that it belongs to; "" for the place of the supports, which are always there.
    sign, twin : int, str
        Mirroring x -> -x multiplies it by the sign and exchanges it with the twin, one of the other support.
    follows : bool
        Whether an exciter knows that it was left out: it then only counts periods, or follows from others.
    units : str
        Of its values without units of length: "rad" of an angle.
    acts : callable, optional
        How it acts, if through others and on no code of kernels: takes the values of all parameters by name, numbers or
        arrays, and returns those of the others that it changes.
    name : str
        As in Python, studies and files, the name that the record is assigned to.
    """

    range: Range
    default: float | None
    symbol: str
    plain: str
    long_name: str
    words: str
    key: str
    dimension: str = ""
    physical: Physical | None = None
    effect: str = ""
    sign: int = 1
    twin: str = ""
    follows: bool = False
    units: str = "1"
    acts: Callable[[Mapping[str, Any]], Mapping[str, Any]] | None = None
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)

    @property
    def letter(self) -> str:
        """The symbol as plain text where `plain` is a word: q of the load."""
        return self.plain if self.plain != self.name else self.symbol.strip("$")

    @property
    def description(self) -> str:
        """What the key means, with the default, as a sentence."""
        return described(self.key, self.default)


def described(key: str, default: float | None) -> str:
    """Return what a key means with its default as a sentence."""
    return f"{key}; required." if default is None else f"{key} ({default:g})."


def _effect(*of: Any, **named: Any) -> Any:
    """Return the record of an effect, which a type checker takes for what kernels have under its name."""
    return Effect(*of, **named)


def _parameter(*of: Any, **named: Any) -> Any:
    """Return the record of a parameter, which a type checker takes for its value."""
    return Parameter(*of, **named)


class OfEffects:
    """Each effect by name: its record here, in kernels 1 or None where it is present or absent (`physics.effects`)."""

    # fmt: off
    damping: int | None = _effect("h = 0", ("h",), is_common=True, calls=("h",))
    forcing: int | None = _effect("f = 0", ("f",), is_common=True, calls=("f", "f2"))
    support_1: int | None = _effect(is_common=True)
    support_2: int | None = _effect(is_common=True)
    restitution: int | None = _effect("R = 1 on the supports included", ("R1", "R2"), is_common=True)
    rest: int | None = _effect("|f| < {pull}", ("f",), is_common=True)
    load: int | None = _effect(
        "load = 0", ("load",), calls=("load",), is_marched=False,
        sentence="a constant load acts",
    )
    soft: int | None = _effect(
        "k = 0 on the supports included", ("k1", "k2"), calls=("k1", "k2"),
        refusal="soft supports are", sentence="soft supports push with a spring and a damper",
        occurs="a support is soft",
    )
    friction: int | None = _effect(
        "friction = 0", ("friction",), calls=("friction",),
        refusal="dry friction is", sentence="dry friction acts against the velocity",
        occurs="friction is above 0",
    )
    second_harmonic: int | None = _effect("f2 = 0", ("f2",), calls=("f2",))
    # fmt: on


EFFECTS: list[Effect] = [each for each in vars(OfEffects).values() if isinstance(each, Effect)]
"""The order of effects in kernels, studies and files."""


@dataclass(frozen=True)
class OfExciter:
    """Each parameter by name: its record here, its value in an exciter and in a row (`physics.exciter`)."""

    # fmt: off
    nu: float = _parameter(
        POSITIVE, 1.0, r"$\nu$", "ν", "frequency of excitation", "frequency of the force",
        "Excitation frequency divided by the eigenfrequency", "frequency",
        Physical(
            "omega", r"$\omega$", "ω", "angular frequency of excitation",
            "Angular frequency of the excitation; in Hz it counts cycles: 9 Hz is 2 pi 9 rad/s",
        ),
        effect="forcing", follows=True,
    )
    f: float = _parameter(
        FINITE, 0.0, "$f$", "f", "amplitude of excitation", "amplitude of the force",
        "Amplitude of the excitation", "force", Physical("F", "$F$", "F"),
        effect="forcing", sign=-1,
    )
    h: float = _parameter(
        NOT_NEGATIVE, 0.0, "$h$", "h", "damping", "damping",
        "Viscous damping", "damping", Physical("H", "$H$", "H"), effect="damping",
    )
    l: float = _parameter(  # noqa: E741
        POSITIVE, None, "$l$", "l", "half distance between the supports", "half distance",
        "Half the distance between the supports", "length", Physical("l"),
    )
    delta: float = _parameter(
        FINITE, 0.0, r"$\delta$", "δ", "offset of the equilibrium", "offset",
        "Offset of the equilibrium: support 1 at l + delta, support 2 at -(l - delta)", "length",
        Physical("delta", key="Offset of the equilibrium"), sign=-1,
    )
    R1: float = _parameter(
        FRACTION, 1.0, "$R_1$", "R₁", "restitution of support 1", "restitution of support 1",
        "Coefficient of restitution of support 1", effect="restitution", twin="R2",
    )
    R2: float = _parameter(
        FRACTION, 1.0, "$R_2$", "R₂", "restitution of support 2", "restitution of support 2",
        "Coefficient of restitution of support 2", effect="restitution", twin="R1",
    )
    k1: float = _parameter(
        NOT_NEGATIVE, 0.0, "$k_1$", "k₁", "stiffness of support 1, 0 if rigid",
        "stiffness of support 1", "Stiffness of support 1; a support without it is rigid",
        "stiffness", Physical("C1", "$C_1$", "C₁"), effect="soft", twin="k2",
    )
    k2: float = _parameter(
        NOT_NEGATIVE, 0.0, "$k_2$", "k₂", "stiffness of support 2, 0 if rigid",
        "stiffness of support 2", "Stiffness of support 2",
        "stiffness", Physical("C2", "$C_2$", "C₂"), effect="soft", twin="k1",
    )
    h1: float = _parameter(
        NOT_NEGATIVE, 0.0, "$h_1$", "h₁", "damping of support 1", "damping of support 1",
        "Damping of support 1, for k1 > 0", "damping",
        Physical("H1", "$H_1$", "H₁", key="Damping of support 1, for C1 > 0"),
        effect="soft", twin="h2", follows=True,
    )
    h2: float = _parameter(
        NOT_NEGATIVE, 0.0, "$h_2$", "h₂", "damping of support 2", "damping of support 2",
        "Damping of support 2, for k2 > 0", "damping",
        Physical("H2", "$H_2$", "H₂", key="Damping of support 2, for C2 > 0"),
        effect="soft", twin="h1", follows=True,
    )
    load: float = _parameter(
        FINITE, 0.0, "$q$", "load", "constant force", "constant force",
        "Constant force", "force", Physical("load"), effect="load", sign=-1,
    )
    friction: float = _parameter(
        NOT_NEGATIVE, 0.0, "$d$", "friction", "dry friction", "dry friction",
        "Dry friction", "force", Physical("friction"), effect="friction",
    )
    f2: float = _parameter(
        FINITE, 0.0, "$f_2$", "f₂", "amplitude of the second harmonic of excitation",
        "second harmonic", "Amplitude of the second harmonic of the excitation", "force",
        Physical("F2", "$F_2$", "F₂"), effect="second_harmonic", sign=-1,
    )
    phi2: float = _parameter(
        FINITE, 0.0, r"$\varphi_2$", "φ₂", "phase of the second harmonic of excitation",
        "its phase", "Phase of the second harmonic, f2 sin(2 nu tau + phi2), in radians", "angle",
        Physical("phi2", key="Phase of the second harmonic, F2 sin(2 omega t + phi2)"),
        effect="second_harmonic", units="rad",
    )
    # fmt: on


PARAMETERS: list[Parameter] = [
    each for each in vars(OfExciter).values() if isinstance(each, Parameter)
]
"""The order of parameters in rows of numbers, tables and files."""


def source_of(function: Callable[..., Any] | None) -> str:
    """Return the source of a function of a record, "" without one."""
    return "" if function is None else inspect.getsource(function)


def facts() -> str:
    """Return what stored numbers depend on in the records: all but texts."""
    effects = [(each.name, each.is_common, each.calls, each.is_marched) for each in EFFECTS]
    parameters = [
        (
            *(each.name, each.range, each.default, each.effect, each.sign, each.twin, each.follows),
            *(each.physical and each.physical.name, each.dimension, source_of(each.acts)),
        )
        for each in PARAMETERS
    ]
    return repr((effects, parameters))
