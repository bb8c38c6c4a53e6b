"""Arguments with units, of exciters that were given with units, as the numbers that calls without units take."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import si_value
from vibropipe.physics.si import eigenfrequency, non_dimensional
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.units import UnitError, to_si

# Names of parameters with units that calls without units do not know.
OWN = frozenset(name for name, each in PHYSICAL.items() if each.non_dimensional) - PARAMETERS.keys()
START_DIMENSIONS = dict(zip(STARTS, ("length", "velocity"), strict=True))


def are_with_units(exciter: Exciter, names: Iterable[str], values: Iterable[Any] = ()) -> bool:
    """Return whether arguments of an exciter of `from_physical` are with units: by a name, as omega, or by a value."""
    if not exciter.written:
        return False
    return any(name in OWN for name in names) or any(map(has_unit, values))


def has_unit(values: Any) -> bool:
    """Return whether a value, or one of a list, is text or a quantity."""
    if isinstance(values, str) or hasattr(values, "magnitude"):
        return True
    return isinstance(values, (list, tuple)) and any(map(has_unit, values))


def plain_name(name: str) -> str:
    """Return the name without units of a parameter, which may be one already."""
    return PHYSICAL[name].non_dimensional if name in OWN else name


def plain_values(exciter: Exciter, name: str, values: Any) -> Any:
    """Return values of a parameter or a start without units.

    Parameters
    ----------
    exciter : Exciter
        Of `from_physical`.
    name : str
        As with units.
    values : number, text, quantity, or an array or list of such
        Numbers are in SI.

    Raises
    ------
    ParameterError
        If a value has a wrong unit, is out of range, or the name is M: a grid of masses is one of mass_ratio = m/M.
    """
    if values is None or (name not in PHYSICAL and name not in STARTS):
        return values  # a pure number, or a name that the call refuses
    if name == "M":
        raise ParameterError("M", values, must="must be given as mass_ratio = m/M where it varies")
    if not has_unit(values):
        si: Any = np.array(values, dtype=float)
    elif isinstance(values, str) or np.ndim(getattr(values, "magnitude", ())) == 0:
        si = _si(name, values)
    else:
        si = np.array([_si(name, each) for each in values])
    m, C = (si_value(each, exciter.written[each]) for each in ("m", "C"))
    if name in STARTS:
        return si if name == "x0" else si / eigenfrequency(m, C)
    return non_dimensional({"m": m, "C": C, name: si})[PHYSICAL[name].non_dimensional]


def _si(name: str, value: Any) -> float:
    """Return a value in SI, or raise a ParameterError naming it."""
    if name not in STARTS:
        return si_value(name, value)
    try:
        return to_si(value, START_DIMENSIONS[name], numbers=True)
    except UnitError as error:
        raise ParameterError(name, value, error.allowed) from None


def plain_mapping(exciter: Exciter, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a mapping by parameter without units."""
    return {plain_name(name): plain_values(exciter, name, each) for name, each in given.items()}
