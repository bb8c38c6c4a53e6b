"""Findings of a study: the value of a quantity and where in the swept parameters it stands; rows without a result.

Symbols and units are those of the dataset's own variables, so that the sentences are right for datasets in SI too.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.regime_words import status_words
from vibropipe.figures.text import format_number, plain_symbol_of, with_units
from vibropipe.report.parts import DASH, Datasets, Line, Table
from vibropipe.solve.shown_units import shows_cycles
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import VOCABULARY
from vibropipe.words.wording import series

UNSOLVED_HEADING = "Which rows and motions did not end as asked?"
TITLE = "Rows and motions to look at"
LINE = "To look at"  # an inaccurate row has a result, and an unbounded one is known
UNBOUNDED, REMEDY = "unbounded", "There is no steady state: the motion grows without bound."
NOTE = "With the ranges of the parameters in which they lie."
DASHES = " A dash: one motion, or no range."
WIDTHS = ("2.7cm", "auto", "auto", "3.9cm", "1fr")


def unsolved_table(datasets: Datasets) -> Table | None:
    """Return a table of all rows and motions with a status other than ok; None if `unsolved_line` tells them."""
    rows = _all_unsolved(datasets)
    head = ["scene", "status", "rows", "among", "what to do"]
    note = NOTE + DASHES * any(DASH in row for row in rows)
    return Table(head, rows, note, WIDTHS, left=5, title=TITLE) if len(rows) > 1 else None


def unsolved_line(datasets: Datasets) -> Line:
    """Return the line on the rows of one status, or the motion, without a result; empty without or with several."""
    rows = _all_unsolved(datasets)
    if len(rows) != 1:
        return Line(LINE, "")
    ((name, status, number, where, remedy),) = rows
    amount = f" {number} rows," if number != DASH else ""
    place = f" at {where}," if where != DASH else ""
    # of what is still changing, or grows, nothing is to be done
    is_left = status in (status_words(Status.MAX_PERIODS), UNBOUNDED)
    todo = "" if is_left else f". {remedy.replace('`', '')}"
    return Line(LINE, f"“{name}”:{amount}{place} {status}{todo}", plain=True)


def _all_unsolved(datasets: Datasets) -> list[list[str]]:
    return [row for name, dataset in datasets.items() for row in unsolved_rows(name, dataset)]


def unsolved_rows(name: str, dataset: xr.Dataset) -> list[list[str]]:
    """Return a row of the table for each status other than ok of a scene; aperiodic motions are results."""
    if "status" not in dataset:
        return []
    status = dataset["status"]
    rows = []
    for mask, words, remedy in _not_as_asked(dataset):
        amount = int(mask.sum())
        which = f"all {amount:,}" if amount == status.size > 1 else f"{amount:,} of {status.size:,}"
        number = which if status.ndim else DASH
        # numbers of attractors mean nothing to a reader
        among = mask.any("attractor_id") if "attractor_id" in mask.dims else mask
        where = extent_text(among) or DASH
        rows.append([name, words, number, where, remedy])
    return rows


def _not_as_asked(dataset: xr.Dataset) -> Iterator[tuple[xr.DataArray, str, str]]:
    """Yield the mask, the words and the remedy of each status other than ok; unbounded motions apart."""
    status = dataset["status"]
    for code in np.unique(status.values[status.values != Status.OK]).tolist():
        mask = status == code
        if "regime" in dataset and code == Status.MAX_PERIODS:
            mask &= dataset["regime"] != Regime.APERIODIC  # a motion that is known, in a window
            grows = mask & (dataset["regime"] == Regime.UNBOUNDED)
            if grows.any():
                yield grows, UNBOUNDED, REMEDY
            mask &= ~grows
        if mask.any():
            yield mask, status_words(code), Status(code).remedy


# Symbol in mathtext -> the same in plain text.
PLAIN = {entry.symbol: entry.plain for entry in VOCABULARY.values() if entry.plain}


def symbol_text(array: xr.DataArray) -> str:
    """Return the symbol of a variable in plain text; its name if it has none."""
    symbol = str(array.attrs.get("symbol", array.name))
    if shows_cycles(array):
        return plain_symbol_of(array)
    return PLAIN.get(symbol, symbol.strip("$").replace("\\", ""))


def value_text(array: xr.DataArray, value: Any, digits: int = 4) -> str:
    """Write a value of a variable with its unit."""
    return with_units(array, format_number(float(value), digits))


def equal_text(array: xr.DataArray, value: Any, digits: int = 4) -> str:
    """Write that a variable has a value: `ν = 1.2`."""
    return f"{symbol_text(array)} = {value_text(array, value, digits)}"


def at_text(coordinates: Iterable[xr.DataArray]) -> str:
    """Write a point of the grid, given by its scalar coordinates, text last: `ν = 1.2, f = 0.5, upwards`."""
    ordered = sorted(coordinates, key=is_text)
    return ", ".join(
        text_of(one) if is_text(one) else equal_text(one, one.item()) for one in ordered
    )


def text_of(array: xr.DataArray) -> str:
    """Write a scalar coordinate that is text; a direction is `upwards` or `downwards`."""
    return f"{array.item()}wards" if array.name == "direction" else str(array.item())


def is_text(array: xr.DataArray) -> bool:
    """Return whether the values of a coordinate are text, such as directions."""
    return array.dtype.kind in "UOT"


def point_text(values: xr.DataArray, dims: Iterable[Hashable] | None = None) -> str:
    """Write the coordinates of a scalar array in `dims` (default: all that it has)."""
    names = values.coords if dims is None else [name for name in dims if name in values.coords]
    return at_text(values[name] for name in names)


def largest(values: xr.DataArray) -> xr.DataArray | None:
    """Return the value of the largest modulus with its coordinates; None if no value is finite."""
    size = abs(values.where(np.isfinite(values)))
    if not bool(size.notnull().any()):
        return None
    if not values.ndim:
        return values
    return values.isel({str(k): int(v) for k, v in size.argmax(...).items()})


def range_text(array: xr.DataArray, values: np.ndarray) -> str:
    """Write the range of some values of a coordinate: `ν = 0.3 … 1.2`."""
    low, high = values.min(), values.max()
    if low == high:
        return equal_text(array, low)
    return f"{symbol_text(array)} = {format_number(float(low))} … {value_text(array, high)}"


def extent_text(mask: xr.DataArray) -> str:
    """Write in which ranges of the coordinates a mask is true; empty of a mask without dimensions."""
    texts = []
    for position, dim in enumerate(mask.dims):
        others = tuple(n for n in range(mask.ndim) if n != position)
        array = mask[dim]
        kept = array.values[mask.values.any(axis=others)]
        if is_text(array):
            words = [text_of(one) for one in array if one.item() in kept]
            texts.append(" and ".join(dict.fromkeys(words)))
        else:
            texts.append(range_text(array, kept))
    return ", ".join(texts)


def place_texts(
    dataset: xr.Dataset, top: xr.DataArray, among: Iterable[Hashable] | None = None
) -> list[str]:
    """Write the point of a largest value, with what is an end of a range, and the same in fewer letters.

    ν = 1 and, at the end of its range, f = 2; or ν = 1 and the largest f. `among` are the dimensions that matter
    (default: all).
    """
    names = dataset["regime"].dims if among is None else among
    dims = [name for name in names if not is_text(dataset[name])]
    alone = point_text(top, dims)
    ends = {
        name: "smallest" if top[name].item() == dataset[name].min().item() else "largest"
        for name in dims
        if dataset.sizes[name] > 2
        and top[name].item() in (dataset[name].min().item(), dataset[name].max().item())
    }
    inner = [name for name in dims if name not in ends]
    if not ends:
        return [alone]
    where = "the end of its range" if len(ends) == 1 else "the ends of their ranges"
    short = [f"the {end} {symbol_text(dataset[name])}" for name, end in ends.items()]
    if not inner:
        return [f"{alone}, {where}", series(short)]
    first = point_text(top, inner)
    return [f"{first} and, at {where}, {point_text(top, ends)}", series([first, *short])]
