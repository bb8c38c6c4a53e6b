"""Physical dimensions with their SI units, and text such as "8 mm" as a number in SI.

pint reads the units. It is imported at the first text, so that what has no units does not wait for it (0.4 s). No
stored number depends on this module beside the numbers that it returns.
"""

from __future__ import annotations

import functools
import math
import re
from difflib import get_close_matches
from typing import Any, NamedTuple


class Dimension(NamedTuple):
    """A physical dimension: its SI unit in CF's spelling, a noun, and an example."""

    units: str
    noun: str
    example: str

    @property
    def plain(self) -> str:
        """The SI unit as it is written by hand: N s/m for N s m-1."""
        return plain_units(self.units)


def plain_units(units: str) -> str:
    """Return units in CF's spelling as they are written by hand: rad/s for rad s-1, m/s^2 for m s-2."""
    divided = re.sub(r"(?:^| )(\w+)-(\d)$", r"/\1^\2", units).removesuffix("^1")
    return divided.replace("/", "1/" if units == "s-1" else "/")


DIMENSIONS = {
    "length": Dimension("m", "a length", "8 mm"),
    "time": Dimension("s", "a time", "0.5 s"),
    "mass": Dimension("kg", "a mass", "2 kg"),
    "stiffness": Dimension("N m-1", "a stiffness", "8 N/mm"),
    "damping": Dimension("N s m-1", "a damping", "40 N s/m"),
    "force": Dimension("N", "a force", "120 N"),
    "frequency": Dimension("rad s-1", "a frequency", "55 rad/s"),
    "velocity": Dimension("m s-1", "a velocity", "0.3 m/s"),
    "energy": Dimension("J", "an energy", "0.2 J"),
    "torque": Dimension("N m", "a torque", "0.2 N m"),
    "power": Dimension("W", "a power", "3 W"),
    "impulse": Dimension("N s", "an impulse", "0.1 N s"),
    "rate": Dimension("s-1", "a rate", "3 1/s"),
    "angle": Dimension("rad", "an angle", "30 deg"),
    "acceleration": Dimension("m s-2", "an acceleration", "9.81 m/s^2"),
}

MINUS = "\u2212"
"""The minus of typeset text, which numbers may have in place of the hyphen."""
NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_TEXT = re.compile(rf"\s*({NUMBER})\s*((?:1\s*/|[^\s\d.,])[^\n]{{0,60}})", re.ASCII)
# Powers of units have one digit, so that a unit costs no time to read.
_LONG_POWER = re.compile(r"[\d⁰¹²³⁴⁵⁶⁷⁸⁹]{2}|\.")
# Units of each dimension as they are usually written, which are suggested for other spellings of them.
_USUAL = {
    "length": ("m", "cm", "mm", "um", "in", "ft"),
    "time": ("s", "ms", "min", "h"),
    "mass": ("kg", "g", "lb"),
    "stiffness": ("N/m", "N/mm", "kN/m", "kN/mm", "lbf/in"),
    "damping": ("N s/m", "N s/mm", "kN s/m", "kg/s", "lbf s/in"),
    "force": ("N", "mN", "kN", "lbf"),
    "frequency": ("Hz", "kHz", "rpm", "rad/s", "deg/s"),
    "velocity": ("m/s", "mm/s", "cm/s", "km/h"),
    "energy": ("J", "mJ", "kJ", "N m", "N mm"),
    "torque": ("N m", "mN m", "N mm"),
    "power": ("W", "mW", "kW", "hp"),
    "impulse": ("N s", "mN s", "kg m/s"),
    "rate": ("1/s",),
    "angle": ("rad", "deg"),
    "acceleration": ("m/s^2", "mm/s^2", "g"),
}
_OTHER_NAMES = {
    "rev/min": "rpm",
    "r/min": "rpm",
    "u/min": "rpm",
    "cpm": "rpm",
    "cps": "Hz",
    "hertz": "Hz",
    "gr": "g",
    "gm": "g",
    "lb": "lbf",
    "lb/in": "lbf/in",
}
# What pint reads as something that is hardly meant: grains.
_MISREAD = ("gr",)
_BETWEEN = re.compile(r"[\s*.\u00b7]+|\^")
_CYCLE = re.compile(r"Hz|hertz|rpm|turn|rev|cycle|cp[ms]", re.IGNORECASE)
_CYCLES = ("hertz", "turn", "revolution", "radian", "cycle", "degree", "rpm")


