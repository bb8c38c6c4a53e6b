"""What the pictures of a sweep show: its dimensions, the quantities of its panels, and the kinds of its rows."""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.motion_words import is_unstable
from vibropipe.figures.phase_plane import Impacts
from vibropipe.figures.text import ORDINALS, axis_label, in_brackets, symbol_of
from vibropipe.scenes.keys.parts import MAX_LINES
from vibropipe.solve.in_si import stated_start
from vibropipe.solve.sweep.sweep_grid import DIRECTION
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


def swept(dataset: xr.Dataset) -> list[str]:
    """Return the swept dimensions, in the order of the dataset, without the direction of following."""
    return [str(name) for name in dataset["regime"].dims if name != DIRECTION]


def directions(dataset: xr.Dataset) -> list[str]:
    """Return the directions in which the rows were followed: up, down, both, or none."""
    if DIRECTION in dataset["regime"].dims:
        return [str(value) for value in dataset[DIRECTION].values]
    follow = str(dataset.attrs.get("follow", ""))
    return [follow.split()[-1]] if follow.endswith((" up", " down")) else []


def is_from_rest(dataset: xr.Dataset) -> bool:
    """Return whether each row starts from the equilibrium without velocity."""
    is_at_origin = stated_start(str(dataset.attrs.get("start", ""))) == (0.0, 0.0)
    return is_at_origin and "load" not in dataset and not directions(dataset)


def axis_and_others(dataset: xr.Dataset) -> tuple[str, list[str]]:
    """Return the parameter of the abscissa, which has the finest grid, and the other swept parameters."""
    dims = swept(dataset)
    along = max(dims, key=lambda name: dataset.sizes[name])
    return along, [name for name in dims if name != along]


def is_map(dataset: xr.Dataset) -> bool:
    """Return whether a sweep has more lines than can be distinguished."""
    _, others = axis_and_others(dataset)
    return any(dataset.sizes[name] > MAX_LINES for name in others)


def strikes(dataset: xr.Dataset) -> xr.DataArray:
    """Return where the mass strikes a support: in no row without a result, nor where it lies on one for good."""
    regime = dataset["regime"]
    struck = (regime != Regime.NO_IMPACT) & (regime < Regime.UNBOUNDED)
    if "impacts_per_orbit" not in dataset:
        return struck
    return struck & (
        (regime != Regime.WITH_REST) | (dataset["impacts_per_orbit"].sum("support") > 0)
    )


def with_impacts_per_period(dataset: xr.Dataset) -> xr.Dataset:
    """Return a sweep with `impacts_per_period`, which older datasets have per orbit alone.

    It has no number where a mass comes to rest: before that a chatter has infinitely many impacts.
    """
    if "impacts_per_period" in dataset and "rests_per_orbit" in dataset:
        rate = dataset["impacts_per_period"]
        moves = dataset["rests_per_orbit"] == 0
        return dataset.assign(impacts_per_period=rate.where(moves).assign_attrs(rate.attrs))
    if "impacts_per_period" in dataset or "impacts_per_orbit" not in dataset:
        return dataset
    multiple = dataset.get("period_multiple", xr.ones_like(dataset["regime"]))
    rate = dataset["impacts_per_orbit"] / multiple.where(multiple > 0, 1)
    solved = ~dataset["regime"].isin([Regime.UNRESOLVED, Regime.UNBOUNDED])
    attrs = {"long_name": "impacts per forcing period", "symbol": "$p_s/m$", "units": "1"}
    return dataset.assign(impacts_per_period=rate.where(solved).assign_attrs(attrs))


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


def row_kinds(row: xr.Dataset) -> dict[str, NDArray[np.bool_]]:
    """Return a mask of the points by kind of mark; each point is in exactly one mask."""
    orbit = row["regime"].values < Regime.APERIODIC
    stable = ~is_unstable(row) if "stable" in row else np.ones_like(orbit)
    multiple = np.zeros_like(orbit)
    if "period_multiple" in row:
        multiple = row["period_multiple"].values > 1
    return {
        "line": orbit & stable & ~multiple,
        "multiple": orbit & stable & multiple,
        "unstable": orbit & ~stable,
        "no_orbit": ~orbit,
    }


def exponent_ends(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the ends within which the largest Lyapunov exponent of a row surely lies; 0 where they are rounding."""
    exponent = dataset["lyapunov_exponent"].where(dataset["regime"] < Regime.UNBOUNDED)
    error = SURE * dataset.get("lyapunov_exponent_error", xr.zeros_like(exponent)).fillna(0.0)
    least = ROUNDING * abs(dataset.get(held_name(dataset, "nu"), xr.DataArray(1.0)))
    low, high = exponent - error, exponent + error
    return low.where(abs(low) > least, 0.0), high.where(abs(high) > least, 0.0)


def combinations(dataset: xr.Dataset, dims: list[str]) -> list[dict[str, int]]:
    """Return the indices of all combinations of values of some dimensions; one empty mapping without any."""
    indices = itertools.product(*(range(dataset.sizes[dim]) for dim in dims))
    return [dict(zip(dims, at, strict=True)) for at in indices]


def evenly(items: list[dict[str, int]], most: int) -> list[dict[str, int]]:
    """Return at most `most` items, evenly spaced with both ends."""
    if len(items) <= most:
        return items
    return [items[n] for n in np.unique(np.linspace(0, len(items) - 1, most).round().astype(int))]


def rows_of_impacts(dataset: xr.Dataset) -> NDArray[np.intp]:
    """Return the flat index of the row of each impact, over the dimensions of `regime`."""
    sizes = dataset["row_size"].transpose(*dataset["regime"].dims).values.ravel()
    return np.repeat(np.arange(sizes.size), sizes)


def row_at(dataset: xr.Dataset, index: int) -> xr.Dataset:
    """Return one row by its flat index, with its own impacts alone."""
    dims = dataset["regime"].dims
    at = np.unravel_index(index, dataset["regime"].shape)
    row = dataset.isel(dict(zip(dims, map(int, at), strict=True)))
    if "row_size" not in dataset or "impact" not in dataset.dims:
        return row
    sizes = dataset["row_size"].transpose(*dims).values.ravel()
    first = int(sizes[:index].sum())
    return row.isel(impact=slice(first, first + int(sizes[index])))


def orbit_impacts(row: xr.Dataset) -> Impacts:
    """Return the impacts of one row at fractions of its orbit (of its last forcing periods without one)."""
    if "impact_phase" not in row:
        none = np.empty(0)
        return Impacts(none, np.empty(0, np.int8), none, none)
    before = row["impact_velocity"].values
    support = row["impact_support"].values
    after = -np.where(support == 1, float(row["R1"]), float(row["R2"])) * before
    if "contact_duration" in row:  # a soft support is entered without a jump
        after = np.where(np.isfinite(row["contact_duration"].values), before, after)
    periods = max(1, int(row.get("period_multiple", xr.DataArray(1))))
    time = (row["impact_period"].values + row["impact_phase"].values) / periods
    order = np.argsort(time, kind="stable")
    return Impacts(time[order], support[order], before[order], after[order])
