"""A measured table of any kind as columns without units, and as a motion, a response or a record."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import number_within, si_value
from vibropipe.physics.si import eigenfrequency, unit_factors
from vibropipe.physics.ties import Ties
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.fit.fit_model import Measured
from vibropipe.solve.fit.record import Reading, Record, check_noise, read_record
from vibropipe.solve.rows.named import named
from vibropipe.solve.with_units import plain_mapping, plain_name, plain_values, si_of_dimension
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.records import POSITIVE
from vibropipe.words.sensors import RECORD, TAU, TIME, name_and_unit
from vibropipe.words.spelling import did_you_mean, latin
from vibropipe.words.units import UnitError, check_unit, plain_units, to_si

A_TABLE = (
    "a table with columns phase and displacement, with swept parameters and quantities, or with time and what sensors "
    "measured"
)
PHASE, NO_UNIT = "phase", ("", "1", "-")
NO_RECORD = "must be left out, since measured is no record over time"


class Column(NamedTuple):
    """A column of a table.

    values : (n,)
    unit : as it was written; empty without one
    """

    values: np.ndarray
    unit: str


def columns_of(measured: Any) -> dict[str, Column]:
    """Return the columns of a table by name.

    measured : mapping, pandas.DataFrame, xarray.Dataset, structured array, or path of a CSV file. Units stand in the
        names, as `velocity (mm/s)`, in the attribute `units` of xarray, or are those of pint
    Raises ParameterError if it is no table of finite numbers, with columns of one length.
    """
    if isinstance(measured, (str, os.PathLike)):
        measured = _file(measured)
    columns: dict[str, Column] = {}
    try:
        for head, given in _entries(measured):
            name, unit = name_and_unit(str(head))
            unit = unit or _own_unit(given)
            name = name.lower() if name.lower() in (*RECORD, PHASE, TAU) else str(latin(name))
            values = _numbers(name, getattr(given, "magnitude", given))
            columns[TIME if name == "t" else name] = Column(values, "" if unit in NO_UNIT else unit)
    except ParameterError:
        raise
    except (KeyError, TypeError, ValueError, IndexError):
        raise ParameterError("measured", measured, A_TABLE, got="another value") from None
    shapes = {column.values.shape for column in columns.values()}
    if len(shapes) != 1 or len(shapes.copy().pop()) != 1:
        raise ParameterError("measured", measured, A_TABLE, got="columns of different lengths")
    for name, column in columns.items():
        bad = np.flatnonzero(~np.isfinite(column.values))
        if bad.size:
            got = f"{column.values[bad[0]]} in line {bad[0] + 1} of {name}"
            raise ParameterError("measured", measured, "a table of finite numbers", got=got)
    return columns


def _numbers(name: str, given: Any) -> np.ndarray:
    """Return a column as numbers; ParameterError if it has text."""
    try:
        return np.asarray(given, float)
    except (TypeError, ValueError):
        texts = [value for value in np.ravel(given).tolist() if isinstance(value, str)]
        if not texts:
            raise
        must = "must have numbers in its columns, and units in their heads, as 'displacement (mm)'"
        got = f"{texts[0]!r} in {name}"
        raise ParameterError("measured", given, must=must, got=got) from None


def _file(path: Any) -> Any:
    """Return the table of a CSV file, or raise a ParameterError."""
    import pandas as pd

    try:
        # Spreadsheets begin a file of UTF-8 with a mark.
        return pd.read_csv(path, comment="#", sep=None, engine="python", encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", "") or "no table"
        allowed = "a table, or the path of a CSV file"
        raise ParameterError("measured", path, allowed, got=f"{path!r} ({why})") from None


def _entries(measured: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the names and the columns of a table; of xarray, coordinates as well."""
    names = getattr(getattr(measured, "dtype", None), "names", None)
    if hasattr(measured, "to_dataset"):
        measured = measured.to_dataset()
    own = getattr(measured, "variables", measured) if names is None else names
    for name in own:
        yield name, measured[name]


