"""Checks of the arguments of the faces: each returns the checked value or raises a ParameterError."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.limits import LAW_IMPACTS, LAW_PERIODS, LAW_TEXT, MAX_SAMPLES, within_text
from vibropipe.physics.parameter_error import as_float, check_keys
from vibropipe.physics.restitution import SUPPORTS
from vibropipe.physics.si import NO_HOUSING, TWICE_DAMPED
from vibropipe.solve.sweep.sweep_grid import DIRECTIONS, Follow
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.parameters import PARAMETERS, STARTS, of_effect
from vibropipe.words.records import FINITE

LEFT_OUT = "must be left out with mass_ratio above 0: it is not computed for a housing that slides"


def span_in_turns(exciter: Exciter, tau_start: float, tau_end: float) -> tuple[float, float]:
    """Return start and end, given in tau, in forcing periods.

    Raises ParameterError if the times are not finite, negative, in the wrong order or beyond 2**52 forcing periods.
    """
    start = as_float("tau_start", tau_start, "a finite number >= 0")
    end = as_float("tau_end", tau_end, "a finite number >= tau_start")
    if not (math.isfinite(start) and start >= 0):
        raise ParameterError("tau_start", start, "a finite number >= 0")
    if not (math.isfinite(end) and end >= start):
        least = "tau_start" if start else "0"  # which may be in seconds in the call
        raise ParameterError("tau_end", end, f"a finite number >= {least}")
    turns = (start * exciter.nu / (2 * math.pi), end * exciter.nu / (2 * math.pi))
    if turns[1] > 2**52:
        raise ParameterError("tau_end", end, "at most 2**52 forcing periods")
    return turns


def check_whole(name: str, value: Any, limits: tuple[int, int]) -> int:
    """Return a whole number within limits (least, most) as an int.

    name : as in the message
    value : int or numpy.integer; a bool is rejected
    Raises ParameterError if it is no whole number within the limits.
    """
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or not limits[0] <= value <= limits[1]:
        raise ParameterError(name, value, within_text(limits))
    return int(value)


def check_over(over: Mapping[str, Any], own: Collection[str] = ()) -> dict[str, np.ndarray]:
    """Return the swept values as one-dimensional arrays of finite floats, or raise a ParameterError.

    own : names beside those of parameters and starts
    """
    arrays = {}
    check_keys("over", over, (*Parameters._fields, *STARTS, *own))
    for name, values in over.items():
        within = PARAMETERS[name].range if name in PARAMETERS else FINITE
        allowed = f"a non-empty list of {within.text if within.words else 'finite numbers'}"
        try:
            if within.words:
                plain = np.atleast_1d(np.asarray(values, dtype=object)).tolist()
                values = [within.number_of(value) for value in plain]
            array = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            raise ParameterError(f"over.{name}", values, allowed) from None
        if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
            raise ParameterError(f"over.{name}", values, allowed)
        if np.unique(array).size != array.size:
            raise ParameterError(f"over.{name}", values, "values that differ from each other")
        arrays[name] = array
    if not arrays:
        must = "must have at least one parameter with its values"
        raise ParameterError("over", over, must=must)
    return arrays


def check_follow(over: Mapping[str, Any], follow: Follow) -> Follow:
    """Return `follow` as a pair, or raise a ParameterError."""
    if follow is None:
        return None
    if isinstance(follow, str) or np.shape(follow) != (2,):
        allowed = 'a pair of a swept parameter and a direction, like ("nu", "up")'
        raise ParameterError("follow", follow, allowed)
    along, direction = follow
    if along not in over:
        raise ParameterError("follow.along", along, f"a swept parameter ({', '.join(over)})")
    if direction not in list(DIRECTIONS):
        raise ParameterError("follow.direction", direction, "up, down or both")
    for name in STARTS:
        if name in over:
            must = f"must be left out when {name} is swept, since a followed row starts from its neighbour"
            raise ParameterError("follow", follow, must=must)
    return along, direction


def check_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    """Return the requested outputs in the order of `OUTPUTS`, or raise a ParameterError."""
    if isinstance(outputs, str) or not set(outputs) <= set(OUTPUTS):
        raise ParameterError("outputs", outputs, f"a list of {', '.join(OUTPUTS)}")
    return tuple(name for name in OUTPUTS if name in outputs)


def check_law(law: Sequence[int]) -> tuple[int, int, int]:
    """Return a law of motion as whole numbers, or raise a ParameterError."""
    ranges = LAW_PERIODS, LAW_IMPACTS, LAW_IMPACTS
    allowed = f"(m, p1, p2): {LAW_TEXT}"
    numbers = law if isinstance(law, Sequence) and not isinstance(law, str) else ()
    is_whole = all(isinstance(n, int | np.integer) and not isinstance(n, bool) for n in numbers)
    if len(numbers) != 3 or not is_whole:
        raise ParameterError("law", law, allowed)
    m, first, second = (int(n) for n in numbers)
    if not all(low <= n <= high for n, (low, high) in zip((m, first, second), ranges, strict=True)):
        raise ParameterError("law", law, allowed)
    return m, first, second


def sample_times(turns: tuple[float, float], per_period: int) -> np.ndarray:
    """Return the times of the samples before the end, in forcing periods after the start.

    turns : start and end, in forcing periods
    Raises ParameterError if there are too many samples.
    """
    span = (turns[1] - turns[0]) * per_period
    # Leaves out a regular sample within rounding of tau_end, which has a sample of its own.
    count = max(1, math.ceil(span - 1e-6)) if span > 0 else 0
    if count > MAX_SAMPLES:
        must = f"must give at most {MAX_SAMPLES} samples up to tau_end"
        got = f"{per_period!r} with {count} samples"
        raise ParameterError("samples_per_period", per_period, must=must, got=got)
    return np.arange(count) / max(per_period, 1)


def check_housing(exciter: Exciter, velocity: Any, **asked: bool) -> float:
    """Return the velocity of a housing at the start as a float.

    Raises ParameterError if it is not finite, or is not 0 where no housing slides; or if anything is asked that is not
    computed for one.
    """
    start = as_float("housing_v0", velocity, FINITE.text)
    if not FINITE.contains(start):
        raise ParameterError("housing_v0", velocity, FINITE.text)
    if exciter.mass_ratio == 0.0:
        if start != 0.0:
            raise ParameterError("housing_v0", velocity, must=NO_HOUSING)
        return start
    for name, is_asked in asked.items():
        if is_asked:
            raise ParameterError(name, True, must=LEFT_OUT, got="")
    return start


def check_accuracy_of_housing(effect: int | None, accuracy: float | None) -> None:
    """Raise a ParameterError for an accuracy of steady states with a housing that slides, `effect`."""
    if effect is not None and accuracy is not None:
        raise ParameterError("accuracy", accuracy, must=LEFT_OUT, got="")


def check_varied(
    argument: str, exciter: Exciter, names: Collection[str], lows: Mapping[str, float]
) -> None:
    """Raise a ParameterError where parameters of a support vary that do not go together, or of a fixed housing.

    Stiffness or damping vary of a support that may be rigid, at a stiffness of 0; the restitution of a soft one varies,
    or it is stated beside a stiffness or damping that varies, so that the damping would have to follow.
    """
    for R, k, h in SUPPORTS:
        least = lows.get(k, getattr(exciter, k))
        if {k, h} & {*names} and not least > 0.0:
            must = f"must be above 0 where {k} or {h} vary: a support with {k} = 0 is rigid"
            raise ParameterError(f"{argument}.{k}" if k in lows else k, least, must=must)
        if R in names and least > 0.0:
            must = f"must be left out where {k} is above 0: vary the damping {h} in its place"
            raise ParameterError(f"{argument}.{R}", R, must=must, got="")
        if {k, h} & {*names} and getattr(exciter, R) < 1.0:
            must = f"must be left out where {k} or {h} vary: state the damping {h} in its place"
            raise ParameterError(R, getattr(exciter, R), must=must)
    mass_ratio = lows.get("mass_ratio", exciter.mass_ratio)
    for name in of_effect("housing") if not mass_ratio > 0.0 else ():
        # A range may begin at a fixed housing; around one there are no derivatives.
        if name in names and (name != "mass_ratio" or name not in lows):
            must = "must be left out where mass_ratio is 0: the housing is fixed then"
            raise ParameterError(f"{argument}.{name}", None, must=must, got="")


def swept_dampings(exciter: Exciter, over: Mapping[str, np.ndarray]) -> set[str]:
    """Return the dampings of supports that follow from a swept restitution or stiffness.

    Raises ParameterError if such a damping is stated, or swept, beside a restitution below 1.
    """
    derived = set()
    for R, k, h in SUPPORTS:
        R_values = over.get(R, np.array([getattr(exciter, R)]))
        k_values = over.get(k, np.array([getattr(exciter, k)]))
        if not ((R_values < 1.0).any() and (k_values > 0.0).any()):
            continue
        if h in over or exciter.states(h):
            must = TWICE_DAMPED.format(R=R, k=k, h=h)
            raise ParameterError(f"over.{h}" if h in over else h, None, must=must, got="")
        if {R, k} & over.keys():
            derived.add(h)
    return derived


def with_frequency(exciter: Exciter, varied: Mapping[str, float]) -> Exciter:
    """Return an exciter with the frequency that varies, at its value, where it states none.

    Raises ParameterError if it has a force, or one varies, and no frequency.
    """
    exciter.check_frequency(varied.keys())
    is_stated = exciter.states("nu") or "nu" not in varied
    return exciter if is_stated else replace(exciter, nu=varied["nu"])
