"""A record of sensors over time: what it may hold, which of its samples count, and its noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import number_within
from vibropipe.solve.fit.record_frequency import (
    MIN_PERIODS,
    check_resolution,
    forcing_line,
    phase_of,
)
from vibropipe.solve.fit.spectrum import Line, folded_noise, steady_index
from vibropipe.words.records import FINITE, NOT_NEGATIVE, POSITIVE
from vibropipe.words.sensors import SENSORS, TAU, TRIGGERS

# Least number of samples of a record.
MIN_SAMPLES = 32
# A sensor is at its limit where so many samples in turn have its largest or its least value.
CLIPPED_RUN = 3
# Samples next to an impact on a rigid support, in intervals of the record, that do not count where no width is given.
BLANKED_INTERVALS = 1.5
KNOWN, UNKNOWN = "known", "unknown"


@dataclass(frozen=True)
class Record:
    """A record of which the motion has settled.

    tau : (n,), increasing times
    columns : what was measured, of `SENSORS`
    values : (n, q)
    is_clipped : (n, q), samples at the limit of a sensor
    transient : number of samples before `tau` that are left out
    line : the frequency of the record
    phase : of the force in the middle of the record, in forcing periods; None where it is not measured
    phase_slack : time by which a trigger, which lies between two samples, may be off
    noise : (q,), standard deviations, given or estimated
    has_noise : whether they are given
    blanking : time on each side of an impact in which velocities and accelerations do not count
    is_signed : whether the direction of the sensors is known
    """

    tau: np.ndarray
    columns: list[str]
    values: np.ndarray
    is_clipped: np.ndarray
    transient: int
    line: Line
    phase: float | None
    phase_slack: float
    noise: np.ndarray
    has_noise: bool
    blanking: float
    is_signed: bool

    @property
    def middle(self) -> float:
        """The time in the middle, from which phases are counted."""
        return float(0.5 * (self.tau[0] + self.tau[-1]))

    @property
    def finds_phase(self) -> bool:
        """Whether the phase of the force is found with the parameters."""
        return self.phase is None or self.phase_slack > 0.0


class Reading(NamedTuple):
    """How a record is read.

    steady_from, blanking : as `identify` takes them, in tau
    sign : `known` or `unknown`
    p : eigenfrequency (rad/s), for messages in Hz
    """

    steady_from: float | None = None
    blanking: float | None = None
    sign: str = UNKNOWN
    p: float | None = None


def read_record(
    exciter: Exciter,
    table: Mapping[str, np.ndarray],
    ranges: Mapping[str, tuple[float, float]],
    noise: Mapping[str, float] | None,
    reading: Reading,
) -> Record:
    """Return a record without units, or raise a ParameterError.

    exciter : its frequency is that of the record unless it states none or nu varies
    table : columns (n,) of finite numbers: `tau`, columns of `SENSORS`, and at most one of `TRIGGERS`
    """
    steady_from, blanking, sign, p = reading
    tau = table[TAU]
    columns = _checked_columns(table, exciter)
    _check_times(tau)
    if sign not in (KNOWN, UNKNOWN):
        raise ParameterError("sign", sign, f"{KNOWN} or {UNKNOWN}")
    first = 0
    if steady_from is not None:
        first = int(np.searchsorted(tau, number_within("steady_from", steady_from, FINITE)))
    if steady_from is not None and tau.size - first < MIN_SAMPLES:
        must = f"must leave at least {MIN_SAMPLES} samples of the record after it"
        raise ParameterError("steady_from", steady_from, must=must)
    tau, rest = tau[first:], {name: values[first:] for name, values in table.items()}
    values = np.column_stack([rest[name] for name in columns])
    is_clipped = np.column_stack([_clipped(name, rest[name]) for name in columns])
    (pulse,) = [name for name in TRIGGERS if name in rest] or [""]
    is_free = "nu" in ranges or not exciter.states("nu")
    stated = None if is_free else exciter.nu
    line = forcing_line(stated, tau, values, is_clipped, rest.get(pulse), p)
    check_resolution(tau, line)
    if steady_from is None:
        settled = steady_index(tau, values, is_clipped, line)
        tau, values, is_clipped = tau[settled:], values[settled:], is_clipped[settled:]
        first += settled
        if settled:
            rest = {name: each[settled:] for name, each in rest.items()}
            line = forcing_line(stated, tau, values, is_clipped, rest.get(pulse), p)
    span = (tau[-1] - tau[0]) * line.nu / (2 * np.pi)
    if span < MIN_PERIODS:
        must = f"must be at least {MIN_PERIODS:g} forcing periods long where the motion is steady"
        raise ParameterError("measured", span, must=must, got=f"{span:.3g} of them")
    step = float(np.median(np.diff(tau)))
    width = BLANKED_INTERVALS * step
    return Record(
        tau, columns, values, is_clipped, first, line,
        phase_of(pulse, tau, rest[pulse], line, exciter, ranges) if pulse else None,
        step if pulse == "trigger" else 0.0,
        _noises(columns, tau, values, is_clipped, line, noise), noise is not None,
        width if blanking is None else number_within("blanking", blanking, NOT_NEGATIVE), sign == KNOWN,
    )  # fmt: skip


def _checked_columns(table: Mapping[str, np.ndarray], exciter: Exciter) -> list[str]:
    """Return what was measured, or raise a ParameterError for other columns of a record."""
    columns = [name for name in SENSORS if name in table]
    known = (TAU, *SENSORS, *TRIGGERS)
    others = [name for name in table if name not in known]
    if others or not columns:
        must = f"must have time and {', '.join(SENSORS)}, or one of them; beside them {' or '.join(TRIGGERS)}"
        raise ParameterError("measured", None, must=must, got=", ".join(others or table))
    if {*TRIGGERS} <= table.keys():
        must = f"must have one column that tells the phase: {' or '.join(TRIGGERS)}"
        raise ParameterError("measured", None, must=must, got="both")
    if "acceleration" in columns and exciter.mass_ratio > 0.0:
        must = "must leave out acceleration beside a housing that may slide"
        raise ParameterError("measured", None, must=must, got="")
    return columns


def _check_times(tau: np.ndarray) -> None:
    """Raise a ParameterError unless there are enough times, and they increase."""
    if tau.size < MIN_SAMPLES:
        must = f"must have at least {MIN_SAMPLES} samples of a record"
        raise ParameterError("measured", tau.size, must=must)
    late = np.flatnonzero(np.diff(tau) <= 0)
    if late.size:
        must = "must have times that increase from sample to sample"
        got = f"none between samples {late[0] + 1} and {late[0] + 2}"
        raise ParameterError("measured", None, must=must, got=got)


def _clipped(name: str, values: np.ndarray) -> np.ndarray:
    """Return which samples (n,) are at a limit of their sensor: in a row of equal largest or least ones."""
    if np.ptp(values) == 0.0:
        must = f"must have values of {name} that differ"
        raise ParameterError("measured", None, must=must, got="one value only, as of a dead sensor")
    is_clipped = np.zeros(values.size, bool)
    for limit in (values.max(), values.min()):
        at_limit = values == limit
        runs = np.convolve(at_limit, np.ones(CLIPPED_RUN), "valid")
        if (runs == CLIPPED_RUN).any():
            is_clipped |= at_limit
    if is_clipped.mean() > 0.5:
        must = f"must have values of {name} within the limits of its sensor"
        raise ParameterError(
            "measured", None, must=must, got=f"{is_clipped.mean():.0%} of them at a limit"
        )
    return is_clipped


def check_noise(noise: Mapping[str, float], columns: list[str]) -> None:
    """Raise a ParameterError unless each measured quantity has a standard deviation, and nothing else."""
    if {*noise} != {*columns}:
        must = f"must have the measured quantities as keys ({', '.join(columns)})"
        raise ParameterError("noise", noise, must=must, got=", ".join(noise))


def _noises(
    columns: list[str],
    tau: np.ndarray,
    values: np.ndarray,
    is_clipped: np.ndarray,
    line: Line,
    noise: Mapping[str, float] | None,
) -> np.ndarray:
    """Return the standard deviations of the noise, given or estimated from what does not repeat."""
    if noise is not None:
        check_noise(noise, columns)
        return np.array([number_within(f"noise.{c}", noise[c], POSITIVE) for c in columns])
    return np.array(
        [
            folded_noise(tau[~clipped], column[~clipped], line.nu)
            for column, clipped in zip(values.T, is_clipped.T, strict=True)
        ]
    )
