"""Every quantity that a dataset can hold: dimensions, units, long name, symbol (`quantities.toml`).

Datasets, figures, reports and documents take names and symbols from here, so that they agree everywhere. No stored
number depends on this module.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Container, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from vibropipe.words.bifurcations import Bifurcation, BranchEnd
from vibropipe.words.boundaries import Meeting
from vibropipe.words.designs import DesignResult, FitResult, FoundResult, ToleranceResult
from vibropipe.words.exciter import PARAMETERS
from vibropipe.words.measurements import Outcome, Passed
from vibropipe.words.regimes import Chaos, Regime
from vibropipe.words.status import Status
from vibropipe.words.units import DIMENSIONS, plain_units

if TYPE_CHECKING:
    import xarray as xr

    Described = TypeVar("Described", bound=xr.Dataset)

ERROR_SUFFIX = "_error"
# What the long names of energies say, and that those of one motion, which has an end, do not.
PER_PERIOD, END_OF_MOTION = " per forcing period", "displacement_end"
# Suffix of what is derived from a quantity -> its long name, and whether it has the units of the quantity.
SUFFIXES: Mapping[str, tuple[str, bool]] = {
    ERROR_SUFFIX: ("error estimate of {}", True),
    "_std": ("standard deviation of {}", True),
    "_worst": ("worst case of the deviation of {}", True),
    "_deviation": ("deviation of {} with one parameter off", True),
    "_contribution": ("share of the variance of {}", False),
    "_sensitivity": ("derivative of {} by each parameter, per unit of that", True),
    "_target": ("wanted {}", True),
    "_lower": ("lower bound of {}", True),
    "_upper": ("upper bound of {}", True),
    "_swept": ("{} at points of a sweep", True),
    "_tolerance": ("tolerance of {}", True),
    "_yield": ("share of scattered parts that keep the goal of {}", False),
    "_quantile": ("quantile of {} over scattered parts", True),
    "_measured": ("measured {}", True),
    "_fitted": ("fitted {}", True),
    "_noise": ("noise of {}", True),
    "_misfit": ("root mean square misfit of {}", True),
}
SENSITIVITY_SUFFIX, PARAMETER = "_sensitivity", "parameter"
UNDEFINED = (
    "NaN where there is no derivative: without an orbit, or with one that is not isolated; at a grazing, a fold or a "
    "pitchfork; of multipliers that are equal; of the phase, and mostly the amplitude, of a harmonic that is zero"
)
"""What NaN says in a sensitivity."""


def _members(kind: type[IntEnum]) -> dict[str, int]:
    return {member.name.lower(): int(member) for member in kind}


REGIMES: Mapping[str, int] = _members(Regime)
FLAGS: Mapping[str, Mapping[str, int]] = {
    "regime": REGIMES,
    "status": _members(Status),
    "outcome": _members(Outcome),
    "support": {"support_1": 1, "support_2": 2},
    "chaos": _members(Chaos),
    "stable": {"unstable": 0, "stable": 1},
    "admissible": {"inadmissible": 0, "admissible": 1},
    "passed": _members(Passed),
    "bifurcation_kind": _members(Bifurcation),
    "end_reason": _members(BranchEnd),
    "border": {"inside": 0, "at_border": 1},
    "attractor_change": {"vanishes": 0, "appears": 1},
    "boundary_kind": {
        name: code for name, code in _members(Bifurcation).items() if code < Bifurcation.END
    },
    "meeting_kind": _members(Meeting),
    "meeting_ends": {"goes_on": 0, "ends": 1},
    "design_result": _members(DesignResult),
    "tolerance_result": _members(ToleranceResult),
    "fit_result": _members(FitResult),
    "parameter_result": _members(FoundResult),
}
"""Names of integer values."""


@dataclass(frozen=True)
class Quantity:
    """One entry of the table; `quantities.toml` defines the fields."""

    long_name: str
    symbol: str
    dims: tuple[str, ...] = ()
    units: str = "1"
    plain: str = ""
    flags: Mapping[str, int] | None = None
    sample_dimension: str | None = None
    dimension: str = ""
    si: Mapping[str, str] = field(default_factory=dict)
    comment: str = ""

    def in_si(self) -> Quantity:
        """Return the entry in a dataset in SI."""
        symbol = self.symbol.replace(r"\nu\tau", r"\omega t").replace(r"\tau", "t")
        dims = tuple(PHYSICAL_NAMES.get(dim, dim) for dim in self.dims)
        units = DIMENSIONS[self.dimension].units if self.dimension else self.units
        words: dict[str, Any] = {key: text for key, text in self.si.items() if key != "name"}
        return replace(self, **{"symbol": symbol, "dims": dims, "units": units, **words})


def _of_each_parameter(name: str, words: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the entries of the table for one whose name stands for a quantity of each parameter."""
    if "{}" not in name:
        return {name: words}
    entries = {}
    for each in PARAMETERS:
        # beside another noun the name of a parameter has no remark, "0 if rigid"
        noun = each.long_name if name == "{}" else each.long_name.partition(",")[0]
        entry = {
            **words,
            **{"symbol": each.symbol, "plain": each.plain, "units": each.units},
            "long_name": words["long_name"].format(noun),
            "dimension": each.dimension if each.units == "1" else "",
        }
        if each.physical is not None and each.physical.name != each.name:
            si = {key: getattr(each.physical, key) for key in ("symbol", "plain", "long_name")}
            si = {key: text for key, text in si.items() if text}
            if "long_name" in si:
                si["long_name"] = words["long_name"].format(si["long_name"])
            entry["si"] = {"name": name.format(each.physical.name), **si}
        entries[name.format(each.name)] = entry
    return entries