def _own_unit(values: Any) -> str:
    """Return the unit that an array has; empty without one."""
    if hasattr(values, "magnitude"):
        return str(values.units)
    attrs = getattr(values, "attrs", {})
    return plain_units(str(attrs.get("units", ""))) if isinstance(attrs, Mapping) else ""


def has_units(columns: Mapping[str, Column]) -> bool:
    """Return whether a table has units, or times in seconds."""
    return TIME in columns or any(column.unit for name, column in columns.items() if name != PHASE)


def plain_table(
    exciter: Exciter, columns: Mapping[str, Column], with_units: bool
) -> dict[str, np.ndarray]:
    """Return the columns of a table without units, time as tau.

    with_units : whether numbers without a unit are in SI
    Raises ParameterError if a unit is none or of another dimension, or the exciter has none, or if a parameter has a
    value that it cannot have.
    """
    if with_units and not exciter.written:
        which = next(
            f"{name} ({column.unit})" if column.unit else name
            for name, column in columns.items()
            if column.unit or name == TIME
        )
        must = "must have no units, and tau in place of time, unless the exciter is of Exciter.from_physical"
        raise ParameterError("measured", None, must=must, got=which)
    _check_ranges(columns, with_units)
    if not with_units:
        return {name: _of_phase(name, column) for name, column in columns.items()}
    factors, plain = unit_factors(**_mass_and_stiffness(exciter)), dict[str, np.ndarray]()
    for name, column in columns.items():
        is_number = name in (PHASE, TAU) or (name in PARAMETERS and name not in PHYSICAL)
        is_strange = TIME in columns and name not in RECORD  # which the reader of records refuses
        if is_number or is_strange:
            plain[name] = _of_phase(name, column)
            continue
        if name in PHYSICAL:
            si = column.values * _factor(name, column.unit, PHYSICAL[name].dimension)
            plain[plain_name(name)] = np.asarray(plain_values(exciter, name, si))
        else:
            dimension = RECORD[name] if name in RECORD else named(name, "measured").dimension
            si = column.values * _factor(name, column.unit, dimension)
            plain[TAU if name == TIME else name] = si / factors.get(dimension, 1.0)
    return plain


def _check_ranges(columns: Mapping[str, Column], with_units: bool) -> None:
    """Raise a ParameterError for a value that a parameter cannot have: a unit changes no limit but 0."""
    entries: dict[str, Any] = {**PARAMETERS, **(PHYSICAL if with_units else {})}
    for name in columns.keys() & entries.keys():
        (values, unit), within = columns[name], entries[name].range
        for n in [n for n, value in enumerate(values) if not within.contains(value)][:1]:
            got = f"{values[n]} {unit}".strip() + f" in line {n + 1}"
            raise ParameterError(f"measured.{name}", values[n], within.text, got=got)


def _of_phase(name: str, column: Column) -> np.ndarray:
    """Return a column without units; of a phase with a unit, in forcing periods."""
    if name != PHASE or not column.unit:
        return column.values
    return column.values * _factor(name, column.unit, "angle") / (2 * np.pi)


def _factor(name: str, unit: str, dimension: str) -> float:
    """Return the SI value of one of a unit, 1 without one, or raise a ParameterError."""
    if not unit:
        return 1.0
    try:
        if not dimension:
            raise UnitError("a number without a unit")
        return to_si(f"1 {check_unit(unit, dimension)}", dimension)
    except UnitError as error:
        hint = f" ({error.hint})" if error.hint else ""
        raise ParameterError(
            f"measured.{name}", unit, error.allowed, got=f"{unit!r}{hint}"
        ) from None


def _mass_and_stiffness(exciter: Exciter) -> dict[str, float]:
    return {name: si_value(name, exciter.written[name]) for name in ("m", "C")}


