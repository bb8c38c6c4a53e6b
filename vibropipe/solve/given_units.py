"""Errors of calls with units in the names, values and units that were given.

A module of its own, since no number depends on it: with `with_units` the datasets of studies would be solved anew.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.with_units import START_DIMENSIONS, in_given_terms, plain_name, plain_values
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.units import DIMENSIONS, NUMBER, tidy, unit_of_text
from vibropipe.words.vocabulary import physical_name

# Limits in what must hold of a value, and names without units in it.
_ENDS = re.compile(rf"from ({NUMBER}) to ({NUMBER})")
_LENGTH = re.compile(r"(l|delta|load) = ([^,]+)")
_OF_LOAD = {"load": "load/C"}  # displaces the equilibrium by as much
_RENAMED = re.compile(r"\b(?:nu|[kh][12])\b")


def in_given_units(error: ParameterError, given: Mapping[str, Any]) -> ParameterError:
    """Return the error of a call as `in_given_terms`, its limits in the unit of the value that was given.

    given : arguments by name, `exciter` among them
    """
    value = repr(error.value)
    if not error.got.startswith(value):
        return _in_metres(error)
    plain = ParameterError(error.name, error.value, error.allowed, error.must)
    told = in_given_terms(plain, given)
    if told is plain:
        return _of_box(error, given.get("along"))
    parameter = given["along"] if told.name in ("to", "at") else told.name.rpartition(".")[2]
    must = _in_unit_of(told.value, told.must, given["exciter"], parameter)
    if parameter not in PARAMETERS:
        must = _RENAMED.sub(lambda match: physical_name(match[0]), must)
    got = told.got + error.got.removeprefix(value)
    return ParameterError(told.name, told.value, must.removeprefix("must be "), must, got)


def _in_metres(error: ParameterError) -> ParameterError:
    """Return the error of supports that coincide with the unit of its lengths; any other one itself."""
    if not error.got.startswith("l = "):
        return error
    got = _LENGTH.sub(lambda match: f"{_OF_LOAD.get(match[1], match[1])} = {match[2]} m", error.got)
    must = error.must.replace("|delta - load|", f"|delta - {_OF_LOAD['load']}|")
    return ParameterError(error.name, error.value, error.allowed, must, got)


def _of_box(error: ParameterError, along: Any) -> ParameterError:
    """Return the error of a parameter at 0, which has no unit, by its name in `along`."""
    names = along if isinstance(along, (list, tuple)) and error.value == 0.0 else ()
    own = next((name for name in names if plain_name(name) == error.name), error.name)
    return ParameterError(own, error.value, error.allowed, error.must, error.got)


def _in_unit_of(given: Any, must: str, exciter: Exciter, name: str) -> str:
    """Return what must hold of a parameter or a start with its limits in the unit of the value that was given."""
    ends = _ENDS.search(must)
    if ends is None or (name not in PHYSICAL and name not in STARTS):
        return must
    dimension = START_DIMENSIONS.get(name) or PHYSICAL[name].dimension
    values = given if isinstance(given, (list, tuple)) else [given]
    written = next(filter(None, map(unit_of_text, values)), "")
    unit = written or DIMENSIONS[dimension].plain
    one = plain_values(exciter, name, f"1 {unit}")
    low, high = (f"{tidy(float(end) / one):.10g}" for end in ends.groups())
    return must.replace(ends[0], f"from {low} to {high} {unit}")
