"""Datasets and grids in SI, by eqs. (2)-(4) backwards: t = tau / p, omega = nu p, F = f C, H = h sqrt(m C)."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import si_value
from vibropipe.physics.si import unit_factors
from vibropipe.physics.ties import Ties
from vibropipe.solve.rows.named import SENSITIVITY, named
from vibropipe.solve.shown_units import (
    CHOSEN,
    DISPLAY_UNITS,
    Shown,
    checked_units,
    dimension_of,
    display_units_of,
    tidied,
    units_as_text,
    units_of,
)
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS
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
# Attributes with goals, `impact_velocity_max_1 < 0.8; ...`, and the parts of one.
GOALS = ("target", "subject_to", "allow", "levels")
_GOAL, _NUMBER = re.compile(r"(\w+)( [=<>][^;]*)"), re.compile(r"[-+\d.][-+\d.e]*")
_START = re.compile(r"x0 (swept|= .+), v0 (swept|= (.+))")


def to_physical(
    dataset: xr.Dataset | xr.DataTree, m: Any, C: Any = None, units: Mapping[str, str] | None = None
) -> xr.Dataset:
    """Convert a dataset to SI, by eqs. (2)-(4).

    Parameters
    ----------
    dataset : xarray.Dataset or xarray.DataTree
        A motion, a steady state, a sweep, a backbone, or a scene of `open_study`, whose lengths are in metres (as those
        of `Exciter.from_physical`). Lazy data stay lazy.
    m, C : number, str or pint.Quantity
        Mass and stiffness, as in `Exciter.from_physical`; or, in place of both, the exciter that it returned.
    units : mapping of str to str, optional
        Units in which `plot` shows the dataset, by dimension: frequency, length, time, velocity, force, energy, power,
        impulse, mass, stiffness, damping, angle (default: those that the exciter, or m and C, were given in; of all
        else SI with a prefix). The dataset itself is in SI.

    Returns
    -------
    xarray.Dataset
        The same quantities in SI, which their attribute `units` states. New names: `time` for `tau` (`impact_time`,
        `grazing_time`, `turn_time`; `free_period` for `tau_bar`), `omega` for `nu`, `F` for `f`, `F2` for `f2`, `H` for
        `h`, `C1` for `k1`, `H1` for `h1` and so on. m and C are scalar coordinates. Numbers without dimension stay,
        among them phases, impacts per period, multipliers and relative errors; base frequencies are in rad/s, energies
        in J.

    Raises
    ------
    ParameterError
        If m or C is missing, out of range or has a wrong unit, the exciter was not made by `from_physical`, a unit of
        `units` is none, or the dataset is in SI already.

    References
    ----------
    K. Ragulskis, P. Paskevicius, L. Ragulskis, "Exciters of vibrations with two pairs of impacting surfaces" (eqs. (2)
    to (4)).
    """
    import xarray as xr

    given = m.written if isinstance(m, Exciter) else {"m": m, "C": C}
    if not given or (isinstance(m, Exciter) and C is not None):
        must = "must be an exciter of from_physical without C, or a mass beside C"
        raise ParameterError("m", m, must=must, got="")
    numbers = {name: si_value(name, given[name]) for name in ("m", "C")}
    data = dataset.to_dataset() if isinstance(dataset, xr.DataTree) else dataset
    if is_physical(data):
        raise ParameterError("dataset", data, must="must be non-dimensional", got="one in SI")
    variables = {
        physical_name(str(name)): _in_si(str(name), variable, numbers)
        for name, variable in data.variables.items()
    }
    if "wear_rate" in variables:
        variables["wear_rate"] = _wear_in_si(variables, numbers)
    variables |= _masses_in_si(data.variables, numbers)
    if PARAMETER in variables:
        variables |= _sensitivities_in_si(variables, numbers)
    coords = {physical_name(str(name)): None for name in data.coords}
    attrs = {name: _text_in_si(str(name), text, numbers) for name, text in data.attrs.items()}
    shown = display_units_of({"physical": given}, checked_units(units or {}))
    if shown:
        attrs[DISPLAY_UNITS] = units_as_text(shown)
    scalars = {name: xr.Variable((), value, attributes(name)) for name, value in numbers.items()}
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coords},
        {name: variables[name] for name in coords} | scalars,
        attrs,
    )


def is_physical(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is in SI."""
    return {"m", "C"} <= set(dataset.coords)


