"""Units of what is shown: those that a study wrote or chose, else prefixes that give small numbers; units as text.

Datasets stay in SI. Their attribute `display_units` holds what was written or chosen; the function of that name makes
copies in these units, from whose variables pictures, captions, tables and pages take them.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.units import DIMENSIONS, is_of_cycles, plain_units, tidy, unit_factor
from vibropipe.words.vocabulary import PARAMETER, SENSITIVITY_SUFFIX, split_suffix

if TYPE_CHECKING:
    import xarray as xr

# Attribute of a dataset: `frequency: Hz; length: mm; F: kN`, by dimension, and by parameter where they differ.
DISPLAY_UNITS = "display_units"
PER_PARAMETER = "/(unit of parameter)"
# Values that come from a user: 9 Hz is shown as 9, not as its neighbour.
GIVEN = {*PARAMETERS, *PHYSICAL, *STARTS, "free_period"}
DIMENSION_OF = {entry.units: name for name, entry in DIMENSIONS.items()}
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
# Prefixes that are tried for a unit, the largest first, with the factor from the stored unit.
PREFIXES: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6)),
    "m s-1": (("m s-1", 1.0), ("mm/s", 1e3)),
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


def units_as_text(units: Mapping[str, str]) -> str:
    """Write units by dimension or parameter as the attribute of a dataset."""
    return "; ".join(f"{name}: {unit}" for name, unit in units.items())


def units_of(dataset: xr.Dataset) -> dict[str, str]:
    """Return the units that were written or chosen for a dataset, by dimension or parameter."""
    pairs = str(dataset.attrs.get(DISPLAY_UNITS, "")).split("; ")
    return dict(pair.split(": ", 1) for pair in pairs if ": " in pair)


def display_units(
    datasets: Mapping[str, xr.Dataset], prefixes: bool = True
) -> dict[str, xr.Dataset]:
    """Return the datasets of a study in units for display; those without physical units as they are.

    All quantities of one dimension get the same unit in all datasets, since pictures and tables show several together:
    the one that was written or chosen, else a prefix that gives small numbers.

    Parameters
    ----------
    datasets : mapping of str to xarray.Dataset
        Datasets in SI, or as this function returns them.
    prefixes : bool
        Whether units that nobody wrote or chose get a prefix instead of staying in SI.
    """
    units: dict[str, str] = {}
    for dataset in datasets.values():
        units = units_of(dataset) | units
    for unit, choices in PREFIXES.items() if prefixes else ():
        sizes = [pair for dataset in datasets.values() for pair in _sizes(dataset, unit)]
        largest = max((size for _, size in sizes), default=0.0)
        if largest > 0.0 and DIMENSION_OF[unit] not in units:
            given = [size for name, size in sizes if name in {*PARAMETERS, *PHYSICAL}]
            units[DIMENSION_OF[unit]] = _prefix(choices, largest, given, USUAL_UNITS.get(unit))[0]
    shown = Shown(units)
    return {name: shown.dataset(dataset) for name, dataset in datasets.items()}


@dataclass(frozen=True)
class Shown:
    """Units for display by dimension or parameter."""

    units: Mapping[str, str]

    def dataset(self, dataset: xr.Dataset) -> xr.Dataset:
        """Return a dataset with all quantities in these units; the same one if it has no others."""
        coords: dict[Hashable, Any] = {}
        data: dict[Hashable, Any] = {}
        for name, variable in dataset.variables.items():
            entry = self._entry(str(name), variable, dataset)
            if entry is not None:
                (coords if name in dataset.coords else data)[name] = entry
        if not (coords or data):
            return dataset
        changed = dataset.assign_coords(coords).assign(data)
        return changed.assign_attrs({DISPLAY_UNITS: units_as_text(self.units)})

    def unit(self, name: str, stored: str) -> str:
        """Return the unit in which a variable is shown: its stored one, if no other is known."""
        dimension = DIMENSION_OF.get(stored, "")
        parameter = split_suffix(name)[0].rpartition("_")[2]  # bifurcation_F is shown as F is
        is_one = parameter in PHYSICAL and PHYSICAL[parameter].dimension == dimension
        of_all = self.units.get(dimension, stored)
        return self.units.get(parameter, of_all) if is_one else of_all

    def _entry(self, name: str, variable: xr.Variable, dataset: xr.Dataset) -> Any:
        """Return dimensions, values and attributes of a variable in its unit; None if it stays as it is."""
        stored = str(variable.attrs.get("units", "1"))
        if name == "parameter_covariance" and PARAMETER in dataset:
            scale = np.outer(self._factors(dataset), self._factors(dataset))
            values = variable.values / scale
            return None if (scale == 1.0).all() else (variable.dims, values, variable.attrs)
        if name.endswith(SENSITIVITY_SUFFIX):
            return self._derivative(name, variable, dataset)
        unit = self.unit(name, stored)
        if unit == stored:
            return None
        attrs = {**variable.attrs, "units": unit}
        if DIMENSION_OF[stored] == "frequency" and is_of_cycles(unit):
            attrs |= _words_of_cycles(variable.attrs)
        values = variable.values * shown_factor(unit)
        return variable.dims, _tidied(values) if split_suffix(name)[0] in GIVEN else values, attrs

    def _derivative(self, name: str, variable: xr.Variable, dataset: xr.Dataset) -> Any:
        """Return dimensions, values and attributes of derivatives by parameters; None if they stay as they are."""
        quantity, of_parameter, _ = str(variable.attrs.get("units", "1")).partition(PER_PARAMETER)
        if not of_parameter or PARAMETER not in dataset:
            return None
        unit = self.unit(name, quantity)
        shares = self._factors(dataset).reshape(dataset[PARAMETER].shape) * shown_factor(unit)
        if (shares == 1.0).all():
            return None
        by_parameter = dataset[PARAMETER].variable.to_base_variable().copy(data=shares)
        values = (variable * by_parameter).transpose(*variable.dims).values
        return variable.dims, values, {**variable.attrs, "units": unit + PER_PARAMETER}

    def _factors(self, dataset: xr.Dataset) -> np.ndarray:
        """Return the values in SI of the units of the parameters by which a dataset has derivatives."""
        names = [str(name) for name in np.ravel(dataset[PARAMETER].values)]
        stored = [DIMENSIONS[PHYSICAL[n].dimension].units if n in PHYSICAL else "1" for n in names]
        return np.array(
            [unit_factor(self.unit(n, unit)) for n, unit in zip(names, stored, strict=True)]
        )


def _words_of_cycles(attrs: Mapping[str, Any]) -> dict[str, str]:
    """Return symbol and long name of an angular frequency that is shown in cycles per time."""
    symbol, name = str(attrs.get("symbol", "")), str(attrs.get("long_name", ""))
    return {
        "symbol": f"${symbol.strip('$')}/2\\pi$" if symbol else "",
        "long_name": name.replace("angular frequency", "frequency"),
    }


def _tidied(values: np.ndarray) -> np.ndarray:
    """Return values that a user may have written without the roundings of their conversion (`tidy`)."""
    different, where = np.unique(values, return_inverse=True)
    return np.array([tidy(float(value)) for value in different])[where].reshape(np.shape(values))


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
    return 1.0 / unit_factor(unit)


def stored_value(array: xr.DataArray) -> float:
    """Return a scalar, which may be in units for display, in the unit that is stored."""
    return float(array) / shown_factor(str(array.attrs.get("units", "1")))


def shown_unit(dataset: xr.Dataset, unit: str) -> tuple[str, float]:
    """Return the unit that a dataset shows in place of a stored one, with the factor: of s, ms and 1000."""
    shown = Shown(units_of(dataset)).unit("", unit)
    return shown, shown_factor(shown)


def shows_cycles(array: xr.DataArray) -> bool:
    """Return whether an array is an angular frequency that is shown in cycles per time."""
    return is_of_cycles(str(array.attrs.get("units", "1")))


def in_si(array: xr.DataArray) -> np.ndarray:
    """Return the values of an array in SI, whatever unit it is shown in; those without units as they are."""
    return np.asarray(array.values) * unit_factor(str(array.attrs.get("units", "1")))


def _largest(values: np.ndarray) -> float:
    """Return the largest finite magnitude, 0 if there is none."""
    size = np.abs(values[np.isfinite(values)])
    return float(size.max(initial=0.0))


def unit_text(units: str) -> str:
    """Write a unit with slashes, raised powers and points for products; dimensionless is empty.

    >>> unit_text("N s m-1")
    'N·s/m'
    >>> unit_text("N s/mm")
    'N·s/mm'
    """
    if units in ("", "1"):
        return ""
    text = units if "/" in units else plain_units(units)
    text = re.sub(r"(?:\^|\*\*)(\d)", lambda power: power[1].translate(_RAISED), text)
    return re.sub(r"\s*[ *·]\s*", "·", text).replace("um", "µm")
