"""The quantities that the pictures of a sweep show: in panels, as series, and in words."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibropipe.figures.text import ORDINALS, axis_label, in_brackets, symbol_of
from vibropipe.scenes.sweep.sweep_rows import with_impacts_per_period
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import (
    ENERGIES,
    OF_SOFT,
    STEADY,
    VOCABULARY,
    drawn_by,
    held_name,
    quantity,
)

DEFAULT_SHOW = (
    "housing_velocity_mean",
    "displacement_amplitude",
    "displacement_mean",
    "impact_velocity_max",
    "impacts_per_period",
)
ENERGY_SHOW = tuple(name for name in drawn_by("sweep") if name in ENERGIES)
MAX_HARMONICS = 3
LETTER_CM = 0.135  # usual width of a letter of 8 pt, with some room
SYMBOL_LETTERS = 3
# Quantities that may be negative; the axis of any other starts at zero. Of complex ones the magnitude is drawn.
SIGNED = {name for name, entry in STEADY.items() if entry.is_signed and not entry.is_complex}
WORKS = ("energy_", "power_")
# Numbers that are counted.
COUNTED = {name for name, entry in STEADY.items() if entry.goal == "law"}
# Quantities whose sign matters: a line marks their zero.
WITH_ZERO_LINE = {"lyapunov_exponent"}
# Standard errors by which an exponent is surely not 0, and rounding of exponents of neutral motions, of the frequency.
SURE, ROUNDING = 3, 1e-9


@dataclass(frozen=True)
class Series:
    """One element of a quantity: `position` along its own dimension `dim`, None if it is a scalar of the row.

    With a `dim` and without a `position` it is the largest of all elements.
    """

    name: str
    dim: str | None = None
    position: int | None = None
    text: str = ""

    def of(self, dataset: xr.Dataset) -> xr.DataArray:
        """Return its values over the swept dimensions of a dataset; magnitudes of complex ones."""
        array = dataset[self.name]
        if self.dim is not None and self.position is None:
            return array.max(self.dim, keep_attrs=True)
        if self.dim is not None:
            array = array.isel({self.dim: self.position})
        if array.dtype.kind == "c":
            array = abs(array).rename(self.name).assign_attrs(array.attrs)
        return array


@dataclass(frozen=True)
class Panel:
    """The series that share an ordinate."""

    series: tuple[Series, ...]

    @property
    def is_higher_harmonic(self) -> bool:
        """Whether it is a harmonic beyond the first alone."""
        own = self.series[0]
        return "harmonic" in (own.dim or "") and (own.position or 0) > 0

    def title(self, dataset: xr.Dataset, width_cm: float) -> str:
        """Return what is drawn in words, with symbol and units as far as they fit on a line."""
        own = self.series[0]
        return fitted_title(dataset, own if len(self.series) == 1 else Series(own.name), width_cm)


def wrapped(text: str, width: int) -> list[str]:
    """Break a text into lines of at most `width` letters; a symbol counts as SYMBOL_LETTERS."""
    lines: list[list[str]] = [[]]
    length = 0
    for token in re.findall(r"\$[^$]*\$\S*|\S+", text):
        size = SYMBOL_LETTERS if token.startswith("$") else len(token)
        if lines[-1] and length + 1 + size > width:
            lines.append([])
            length = 0
        length += size + (1 if lines[-1] else 0)
        lines[-1].append(token)
    return [" ".join(line) for line in lines]


def of_orbits(dataset: xr.Dataset, own: Series) -> xr.DataArray:
    """Return an element of a quantity in the rows with an orbit: that of a window is no maximum."""
    return own.of(with_impacts_per_period(dataset)).where(dataset["regime"] < Regime.APERIODIC)


def series_of(dataset: xr.Dataset, name: str) -> list[Series]:
    """Return the series of a quantity: one for each support, multiplier or of the first harmonics."""
    array, rows = dataset[name], dataset["regime"].dims
    own = [str(dim) for dim in array.dims if dim not in rows]
    if not own:
        return [Series(name, text=symbol_of(array))]
    dim = own[0]
    amount = min(array.sizes[dim], MAX_HARMONICS if "harmonic" in dim else array.sizes[dim])
    numbers = dataset[dim].values if dim in dataset.coords else np.arange(1, amount + 1)
    texts = [f"support {n}" if dim == "support" else symbol_of(array, int(n)) for n in numbers]
    return [Series(name, dim, n, text) for n, text in enumerate(texts[:amount])]


def panels_of(dataset: xr.Dataset, show: Collection[str] = (), joined: bool = False) -> list[Panel]:
    """Return the panels of the quantities to show that the data have.

    dataset : a sweep, with `impacts_per_period`
    show : quantities (default: DEFAULT_SHOW; of both supports the larger one, and no impacts per period, unless
        joined)
    joined : whether the elements of a quantity share a panel
    """
    panels = []
    for name in dict.fromkeys(show or DEFAULT_SHOW):
        if not is_shown(dataset, name):
            continue
        series = series_of(dataset, name)
        if joined:
            panels.append(Panel(tuple(series)))
        elif show:
            panels += [Panel((each,)) for each in series]
        elif name == "impact_velocity_max":
            panels.append(Panel((Series(name, "support", None),)))
        elif name == "displacement_amplitude" and is_shown(dataset, DEFAULT_SHOW[0]):
            # what the housing does takes the place of the third
            panels += [Panel((each,)) for each in series[:2]]
        elif name != "impacts_per_period":
            panels += [Panel((each,)) for each in series]
    return panels


def is_shown(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a row has a value of a quantity; works of an effect that are all 0 are none (soft supports)."""
    if name not in dataset or has_no_value(dataset, name):
        return False
    needs_effect = name in STEADY and STEADY[name].effect and name.startswith(WORKS)
    return not (needs_effect and not np.nan_to_num(dataset[name].values).any())


