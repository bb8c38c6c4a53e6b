"""Errors of calls with units in the names, values and units that were given.

A module of its own, since no number depends on it: with `with_units` the datasets of studies would be solved anew.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.with_units import START_DIMENSIONS, in_given_terms, plain_values
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.units import DIMENSIONS, NUMBER, tidy, unit_of_text
from vibropipe.words.vocabulary import physical_name

# Limits in what must hold of a value, and names without units in it.
_ENDS = re.compile(rf"from ({NUMBER}) to ({NUMBER})")
_RENAMED = re.compile(r"\b(?:nu|[kh][12])\b")


def in_given_units(error: ParameterError, given: Mapping[str, Any]) -> ParameterError:
    """Return the error of a call as `in_given_terms`, its limits in the unit of the value that was given.

    given : arguments by name, `exciter` among them
    """
    value = repr(error.value)
    if not error.got.startswith(value):
        return error
    plain = ParameterError(error.name, error.value, error.allowed, error.must)
    told = in_given_terms(plain, given)
    if told is plain:
        return error
    parameter = given["along"] if told.name in ("to", "at") else told.name.rpartition(".")[2]
    must = _in_unit_of(told.value, told.must, given["exciter"], parameter)
    if parameter not in PARAMETERS:
        must = _RENAMED.sub(lambda match: physical_name(match[0]), must)
    got = told.got + error.got.removeprefix(value)
    return ParameterError(told.name, told.value, must.removeprefix("must be "), must, got)


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
