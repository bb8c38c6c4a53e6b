"""Variables and attributes of datasets in SI, by eqs. (2)-(4) backwards; masses fall where ratios m/M rise."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.si import unit_factors
from vibropipe.solve.rows.named import SENSITIVITY, named
from vibropipe.solve.shown_units import tidied
from vibropipe.words.parameters import PARAMETERS, STARTS
from vibropipe.words.units import DIMENSIONS
from vibropipe.words.vocabulary import (
    PARAMETER,
    PHYSICAL_NAMES,
    SENSITIVITY_SUFFIX,
    VOCABULARY,
    attributes,
    physical_attributes,
    physical_name,
    physical_quantity,
    quantity,
    split_suffix,
)

if TYPE_CHECKING:
    import xarray as xr

# Values that come from a user, forth and back: 20 rad/s is to be found as 20.
GIVEN = (*PARAMETERS, *STARTS, "tau_bar")
# Pure numbers m/M that stand for another mass M.
MASS_RATIOS = [name for name, own in PHYSICAL_NAMES.items() if VOCABULARY[own].units == "kg"]
# What is derived from a ratio: ends of its range, which change places, and small changes, taken at the ratio itself.
OTHER_END = {"_lower": "_upper", "_upper": "_lower"}
CHANGES = {
    "_std": 1.0,
    "_tolerance": 1.0,
    "_worst": 1.0,
    SENSITIVITY_SUFFIX: -1.0,
    "_deviation": -1.0,
}
# Values of parameters, each in the unit of its own.
OF_PARAMETERS = {"within", "counterexample"}
# Attributes of a variable that differ in SI; others, such as flags, stay.
WORDS = ("units", "symbol", "long_name")
# Attribute of rows that are proved: how far parameters may be off, `R1 +- 0.01; delta +- 0.002`.
ROWS_WITHIN = "proof_within"
# Attributes with goals, `impact_velocity_max_1 < 0.8; ...`, and the parts of one.
GOALS = ("target", "subject_to", "allow", "levels")
_GOAL, _NUMBER = re.compile(r"(\w+)( [=<>][^;]*)"), re.compile(r"[-+\d.][-+\d.e]*")
_START = re.compile(r"x0 (swept|= .+), v0 (swept|= (.+))")
_STATED = re.compile(r"x0 = ([-+.e\d]+)(?: m)?, v0 = ([-+.e\d]+)(?: m/s)?")


def convert(name: str, values: Any, numbers: Mapping[str, float]) -> Any:
    """Return values of a quantity in SI.

    name : as in non-dimensional datasets; a name that the vocabulary does not have is a pure number
    values : numbers, an array or a lazy array
    numbers : m and C in SI
    """
    base, suffix = split_suffix(name)
    if base in MASS_RATIOS and suffix == "_sort_area":
        return 1.0 - np.asarray(values)  # the part with the larger ratio has the smaller mass
    if base in MASS_RATIOS and suffix not in CHANGES and physical_attributes(name)["units"] == "kg":
        with np.errstate(divide="ignore"):
            return tidied(numbers["m"] / np.asarray(values))
    try:
        dimension = quantity(name).dimension
    except KeyError:
        return values
    factor = unit_factors(**numbers).get(dimension, 1.0)
    if factor == 1.0:
        return values
    # The derivatives of an orbit beside a grazing may be as large as numbers are.
    with np.errstate(over="ignore"):
        return tidied(values * factor) if name in GIVEN else values * factor


def in_si(name: str, variable: xr.Variable, numbers: Mapping[str, float]) -> xr.Variable:
    """Return a variable in SI, with its dimensions under their names there."""
    import xarray as xr

    dims = [PHYSICAL_NAMES.get(str(dim), str(dim)) for dim in variable.dims]
    # the data of an index are no array to calculate with
    data = variable.values if isinstance(variable, xr.IndexVariable) else variable.data
    attrs = dict(variable.attrs)
    try:
        words, plain = physical_attributes(name), attributes(name)
    except KeyError:
        words, plain = {}, {}
    attrs |= {key: words[key] for key in WORDS if words.get(key) != plain.get(key)}
    if name in (PARAMETER, "other_parameter", "foretold_by"):
        data = [physical_name(str(each)) for each in data]
    return xr.Variable(dims, convert(name, data, numbers), attrs)


def masses_in_si(
    variables: Mapping[Hashable, xr.Variable], numbers: Mapping[str, float]
) -> dict[str, xr.Variable]:
    """Return what is derived from ratios m/M as that of the masses M, which fall where the ratios rise.

    Small changes are of first order in the ratio, where that is known.
    """
    changed = {}
    for name in map(str, variables):
        base, suffix = split_suffix(name)
        if base not in MASS_RATIOS:
            continue
        if suffix in OTHER_END:
            other = PHYSICAL_NAMES[base] + OTHER_END[suffix]
            changed[other] = in_si(base + OTHER_END[suffix], variables[name], numbers)
        elif suffix in CHANGES:
            ratio = variables.get(base, np.nan)
            mass = in_si(name, variables[name], numbers)
            changed[physical_name(name)] = mass * (CHANGES[suffix] * numbers["m"] / ratio**2)
            changed[physical_name(name)].attrs = mass.attrs
    return changed


def _goal_in_si(name: str, bound: str, numbers: Mapping[str, float]) -> str:
    """Return a goal in SI, with the unit of its bound; one of a ratio of masses stays as it is."""
    goal = named(name, "target")
    if goal.variable in MASS_RATIOS:
        return name + bound
    words = physical_quantity(goal.variable)
    unit = "" if goal.derived == SENSITIVITY or words.units == "1" else f" {words.units}"
    if unit:
        bound = _NUMBER.sub(
            lambda each: f"{float(convert(goal.variable, float(each[0]), numbers)):.10g}{unit}",
            bound,
        )
    return physical_name(name) + bound


def stated_start(text: str) -> tuple[float, float] | None:
    """Return the displacement and velocity of an attribute `start`, stored with or without units; None if it varies."""
    start = _STATED.fullmatch(text)
    return None if start is None else (float(start[1]), float(start[2]))


def wear_in_si(variables: Mapping[str, xr.Variable], numbers: Mapping[str, float]) -> xr.Variable:
    """Return the rates of wear, per second already, of velocities in m/s to the power of the exponent."""
    import xarray as xr

    rate, exponent = variables["wear_rate"], variables.get("wear_exponent", xr.Variable((), 0.0))
    wear = (rate * unit_factors(**numbers)["velocity"] ** exponent).transpose(*rate.dims)
    wear.attrs = rate.attrs
    return wear


def sensitivities_in_si(
    variables: Mapping[str, xr.Variable], numbers: Mapping[str, float]
) -> dict[str, xr.Variable]:
    """Return the names of the parameters in SI, and sensitivities per unit of the parameters in SI."""
    import xarray as xr

    parameter, factors = variables[PARAMETER], unit_factors(**numbers)
    names = np.asarray(parameter.values)
    of_each = [
        factors.get(quantity(str(name)).dimension if name in VOCABULARY else "", 1.0)
        for name in names.ravel()
    ]
    units = xr.Variable(parameter.dims, np.reshape(of_each, names.shape))
    masses = xr.Variable(parameter.dims, names == "M")
    if masses.any():
        # M falls where the ratio m/M rises: dM = -M^2/m d(m/M).
        slope = variables["M"] ** 2 / -numbers["m"] if "M" in variables else np.nan
        units = xr.where(masses, slope, units)
    physical_names = [physical_name(str(name)) for name in names.ravel()]
    renamed = np.reshape(physical_names, names.shape)
    changed = {PARAMETER: xr.Variable(parameter.dims, renamed)}
    for name, variable in variables.items():
        if name.endswith(SENSITIVITY_SUFFIX):
            changed[name] = variable / units
        elif name.endswith("_deviation") and PARAMETER in variable.dims:
            # Parts whose ratio is lower have the greater mass.
            changed[name] = xr.where(masses, variable.isel(side=slice(None, None, -1)), variable)
            changed[name] = changed[name].transpose(*variable.dims)
    for name in OF_PARAMETERS & variables.keys():
        changed[name] = variables[name] * units
    covariance = variables.get("parameter_covariance")
    if covariance is not None:
        dims = ["other_parameter" if dim == PARAMETER else dim for dim in units.dims]
        other = xr.Variable(dims, units.data)
        changed["parameter_covariance"] = covariance * (units * other)
    for name, variable in changed.items():
        variable.attrs = variables[name].attrs
    return changed


def text_in_si(name: str, text: Any, numbers: Mapping[str, float]) -> Any:
    """Return an attribute of a dataset in SI: its start, and the parameters that it follows."""
    if name in GOALS and isinstance(text, str):
        return _GOAL.sub(lambda each: _goal_in_si(each[1], each[2], numbers), text)
    if name == ROWS_WITHIN and isinstance(text, str):
        pairs = (part.split(" +- ") for part in text.split("; "))
        return "; ".join(
            f"{physical_name(own)} +- {float(convert(own, float(off), numbers))!r}"
            for own, off in pairs
        )
    if name in ("boundary", "vary") and isinstance(text, str):
        return " ".join(map(physical_name, text.split()))
    if name == "foretold_by":
        return "; ".join(map(physical_name, text.split("; ")))
    if name == "follow" and isinstance(text, str):
        parameter, space, direction = text.partition(" ")
        return physical_name(parameter) + space + direction
    match = _START.fullmatch(str(text)) if name == "start" else None
    if match is None:
        return text
    x0, v0 = match[1], match[2]
    if x0 not in ("swept", "= load"):
        # behind its number, which words may follow
        x0 = re.sub(r"= ([-+.\d][-+.e\d]*)", r"= \1 m", x0)
    if v0 != "swept":
        velocity = convert("velocity", float(match[3]), numbers)
        v0 = f"= {velocity:g} {DIMENSIONS['velocity'].plain}"
    return f"x0 {x0}, v0 {v0}"
