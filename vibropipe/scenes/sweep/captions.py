"""Captions of the pictures of a sweep, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    NO_CURVES,
    REGIME_TEXT,
    UNRESOLVED_TEXT,
    format_number,
    grid_text,
    plain_parameters,
    regime_name,
    sentences,
)
from vibropipe.scenes.sweep.curves import axis_and_others, panels_of, row_kinds, swept
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import PLAIN_SYMBOLS
from vibropipe.words.wording import count, series


def describe_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> str:
    """Return the caption of the curves: parameters, largest first harmonic, and rows drawn as marks."""
    along, others = axis_and_others(dataset)
    lines = series(f"{PLAIN_SYMBOLS[name]} = {grid_text(dataset[name].values)}" for name in others)
    backbone_text = "Wide grey line: conservative exciter" if backbone is not None else ""
    quantities = {name for _, name, _ in panels_of(dataset, show)}
    has_harmonics = not quantities or "displacement_amplitude" in quantities
    return sentences(
        f"Steady states against {PLAIN_SYMBOLS[along]}" + (f" for {lines}" if lines else ""),
        "" if quantities else NO_CURVES,
        (peak_text(dataset) if has_harmonics else "") or velocity_text(dataset),
        row_kinds_text(dataset, show),
        unresolved_text(dataset),
        backbone_text,
    )


def peak_text(dataset: xr.Dataset) -> str:
    """Write the maximum of the first harmonic of displacement."""
    if "displacement_amplitude" not in dataset:
        return ""
    first = dataset["displacement_amplitude"].isel(harmonic=0)
    if not bool(np.isfinite(first).any()):
        return ""
    return f"The maximum of the first harmonic is {format_number(float(first.max()))}, at {location_text(first)}"


def location_text(values: xr.DataArray) -> str:
    """Write the swept parameters at the maximum of an array."""
    at = values.isel({str(k): int(v) for k, v in values.argmax(...).items()})
    return plain_parameters({str(name): at[name].values.item() for name in values.dims})


def row_kinds_text(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Write the numbers of rows that are drawn as marks or not at all."""
    kinds = row_kinds(dataset)
    drawn = bool(panels_of(dataset, show))
    descriptions = [
        ("multiple", "an orbit of m > 1 forcing periods", " (circles)"),
        ("unstable", "an unstable orbit", " (crosses)"),
        ("no_orbit", "no periodic orbit", " (dots: averages)"),
    ]
    amounts = {kind: int(mask.sum()) for kind, mask in kinds.items()}
    text = series(
        f"{amounts[kind]} {'has' if amounts[kind] == 1 else 'have'} {what}{mark if drawn else ''}"
        for kind, what, mark in descriptions
        if amounts[kind]
    )
    total = dataset["regime"].size
    return f"Of {count(total, 'row')}, {text}; bars: regime of each row" if text else ""


def unresolved_text(dataset: xr.Dataset) -> str:
    """Write the number of unresolved rows by reason; empty if there are none."""
    unresolved = dataset["regime"].values == Regime.UNRESOLVED
    if not unresolved.any() or "status" not in dataset:
        return ""
    codes, amounts = np.unique(dataset["status"].values[unresolved], return_counts=True)
    reasons = series(
        f"{UNRESOLVED_TEXT.get(Status(code), Status(code).name.lower())} ({amount})"
        for code, amount in zip(codes.tolist(), amounts.tolist(), strict=True)
    )
    total = count(dataset["regime"].size, "row")
    return f"Unresolved: {int(unresolved.sum())} of {total}: {reasons}"


def describe_map(dataset: xr.Dataset) -> str:
    """Return the caption of the maps: share of each regime, and largest impact velocities."""
    dims = swept(dataset)
    size = " × ".join(str(dataset.sizes[name]) for name in dims)
    names = series(PLAIN_SYMBOLS[name] for name in dims)
    multiple = int((dataset["period_multiple"] > 1).sum()) if "period_multiple" in dataset else 0
    maxima = maxima_text(dataset)
    return sentences(
        f"Steady-state regimes on a {size} grid of {names}: {shares_text(dataset)}",
        f"Dots: orbits of m > 1 forcing periods ({count(multiple, 'cell')})" if multiple else "",
        f"Lower panels: largest impact velocity on each support; its maximum {maxima}"
        if maxima
        else "",
        unresolved_text(dataset),
    )


def shares_text(dataset: xr.Dataset) -> str:
    """Write the share of each regime, the most frequent first."""
    codes, amounts = np.unique(dataset["regime"].values, return_counts=True)
    permutation = np.argsort(-amounts, kind="stable")
    total = dataset["regime"].size
    return series(
        f"{format_number(100 * float(amounts[n]) / total, 3)} % {REGIME_TEXT[regime_name(int(codes[n]))]}"
        for n in permutation
    )


def velocity_text(dataset: xr.Dataset) -> str:
    """Write the maximum of the impact velocity on each support, as a sentence."""
    maxima = maxima_text(dataset)
    return f"The largest impact velocity {maxima}" if maxima else ""


def maxima_text(dataset: xr.Dataset) -> str:
    """Write the maximum of the impact velocity on each support, as the end of a sentence."""
    if "impact_velocity_max" not in dataset:
        return ""
    clauses = []
    for support in dataset["support"].values:
        velocity = dataset["impact_velocity_max"].sel(support=support)
        if bool(np.isfinite(velocity).any()):
            top = format_number(float(velocity.max()))
            clauses.append(f"on support {support} is {top}, at {location_text(velocity)}")
    return series(clauses)