def _table() -> dict[str, Quantity]:
    """Return the quantities of `quantities.toml`."""
    text = Path(__file__).with_name("quantities.toml").read_text(encoding="utf-8")
    return {
        each: Quantity(
            dims=tuple(entry.pop("dims", "").split()),
            flags=FLAGS.get(entry.pop("flags", "")),
            **entry,
        )
        for subject in tomllib.loads(text).values()
        for name, words in subject.items()
        for each, entry in _of_each_parameter(name, dict(words)).items()
    }


_TABLE = _table()
PHYSICAL_NAMES: Mapping[str, str] = {
    name: entry.si["name"] for name, entry in _TABLE.items() if "name" in entry.si
}
"""Names in a dataset in SI, of the quantities that have another one there."""


def _vocabulary() -> dict[str, Quantity]:
    """Return the table, each quantity with its own name in SI right after it."""
    entries: dict[str, Quantity] = {}
    for name, entry in _TABLE.items():
        entries[name] = entry
        if name in PHYSICAL_NAMES:
            entries[PHYSICAL_NAMES[name]] = entry.in_si()
    return entries


VOCABULARY: Mapping[str, Quantity] = _vocabulary()
PLAIN_SYMBOLS: Mapping[str, str] = {
    name: entry.plain for name, entry in VOCABULARY.items() if entry.plain
}


def quantity(name: str) -> Quantity:
    """Return the table's entry of a quantity.

    Parameters
    ----------
    name : str
        Name of a variable. `<name>_error` is the error estimate of `<name>`, in its units; so are others of `SUFFIXES`.
        `<name>_sensitivity` is its derivative by each parameter, in its units over those of the parameter.

    Raises
    ------
    KeyError
        If the table has no such quantity.
    """
    entry = VOCABULARY.get(name)
    if entry is not None:
        return entry
    base_name, suffix = split_suffix(name)
    base = VOCABULARY.get(base_name)
    if base is not None and suffix == SENSITIVITY_SUFFIX:
        return _sensitivity(base)
    if base is None or not suffix:
        raise KeyError(f"{name!r} is not in the vocabulary (vibropipe/words/quantities.toml)")
    text, has_units = SUFFIXES[suffix]
    entry = replace(
        base,
        long_name=text.format(base.long_name),
        plain="",
        flags=None,
        sample_dimension=None,
        si={},
    )
    return entry if has_units else replace(entry, units="1", dimension="")


