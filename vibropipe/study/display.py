"""The units in which a study shows what it finds: those of its key `units`, else those in which it is written."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from vibropipe.words.parameters import PHYSICAL
from vibropipe.words.units import DIMENSIONS, UnitError, check_unit, unit_of_text

# Dimensions whose parameters stand for themselves: each keeps its own unit. Lengths, times, frequencies and velocities
# of several quantities share the axes of a picture, and with them one unit.
OF_A_PARAMETER = ("mass", "stiffness", "damping", "force", "angle")
TEXTS = ("title", "caption", "description", "question", "hero", "units", "kind")
_BOUND = re.compile(r"[<>]=?([^<>,]+)")


def display_units_of(tree: Mapping[str, Any], chosen: Mapping[str, str]) -> dict[str, str]:
    """Return the units of a study by dimension, and by parameter where one is written in another unit.

    Of several units of one dimension the one that most keys are written in holds, the first of equals.

    Parameters
    ----------
    tree : mapping
        The study as it is written, with text for quantities.
    chosen : mapping of str to str
        Units by dimension that the study chooses.
    """
    written = Counter(_units_in(tree, ""))
    of_dimension, of_parameter = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for (key, unit), amount in written.items():
        dimension = _dimension_of(unit)
        if key in PHYSICAL:
            of_parameter[key, unit] += amount
        if dimension != "angle":  # phases of harmonics are not written
            of_dimension[dimension, unit] += amount
    units = {**_most(of_dimension), **chosen}
    units.pop("", None)
    for name, unit in _most(of_parameter).items():
        dimension = PHYSICAL[name].dimension
        is_free = dimension in OF_A_PARAMETER and dimension not in chosen
        if is_free and _dimension_of(unit) == dimension and units.get(dimension) != unit:
            units[name] = unit
    return units


def _units_in(node: Any, key: str) -> Iterator[tuple[str, str]]:
    """Yield parameter or key and unit of each quantity that is written, of each list once."""
    if isinstance(node, Mapping):
        for name, value in node.items():
            if name not in TEXTS:
                yield from _units_in(value, key if key in PHYSICAL else str(name))
    elif isinstance(node, list):
        yield from dict.fromkeys(pair for entry in node for pair in _units_in(entry, key))
    elif isinstance(node, str):
        for text in _BOUND.findall(node) or [node]:
            if unit := unit_of_text(text.strip()):
                yield key, unit


def _dimension_of(unit: str) -> str:
    """Return the dimension of a unit, empty if it is none."""
    for dimension in DIMENSIONS.keys() - {"acceleration", "rate"}:
        try:
            check_unit(unit, dimension)
        except UnitError:
            continue
        return dimension
    return ""


def _most(amounts: Counter[tuple[str, str]]) -> dict[str, str]:
    """Return the unit with the largest number for each name, the first of equals."""
    found: dict[str, str] = {}
    for (name, unit), _ in amounts.most_common():
        found.setdefault(name, unit)
    return found
