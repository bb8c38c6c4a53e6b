"""Labels and values of a backbone in the units of its dataset."""

from __future__ import annotations

import xarray as xr

from vibropipe.figures.text import format_number
from vibropipe.words.units import plain_units
from vibropipe.words.vocabulary import attributes


def units_of(array: xr.DataArray) -> str:
    """Return the units of an array as they are written by hand, empty for a pure number."""
    units = str(array.attrs.get("units", "1"))
    return "" if units == "1" else plain_units(units)


def shown_label(array: xr.DataArray) -> str:
    """Return the label of the axis of an array: long name, symbol, and units unless it is a pure number."""
    words = attributes(str(array.name)) | array.attrs
    units = units_of(array)
    return f"{words['long_name']} {words['symbol']}" + (f" ({units})" if units else "")


def shown_value(array: xr.DataArray, value: float, digits: int = 4) -> str:
    """Write a value of an array with its units."""
    return f"{format_number(float(value), digits)} {units_of(array)}".strip()