def split_suffix(name: str) -> tuple[str, str]:
    """Return the quantity that one is derived from, and its suffix; the name itself and "" of any other."""
    for suffix in SUFFIXES:
        base = name.removesuffix(suffix)
        if base != name and base in VOCABULARY and name not in VOCABULARY:
            return base, suffix
    return name, ""


def _sensitivity(base: Quantity) -> Quantity:
    """Return the entry of the derivative of a quantity by each parameter."""
    return replace(
        base,
        long_name=SUFFIXES[SENSITIVITY_SUFFIX][0].format(base.long_name),
        symbol=rf"$\partial {base.symbol.strip('$')}/\partial p$",
        comment=UNDEFINED,
        plain="",
        dims=(*base.dims, PARAMETER),
        flags=None,
        sample_dimension=None,
        si={},
    )


def dimensions_hash() -> str:
    """Return a hash (16 hex digits) of what datasets in SI depend on in the table: dimensions and names."""
    dimensions = {name: entry.dimension for name, entry in _TABLE.items() if entry.dimension}
    text = repr((sorted(dimensions.items()), sorted(PHYSICAL_NAMES.items())))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def physical_name(name: str) -> str:
    """Return the name of a quantity in a dataset in SI, error estimates and the like included."""
    base, suffix = split_suffix(name)
    return PHYSICAL_NAMES.get(base, base) + suffix


def physical_quantity(name: str) -> Quantity:
    """Return the entry, in SI, of a quantity under its name in non-dimensional datasets."""
    entry = quantity(name).in_si()
    # the units of a derivative differ along the dimension `parameter`
    is_derivative = name.endswith(SENSITIVITY_SUFFIX)
    return replace(entry, units=f"{entry.units}/(unit of parameter)") if is_derivative else entry


def label(name: str) -> str:
    """Return the label of an axis: long name, symbol, and units unless dimensionless."""
    entry = quantity(name)
    units = "" if entry.units == "1" else f" ({plain_units(entry.units)})"
    return f"{entry.long_name} {entry.symbol}{units}"


def held_name(names: Container[Any], name: str) -> str:
    """Return the name of a quantity among those of a dataset, which may be in SI."""
    return physical_name(name) if physical_name(name) in names else name


def attributes(name: str) -> dict[str, Any]:
    """Return the CF attributes of `name`: units, long_name, symbol, and flags if it has any."""
    return _attributes(quantity(name))


def physical_attributes(name: str) -> dict[str, Any]:
    """Return the CF attributes, in SI, of a quantity under its name in non-dimensional datasets."""
    return _attributes(physical_quantity(name))


def _attributes(entry: Quantity) -> dict[str, Any]:
    import numpy as np

    attrs: dict[str, Any] = {
        "units": entry.units,
        "long_name": entry.long_name,
        "symbol": entry.symbol,
    }
    if entry.comment:
        attrs["comment"] = entry.comment
    if entry.sample_dimension is not None:
        attrs["sample_dimension"] = entry.sample_dimension
    if entry.flags is not None:
        attrs["flag_values"] = np.array(list(entry.flags.values()), dtype=np.int8)
        attrs["flag_meanings"] = " ".join(entry.flags)
    return attrs


def describe(dataset: Described) -> Described:
    """Set the attributes of every variable of a dataset in place, and return it.

    Other attributes stay. `flag_values` get the type of the variable, as the CF conventions require. Energies of one
    motion are from its start to its end, all others per forcing period.

    Raises
    ------
    KeyError
        If the table has no quantity of the name of a variable.
    """
    for name, variable in dataset.variables.items():
        attrs = attributes(str(name))
        if "flag_values" in attrs:
            # Truth values are stored as int8.
            dtype = variable.dtype if variable.dtype.kind in "iu" else "int8"
            attrs["flag_values"] = attrs["flag_values"].astype(dtype)
        if str(name).startswith("energy_") and END_OF_MOTION in dataset:
            attrs["long_name"] = attrs["long_name"].replace(PER_PERIOD, "")
        variable.attrs.update(attrs)
    return dataset