def plain_arguments(exciter: Exciter, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `identify` without units; bare numbers are in SI."""
    own = _mass_and_stiffness(exciter)
    factors, p = unit_factors(**own), eigenfrequency(**own)
    plain = dict(given)
    plain["vary"] = plain_mapping(exciter, given["vary"])
    plain |= {name: plain_values(exciter, name, given[name]) for name in ("x0", "v0")}
    for name in ("steady_from", "blanking"):
        if given[name] is not None:
            plain[name] = si_of_dimension(name, given[name], "time") * p
    if given["noise"] is not None:
        plain["noise"] = {}
        for name, value in given["noise"].items():
            dimension = RECORD[name] if name in RECORD else named(name, "noise").dimension
            plain["noise"][name] = value
            if dimension:
                si = si_of_dimension(f"noise.{name}", value, dimension)
                plain["noise"][name] = si / factors.get(dimension, 1.0)
    return plain


def read_table(
    exciter: Exciter,
    measured: Any,
    ranges: Mapping[str, tuple[float, float]],
    noise: Mapping[str, float] | None,
    reading: Reading,
    ties: Ties,
) -> Measured | Record:
    """Return a table without units, of a motion, a response or a record, or raise a ParameterError.

    exciter : the parameters that are known
    measured : columns by name
    noise : as `identify` takes it
    reading : of a record alone
    ties : a record is read with the tied parameters at the lower ends of the ranges
    """
    table = {name: column.values for name, column in columns_of(measured).items()}
    if TAU in table:  # a record
        if "nu" in ties.expressions:
            must = "must be left out beside a record, in which the frequency is found"
            raise ParameterError("ties.nu", ties.texts["nu"], must=must, got="")
        lows = {name: ends[0] for name, ends in ranges.items()}
        exciter = replace(exciter, **ties.checked({**exciter.numbers()._asdict(), **lows}))
        return read_record(exciter, table, ranges, noise, reading)
    of_record = {"steady_from": reading.steady_from, "blanking": reading.blanking}
    for name, value in of_record.items():
        if value is not None:
            raise ParameterError(name, value, must=NO_RECORD, got="")
    return read_measured(table, ranges, noise)


def read_measured(
    table: Mapping[str, np.ndarray], ranges: Mapping[str, Any], noise: Mapping[str, float] | None
) -> Measured:
    """Return a table of a motion or a response, or raise a ParameterError."""
    if {"phase", CURVE} == {*table}:
        over, names, values = {"phase": table["phase"]}, [], table[CURVE][:, None]
    elif "phase" in table:
        others = [name for name in table if name != "phase"]
        hint = " ".join(filter(None, (did_you_mean(name, [CURVE]) for name in others)))
        got = (", ".join(others) or "nothing") + (f" ({hint})" if hint else "")
        must = "must have the column displacement, and no other, beside the phase"
        raise ParameterError("measured", table, must=must, got=got)
    else:
        over = {name: table[name] for name in table if name in Parameters._fields}
        names = [named(name, "measured") for name in table if name not in over]
        for place in (name.name for name in names if name.is_place):
            must = "must have quantities of the motion: the place of a bifurcation is found along its branch"
            raise ParameterError("measured", place, must=must, got=place)
        if not over or not names:
            raise ParameterError("measured", table, A_TABLE, got=", ".join(table))
        for name in over.keys() & ranges.keys():
            must = f"must leave out {name}, since it stands in the table"
            raise ParameterError("vary", ranges, must=must, got="")
        values = np.column_stack([table[name.name] for name in names])
    columns = [name.name for name in names] or [CURVE]
    if noise is None and len(columns) > 1:
        must = f"is required, since several quantities are measured ({', '.join(columns)})"
        raise ParameterError("noise", noise, must=must, got="")
    if noise is not None:
        check_noise(noise, columns)
    if values.size <= len(ranges):
        must = f"must have more numbers than parameters to be found ({len(ranges)})"
        raise ParameterError("measured", values.size, must=must)
    sigma = [number_within(f"noise.{c}", (noise or {}).get(c, 1.0), POSITIVE) for c in columns]
    return Measured(over, values, names, 1 / np.array(sigma), noise is not None)
