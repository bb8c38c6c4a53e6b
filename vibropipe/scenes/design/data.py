"""What pictures and tables of designs show: the wanted quantities, and parameters by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.text import in_brackets, symbol_of
from vibropipe.words.vocabulary import PHYSICAL_NAMES

# Quantities shown where no goal names any.
USUAL = ("displacement_mean", "displacement_amplitude_1", "impact_velocity_max_1")
INNER = ("support", "harmonic", "multiplier")
ENDS = ("target", "lower", "upper")


class Part(NamedTuple):
    """One number of a vector quantity: its variable, and the label along its own dimension, if any."""

    variable: str
    dim: str = ""
    label: int = 0

    @property
    def name(self) -> str:
        """Its name with index."""
        return f"{self.variable}_{self.label}" if self.dim else self.variable

    def of(self, dataset: xr.Dataset, suffix: str = "") -> xr.DataArray:
        """Return its values, or those of a quantity derived from it."""
        values = dataset[self.variable + suffix]
        return values.sel({self.dim: self.label}) if self.dim else values

    def symbol(self, dataset: xr.Dataset) -> str:
        """Return its symbol as mathtext."""
        return symbol_of(dataset[self.variable], self.label or None)

    def words(self, dataset: xr.Dataset) -> str:
        """Return its long name and symbol, with the support that it is of."""
        return (
            f"{dataset[self.variable].attrs.get('long_name', self.variable)} {self.short(dataset)}"
        )

    def plain_words(self, dataset: xr.Dataset) -> str:
        """Return its long name as plain text, with the support or harmonic that it is of."""
        name = dataset[self.variable].attrs.get("long_name", self.variable.replace("_", " "))
        return f"{name} ({self.dim} {self.label})" if self.dim else str(name)

    def short(self, dataset: xr.Dataset) -> str:
        """Return its symbol, with the support that it is of."""
        return self.symbol(dataset) + (f", support {self.label}" if self.dim == "support" else "")

    def label_text(self, dataset: xr.Dataset, short: bool = False) -> str:
        """Return the label of an axis: words or symbol, and the unit."""
        text = self.short(dataset) if short else self.words(dataset)
        return in_brackets(text, dataset[self.variable])

    def end(self, dataset: xr.Dataset, which: str) -> float:
        """Return its target, lower or upper bound; NaN without one."""
        if f"{self.variable}_{which}" not in dataset:
            return float("nan")
        return float(self.of(dataset, f"_{which}"))


def wanted_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the parts with a target or a bound, then those to be least; the usual ones if there are none."""
    found: list[Part] = []
    for name in map(str, dataset.data_vars):
        stem, _, end = name.rpartition("_")
        if end in ENDS and stem in dataset:
            values = dataset[name]
            dim = str(values.dims[0]) if values.dims else ""
            labels = (
                [int(n) for n in values[dim].values[np.isfinite(values.values)]] if dim else [0]
            )
            found += [Part(stem, dim, label) for label in labels]
    found += [Part(name) for name in ("displacement_misfit",) if name in dataset]
    named = [text.removeprefix("-") for text in objectives(dataset)]
    found += [part for name in named for part in [part_of(dataset, name)] if part]
    return list(dict.fromkeys(found or usual_parts(dataset)))


def usual_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the usual quantities that a dataset has."""
    return [part for name in USUAL for part in [part_of(dataset, name)] if part]


def spread_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the wanted quantities whose spread is known; the usual ones if there are none."""
    for parts in (wanted_parts(dataset), usual_parts(dataset)):
        if kept := [part for part in parts if f"{part.variable}_contribution" in dataset]:
            return kept
    return []


def objectives(dataset: xr.Dataset) -> list[str]:
    """Return the quantities to be least, as they are written."""
    return str(dataset.attrs.get("minimise", "")).split("; ") if "minimise" in dataset.attrs else []


def part_of(dataset: xr.Dataset, name: str) -> Part | None:
    """Return a quantity of a dataset by its name with index; None if it is another one."""
    if name in dataset:
        return Part(name)
    if PHYSICAL_NAMES.get(name) in dataset:
        return Part(PHYSICAL_NAMES[name])
    stem, _, label = name.rpartition("_")
    if stem in dataset and label.isdigit():
        dims = [str(dim) for dim in dataset[stem].dims if dim in INNER]
        return Part(stem, dims[0], int(label)) if dims else None
    return None


def varied(dataset: xr.Dataset) -> list[str]:
    """Return the names of the varied parameters."""
    return str(dataset.attrs["vary"]).split()


def numbers(dataset: xr.Dataset) -> np.ndarray:
    """Return the numbers of the designs, from 1."""
    return np.arange(1, dataset.sizes["design"] + 1)


def has_spread(dataset: xr.Dataset) -> bool:
    """Return whether tolerances of parameters were given."""
    return "law_change_share" in dataset


def has_yield(dataset: xr.Dataset) -> bool:
    """Return whether it is known how many scattered parts keep all that is wanted."""
    return "yield" in dataset


def has_tolerances(dataset: xr.Dataset) -> bool:
    """Return whether the tolerances that parameters need were asked for."""
    return "tolerance_result" in dataset
