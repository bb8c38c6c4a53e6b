"""Datasets in SI as copies in other units: those that a study wrote or chose, by dimension or parameter."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import ParameterError
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
from vibropipe.words.units import (
    DIMENSIONS,
    UnitError,
    check_unit,
    is_of_cycles,
    plain_units,
    tidy,
    unit_factor,
    unit_of_text,
)
from vibropipe.words.vocabulary import PARAMETER, SENSITIVITY_SUFFIX, split_suffix

if TYPE_CHECKING:
    import xarray as xr

# Attribute of a dataset: `frequency: Hz; length: mm; F: kN`, by dimension, and by parameter where they differ.
DISPLAY_UNITS = "display_units"
SHOWN_UNITS = "shown_units"  # the same of a copy, which is in these units
PER_PARAMETER = "/(unit of parameter)"
# Values that come from a user: 9 Hz is shown as 9, not as its neighbour.
GIVEN = {*PARAMETERS, *PHYSICAL, *STARTS, "free_period"}
# Dimensions whose parameters stand for themselves: each keeps its own unit. Lengths, times, frequencies and velocities
# of several quantities share the axes of a picture, and with them one unit.
OF_A_PARAMETER = ("mass", "stiffness", "damping", "force", "angle")
TEXTS = ("title", "caption", "description", "question", "hero", "units", "kind")
_FORCE = re.compile(r"\b\w?N\b|lbf")
_BOUND = re.compile(r"[<>]=?([^<>,]+)")
# Dimensions whose units can be chosen.
CHOSEN = tuple(name for name in DIMENSIONS if name not in ("rate", "acceleration"))
DIMENSION_OF = {entry.units: name for name, entry in DIMENSIONS.items()}


def units_as_text(units: Mapping[str, str]) -> str:
    """Write units by dimension or parameter as the attribute of a dataset."""
    return "; ".join(f"{name}: {unit}" for name, unit in units.items())


def checked_units(units: Mapping[str, Any]) -> dict[str, str]:
    """Return units by dimension, or raise a ParameterError that names the one that is none."""
    for name, unit in units.items():
        if name not in CHOSEN:
            must = f"must be units by dimension ({', '.join(CHOSEN)})"
            raise ParameterError("units", units, must=must, got=repr(name))
        try:
            check_unit(unit, name)
        except UnitError as error:
            hint = f" ({error.hint})" if error.hint else ""
            raise ParameterError(
                f"units.{name}", unit, error.allowed, got=f"{unit!r}{hint}"
            ) from None
    return {name: " ".join(unit.split()) for name, unit in units.items()}


def units_of(dataset: xr.Dataset) -> dict[str, str]:
    """Return the units that were written or chosen for a dataset, or those it is in, by dimension or parameter."""
    return units_from_text(dataset.attrs.get(SHOWN_UNITS, dataset.attrs.get(DISPLAY_UNITS, "")))


def units_from_text(text: object) -> dict[str, str]:
    """Return units by dimension or parameter from the attribute of a dataset."""
    return dict(pair.split(": ", 1) for pair in str(text).split("; ") if ": " in pair)


def display_units_of(tree: Mapping[str, Any], chosen: Mapping[str, str]) -> dict[str, str]:
    """Return the units in which quantities are written, by dimension, and by parameter where one has another unit.

    Of several units of one dimension the one that most keys are written in holds, the first of equals.

    tree : the study, or the arguments of `Exciter.from_physical`, as it is written, with text for quantities
    chosen : units by dimension that the study chooses
    """
    written = Counter(_units_in(tree, ""))
    of_dimension, of_parameter = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for (key, unit), amount in written.items():
        dimension = dimension_of(unit)
        if key in PHYSICAL:
            of_parameter[key, unit] += amount
        if dimension != "angle":  # phases of harmonics are not written
            of_dimension[dimension, unit] += amount
    units = {**_most(of_dimension), **chosen}
    units.pop("", None)
    for name, unit in _most(of_parameter).items():
        dimension = PHYSICAL[name].dimension
        is_free = dimension in OF_A_PARAMETER and dimension not in chosen
        if is_free and dimension_of(unit) == dimension and units.get(dimension) != unit:
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
    else:
        for text in (isinstance(node, str) and _BOUND.findall(node)) or [node]:
            if unit := unit_of_text(text):
                yield key, unit


def dimension_of(unit: str) -> str:
    """Return the dimension of a unit, empty if it is none; of a force times a length a torque, which is no energy."""
    for dimension in CHOSEN:
        try:
            check_unit(unit, dimension)
        except UnitError:
            continue
        is_product = dimension == "energy" and _FORCE.search(unit)
        return "torque" if is_product else dimension
    return ""


def _most(amounts: Counter[tuple[str, str]]) -> dict[str, str]:
    """Return the unit with the largest number for each name, the first of equals."""
    found: dict[str, str] = {}
    for (name, unit), _ in amounts.most_common():
        found.setdefault(name, unit)
    return found


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
        return changed.assign_attrs({SHOWN_UNITS: units_as_text(self.units)})

    def unit(self, name: str, stored: str) -> str:
        """Return the unit in which a variable is shown: its stored one, if no other is known."""
        dimension = DIMENSION_OF.get(stored, "")
        parameter = split_suffix(name)[0].rpartition("_")[2]  # bifurcation_F is shown as F is
        is_one = parameter in PHYSICAL and PHYSICAL[parameter].dimension == dimension
        of_all = self.units.get(dimension, stored)
        return self.units.get(parameter, of_all) if is_one else of_all

    def texts(self, name: str, values: Iterable[float], stored: str) -> tuple[list[str], str]:
        """Return stored values of a parameter as texts in its unit, and that with a blank before it, or empty."""
        unit = self.unit(name, stored)
        shown = [tidy(float(value) * shown_factor(unit)) for value in values]
        return [f"{value:g}" for value in shown], "" if unit == "1" else f" {plain_units(unit)}"

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
        with np.errstate(over="ignore"):  # an error estimate may be beyond single precision
            values = variable.to_base_variable().data * shown_factor(unit)  # lazy data stay lazy
        return (variable.dims, tidied(values) if split_suffix(name)[0] in GIVEN else values, attrs)

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


def tidied(values: Any) -> np.ndarray:
    """Return values that a user may have written without the roundings of their conversion (`tidy`)."""
    different, where = np.unique(np.asarray(values), return_inverse=True)
    return np.array([tidy(float(value)) for value in different])[where].reshape(np.shape(values))


def shown_factor(unit: str) -> float:
    """Return the factor from the stored unit to one that is shown: 1000 for mm, whose stored unit is m."""
    return 1.0 / unit_factor(unit)


def shown_unit(dataset: xr.Dataset, unit: str) -> tuple[str, float]:
    """Return the unit that a dataset shows in place of a stored one, with the factor: of s, ms and 1000."""
    shown = shown_in(dataset).unit("", unit)
    return shown, shown_factor(shown)


def shown_in(dataset: xr.Dataset) -> Shown:
    """Return the units that a dataset is in: SI unless it is a copy of `display_units`."""
    return Shown(units_of(dataset) if SHOWN_UNITS in dataset.attrs else {})


def shows_cycles(array: xr.DataArray) -> bool:
    """Return whether an array is an angular frequency that is shown in cycles per time."""
    return is_of_cycles(str(array.attrs.get("units", "1")))


def in_si(array: xr.DataArray) -> np.ndarray:
    """Return the values of an array in SI, whatever unit it is shown in; those without units as they are."""
    return np.asarray(array.values) * unit_factor(str(array.attrs.get("units", "1")))
