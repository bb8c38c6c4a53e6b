"""Units of what is shown: a physical dataset in the prefixes that give small numbers, and units as text."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.vocabulary import SENSITIVITY_SUFFIX, split_suffix

if TYPE_CHECKING:
    import xarray as xr

# Prefixes that are tried for a unit, the largest first, with the factor from the stored unit.
PREFIXES: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6)),
    "m s-1": (("m s-1", 1.0), ("mm s-1", 1e3)),
    "N": (("kN", 1e-3), ("N", 1.0), ("mN", 1e3)),
    "J": (("J", 1.0), ("mJ", 1e3), ("µJ", 1e6)),
    "s": (("s", 1.0), ("ms", 1e3)),
}
# The largest magnitude of a unit, and that of each parameter, is at least this in the prefix that is chosen.
MIN_MAGNITUDE = 0.5
# Units in which parameters are usually stated: none gets a larger prefix on account of other quantities.
USUAL_UNITS: Mapping[str, str] = {"m": "mm", "N": "N"}
# What is derived from a quantity and of its size: all else, such as errors and spreads, may be of any size.
OF_ITS_SIZE = ("", "_target", "_lower", "_upper", "_measured", "_fitted")


def display_units(datasets: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Return the datasets of a study in units for display; those without physical units as they are.

    All quantities of one unit get the same prefix, in all datasets, since pictures and tables show several together.
    """
    prefixes: dict[str, tuple[str, float]] = {}
    for unit, choices in PREFIXES.items():
        sizes = [pair for dataset in datasets.values() for pair in _sizes(dataset, unit)]
        largest = max((size for _, size in sizes), default=0.0)
        if largest > 0.0:
            given = [size for name, size in sizes if name in {*PARAMETERS, *PHYSICAL}]
            prefixes[unit] = _prefix(choices, largest, given, USUAL_UNITS.get(unit))
    return {name: _scaled(dataset, prefixes) for name, dataset in datasets.items()}


def _sizes(dataset: xr.Dataset, unit: str) -> list[tuple[str, float]]:
    """Return name and largest magnitude of the variables with a unit, without zeros and what may be of any size."""
    found = [
        (str(name), _largest(variable.values))
        for name, variable in dataset.variables.items()
        if variable.attrs.get("units") == unit and split_suffix(str(name))[1] in OF_ITS_SIZE
    ]
    return [(name, size) for name, size in found if size > 0.0]


def _prefix(
    choices: Sequence[tuple[str, float]], largest: float, given: Sequence[float], usual: str | None
) -> tuple[str, float]:
    """Return the prefix that suits the largest magnitude, at most the usual unit if one `given` would be small."""
    fitting = [entry for entry in choices if largest * entry[1] >= MIN_MAGNITUDE] or choices[-1:]
    if usual is not None and any(size * fitting[0][1] < MIN_MAGNITUDE for size in given):
        limit = dict(choices)[usual]
        fitting = [entry for entry in fitting if entry[1] >= limit]
    return fitting[0]


def shown_factor(unit: str) -> float:
    """Return the factor from the stored unit to one that is shown: 1000 for mm, whose stored unit is m."""
    return next((f for choices in PREFIXES.values() for shown, f in choices if shown == unit), 1.0)


def shown_unit(dataset: xr.Dataset, unit: str) -> tuple[str, float]:
    """Return the unit that a dataset shows in place of a stored one, with the factor: of s, ms and 1000."""
    shown = {
        str(variable.attrs.get("units"))
        for name, variable in dataset.variables.items()
        if not str(name).endswith(SENSITIVITY_SUFFIX)
    }
    same = (unit, 1.0)
    return next((entry for entry in PREFIXES.get(unit, ()) if entry[0] in shown), same)


def _scaled(dataset: xr.Dataset, prefixes: Mapping[str, tuple[str, float]]) -> xr.Dataset:
    """Return a dataset with the units that are in `prefixes` replaced."""
    coords: dict[Hashable, Any] = {}
    data: dict[Hashable, Any] = {}
    for name, variable in dataset.variables.items():
        unit, factor = prefixes.get(str(variable.attrs.get("units")), ("", 1.0))
        # units of a sensitivity are those of a quantity over those of a parameter
        if factor != 1.0 and not str(name).endswith(SENSITIVITY_SUFFIX):
            attrs = {**variable.attrs, "units": unit}
            target = coords if name in dataset.coords else data
            target[name] = (variable.dims, variable.values * factor, attrs)
    return dataset.assign_coords(coords).assign(data) if coords or data else dataset


def _largest(values: np.ndarray) -> float:
    """Return the largest finite magnitude, 0 if there is none."""
    size = np.abs(values[np.isfinite(values)])
    return float(size.max(initial=0.0))


def unit_text(units: str) -> str:
    """Write a CF unit with slashes, one that has slashes as it is; dimensionless is empty.

    >>> unit_text("N s m-1")
    'N·s/m'
    """
    if units in ("", "1"):
        return ""
    if "/" in units:
        return units
    above: list[str] = []
    below: list[str] = []
    for base, power in re.findall(r"([^\W\d]+)(-?\d+)?", units):
        text = base + {"": "", "-1": "", "2": "²", "-2": "²"}.get(power, power.lstrip("-"))
        (below if power.startswith("-") else above).append(text)
    return "/".join(["·".join(above) or "1", *below])
