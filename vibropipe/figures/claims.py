"""How sentences tell numbers: bounds rounded so that they hold, and borders between two values of a grid.

A largest error or an upper bound is rounded up, a margin or a tolerance down, an interval outwards: what is written is
true of the number itself. A value of a grid is no border: that lies between two of them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Hashable, Iterable
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from itertools import islice

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number, plain_symbol_of, with_units
from vibropipe.words.wording import series

# Digits beyond which two numbers count as equal: 0.1 + 0.2 is rounded up to 0.3, not to 0.301.
EXACT = Context(prec=12, rounding=ROUND_HALF_EVEN)
DIGITS, MOST_DIGITS = 4, 12
NEAR = 1e-9  # relative difference below which a neighbour is no smaller


def at_most(value: float, digits: int = 3) -> str:
    """Write a number rounded up: an upper bound, or the largest error.

    >>> at_most(2.0001), at_most(0.1 + 0.2)
    ('2.01', '0.3')
    """
    return format_number(_rounded(value, digits, ROUND_CEILING), digits)


def at_least(value: float, digits: int = 3) -> str:
    """Write a number rounded down: a lower bound, a margin or a tolerance.

    >>> at_least(1.9999), at_least(-2.0001)
    ('1.99', '−2.01')
    """
    return format_number(rounded_down(value, digits), digits)


def rounded_down(value: float, digits: int) -> float:
    """Return a number rounded down to some significant digits."""
    return _rounded(value, digits, ROUND_FLOOR)


def _rounded(value: float, digits: int, rounding: str) -> float:
    """Return a number with `digits` significant digits, rounded as the decimal module says."""
    if not math.isfinite(value):
        return value
    context = Context(prec=digits, rounding=rounding)
    return float(context.plus(EXACT.create_decimal_from_float(value)))


# Between the ends of a range in a cell of a table.
RANGE = " … "
# Text that is one number: sign, whole part, decimals, per cent.
_NUMBER = re.compile(r"([−±+] ?)?(\d[\d,]*)(\.\d+)?( %)?")


def even_digits(cells: list[str], are_exact: bool = False) -> list[str]:
    """Return texts, of a column or of both ends of a range, whose numbers have their last zeros.

    These are as many digits as most of those with decimals have or, of exact numbers such as those of a grid, as many
    decimals as any has. A cell may have both ends of a range.

    >>> even_digits(["0.652", "0.4466", "0.1782", "–"])
    ['0.6520', '0.4466', '0.1782', '–']
    >>> even_digits(["24", "8.9", "7"])
    ['24', '8.9', '7.0']
    >>> even_digits(["10 … 80", "10.25 … 54.75"])
    ['10.00 … 80.00', '10.25 … 54.75']
    """
    parts = [cell.split(RANGE) for cell in cells]
    if any(len(part) > 1 for part in parts):
        evened = iter(even_digits([text for part in parts for text in part], are_exact))
        return [RANGE.join(islice(evened, len(part))) for part in parts]
    found = [_NUMBER.fullmatch(cell) for cell in cells]
    digits = [
        len(re.sub(r"\D", "", cell).lstrip("0")) if match else 0
        for cell, match in zip(cells, found, strict=True)
    ]
    decimals = [len(match[3] or ".") - 1 if match else 0 for match in found]
    broken = sorted((n for n, places in zip(digits, decimals, strict=True) if places), reverse=True)
    if not broken:
        return cells
    usual, texts = max(broken, key=broken.count), []
    for cell, match, n, places in zip(cells, found, digits, decimals, strict=True):
        zeros = max(decimals) - places
        if not are_exact:
            zeros = min(usual - n, zeros)
        if match is None or not n or zeros < 1:
            texts.append(cell)
        else:
            texts.append(
                f"{match[1] or ''}{match[2]}{match[3] or '.'}{'0' * zeros}{match[4] or ''}"
            )
    return texts


def outwards(low: float, high: float, digits: int = DIGITS) -> tuple[str, str]:
    """Write both ends of an interval, rounded outwards, with as many digits as show most of its width."""
    for number in range(digits, MOST_DIGITS + 1):
        first, last = _rounded(low, number, ROUND_FLOOR), _rounded(high, number, ROUND_CEILING)
        if abs((last - first) - (high - low)) <= 0.2 * (high - low):
            break
    low_text, high_text = even_digits([format_number(end, number) for end in (first, last)])
    return low_text, high_text


def from_to(first: float, last: float, digits: int = DIGITS) -> str:
    """Write both ends of a range with as many digits as tell them apart, equal ones once.

    >>> from_to(0.6, 1.6), from_to(1.0, 1.00002), from_to(1.23456, 1.23456)
    ('0.6 to 1.6', '1 to 1.00002', '1.235')
    """
    texts: list[str] = []
    for number in range(digits, MOST_DIGITS + 1):
        texts = [format_number(end, number) for end in (first, last)]
        if first == last or texts[0] != texts[1]:
            break
    return " to ".join(dict.fromkeys(texts))


def between_text(axis: xr.DataArray, one: float, other: float) -> str:
    """Write that something lies between two values of a coordinate: `between ν = 0.8 and 0.85`."""
    low, high = outwards(min(one, other), max(one, other))
    return f"between {plain_symbol_of(axis)} = {low} and {with_units(axis, high)}"


def only_between_text(axis: xr.DataArray, mask: np.ndarray) -> str:
    """Write outside which neighbouring values of a sorted coordinate a mask is false.

    >>> axis = xr.DataArray([1.0, 2.0, 3.0, 4.0], dims="nu", name="nu")
    >>> only_between_text(axis, np.array([False, True, True, False]))
    'only between ν = 1 and 4'
    >>> only_between_text(axis, np.array([True, True, False, False]))
    'only below ν = 3'
    >>> only_between_text(axis, np.array([True, False, False, True]))
    ''
    """
    values, kept = axis.values, np.flatnonzero(mask)
    if not kept.size:
        return ""
    first, last = kept[0], kept[-1]
    if first == 0 and last == values.size - 1:
        return ""
    symbol = plain_symbol_of(axis)
    if first == 0:
        return f"only below {symbol} = {with_units(axis, at_most(float(values[last + 1]), DIGITS))}"
    if last == values.size - 1:
        return (
            f"only above {symbol} = {with_units(axis, at_least(float(values[first - 1]), DIGITS))}"
        )
    return f"only {between_text(axis, float(values[first - 1]), float(values[last + 1]))}"


def rising_text(values: xr.DataArray, at: xr.DataArray, dims: Iterable[Hashable]) -> str:
    """Write that the largest value of an array lies at an end of a range and rises towards it; empty if it does not.

    values : values over their grid
    at : the largest of them by modulus, with its coordinates
    dims : dimensions of the swept parameters
    """
    names = [str(dim) for dim in dims if _rises_at_end(values, at, str(dim))]
    if not names:
        return ""
    return f"it still rises at the end of the range of {series(plain_symbol_of(values[each]) for each in names)}"


def _rises_at_end(values: xr.DataArray, at: xr.DataArray, dim: str) -> bool:
    """Return whether `at` lies at an end of the range of a dimension of numbers, and the value beside it is smaller."""
    axis = values[dim]
    if axis.size < 2 or axis.dtype.kind not in "fiu" or dim not in at.coords:
        return False
    others = {
        str(name): at[name].item() for name in values.dims if name in at.coords and name != dim
    }
    line = abs(values.sel(others).sortby(dim))
    where = int(np.flatnonzero(line[dim].values == at[dim].item())[0])
    beside = {0: 1, axis.size - 1: axis.size - 2}.get(where)
    if beside is None:
        return False
    top, next_to = float(line[where]), float(line[beside])
    return math.isfinite(next_to) and next_to < top * (1.0 - NEAR)


def percent(share: float, up: bool = False) -> str:
    """Write a share in per cent to one decimal, rounded down or up: what is not all is never 100 %."""
    tenths = math.ceil(1000 * share - 1e-9) if up else math.floor(1000 * share + 1e-9)
    return f"{tenths / 10:g} %"
