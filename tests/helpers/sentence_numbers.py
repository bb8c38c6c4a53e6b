"""Numbers of sentences that the program writes, each to be found in its dataset."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
import xarray as xr

RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
# Names with digits, which are no numbers.
NAMES = re.compile(r"RK45|DOP853|[RC][₁₂]|figure \d+|support \d")
PLAIN, POWER = r"(−?\d[\d,]*(?:\.\d+)?)", r"10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
NUMBER = re.compile(rf"{PLAIN} × {POWER}|{POWER}|{PLAIN}")
# What a number is multiplied by for print: percent, and ns written in µs, ms or s.
SCALES = (1.0, 100.0, 1e-3, 1e-6, 1e-9)


def numbers_in(text: str) -> list[tuple[float, int]]:
    """Return the numbers of a text with their significant digits."""
    found = []
    for match in NUMBER.finditer(NAMES.sub("", text)):
        factor, raised, lone, plain = match.groups()
        digits = (factor or plain or "1").replace(",", "").replace("−", "-")
        value = float(digits) * 10.0 ** int((raised or lone or "0").translate(RAISED))
        found.append((value, len(digits.replace(".", "").lstrip("-0").rstrip("0")) or 1))
    return found


def values_of(dataset: xr.Dataset) -> np.ndarray:
    """Return all numbers of a dataset, its attributes and its sizes."""
    arrays = [v.values for v in dataset.variables.values() if v.dtype.kind in "fiu"]
    attrs = [v for v in dataset.attrs.values() if isinstance(v, int | float)]
    values = np.concatenate(
        [*(np.ravel(a).astype(float) for a in arrays), attrs, list(dataset.sizes.values())]
    )
    return values[np.isfinite(values)]


def missing(
    texts: Iterable[str], dataset: xr.Dataset, derived: Iterable[float] = ()
) -> list[float]:
    """Return the numbers of some texts that are neither in a dataset nor derived from it, rounded as written."""
    pool = np.concatenate([values_of(dataset), np.fromiter(derived, float)])
    lost = []
    for value, digits in (pair for text in texts for pair in numbers_in(text)):
        unit = 10.0 ** (np.floor(np.log10(abs(value))) + 1 - digits) if value else 1e-300
        if not any((np.abs(pool * scale - value) <= unit * (1 + 1e-9)).any() for scale in SCALES):
            lost.append(value)
    return lost