class UnitError(ValueError):
    """A value that is no quantity of its dimension.

    allowed : what is allowed, a noun phrase
    hint : what is wrong with the unit, or what was probably meant; may be empty
    """

    def __init__(self, allowed: str, hint: str = "") -> None:
        super().__init__(allowed, hint)
        self.allowed, self.hint = allowed, hint


def allowed_text(dimension: str, numbers: bool = False) -> str:
    """Return what a quantity takes as a noun phrase; `numbers`: whether bare numbers in SI are taken as well."""
    entry = DIMENSIONS[dimension]
    with_unit = f"{entry.noun} with its unit, such as {entry.example}"
    return f"a number in {entry.plain} or {with_unit}" if numbers else with_unit


def to_si(value: Any, dimension: str, numbers: bool = False) -> float:
    """Return a quantity as a finite number in SI.

    value : number and unit as text ("8 mm"); a quantity of any registry of pint; a number, which must be 0 unless
        `numbers`. A frequency in Hz counts cycles: 9 Hz is 2 pi 9 rad/s
    dimension : one of `DIMENSIONS`
    numbers : whether bare numbers are in SI, instead of an error
    Raises UnitError if the value has no unit, an unknown one or one of another dimension, or is not finite.
    """
    allowed = allowed_text(dimension, numbers)
    if isinstance(value, str):
        match = _TEXT.fullmatch(value.replace(MINUS, "-"))
        if match is None:
            raise UnitError(allowed, _text_hint(value))
        unit = match[2].strip()
        try:
            number = tidy(float(match[1]) * _factor(unit, dimension, allowed))
        except UnitError as error:
            meant = usual_unit(unit, dimension)
            hint = f"did you mean {match[1]} {meant}?" if meant else error.hint
            raise UnitError(allowed, hint) from None
    elif hasattr(value, "magnitude") and hasattr(value, "units"):
        unit = str(value.units)
        number = _number(value.magnitude, allowed) * _factor(unit, dimension, allowed)
    else:
        number = _number(value, allowed)
        if number != 0.0 and not numbers:
            raise UnitError(allowed, "it has no unit")
    if not math.isfinite(number):
        raise UnitError(allowed)
    return number + 0.0


def unit_of_text(text: Any) -> str:
    """Return the unit of a quantity as it was written, a text or a quantity of pint; empty if it has none."""
    if hasattr(text, "magnitude") and hasattr(text, "units"):
        return f"{text.units:~}".replace(" / ", "/")
    match = _TEXT.fullmatch(text.replace(MINUS, "-")) if isinstance(text, str) else None
    return " ".join(match[2].split()) if match else ""


def allowed_unit(dimension: str) -> str:
    """Return what a unit of a dimension may be as a noun phrase."""
    noun, usual = DIMENSIONS[dimension].noun.split()[1], _USUAL[dimension]
    return f"a unit of {noun}, such as {' or '.join(usual[:2])}"


def check_unit(unit: Any, dimension: str) -> str:
    """Return a unit of a dimension without blanks around it, or raise UnitError.

    Raises UnitError if it is no unit, or one of another dimension; the hint suggests the nearest usual one.
    """
    usual = _USUAL[dimension]
    noun = DIMENSIONS[dimension].noun.split()[1]
    allowed = (
        f"a unit of {noun}, such as {', '.join(usual[:-1])}{' or ' if usual[1:] else ''}{usual[-1]}"
    )
    if not isinstance(unit, str) or not unit.strip():
        raise UnitError(allowed)
    text = " ".join(unit.split())
    try:
        _factor(text, dimension, allowed)
    except UnitError as error:
        near = get_close_matches(text, usual, 1, 0.5)
        meant = usual_unit(text, dimension) or (near[0] if near and "known" in error.hint else "")
        raise UnitError(allowed, f"did you mean {meant}?" if meant else error.hint) from None
    return text


