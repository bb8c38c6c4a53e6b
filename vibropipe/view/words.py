"""Labels of the page: plain Unicode, since TeX would fetch fonts from outside; and its scripts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import xarray as xr
from bokeh.models import CustomJS, CustomJSTickFormatter

from vibropipe.figures.text import axis_label, format_number, symbol_of, with_units
from vibropipe.figures.units import LOWERED
from vibropipe.store.show import plain_symbol


def source_of(name: str) -> str:
    """Return the text of a script of this folder."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def short_ticks() -> CustomJSTickFormatter:
    """Return what writes ticks in their shortest form."""
    return CustomJSTickFormatter(code=source_of("ticks.js"))


def script(name: str, **arguments: Any) -> CustomJS:
    """Return a script of this folder as a callback; its arguments are models and values by name."""
    return CustomJS(args=arguments, code=source_of(name))


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
