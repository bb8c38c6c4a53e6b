"""Datasets and grids in SI, by eqs. (2)-(4) backwards: t = tau / p, omega = nu p, F = f C, H = h sqrt(m C)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import si_value
from vibropipe.physics.ties import Ties
from vibropipe.solve.in_si import (
    WORDS,
    convert,
    in_si,
    masses_in_si,
    sensitivities_in_si,
    text_in_si,
    wear_in_si,
)
from vibropipe.solve.shown_units import (
    CHOSEN,
    DISPLAY_UNITS,
    Shown,
    checked_units,
    dimension_of,
    display_units_of,
    units_as_text,
    units_of,
)
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.parameters import PHYSICAL
from vibropipe.words.vocabulary import (
    PARAMETER,
    VOCABULARY,
    attributes,
    physical_attributes,
    physical_name,
)

if TYPE_CHECKING:
    import xarray as xr


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
        Units in which `plot` shows the dataset, by dimension: frequency, length, time, velocity, force, energy, torque,
        power, impulse, mass, stiffness, damping, angle (default: those that the exciter, or m and C, were given in; of
        all else SI with a prefix). The dataset itself is in SI.

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
        physical_name(str(name)): in_si(str(name), variable, numbers)
        for name, variable in data.variables.items()
    }
    if "wear_rate" in variables:
        variables["wear_rate"] = wear_in_si(variables, numbers)
    variables |= masses_in_si(data.variables, numbers)
    if PARAMETER in variables:
        variables |= sensitivities_in_si(variables, numbers)
    coords = {physical_name(str(name)): None for name in data.coords}
    attrs = {name: text_in_si(str(name), text, numbers) for name, text in data.attrs.items()}
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

    Raises ParameterError if the dataset has no units, or one that is listed is none or has the dimension of another.
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
