"""Units of what is shown: a physical dataset in the prefixes that give small numbers, and units as text."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.words.vocabulary import ERROR_SUFFIX

# Prefixes that are tried for a unit, the largest first, with the factor from the stored unit.
PREFIXES: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6)),
    "m s-1": (("m s-1", 1.0), ("mm s-1", 1e3)),
    "N": (("kN", 1e-3), ("N", 1.0), ("mN", 1e3)),
    "J": (("J", 1.0), ("mJ", 1e3), ("µJ", 1e6)),
    "s": (("s", 1.0), ("ms", 1e3)),
}
# The largest magnitude of a unit is at least this in the prefix that is chosen.
MIN_MAGNITUDE = 0.5


def display_units(datasets: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Return the datasets of a study in units for display; those without physical units as they are.

    All quantities of one unit get the same prefix, in all datasets, since pictures and tables show several together.
    """
    units = {
        name: {str(n): v.attrs.get("units") for n, v in dataset.variables.items()}
        for name, dataset in datasets.items()
    }
    prefixes: dict[str, tuple[str, float]] = {}
    for unit, choices in PREFIXES.items():
        largest = max(
            (
                _largest(datasets[name][variable].values)
                for name, of_variables in units.items()
                for variable, own in of_variables.items()
                # an error may be of any size, and is never drawn
                if own == unit and not variable.endswith(ERROR_SUFFIX)
            ),
            default=0.0,
        )
        fitting = [entry for entry in choices if largest * entry[1] >= MIN_MAGNITUDE]
        if largest > 0.0:
            prefixes[unit] = fitting[0] if fitting else choices[-1]
    return {name: _scaled(dataset, prefixes) for name, dataset in datasets.items()}


def scale(dataset: xr.Dataset, unit: str) -> float:
    """Return the factor from a stored unit to the one shown in a dataset: of s, 1000 where its times are in ms."""
    factors = dict(PREFIXES[unit])
    shown = {str(variable.attrs.get("units")) for variable in dataset.variables.values()}
    return next((factor for name, factor in factors.items() if name in shown), 1.0)


def _scaled(dataset: xr.Dataset, prefixes: Mapping[str, tuple[str, float]]) -> xr.Dataset:
    """Return a dataset with the units that are in `prefixes` replaced."""
    coords: dict[Hashable, Any] = {}
    data: dict[Hashable, Any] = {}
    for name, variable in dataset.variables.items():
        unit, factor = prefixes.get(str(variable.attrs.get("units")), ("", 1.0))
        if factor != 1.0:
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