def in_units(dataset: xr.Dataset, text: str) -> xr.Dataset:
    """Return a dataset in SI in units that a user lists, `Hz, mm`, and else in those of its study; `SI` alone keeps it.

    Raises
    ------
    ParameterError
        If the dataset has no units, or one that is listed is none or has the dimension of another.
    """
    if not is_physical(dataset):
        must = "must be left out: the dataset has no units, as its study has no key physical"
        raise ParameterError("units", text, must=must, got="")
    if text.strip().upper() == "SI":
        return dataset
    chosen: dict[str, str] = {}
    for unit in (" ".join(each.split()) for each in text.split(",")):
        dimension = dimension_of(unit)
        if dimension not in CHOSEN:
            must = f"must be SI or units of {', '.join(CHOSEN)}, such as Hz, mm"
            raise ParameterError("units", text, must=must, got=repr(unit))
        if dimension in chosen:
            must = f"must have one unit of {dimension}"
            raise ParameterError("units", text, must=must, got=f"{chosen[dimension]} and {unit}")
        chosen[dimension] = unit
    kept = {
        name: unit for name, unit in units_of(dataset).items()
        if name not in PHYSICAL or PHYSICAL[name].dimension not in chosen
    }  # fmt: skip
    return Shown(kept | chosen).dataset(dataset)


def stored(dataset: xr.Dataset, mass_and_stiffness: tuple[float, float] | None) -> xr.Dataset:
    """Return a dataset as it is stored: in SI if its study states m and C."""
    return dataset if mass_and_stiffness is None else to_physical(dataset, *mass_and_stiffness)


def physical_grid(grid: SweepGrid, m: float, C: float) -> SweepGrid:
    """Return the grid of a sweep in SI, with the very values that `to_physical` makes of its coordinates."""
    numbers = {"m": m, "C": C}
    shared = {name: float(convert(name, value, numbers)) for name, value in grid.shared.items()}
    return replace(
        grid,
        values={physical_name(n): convert(n, values, numbers) for n, values in grid.values.items()},
        follow=grid.follow and (physical_name(grid.follow[0]), *grid.follow[1:]),
        shared={physical_name(name): value for name, value in shared.items()} | numbers,
        ties=Ties(),  # which name parameters without units; rows hold what is tied
    )


def grid_attributes(name: str, grid: SweepGrid) -> dict[str, Any]:
    """Return the attributes of a swept parameter that differ in a grid in SI; none for any other grid or variable."""
    if "C" not in grid.shared or name not in grid.values or name not in VOCABULARY:
        return {}
    words = physical_attributes(name)
    return {key: words[key] for key in WORDS}


