"""Names of the parameters of the exciter, with and without units, and of its effects, made from their records."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from vibropipe.words.exciter import EFFECTS
from vibropipe.words.exciter import PARAMETERS as RECORDS
from vibropipe.words.records import FINITE, NOT_NEGATIVE, POSITIVE, Parameter, Range, described

EFFECT_NAMES = tuple(each.name for each in EFFECTS)
if TYPE_CHECKING:
    Effect = str
else:
    Effect = Literal[EFFECT_NAMES]

COMMON_EFFECTS = tuple(each.name for each in EFFECTS if each.is_common)
"""Effects of eqs. (5), (6), which kernels have unless effects are stated; further ones only where they are present."""

STARTS = ("x0", "v0")
"""Parts of a start, which a sweep takes like parameters."""

PARAMETERS: Mapping[str, Parameter] = {each.name: each for each in RECORDS}
"""The order of parameters in rows of numbers, tables and files."""

if TYPE_CHECKING:
    ParameterName = str
else:
    ParameterName = Literal[tuple(name for name in PARAMETERS if not PARAMETERS[name].range.words)]

DEFAULTS: Mapping[str, float] = {
    name: entry.default for name, entry in PARAMETERS.items() if entry.default is not None
}
THROUGH_OTHERS: Mapping[str, Mapping[str, str]] = {
    name: entry.acts for name, entry in PARAMETERS.items() if entry.acts is not None
}
"""Parameters that act through others: the expressions of those."""

ACTED: Mapping[str, str] = {
    target: expression for acts in THROUGH_OTHERS.values() for target, expression in acts.items()
}
"""Parameters that others act on, each by one of them: what kernels see of each, as an expression."""
if len(ACTED) < sum(map(len, THROUGH_OTHERS.values())):
    raise ValueError(f"two parameters act on the same one: {THROUGH_OTHERS}")

CONTINUOUS = tuple(name for name, entry in PARAMETERS.items() if not entry.range.words)
"""Parameters whose values are no words."""

FOLLOWED = tuple(name for name in CONTINUOUS if THROUGH_OTHERS.get(name) != {})
"""Parameters along which orbits and bifurcations can be followed."""

_FURTHER_EFFECTS = {each.name for each in EFFECTS if not each.is_common}
FURTHER = tuple(
    name
    for name, entry in PARAMETERS.items()
    if entry.effect in _FURTHER_EFFECTS or name in THROUGH_OTHERS
)
"""Parameters beyond eqs. (5), (6): datasets and fingerprints have them only where they differ from their default."""

FOLLOWING = tuple(name for name, entry in PARAMETERS.items() if entry.follows)
"""Parameters that an exciter knows to be left out."""

MIRRORED = {name: (entry.twin or name, entry.sign) for name, entry in PARAMETERS.items()}
"""Whose value, with which sign, each parameter takes under mirroring."""

TWINS = tuple((name, entry.twin) for name, entry in PARAMETERS.items() if name < entry.twin)
"""Parameters of support 1 and their counterparts of support 2."""


WITHOUT_UNITS = tuple(name for name, entry in PARAMETERS.items() if entry.physical is None)
"""Parameters that are pure numbers in a study with units, too."""


def of_effect(*effects: str) -> tuple[str, ...]:
    """Return the parameters of some effects."""
    return tuple(name for name, entry in PARAMETERS.items() if entry.effect in effects)


FORCES = tuple(
    n
    for n in of_effect("forcing", "second_harmonic", "shaker")
    if PARAMETERS[n].dimension in ("force", "length")
)
"""Amplitudes of the harmonics of the force, and of a frame that is shaken."""


if TYPE_CHECKING:
    from typing import Self

    from vibropipe.words.exciter import OfExciter

    class NamedFields(tuple[Any, ...]):
        """What a named tuple has beside its fields, which are made from records."""

        _fields: tuple[str, ...]

        def __new__(cls, *values: Any, **named: Any) -> Self: ...  # noqa: D102
        def _asdict(self) -> dict[str, Any]: ...
        def _replace(self, **named: Any) -> Self: ...

    class _Row(NamedFields, OfExciter): ...

else:
    _Row = namedtuple("Parameters", PARAMETERS, defaults=list(DEFAULTS.values())[-len(FURTHER) :])


class Parameters(_Row):
    """Parameters of one row as kernels read them, in the order of `PARAMETERS`; one compiled kernel serves all rows."""

    __slots__ = ()


class Acted(float):
    """The value of a parameter that another one acts on; `stated` is its own."""

    stated: float

    def __new__(cls, value: float, stated: float = 0.0) -> Acted:  # noqa: D102
        self = super().__new__(cls, value)
        self.stated = stated
        return self


class TiedValue(float):
    """The value of a parameter that is tied to others: copies of its exciter compute it again, by its `ties` if any."""

    ties: Mapping[str, str]

    def __new__(cls, value: float, ties: Mapping[str, str] | None = None) -> TiedValue:  # noqa: D102
        self = super().__new__(cls, value)
        self.ties = ties or {}
        return self


def stated_value(value: Any) -> Any:
    """Return the own value of a parameter that another one may act on."""
    return value.stated if isinstance(value, Acted) else value


def acting(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters by name, numbers or arrays, as kernels see them: what acts through others is absent then."""
    seen = dict(values)
    if any(isinstance(value, Acted) for value in seen.values()):
        return seen
    for name, acts in THROUGH_OTHERS.items():
        if acts and occurs(seen.get(name, 0.0)):
            seen |= {other: _evaluated(text, seen) for other, text in acts.items()}
            seen[name] = 0.0 * _as_numbers(seen[name])
    return seen


