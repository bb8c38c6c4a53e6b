"""The forcing frequency of a record, and the phase of its force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.fit.spectrum import Line, largest_line, line_at, line_of_trigger
from vibropipe.words.parameters import PARAMETERS

if TYPE_CHECKING:
    from vibropipe.solve.fit.record import Record

# Least numbers of forcing periods of a record, and of samples in one.
MIN_PERIODS, MIN_SAMPLES_PER_PERIOD = 3.0, 8.0
# A stated frequency is refused if the phase is off by more than this (rad) at an end of the record, and by more than
# six deviations of the frequency of the record.
MAX_DRIFT, DEVIATIONS = 0.3, 6.0


def forcing_line(
    stated: float | None,
    tau: np.ndarray,
    values: np.ndarray,
    is_clipped: np.ndarray,
    pulse: np.ndarray | None,
    p: float | None,
) -> Line:
    """Return the forcing frequency: as stated, or that of the force, or of the record.

    stated : the frequency that the exciter states
    tau : (n,)
    values, is_clipped : (n, q), what sensors measured, and which samples are at their limits
    pulse : (n,), a force or a trigger
    p : eigenfrequency (rad/s), for messages in Hz
    Raises ParameterError if the record has no period, or another one than is stated.
    """
    if pulse is not None:
        found = line_of_trigger(tau, pulse) or largest_line(tau, pulse[:, None], None)
    else:
        found = largest_line(tau, values, is_clipped)
    if found is None:
        must = "must have a period"
        got = "a record whose spectrum has no line above its noise"
        raise ParameterError("measured", None, must=must, got=got)
    if stated is None:
        return found
    own = found if pulse is not None else line_at(tau, values, is_clipped, stated)
    off = np.inf if own is None else abs(own.nu - stated)
    drift = 0.5 * (tau[-1] - tau[0]) * off
    if own is None or (drift > MAX_DRIFT and off > DEVIATIONS * own.std):
        near = frequency_text(found.nu, p)
        must = f"must be the forcing frequency of the record, whose largest line is at {near}, or be left out"
        name = "nu" if p is None else "omega"
        raise ParameterError(name, stated, must=must, got=frequency_text(stated, p))
    return Line(stated, 0.0)


def frequency_text(nu: float, p: float | None) -> str:
    """Write a frequency, in Hz where the eigenfrequency p (rad/s) is known."""
    return f"{nu:.6g}" if p is None else f"{nu * p / (2 * np.pi):.6g} Hz"


def check_resolution(tau: np.ndarray, line: Line) -> None:
    """Raise a ParameterError if the samples are too far apart for the forcing frequency."""
    per_period = 2 * np.pi / line.nu / float(np.median(np.diff(tau)))
    if per_period < MIN_SAMPLES_PER_PERIOD:
        must = f"must have at least {MIN_SAMPLES_PER_PERIOD:g} samples in each forcing period"
        raise ParameterError("measured", per_period, must=must, got=f"{per_period:.3g}")


def phase_of(
    name: str,
    tau: np.ndarray,
    values: np.ndarray,
    line: Line,
    exciter: Exciter,
    ranges: Mapping[str, tuple[float, float]],
) -> float:
    """Return the phase of the force in the middle of a record, in forcing periods, from its column."""
    middle = 0.5 * (tau[0] + tau[-1])
    if name == "trigger":
        own = line_of_trigger(tau, values)
        if own is not None and own.rise is not None:
            return float((middle - own.rise) * own.nu / (2 * np.pi) % 1.0)
    angle = line.nu * (tau - middle)
    basis = np.column_stack([np.ones_like(tau), np.sin(angle), np.cos(angle)])
    _, sine, cosine = np.linalg.lstsq(basis, values, rcond=None)[0]
    f = 0.5 * sum(ranges["f"]) if "f" in ranges else exciter.f
    is_negative = f + exciter.shaker * line.nu**2 < 0
    return float((np.arctan2(cosine, sine) / (2 * np.pi) + 0.5 * is_negative) % 1.0)


def with_frequency_of(record: Record, factor: float) -> Record | None:
    """Return a record with a multiple or a fraction of its frequency as that of the force.

    None where the record is too short or too coarse for it, or has no line at the fraction.
    """
    nu = record.line.nu * factor
    step, span = float(np.median(np.diff(record.tau))), float(np.ptp(record.tau))
    if (
        2 * np.pi / nu < MIN_SAMPLES_PER_PERIOD * step
        or span * nu < MIN_PERIODS * 2 * np.pi
        or (factor < 1 and line_at(record.tau, record.values, record.is_clipped, nu) is None)
    ):
        return None
    return replace(record, line=Line(nu, record.line.std * factor))


def ranges_with_frequency(
    record: Record, ranges: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]] | None:
    """Return the ranges of what is to be found, with the frequency where none is stated; None where it lies beyond.

    A frequency range is narrowed to that of the record, within six deviations or the drift that is allowed to a stated
    one: farther off phases do not agree, and jumps of the velocity shift a line by more than its deviation.
    """
    nu, std = record.line.nu, record.line.std
    if std == 0.0:
        return dict(ranges)
    width = max(DEVIATIONS * std, 2 * MAX_DRIFT / float(np.ptp(record.tau)))
    low, high = ranges.get("nu", (0.0, np.inf))
    narrow = max(low, nu - width), min(high, nu + width)
    if narrow[0] >= narrow[1]:
        return None
    both = {**ranges, "nu": narrow}
    return {name: both[name] for name in (*PARAMETERS, *both) if name in both}
