"""Arguments with units, of exciters that were given with units, as the numbers that calls without units take."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import si_value
from vibropipe.physics.si import eigenfrequency, non_dimensional, unit_factors
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.rows.named import named
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS, WITHOUT_UNITS
from vibropipe.words.units import MINUS, UnitError, to_si
from vibropipe.words.vocabulary import PLACES_IN_SI

# Names of parameters with units that calls without units do not know.
OWN = frozenset(name for name, each in PHYSICAL.items() if each.non_dimensional) - PARAMETERS.keys()
_VARIED = [
    name for name, each in PHYSICAL.items() if each.non_dimensional not in ("", "mass_ratio")
]
_OF_UNITS = "does not vary in a call: make an exciter for each value. What varies is " + ", ".join(
    (*_VARIED, *WITHOUT_UNITS, "mass_ratio")
)
_OF_UNBALANCE = "does not vary in a call: vary shaker, which is m_e e / m, in its place"
_OF_GRAVITY = "does not vary in a call: vary load, which has -m gravity sin(slope), in its place"
UNVARIED = {
    "m": _OF_UNITS,
    "C": _OF_UNITS,
    "M": "must be given as mass_ratio = m/M where it varies",
    "m_e": _OF_UNBALANCE,
    "e": _OF_UNBALANCE,
    "slope": _OF_GRAVITY,
    "gravity": _OF_GRAVITY,
}
"""Parameters with units that no call varies: what to do."""
_BOUND = re.compile(r"\s*([<>])=?([^<>]+)")
START_DIMENSIONS = dict(zip(STARTS, ("length", "velocity"), strict=True))


def are_with_units(exciter: Exciter, *given: Any) -> bool:
    """Return whether arguments of an exciter of `from_physical` are with units: by a value, or a name such as omega.

    given : mappings by name, values, arrays or lists of values
    """
    return bool(exciter.written) and any(
        any(
            plain_name(name) != name or name in UNVARIED or has_unit(value)
            for name, value in each.items()
        )
        if isinstance(each, Mapping)
        else isinstance(each, str) or has_unit(each)
        for each in given
    )


def has_unit(values: Any) -> bool:
    """Return whether a value, or one of a list, is a quantity or text other than bounds of bare numbers."""
    if isinstance(values, str):
        return not all(_is_number(end) for _sign, end in _bounds(values) or [("", values)])
    if hasattr(values, "magnitude"):
        return True
    return isinstance(values, (list, tuple)) and any(map(has_unit, values))


def plain_name(name: str) -> str:
    """Return the name without units of a parameter, or of the place of a bifurcation; it may be one already."""
    return PHYSICAL[name].non_dimensional if name in OWN else PLACES_IN_SI.get(name, name)


def plain_values(exciter: Exciter, name: str, values: Any) -> Any:
    """Return values of a parameter or a start without units.

    exciter : of `from_physical`
    name : as with units
    values : number, text, quantity, or an array or list of such; numbers are in SI
    Raises ParameterError if a value has a wrong unit, is out of range, or the parameter does not vary in calls.
    """
    if values is None or (name not in PHYSICAL and name not in STARTS):
        return values  # a pure number, or a name that the call refuses
    if name in UNVARIED:
        raise ParameterError(name, values, must=UNVARIED[name], got="")
    if not has_unit(values):
        si: Any = np.array(values, dtype=float)
    elif isinstance(values, str) or np.ndim(getattr(values, "magnitude", ())) == 0:
        si = _si(name, values)
    else:
        si = np.array([_si(name, each) for each in values])
    m, C = _mass_and_stiffness(exciter)
    if name in STARTS:
        return si if name == "x0" else si / eigenfrequency(m, C)
    return non_dimensional({"m": m, "C": C, name: si})[PHYSICAL[name].non_dimensional]


def _si(name: str, value: Any) -> float:
    """Return a value of a parameter or a start in SI, or raise a ParameterError naming it."""
    if name in STARTS:
        return si_of_dimension(name, value, START_DIMENSIONS[name])
    return si_value(name, value)


def si_of_dimension(argument: str, value: Any, dimension: str) -> float:
    """Return a value of a physical dimension in SI, or raise a ParameterError naming its argument."""
    try:
        return to_si(value, dimension, numbers=True)
    except UnitError as error:
        hint = f" ({error.hint})" if error.hint else ""
        raise ParameterError(argument, value, error.allowed, got=repr(value) + hint) from None


def in_given_terms(error: ParameterError, given: Mapping[str, Any]) -> ParameterError:
    """Return the error of a call with the name and the value that were given where it has those without units.

    given : arguments by name, `exciter` among them
    """
    if error.got != repr(error.value) or not are_with_units(given["exciter"], *given.values()):
        return error
    argument, _, key = error.name.partition(".")
    if argument in given and not key:
        return ParameterError(argument, given[argument], error.allowed, error.must)
    for name, values in given.items():
        if name == "ties" or (key and name != argument) or not isinstance(values, Mapping):
            continue
        for own, value in values.items():
            if plain_name(own) == (key or argument) and (own != key or has_unit(value)):
                return ParameterError(f"{name}.{own}", value, error.allowed, error.must)
    return error


def plain_time(exciter: Exciter, name: str, value: Any) -> float:
    """Return a time in 1/p, from seconds or a time with a unit; name : of its argument."""
    return si_of_dimension(name, value, "time") * eigenfrequency(*_mass_and_stiffness(exciter))


def plain_velocity(exciter: Exciter, name: str, value: Any) -> float:
    """Return a velocity in m p, from m/s or one with a unit; name : of its argument."""
    return si_of_dimension(name, value, "velocity") / eigenfrequency(*_mass_and_stiffness(exciter))


def _mass_and_stiffness(exciter: Exciter) -> tuple[float, float]:
    """Return m and C of an exciter of `from_physical`, in SI."""
    m, C = (si_value(each, exciter.written[each]) for each in ("m", "C"))
    return m, C


def plain_mapping(exciter: Exciter, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping by parameter without units."""
    return {plain_name(name): plain_values(exciter, name, each) for name, each in given.items()}


