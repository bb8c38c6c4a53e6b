"""Units of what is shown: a physical dataset in the prefixes that give small numbers, and units as text."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
import xarray as xr

# Prefixes that are tried for a unit, the largest first, with the factor from the stored unit.
PREFIXES: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6)),
    "m s-1": (("m s-1", 1.0), ("mm s-1", 1e3)),
    "N": (("kN", 1e-3), ("N", 1.0), ("mN", 1e3)),
    "J": (("J", 1.0), ("mJ", 1e3), ("µJ", 1e6)),
    "s": (("s", 1.0), ("ms", 1e3)),
}
# The largest magnitude of a unit is at least this in the prefix that is chosen.
LEAST = 0.5


def display_units(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset in units for display; a dataset without physical units is returned as it is.

    All quantities of one unit get the same prefix.
    """
    changed: dict[str, tuple[str, float]] = {}
    for unit, prefixes in PREFIXES.items():
        names = [str(n) for n, v in dataset.variables.items() if v.attrs.get("units") == unit]
        largest = max((_largest(dataset[name].values) for name in names), default=0.0)
        fitting = [entry for entry in prefixes if largest * entry[1] >= LEAST]
        chosen = fitting[0] if fitting else prefixes[-1]
        if largest > 0.0 and chosen[1] != 1.0:
            changed |= dict.fromkeys(names, chosen)
    if not changed:
        return dataset
    scaled = {}
    for name, (unit, factor) in changed.items():
        variable = dataset[name].variable
        attrs = {**variable.attrs, "units": unit}
        scaled[name] = (variable.dims, variable.values * factor, attrs)
    coords = {name: value for name, value in scaled.items() if name in dataset.coords}
    data = {name: value for name, value in scaled.items() if name not in coords}
    return dataset.assign_coords(coords).assign(data)


def _largest(values: np.ndarray) -> float:
    """Return the largest finite magnitude, 0 if there is none."""
    size = np.abs(values[np.isfinite(values)])
    return float(size.max(initial=0.0))


def unit_text(units: str) -> str:
    """Write a CF unit with slashes; dimensionless is empty.

    >>> unit_text("N s m-1")
    'N·s/m'
    """
    if units in ("", "1"):
        return ""
    above: list[str] = []
    below: list[str] = []
    for base, power in re.findall(r"([^\W\d]+)(-?\d+)?", units):
        text = base + {"": "", "-1": "", "2": "²", "-2": "²"}.get(power, power.lstrip("-"))
        (below if power.startswith("-") else above).append(text)
    return "/".join(["·".join(above) or "1", *below])
