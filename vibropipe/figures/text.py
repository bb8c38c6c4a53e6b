"""Words and numbers as figures and the report spell them: plain text or mathtext, never markup.

A user's own text never passes through here: only values and names of the vocabulary do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr

from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import PLAIN_SYMBOLS, REGIMES, quantity

REGIME_WORDS = {
    "no_impact": "no impact",
    "one_sided_1": "one-sided, support 1",
    "one_sided_2": "one-sided, support 2",
    "two_sided": "two-sided",
    "with_rest": "with rest",
    "aperiodic": "aperiodic",
    "unbounded": "unbounded",
    "unresolved": "unresolved",
}
REGIME_SHORT = {
    "no_impact": "no impact",
    "one_sided_1": "one-sided 1",
    "one_sided_2": "one-sided 2",
    "two_sided": "two-sided",
    "with_rest": "rest",
    "aperiodic": "aperiodic",
    "unbounded": "unbounded",
    "unresolved": "unresolved",
}
# Why a row is unresolved, by status.
UNRESOLVED_WORDS = {
    Status.MAX_IMPACTS: "more impacts in a forcing period than are marched",
    Status.MAX_PERIODS: "still growing at the end of the march",
    Status.ROOT_BOUND: "an impact was not located",
    Status.NOT_FINITE: "numbers out of range",
    Status.LOG_FULL: "more contacts than are kept",
    Status.SUPPORT_REACHED: "a support is reached that was left out",
    Status.MAX_STEPS: "more steps in a forcing period than are marched",
}
# what stands where there is nothing to draw
SAMPLES_NOT_ASKED = (
    "Displacement and velocity were not asked for: add motion to outputs, "
    "with samples_per_period above 0"
)
IMPACTS_NOT_ASKED = "Impacts were not asked for: add impacts to outputs"
CURVES_NOT_ASKED = (
    "Only the regimes are drawn: neither harmonics nor impacts were asked for in outputs"
)
NO_SUPPORT_STRUCK = "No support is struck"
FEW_VALUES = 8
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


def regime_name(code: int) -> str:
    """Return the name of a regime's integer value; KeyError on a value without one."""
    for name, value in REGIMES.items():
        if value == code:
            return name
    raise KeyError(f"{code} is not a regime (vibropipe/words/vocabulary.py)")


def format_number(value: float, digits: int = 4) -> str:
    """Write ``value`` with ``digits`` significant digits, a true minus and powers of ten.

    >>> number(-0.035367)
    '−0.03537'
    >>> number(1.5e-13)
    '1.5 × 10⁻¹³'
    """
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    mantissa, _, exponent = f"{value + 0.0:.{digits}g}".partition("e")
    text = mantissa.replace("-", "−")
    if not exponent:
        return text
    raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{text} × 10{raised}"


def scalar_parameters(dataset: xr.Dataset) -> dict[str, float]:
    """Return the exciter's parameters that have one value in ``dataset`` (swept ones have not)."""
    return {
        name: float(dataset[name])
        for name in PARAMETERS
        if name in dataset.variables and dataset[name].ndim == 0
    }


def parameter_line(dataset: xr.Dataset, leave_out: Iterable[str] = ()) -> str:
    """Write the scalar parameters of ``dataset`` as one line of mathtext: nu = 1, f = -1, ..."""
    left_out = set(leave_out)
    parts = [
        f"{quantity(name).symbol} = {mathtext(value)}"
        for name, value in scalar_parameters(dataset).items()
        if name not in left_out
    ]
    return ",  ".join(parts)


def plain_parameters(values: dict[str, float]) -> str:
    """Write parameters as plain text, for a sentence of the report."""
    return ", ".join(
        f"{PLAIN_SYMBOLS.get(name, name)} = {format_number(v)}" for name, v in values.items()
    )


def mathtext(value: float) -> str:
    """Write a number for matplotlib: as ``format_number`` does, powers of ten raised by mathtext."""
    text = format_number(value)
    if " × 10" not in text:
        return text
    mantissa, exponent = f"{value:.4g}".split("e")
    return rf"${mantissa}\times 10^{{{int(exponent)}}}$"


def sentences(*parts: str) -> str:
    """Join what there is to say, each part a sentence without its full stop."""
    return " ".join(f"{part}." for part in parts if part)


def grid_text(values: np.ndarray) -> str:
    """Write a grid: its values, or where there are many its ends and their number."""
    if values.size <= FEW_VALUES:
        return ", ".join(format_number(float(value)) for value in values)
    return f"{format_number(float(values.min()))} … {format_number(float(values.max()))} ({values.size} values)"


def times(amount: int) -> str:
    """Write how often: once, twice, 7 times."""
    return {1: "once", 2: "twice"}.get(amount, f"{amount} times")


def departure(dataset: xr.Dataset) -> float:
    """Return the largest difference in displacement from the exact motion."""
    return float(np.abs(dataset["displacement"] - dataset["displacement_exact"]).max())


def digits(value: float) -> str:
    """Write a number with three digits, whole ones in full up to six."""
    return f"{value:.0f}" if 100 <= value < 1e6 else format_number(value, 3)