def convert(name: str, values: Any, numbers: Mapping[str, float]) -> Any:
    """Return values of a quantity in SI.

    Parameters
    ----------
    name : str
        Its name in non-dimensional datasets; one that the vocabulary does not have is a pure number.
    values : array_like
        Numbers, an array or a lazy array.
    numbers : mapping of str to float
        m and C in SI.
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
    return tidied(values * factor) if name in GIVEN else values * factor


def _in_si(name: str, variable: xr.Variable, numbers: Mapping[str, float]) -> xr.Variable:
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
    if name in (PARAMETER, "other_parameter"):
        data = [physical_name(str(each)) for each in data]
    return xr.Variable(dims, convert(name, data, numbers), attrs)


def _masses_in_si(
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
            changed[other] = _in_si(base + OTHER_END[suffix], variables[name], numbers)
        elif suffix in CHANGES:
            ratio = variables.get(base, np.nan)
            mass = _in_si(name, variables[name], numbers)
            changed[physical_name(name)] = mass * (CHANGES[suffix] * numbers["m"] / ratio**2)
            changed[physical_name(name)].attrs = mass.attrs
    return changed


def _goal_in_si(name: str, bound: str, numbers: Mapping[str, float]) -> str:
    """Return the bound of a goal in SI, with its unit; that of a ratio of masses stays, as its name does."""
    goal = named(name, "target")
    if goal.variable in MASS_RATIOS:
        return bound
    words = physical_quantity(goal.variable)
    unit = "" if goal.derived == SENSITIVITY or words.units == "1" else f" {words.units}"
    if not unit:
        return bound
    return _NUMBER.sub(
        lambda match: f"{float(convert(goal.variable, float(match[0]), numbers)):g}{unit}", bound
    )


def _wear_in_si(variables: Mapping[str, xr.Variable], numbers: Mapping[str, float]) -> xr.Variable:
    """Return the rates of wear, per second already, of velocities in m/s to the power of the exponent."""
    import xarray as xr

    rate, exponent = variables["wear_rate"], variables.get("wear_exponent", xr.Variable((), 0.0))
    wear = (rate * unit_factors(**numbers)["velocity"] ** exponent).transpose(*rate.dims)
    wear.attrs = rate.attrs
    return wear


def _sensitivities_in_si(
    variables: Mapping[str, xr.Variable], numbers: Mapping[str, float]
) -> dict[str, xr.Variable]:
    """Return the names of the parameters in SI, and sensitivities per unit of the parameters in SI."""
    import xarray as xr

    parameter, factors = variables[PARAMETER], unit_factors(**numbers)
    names = np.asarray(parameter.values)
    dimensions = [
        quantity(str(name)).dimension if name in VOCABULARY else "" for name in names.ravel()
    ]
    units = xr.Variable(
        parameter.dims,
        np.reshape([factors.get(dimension, 1.0) for dimension in dimensions], names.shape),
    )
    masses = xr.Variable(parameter.dims, names == "M")
    if masses.any():
        # M falls where the ratio m/M rises: dM = -M^2/m d(m/M).
        slope = variables["M"] ** 2 / -numbers["m"] if "M" in variables else np.nan
        units = xr.where(masses, slope, units)
    physical_names = [physical_name(str(name)) for name in names.ravel()]
    renamed = np.reshape(physical_names, names.shape)
    changed = {PARAMETER: xr.Variable(parameter.dims, renamed, parameter.attrs)}
    for name, variable in variables.items():
        if name.endswith(SENSITIVITY_SUFFIX):
            changed[name] = variable / units
            changed[name].attrs = variable.attrs
        elif name.endswith("_deviation") and PARAMETER in variable.dims:
            # Parts whose ratio is lower have the greater mass.
            changed[name] = xr.where(masses, variable.isel(side=slice(None, None, -1)), variable)
            changed[name] = changed[name].transpose(*variable.dims)
            changed[name].attrs = variable.attrs
    for name in OF_PARAMETERS & variables.keys():
        changed[name] = variables[name] * units
        changed[name].attrs = variables[name].attrs
    covariance = variables.get("parameter_covariance")
    if covariance is not None:
        dims = ["other_parameter" if dim == PARAMETER else dim for dim in units.dims]
        other = xr.Variable(dims, units.data)
        changed["parameter_covariance"] = covariance * (units * other)
        changed["parameter_covariance"].attrs = covariance.attrs
    return changed


def _text_in_si(name: str, text: Any, numbers: Mapping[str, float]) -> Any:
    """Return an attribute of a dataset in SI: its start, and the parameters that it follows."""
    if name in GOALS and isinstance(text, str):
        return _GOAL.sub(lambda match: match[1] + _goal_in_si(match[1], match[2], numbers), text)
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
        x0 += " m"
    if v0 != "swept":
        velocity = convert("velocity", float(match[3]), numbers)
        v0 = f"= {velocity:g} {DIMENSIONS['velocity'].plain}"
    return f"x0 {x0}, v0 {v0}"
