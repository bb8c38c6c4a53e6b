"""Nominal values of designs and the tolerances that they need, in numbers that suit each other."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least
from vibropipe.figures.text import format_number, measured, with_units
from vibropipe.solve.design.scattered_parts import MAX_CORNERS

# Significant digits of nominal values, at most and without a tolerance, and of tolerances and deviations; share of a
# tolerance that the rounding of its nominal value may take unseen.
MOST_DIGITS, USUAL_DIGITS, DIGITS, UNSEEN = 5, 4, 2, 1e-3


def nominal_text(dataset: xr.Dataset, name: str, row: int = 0) -> str:
    """Write the nominal value of a design with its unit."""
    write = measured if dataset[name].ndim else format_number
    number = write(nominal(dataset, name, row), nominal_digits(dataset, name, row))
    return with_units(dataset[name], number)


def nominal_numbers(dataset: xr.Dataset, name: str) -> list[str]:
    """Write the values of a parameter of all designs."""
    return [
        measured(nominal(dataset, name, row), nominal_digits(dataset, name, row))
        for row in range(dataset.sizes["design"])
    ]


def nominal_digits(dataset: xr.Dataset, name: str, row: int) -> int:
    """Return the significant digits of a parameter wherever it is told: as many as one of the designs needs.

    A value near 0 has no more decimals than any other one needs.
    """
    needed = [digits_needed(dataset, name, n) for n in range(dataset.sizes["design"])]
    value = nominal(dataset, name, row)
    if not (dataset[name].ndim and value and tolerance_of(dataset, name, row) > 0.0):
        return max(needed)
    whole = [
        math.floor(math.log10(abs(nominal(dataset, name, n) or 1.0))) for n in range(len(needed))
    ]
    decimals = max(digits - 1 - places for digits, places in zip(needed, whole, strict=True))
    return max(DIGITS, min(max(needed), decimals + 1 + whole[row]))


def digits_needed(dataset: xr.Dataset, name: str, row: int) -> int:
    """Return the significant digits of a nominal value: if it was found, one more than its tolerance has."""
    value, tolerance = nominal(dataset, name, row), tolerance_of(dataset, name, row)
    if not (dataset[name].ndim and value and tolerance > 0.0):
        return MOST_DIGITS if tolerance > 0.0 else USUAL_DIGITS
    more = np.floor(np.log10(abs(value))) - np.floor(np.log10(tolerance)) + DIGITS + 1
    return int(np.clip(more, DIGITS, MOST_DIGITS))


def nominal(dataset: xr.Dataset, name: str, row: int) -> float:
    """Return the value of a parameter of a design."""
    values = dataset[name].values
    return float(values[row] if values.ndim else values)


def tolerance_of(dataset: xr.Dataset, name: str, row: int) -> float:
    """Return the tolerance of a parameter of a design; NaN without one."""
    held = f"{name}_tolerance"
    return float(dataset[held].values[row]) if held in dataset else float("nan")


def kept_tolerance(dataset: xr.Dataset, name: str, row: int) -> float:
    """Return a tolerance, less what the nominal value is rounded by where it is shown."""
    value, tolerance = nominal(dataset, name, row), tolerance_of(dataset, name, row)
    rounding = abs(value - float(f"{value:.{nominal_digits(dataset, name, row)}g}"))
    # Else a tolerance of 0.01 is 0.0099 beside a deviation of 0.01.
    return tolerance if rounding < UNSEEN * tolerance else max(tolerance - rounding, 0.0)


def shown_tolerance(dataset: xr.Dataset, name: str, row: int) -> str:
    """Write a tolerance, less what the nominal value is rounded by, and rounded down."""
    # What is short of a digit by rounding alone, as that of a deviation that is given, has it.
    return at_least(kept_tolerance(dataset, name, row) * (1.0 + 1e-9), DIGITS)


def held_too_wide(dataset: xr.Dataset, row: int) -> list[str]:
    """Return the parameters of a design whose tolerance is below the deviation that is given for them."""
    if dataset.attrs.get("scatter") != "given":
        return []
    return [
        name
        for name in toleranced(dataset)
        if f"{name}_std" in dataset
        and float(dataset[f"{name}_tolerance"].values[row]) < float(dataset[f"{name}_std"])
    ]


def toleranced(dataset: xr.Dataset) -> list[str]:
    """Return the parameters that have tolerances."""
    return [str(name) for name in dataset.coords if f"{name}_tolerance" in dataset]


def hold_at_once(dataset: xr.Dataset) -> bool:
    """Return whether tolerances were tried in all combinations of their ends; else each was alone."""
    return len(toleranced(dataset)) <= MAX_CORNERS