@functools.cache
def unit_factor(unit: str) -> float:
    """Return the SI value of one of a unit as it is written by hand, of the first dimension that it can be of.

    1 of units in CF's spelling, which are those of SI, and of pure numbers.
    """
    if unit in {"", "1", *(entry.units for entry in DIMENSIONS.values())}:
        return 1.0
    for dimension in DIMENSIONS:
        try:
            return _factor(unit, dimension, "")
        except UnitError:
            continue
    return 1.0


def is_of_cycles(unit: str) -> bool:
    """Return whether a unit is one of frequency that counts cycles, as Hz and rpm do, and not radians or degrees."""
    return _CYCLE.search(unit) is not None


def usual_unit(unit: str, dimension: str) -> str:
    """Return the usual spelling of a unit, which differs in capitals and in what stands between; empty for none."""

    def skeleton(text: str) -> str:
        return _BETWEEN.sub("", text).casefold()

    usual = {skeleton(each): each for each in _USUAL[dimension]}
    other = _OTHER_NAMES.get(unit.casefold(), "")
    return usual.get(skeleton(unit), other if other in _USUAL[dimension] else "")


def tidy(number: float) -> float:
    """Return the number of at most 12 digits that lies within four roundings of a number, or the number itself.

    A quantity that is converted forth and back, 20 rad/s over sqrt(C/m), then comes back as 20, not as its neighbour.
    """
    short = float(f"{number:.12g}")
    return short if abs(short - number) <= 4 * math.ulp(number) else number


def _number(value: Any, allowed: str) -> float:
    try:
        if isinstance(value, (bytes, bool)) or value is None:
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise UnitError(allowed) from None


def _text_hint(text: str) -> str:
    if re.fullmatch(NUMBER, text.strip(), re.ASCII):
        return "it has no unit"
    pointed = text.replace(",", ".", 1)
    return f"write {pointed}, with a point" if _TEXT.fullmatch(pointed) else ""


def _factor(unit: str, dimension: str, allowed: str) -> float:
    """Return the SI value of one `unit`; raise UnitError if it is unknown or of another dimension."""
    _registry()  # errors of the import are not those of the unit
    try:
        if _LONG_POWER.search(unit) or unit in _MISREAD:
            raise ValueError("no unit, or one that is not meant")
        # Of an acceleration g is that of gravity, and not a gram.
        name = "g_0" if (unit, dimension) == ("g", "acceleration") else unit
        factor, is_angular, same = _parsed(name, dimension)
    except Exception:
        # pint raises errors of a dozen kinds for text that is no unit, and assertions
        raise UnitError(allowed, f"{unit!r} is no unit that is known") from None
    if not same:
        raise UnitError(allowed, f"{unit} is no unit of {DIMENSIONS[dimension].noun.split()[1]}")
    if dimension == "frequency" and not is_angular:
        hint = f"{unit} may count radians or cycles: write rad/s, Hz or rpm"
        raise UnitError(allowed, hint)
    if dimension == "angle" and not is_angular:
        raise UnitError(allowed, f"{unit} is no unit of angle")
    return factor


@functools.cache
def _parsed(unit: str, dimension: str) -> tuple[float, bool, bool]:
    """Return the SI value of a unit, whether it names an angle or cycles, and whether it is of the dimension."""
    registry = _registry()
    parsed = registry.parse_units(unit)
    wanted = registry.parse_units(DIMENSIONS[dimension].plain)
    if not parsed.is_compatible_with(wanted):
        return math.nan, False, False
    is_angular = any(name.endswith(_CYCLES) or "revolution" in name for name in parsed._units)
    return float(registry.Quantity(1.0, parsed).to(wanted).magnitude), is_angular, True


@functools.cache
def _registry() -> Any:
    """Return pint's registry, in which Hz counts cycles; by default it takes 1 Hz for 1 rad/s."""
    import pint

    registry: Any = pint.UnitRegistry(on_redefinition="ignore")
    registry.define("hertz = turn / second = Hz")
    return registry
