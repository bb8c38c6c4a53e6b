"""Names, symbols, units and attributes of quantities and of what is derived from them, made from their records.

Datasets, figures, reports and documents take them from here, so that they agree everywhere.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Container, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from vibropipe.words.proofs import PREFIX
from vibropipe.words.quantities import QUANTITIES, Quantity
from vibropipe.words.units import plain_units

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
    "_sort_threshold": ("threshold that sorts good parts from bad ones by {}", True),
    "_sort_area": ("share of pairs in which the good part has the larger {}", False),
    "_sort_wrong": ("share of parts sorted wrongly by {}", False),
    "_sort_wrong_low": ("lower end of the share of parts sorted wrongly by {}", False),
    "_sort_wrong_high": ("upper end of the share of parts sorted wrongly by {}", False),
    "_quantile": ("quantile of {} over scattered parts", True),
    "_measured": ("measured {}", True),
    "_fitted": ("fitted {}", True),
    "_noise": ("noise of {}", True),
    "_offset": ("offset of the sensor of {}", True),
    "_sign": ("sign of the sensor of {}", False),
    "_left_out": ("number of samples of {} that do not count", False),
    "_twin": ("{} of other parameters that fit as well", True),
    "_low": ("lower bound of {}, proved", True),
    "_high": ("upper bound of {}, proved", True),
    "_misfit": ("root mean square misfit of {}", True),
}
# What the place of a bifurcation begins with, before the name of what is followed.
PLACE = "bifurcation_"
# What begins the name of a parameter somewhere, and where that is.
AT_PLACES = {
    PLACE: "at the bifurcation",
    "meeting_": "at the meeting",
    "crossing_": "at which motor and load have the same torque",
    "jump_": "before the jump",
}
SENSITIVITY_SUFFIX, PARAMETER = "_sensitivity", "parameter"
_NAME = re.compile(r"[A-Za-z]\w*")
UNDEFINED = (
    "NaN where there is no derivative: without an orbit, or with one that is not isolated; at a grazing, a fold or a "
    "pitchfork; of multipliers that are equal; of the phase, and mostly the amplitude, of a harmonic that is zero"
)
"""What NaN says in a sensitivity."""


PHYSICAL_NAMES: Mapping[str, str] = {
    name: entry.si["name"] for name, entry in QUANTITIES.items() if "name" in entry.si
}
"""Names in a dataset in SI, of the quantities that have another one there."""


def _vocabulary() -> dict[str, Quantity]:
    """Return the table, each quantity with its own name in SI right after it."""
    entries: dict[str, Quantity] = {}
    for name, entry in QUANTITIES.items():
        entries[name] = entry
        if name in PHYSICAL_NAMES:
            entries[PHYSICAL_NAMES[name]] = entry.in_si()
    return entries


VOCABULARY: Mapping[str, Quantity] = _vocabulary()
PLAIN_SYMBOLS: Mapping[str, str] = {
    name: entry.plain for name, entry in VOCABULARY.items() if entry.plain
}

STEADY: Mapping[str, Quantity] = {
    name: entry for name, entry in QUANTITIES.items() if entry.output is not None
}
"""Quantities of steady states, in the order of files."""
# Parameters that a motion is followed along to a bifurcation.
PLACED = ("nu", "f", "h", "l", "delta", "R1", "R2")
PLACES: Mapping[str, tuple[str, str, str]] = {
    f"{kind}_{along}_{way}": (kind, along, way)
    for along in PLACED
    for kind in ("fold", "flip", "pitchfork", "grazing")
    for way in ("up", "down")
}
"""Places of bifurcations of steady states: of which kind, along which parameter, and in which direction."""
PLACES_IN_SI: Mapping[str, str] = {
    PHYSICAL_NAMES[name]: name for name in PLACES if name in PHYSICAL_NAMES
}
"""Those with another name in SI, fold_omega_up, by that name."""
GOALS: Mapping[str, Quantity] = {**STEADY, **{name: QUANTITIES[name] for name in PLACES}}
"""Quantities that a design may take, and others of steady states."""
OF_CONTACT: Mapping[str, str] = {
    entry.largest_of: name for name, entry in STEADY.items() if entry.largest_of
}
"""Those of each contact with a soft support, over `impact`, and the largest of a steady state, over `support`."""
OF_SOFT = tuple(OF_CONTACT.values())
ENERGIES = tuple(name for name, entry in STEADY.items() if entry.output == "energy")
POWERS: Mapping[str, str] = {
    name: energy for energy in ENERGIES if (name := energy.replace("energy", "power")) in STEADY
}
"""Powers, and the energies per forcing period of which they are the rates."""
EVENTS: Mapping[str, tuple[str, ...]] = {
    dim: tuple(name for name, each in QUANTITIES.items() if each.dims == (dim,) and each.dimension)
    for dim, entry in QUANTITIES.items()
    if entry.axis == "events"
}
"""Lists of events of a motion, by their coordinate: times, velocities and the like, the time first."""


def row_dims(name: str) -> tuple[str, ...]:
    """Return the dimensions that a quantity of steady states has in rows of them."""
    dims = QUANTITIES[name].dims
    return (
        dims if "impact" in dims else ("row", *("phase" if dim == "tau" else dim for dim in dims))
    )


def drawn_by(kind: str) -> tuple[str, ...]:
    """Return the quantities that a study can ask the pictures of a kind of scene to show."""
    return tuple(name for name, entry in QUANTITIES.items() if kind in entry.drawn)


@functools.cache
def quantity(name: str) -> Quantity:
    """Return the table's entry of a quantity.

    name : name of a variable. `<name>_error` is the error estimate of `<name>`, in its units; so are others of
        `SUFFIXES`. `<name>_sensitivity` is its derivative by each parameter, in its units over those of the parameter.
        `proof_<name>` is the same of the proof in the dataset of a scene
    Raises KeyError if the table has no such quantity.
    """
    entry = VOCABULARY.get(name)
    if entry is not None:
        return entry
    if name.startswith(PREFIX):
        entry = quantity(name.removeprefix(PREFIX))
        return replace(entry, dims=tuple(map(of_proof, entry.dims)), sample_dimension=None)
    base_name, suffix = split_suffix(name)
    if base_name not in VOCABULARY or not suffix:
        raise KeyError(f"{name!r} is not in the vocabulary (vibropipe/words/quantities.toml)")
    return _derived(VOCABULARY[base_name], suffix)


def _derived(base: Quantity, suffix: str) -> Quantity:
    """Return the entry of what is derived from a quantity, by its suffix."""
    if suffix == SENSITIVITY_SUFFIX:
        return _sensitivity(base)
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


def of_proof(name: str) -> str:
    """Return the name, in the dataset of a scene, of a variable or a dimension of its proof."""
    return name if name == "support" else f"{PREFIX}{name}"


@functools.cache
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
    dimensions = {name: entry.dimension for name, entry in QUANTITIES.items() if entry.dimension}
    text = repr((sorted(dimensions.items()), sorted(PHYSICAL_NAMES.items())))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def physical_name(name: str) -> str:
    """Return the name of a quantity in a dataset in SI, error estimates and the like included."""
    base, suffix = split_suffix(name)
    return PHYSICAL_NAMES.get(base, base) + suffix


def physical_quantity(name: str) -> Quantity:
    """Return the entry, in SI, of a quantity under its name in non-dimensional datasets."""
    base, suffix = split_suffix(name)
    if not suffix or name.startswith(PREFIX):
        return quantity(name).in_si()
    entry = _derived(VOCABULARY[base].in_si(), suffix)
    # the units of a derivative differ along the dimension `parameter`
    is_derivative = suffix == SENSITIVITY_SUFFIX
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


def own_attributes(name: str) -> dict[str, Any]:
    """Return the CF attributes of a number under a name that a user has chosen, such as zeta, or derived from one."""
    base, text = name, "{}"
    for suffix, (of, _) in SUFFIXES.items():
        if name.endswith(suffix):
            base, text = name.removesuffix(suffix), of
    for place, where in AT_PLACES.items():
        if base.startswith(place):
            base, text = base.removeprefix(place), text.format(f"{{}} {where}")
    return {"units": "1", "long_name": text.format(base), "symbol": base}


def attributes_of_dimension(name: str) -> dict[str, Any]:
    """Return the CF attributes of a dimension of a grid, which a user may have named."""
    return attributes(name) if name in VOCABULARY else own_attributes(name)


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
    motion are from its start to its end, all others per forcing period; a measured phase counts forcing periods. Names
    that stand in the attribute `ties` may be those of a user; coordinates that were taken over with their words keep
    them.

    Raises KeyError if the table has no quantity of the name of a variable.
    """
    own = set(_NAME.findall(dataset.attrs.get("ties", "")))
    variables = dataset.variables
    own |= {str(name) for name in dataset.coords if variables[name].attrs.get("long_name") == name}
    own -= VOCABULARY.keys()
    own |= {f"{place}{name}" for name in own for place in AT_PLACES}
    own |= {f"{name}{suffix}" for name in own for suffix in SUFFIXES}
    for name, variable in variables.items():
        if name in own:
            variable.attrs.update(own_attributes(str(name)))
            continue
        attrs = attributes(str(name))
        if "flag_values" in attrs:
            # Truth values are stored as int8.
            dtype = variable.dtype if variable.dtype.kind in "iu" else "int8"
            attrs["flag_values"] = attrs["flag_values"].astype(dtype)
        if str(name).startswith("energy_") and END_OF_MOTION in dataset:
            attrs["long_name"] = attrs["long_name"].replace(PER_PERIOD, "")
        if name == "phase" and "measurement" in variable.dims:
            attrs |= {"long_name": "phase in forcing periods", "symbol": r"$\tau/T$"}
        variable.attrs.update(attrs)
    return dataset
