"""Where free motions without losses begin to strike a support, in closed form and in the units of a dataset."""

from __future__ import annotations

import math

import xarray as xr

from vibropipe.solve.shown_units import in_si, shown_factor
from vibropipe.words.vocabulary import held_name


def longest_period(dataset: xr.Dataset, delta_over_l: float) -> float:
    """Return the period at which a motion touches the farther support: 2 arccos(-(1 - |d|) / (1 + |d|)), d = delta/l.

    Motions of every shorter period strike both supports, eq. (10).
    """
    off = abs(delta_over_l)
    period = 2.0 * math.acos(max(-1.0, -(1.0 - off) / (1.0 + off)))
    if not {"m", "C"} <= set(dataset.coords):
        return period
    unit = str(dataset[held_name(dataset, "tau_bar")].attrs.get("units", "s"))
    m, C = (float(in_si(dataset[name])) for name in ("m", "C"))
    return period * math.sqrt(m / C) * shown_factor(unit)


def first_strikes(dataset: xr.Dataset) -> tuple[float, float]:
    """Return the amplitudes from which motions strike the nearer and the farther support."""
    numbers = {
        name: float(in_si(dataset[name])) if name in dataset.coords else absent
        for name, absent in (("l", math.nan), ("delta", 0.0), ("load", 0.0), ("C", 1.0))
    }
    offset = abs(numbers["delta"] - numbers["load"] / numbers["C"])
    factor = shown_factor(str(dataset["amplitude"].attrs.get("units", "1")))
    return factor * (numbers["l"] - offset), factor * (numbers["l"] + offset)