def has_no_value(dataset: xr.Dataset, name: str) -> bool:
    """Return whether no row has a value of a quantity; a panel of impacts says that there are none."""
    of_impacts = name in ("impact_velocity_max", *OF_SOFT)
    return not of_impacts and not np.isfinite(dataset[name].values).any()


def series_words(dataset: xr.Dataset, series: Series) -> str:
    """Return one element of a quantity in words: `largest velocity before impact, support 1`."""
    words = axis_label(dataset[series.name]).partition("$")[0].partition(" (")[0].strip()
    if series.dim is None:
        return words
    if series.position is None:
        return f"{words}, either {series.dim}"
    number = element_number(dataset, series)
    if series.dim == "support":
        return f"{words}, support {number}"
    if "harmonic" in series.dim and number <= len(ORDINALS):
        return f"{ORDINALS[number - 1]} {words}"
    return f"{words} {number}"


def element_number(dataset: xr.Dataset, series: Series) -> int:
    """Return the number of one element of a quantity, such as that of a support or harmonic."""
    position = series.position or 0
    if series.dim in dataset.coords:
        return int(dataset[series.dim].values[position])
    return position + 1


def fitted_title(dataset: xr.Dataset, series: Series, width_cm: float) -> str:
    """Return words, symbol and units of one element of a quantity as far as they fit on a line."""
    array = dataset[series.name]
    number = None if series.position is None else element_number(dataset, series)
    symbol = symbol_of(array, number)
    words = series_words(dataset, series)
    texts = [f"{words} {symbol}".strip(), words, symbol or words]
    if series.dim == "support":
        texts = [*texts[series.position is None : 2], f"{symbol}, {words.rpartition(', ')[2]}"]
    elif series.dim is not None and " harmonic" in words:
        texts.insert(2, f"{words.partition(' harmonic')[0]} harmonic {symbol}")
    return first_fitting(texts, array, width_cm)


def fitted_label(array: xr.DataArray, width_cm: float) -> str:
    """Return words, symbol and units of a coordinate as far as they fit on a line; the symbol says of what it is."""
    words, symbol = axis_label(array).partition("$")[0].partition(" (")[0].strip(), symbol_of(array)
    both = words if symbol == words else f"{words} {symbol}".strip()  # equal of a name of one's own
    short = f"{words.partition(' of ')[0]} {symbol}" if symbol != words else words
    return first_fitting([both, short, words, symbol or words], array, width_cm)


def first_fitting(texts: list[str], array: xr.DataArray, width_cm: float) -> str:
    """Return the first text that fits with its units, else the last one."""
    for text in texts:
        shown = in_brackets(text, array)
        letters = len(re.sub(r"\$[^$]*\$", "x" * SYMBOL_LETTERS, shown))
        if letters * LETTER_CM <= width_cm:
            break
    return shown


def family_size(dataset: xr.Dataset, name: str, among: Iterable[str] | None = None) -> float:
    """Return the largest magnitude of quantities with the first word and the dimension of one; no sample counts.

    among : their names (default: all in the dataset)
    """
    size = 0.0
    for other in map(str, dataset.data_vars if among is None else among):
        is_known = other in dataset and other in VOCABULARY
        if is_known and family_of(other) == family_of(name) and is_of_rows(dataset[other]):
            values = np.abs(dataset[other].values)
            size = max(size, float(values[np.isfinite(values)].max(initial=0.0)))
    return size


def is_of_rows(array: xr.DataArray) -> bool:
    """Return whether an array has few values for each row: no samples of a motion, sections or impacts one by one."""
    return not {"phase", "visit", "impact"} & {*array.dims}


def family_of(name: str) -> tuple[str, str]:
    """Return the first word and the dimension of a quantity; those of one family are comparable."""
    return name.partition("_")[0], quantity(name).dimension


def without_rounding(dataset: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Return a sweep in which values of some quantities that are rounding are 0."""
    found = {
        name: dataset[name].where(
            ~(abs(dataset[name]) <= ROUNDING * family_size(dataset, name)), 0.0
        )
        for name in names
        if dataset[name].dtype.kind == "f"
    }
    return dataset.assign(
        {name: each.assign_attrs(dataset[name].attrs) for name, each in found.items()}
    )


def exponent_ends(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the ends within which the largest Lyapunov exponent of a row surely lies; 0 where they are rounding."""
    exponent = dataset["lyapunov_exponent"].where(dataset["regime"] < Regime.UNBOUNDED)
    error = SURE * dataset.get("lyapunov_exponent_error", xr.zeros_like(exponent)).fillna(0.0)
    least = ROUNDING * abs(dataset.get(held_name(dataset, "nu"), xr.DataArray(1.0)))
    low, high = exponent - error, exponent + error
    return low.where(abs(low) > least, 0.0), high.where(abs(high) > least, 0.0)
