"""What a dataset of basins says of its attractors: the swept parameter, where each is, and its laws of motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.text import REGIME_TEXT, regime_name
from vibropipe.report.findings import symbol_text, value_text

# Laws of motion that a text lists; a cascade has more.
MAX_LAWS = 3


class Change(NamedTuple):
    """An attractor that appears or vanishes at a value of the swept parameter; other: -1 if there is none."""

    appears: bool
    value: float
    attractor: int
    other: int


def swept_name(dataset: xr.Dataset) -> str | None:
    """Return the swept parameter of basins, or None."""
    return next((str(dim) for dim in dataset["basin_share"].dims if dim != "attractor_id"), None)


def changes_of(dataset: xr.Dataset) -> list[Change]:
    """Return where attractors appear and vanish, in the order of the values."""
    name = swept_name(dataset)
    columns = (f"bifurcation_{name}", "changed_attractor", "other_attractor")
    values, own, other = (dataset[column].values.tolist() for column in columns)
    appears = dataset["attractor_change"].values == 1
    changes = map(Change, appears.tolist(), values, own, other)
    return sorted(changes, key=lambda change: change.value)


def law_text(regime: int, multiple: int) -> str:
    """Write a law of motion: two-sided, m = 3."""
    law = REGIME_TEXT[regime_name(regime)]
    return f"{law}, m = {multiple}" if multiple else law


def laws_text(dataset: xr.Dataset, index: int) -> str:
    """Write the laws of an attractor with increasing parameter: two-sided, m = 1 to 4; aperiodic."""
    name = swept_name(dataset)
    row = dataset.sel(attractor_id=index)
    if name is not None:
        row = row.isel({name: np.isfinite(row["basin_share"].values)})
    pairs = zip(np.atleast_1d(row["regime"]), np.atleast_1d(row["period_multiple"]), strict=True)
    multiples: dict[int, list[int]] = {}
    for regime, multiple in pairs:
        multiples.setdefault(int(regime), []).append(int(multiple))
    texts = []
    for regime, numbers in list(multiples.items())[:MAX_LAWS]:
        least, most = min(numbers), max(numbers)
        end = f" to {most}" if most > least else ""
        texts.append(law_text(regime, least) + end)
    return "; ".join(texts) + ("; …" if len(multiples) > MAX_LAWS else "")


def presence(dataset: xr.Dataset, index: int) -> np.ndarray:
    """Return at which values of the swept parameter an attractor is."""
    present: np.ndarray = np.isfinite(dataset["basin_share"].sel(attractor_id=index).values)
    return present


def place_text(dataset: xr.Dataset, value: float) -> str:
    """Write a value of the swept parameter: ν = 1.2."""
    axis = dataset[swept_name(dataset)]
    return f"{symbol_text(axis)} = {value_text(axis, value)}"
