"""A measured table as a motion, a response or a record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.parameter_error import number_within
from vibropipe.physics.ties import Ties
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.fit.fit_model import Measured
from vibropipe.solve.fit.measured_table import A_TABLE, columns_of
from vibropipe.solve.fit.record import Reading, Record, check_noise, read_record
from vibropipe.solve.rows.named import named
from vibropipe.words.records import POSITIVE
from vibropipe.words.sensors import TAU
from vibropipe.words.spelling import did_you_mean

NO_RECORD = "must be left out, since measured is no record over time"


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
