"""Text of numbers, parameters and regimes in figures and reports: plain text or mathtext, never markup.

Only values and names of the vocabulary pass through here, never a user's own text.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import PLAIN_SYMBOLS, REGIMES, quantity

REGIME_TEXT = {name: name.replace("_", " ") for name in REGIMES} | {
    "one_sided_1": "one-sided, support 1",
    "one_sided_2": "one-sided, support 2",
    "two_sided": "two-sided",
}
# Reason why a row is unresolved, by status.
UNRESOLVED_TEXT = {
    Status.MAX_IMPACTS: "too many impacts in a forcing period",
    Status.MAX_PERIODS: "still growing at the end of the march",
    Status.ROOT_BOUND: "impact not located",
    Status.NOT_FINITE: "floating-point overflow",
    Status.LOG_FULL: "more contacts than the log holds",
    Status.SUPPORT_REACHED: "a support left out of the effects is reached",
    Status.MAX_STEPS: "too many steps in a forcing period",
}
# Text in place of a missing curve.
NO_SAMPLES = "Displacement and velocity are not stored: add motion to outputs, with samples_per_period above 0"
NO_IMPACTS = "Impacts are not stored: add impacts to outputs"
NO_CURVES = "Regimes only, since outputs include neither harmonics nor impacts"
NO_SUPPORT_STRUCK = "No support is struck"
FEW_VALUES = 8
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


def regime_name(code: int) -> str:
    """Return the name of a regime's integer value; raises KeyError for an unknown value."""
    for name, value in REGIMES.items():
        if value == code:
            return name
    raise KeyError(f"{code} is not a regime (vibropipe/words/vocabulary.py)")


def format_number(value: float | str, digits: int = 4) -> str:
    """Write a number with `digits` significant digits, a true minus sign and powers of ten; text stays.

    >>> format_number(-0.035367)
    '−0.03537'
    >>> format_number(1.5e-13)
    '1.5 × 10⁻¹³'
    """
    if isinstance(value, str):  # a direction
        return value
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
    """Return the parameters of the exciter that are not swept in a dataset."""
    return {
        name: float(dataset[name])
        for name in PARAMETERS
        if name in dataset.variables and dataset[name].ndim == 0
    }


def parameter_line(dataset: xr.Dataset, leave_out: Iterable[str] = ()) -> str:
    """Write the parameters that are not swept as one line of mathtext: nu = 1, f = -1, ..."""
    left_out = set(leave_out)
    parts = [
        f"{quantity(name).symbol} = {mathtext(value)}"
        for name, value in scalar_parameters(dataset).items()
        if name not in left_out
    ]
    return ",  ".join(parts)


def plain_parameters(values: Mapping[str, float | str]) -> str:
    """Write parameters as plain text, for a sentence of the report."""
    return ", ".join(
        f"{PLAIN_SYMBOLS.get(name, name)} = {format_number(v)}" for name, v in values.items()
    )


def mathtext(value: float | str) -> str:
    """Write a number as `format_number` does, with powers of ten in mathtext."""
    text = format_number(value)
    if " × 10" not in text:
        return text
    mantissa, exponent = f"{value:.4g}".split("e")
    return rf"${mantissa}\times 10^{{{int(exponent)}}}$"


def sentences(*parts: str) -> str:
    """Join sentences, given without their full stops; empty ones are left out."""
    return " ".join(f"{part}." for part in parts if part)


def grid_text(values: np.ndarray) -> str:
    """Write the values of a grid; of more than FEW_VALUES, the ends and the number."""
    if values.size <= FEW_VALUES:
        return ", ".join(format_number(value) for value in values.tolist())
    return f"{format_number(float(values.min()))} … {format_number(float(values.max()))} ({values.size} values)"


def times(amount: int) -> str:
    """Write a number of occurrences: once, twice, 7 times."""
    return {1: "once", 2: "twice"}.get(amount, f"{amount} times")


def departure(dataset: xr.Dataset) -> float:
    """Return the largest deviation of displacement from the exact motion."""
    return float(np.abs(dataset["displacement"] - dataset["displacement_exact"]).max())


def digits(value: float) -> str:
    """Write a number with three significant digits, in full from 100 to 1e6."""
    return f"{value:.0f}" if 100 <= value < 1e6 else format_number(value, 3)