def _evaluated(expression: str, values: Mapping[str, Any]) -> Any:
    """Return the value of an expression of a record; parameters without a value have their defaults."""
    numbers = {name: _as_numbers(value) for name, value in {**DEFAULTS, **values}.items()}
    return eval(expression, {"__builtins__": {}}, numbers)


def names_in(expression: str) -> tuple[str, ...]:
    """Return the parameters that an expression of a record depends on."""
    return compile(expression, "", "eval").co_names


def _as_numbers(value: Any) -> Any:
    """Return the value of a parameter as a number or an array."""
    if isinstance(value, float):
        return value
    import numpy as np  # commands that compute nothing do without

    return np.asarray(value)


def occurs(value: Any) -> bool:
    """Return whether a parameter, a number or an array, is other than 0 anywhere; one motion has numbers."""
    return value != 0.0 if isinstance(value, float) else bool(_as_numbers(value).any())


def slopes_of_acted(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return of each parameter that others act on its derivatives by parameters, at their values: numbers or arrays."""
    own = {name: stated_value(value) for name, value in values.items()}
    slopes: dict[str, dict[str, Any]] = {}
    for target, expression in ACTED.items():
        slopes[target] = {
            name: _evaluated(expression, {**own, name: own[name] + 1e-100j}).imag / 1e-100
            for name in names_in(expression)
        }
    return slopes


def without_absent(values: Mapping[str, float]) -> dict[str, float]:
    """Return parameters without those of `FURTHER` that have their default."""
    return {
        name: value
        for name, value in values.items()
        if name not in FURTHER or value != DEFAULTS[name]
    }


def or_default(values: Mapping[str, float], name: str) -> float:
    """Return a parameter of those that `without_absent` has left, or another number that is 0 where it is left out."""
    return values.get(name, DEFAULTS.get(name, 0.0))


class PhysicalParameter(NamedTuple):
    """A parameter with units: dimension (`words.units`), range in SI, name by eqs. (2)-(4), if any, text of its key."""

    dimension: str
    range: Range
    non_dimensional: str
    key: str


def _with_units(entry: Parameter) -> dict[str, PhysicalParameter]:
    """Return the counterpart of a parameter, by its name; empty without one."""
    if entry.physical is None:
        return {}
    physical = entry.physical
    key = described(physical.key or entry.key, entry.default)
    if entry.default or physical.dimension:  # it belongs to the number without units
        key = f"{physical.key}."
    dimension, within = physical.dimension or entry.dimension, physical.range or entry.range
    return {physical.name: PhysicalParameter(dimension, within, entry.name, key)}


PHYSICAL: Mapping[str, PhysicalParameter] = {
    "m": PhysicalParameter("mass", POSITIVE, "", "Mass."),
    "C": PhysicalParameter("stiffness", POSITIVE, "", "Stiffness of the spring."),
    **{name: physical for each in RECORDS for name, physical in _with_units(each).items()},
    "m_e": PhysicalParameter(
        *("mass", NOT_NEGATIVE, ""),
        "Mass that turns on the mass m, which includes it, at the radius e: adds m_e e / m to shaker.",
    ),
    "e": PhysicalParameter(*("length", NOT_NEGATIVE, ""), "Radius at which m_e turns, with omega."),
    "slope": PhysicalParameter(
        *("angle", FINITE, ""),
        "Angle at which x rises: gravity adds -m gravity sin(slope) to load, and -M gravity sin(slope) to P (0).",
    ),
    "gravity": PhysicalParameter(
        *("acceleration", NOT_NEGATIVE, ""),
        "Acceleration of gravity, beside slope (9.80665 m/s^2).",
    ),
}
"""Parameters of the exciter with units, from which eqs. (2)-(4) make the others.

x rises at the angle `slope`, so that gravity adds -m gravity sin(slope) to `load`, and -M gravity sin(slope) to `P`
with a housing that slides.
"""

STANDARD_GRAVITY = 9.80665  # m/s^2

RIGID_AT_ZERO = ("k1", "k2")
"""Stiffnesses of supports: 0 stands for a rigid one, which is the limit of large values."""
SOFT_ALONG = "must be above 0 where it varies, since 0 stands for a rigid support"