def plain_deviations(
    exciter: Exciter, given: Mapping[str, Any], varied: Iterable[str] = ()
) -> dict[str, Any]:
    """Return how far parameters may be off, by name, without units; M by its ratio, in the first order.

    Raises ParameterError if a value has a wrong unit, or M is given for a housing that is fixed or whose mass varies.
    """
    plain = plain_mapping(exciter, {name: each for name, each in given.items() if name != "M"})
    if "M" in given:
        ratio = exciter.mass_ratio
        if ratio == 0.0:
            raise ParameterError("M", given["M"], must="must be left out: the housing is fixed")
        if "mass_ratio" in varied:
            must = (
                "must be left out beside a range of mass_ratio: what M may be off is that of one M"
            )
            raise ParameterError("M", given["M"], must=must)
        off, m = si_value("M", given["M"]), si_value("m", exciter.written["m"])
        plain["mass_ratio"] = ratio**2 / m * off
    return plain


def plain_goals(exciter: Exciter, argument: str, given: Mapping[str, Any] | None) -> Any:
    """Return targets, bounds or allowances of a design, by quantity, without units; bare numbers are in SI.

    Raises ParameterError if a quantity is unknown, or a value has a wrong unit.
    """
    if given is None:
        return None
    written = {each: si_value(each, exciter.written[each]) for each in ("m", "C")}
    factors = unit_factors(**written)

    def plain(name: str, dimension: str, value: Any) -> float:
        if not dimension:
            return value
        if isinstance(value, str) and _is_number(value):
            value = float(value)
        return si_of_dimension(f"{argument}.{name}", value, dimension) / factors.get(dimension, 1.0)

    def plain_goal(name: str, value: Any) -> Any:
        if name == CURVE:
            return value  # lengths keep their numbers
        dimension = named(plain_name(name), argument).dimension
        if isinstance(value, str) and (bounds := _bounds(value)):
            return ", ".join(f"{sign} {plain(name, dimension, end)}" for sign, end in bounds)
        if isinstance(value, (tuple, list)):
            return [plain(name, dimension, end) for end in value]
        return plain(name, dimension, value)

    return {plain_name(name): plain_goal(name, value) for name, value in given.items()}


def plain_levels(exciter: Exciter, of: Any) -> Any:
    """Return kinds of bifurcations and values of quantities without units; what is neither is refused later."""
    if isinstance(of, Mapping):
        return plain_goals(exciter, "of", of)
    return [plain_levels(exciter, each) for each in of] if isinstance(of, (list, tuple)) else of


def plain_objectives(minimise: Any) -> Any:
    """Return the names of what is to be least, those of parameters without units; others are refused later."""
    if isinstance(minimise, str):
        sign = "-" if minimise.startswith("-") else ""
        return sign + plain_name(minimise.removeprefix(sign).strip())
    return (
        [plain_objectives(each) for each in minimise]
        if isinstance(minimise, (list, tuple))
        else minimise
    )


def _bounds(text: str) -> list[tuple[str, str]]:
    """Return the signs and the ends of bounds as text; of any other text nothing."""
    parts = [_BOUND.fullmatch(part) for part in text.replace(MINUS, "-").split(",")]
    return [(part[1], part[2].strip()) for part in parts if part] if all(parts) else []


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
