"""Labels of the page: plain Unicode, since TeX would fetch fonts from outside."""

from __future__ import annotations

import re

import xarray as xr

from vibropipe.figures.text import axis_label, format_number, symbol_of, with_units
from vibropipe.figures.units import LOWERED
from vibropipe.store.show import plain_symbol

_RAISED = {"^-": "⁻", "^+": "⁺"}


def unicode_text(text: str) -> str:
    """Return a text with mathtext as plain text: `$R_1$` as R₁."""
    plain = re.sub(r"\$[^$]*\$", lambda match: plain_symbol(match[0]), text)
    for mark, letter in _RAISED.items():
        plain = plain.replace(mark, letter)
    return re.sub(r"_(\d+)", lambda match: match[1].translate(LOWERED), plain)


def label_of(array: xr.DataArray, index: int | None = None) -> str:
    """Return the label of an axis: long name, symbol and units; of a value that is a word, its long name."""
    if "flag_meanings" in array.attrs:
        return str(array.attrs["long_name"])
    return unicode_text(axis_label(array, index))


def symbol(array: xr.DataArray, index: int | None = None) -> str:
    """Return the symbol of a quantity."""
    return unicode_text(symbol_of(array, index))


def number(value: float, digits: int = 6) -> str:
    """Write a number for a table."""
    return format_number(value, digits)


def value_of(array: xr.DataArray, value: float | str, digits: int = 6) -> str:
    """Write a value of a quantity with its units; text stays."""
    return value if isinstance(value, str) else with_units(array, number(value, digits))
