"""What to see in the pictures of a sweep, said from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    CURVES_NOT_ASKED,
    REGIME_WORDS,
    UNRESOLVED_WORDS,
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
    """Say what is swept, where the first harmonic peaks, and which rows are no plain orbits."""
    along, others = axis_and_others(dataset)
    lines = series(f"{PLAIN_SYMBOLS[name]} = {grid_text(dataset[name].values)}" for name in others)
    beside = "The wide grey line is the conservative exciter" if backbone is not None else ""
    return sentences(
        f"Steady states against {PLAIN_SYMBOLS[along]}" + (f" for {lines}" if lines else ""),
        "" if panels_of(dataset, show) else CURVES_NOT_ASKED,
        peak_words(dataset) or hardest_words(dataset),
        odd_words(dataset, show),
        unresolved_words(dataset),
        beside,
    )


def peak_words(dataset: xr.Dataset) -> str:
    """Say where the first harmonic of displacement is largest."""
    if "displacement_amplitude" not in dataset:
        return ""
    first = dataset["displacement_amplitude"].isel(harmonic=0)
    if not bool(np.isfinite(first).any()):
        return ""
    return f"The first harmonic is largest, {format_number(float(first.max()))}, at {place_words(first)}"


def place_words(values: xr.DataArray) -> str:
    """Write the swept parameters where ``values`` is largest."""
    at = values.isel({str(k): int(v) for k, v in values.argmax(...).items()})
    return plain_parameters({str(name): float(at[name]) for name in values.dims})


def odd_words(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Count the rows that are drawn as marks or not at all."""
    kinds = row_kinds(dataset)
    drawn = bool(panels_of(dataset, show))
    said = [
        ("multiple", "an orbit of m > 1 forcing periods", " (circles)"),
        ("unstable", "an unstable orbit", " (crosses)"),
        ("no_orbit", "no orbit", " (dots, where an average exists)"),
    ]
    amounts = {kind: int(mask.sum()) for kind, mask in kinds.items()}
    text = series(
        f"{amounts[kind]} {'has' if amounts[kind] == 1 else 'have'} {what}{mark if drawn else ''}"
        for kind, what, mark in said
        if amounts[kind]
    )
    total = dataset["regime"].size
    return f"Of {count(total, 'row')} {text}; the bars show the regime of each" if text else ""


def unresolved_words(dataset: xr.Dataset) -> str:
    """Count the rows without a result that can be relied on, by what went wrong; nothing if there are none."""
    unresolved = dataset["regime"].values == Regime.UNRESOLVED
    if not unresolved.any() or "status" not in dataset:
        return ""
    codes, amounts = np.unique(dataset["status"].values[unresolved], return_counts=True)
    why = series(
        f"{UNRESOLVED_WORDS.get(Status(code), Status(code).name.lower())} ({amount})"
        for code, amount in zip(codes.tolist(), amounts.tolist(), strict=True)
    )
    total = count(dataset["regime"].size, "row")
    return f"Unresolved: {int(unresolved.sum())} of {total}: {why}"


def describe_map(dataset: xr.Dataset) -> str:
    """Say what the cells are, what share each regime takes, and where impacts are hardest."""
    dims = swept(dataset)
    size = " × ".join(str(dataset.sizes[name]) for name in dims)
    over = series(PLAIN_SYMBOLS[name] for name in dims)
    multiple = int((dataset["period_multiple"] > 1).sum()) if "period_multiple" in dataset else 0
    return sentences(
        f"The steady state of {size} exciters over {over}: {shares_words(dataset)}",
        f"Dots: orbits of m > 1 forcing periods ({count(multiple, 'cell')})" if multiple else "",
        "Below: the hardest impact of the orbit on each support" if hardest_words(dataset) else "",
        hardest_words(dataset),
        unresolved_words(dataset),
    )


def shares_words(dataset: xr.Dataset) -> str:
    """Write the share of each regime, the most frequent first."""
    codes, amounts = np.unique(dataset["regime"].values, return_counts=True)
    order = np.argsort(-amounts, kind="stable")
    total = dataset["regime"].size
    return series(
        f"{format_number(100 * float(amounts[n]) / total, 3)} % {REGIME_WORDS[regime_name(int(codes[n]))]}"
        for n in order
    )


def hardest_words(dataset: xr.Dataset) -> str:
    """Say where each support is struck hardest."""
    if "impact_velocity_max" not in dataset:
        return ""
    said = []
    for support in dataset["support"].values:
        struck = dataset["impact_velocity_max"].sel(support=support)
        if bool(np.isfinite(struck).any()):
            top = format_number(float(struck.max()))
            said.append(f"support {support} is struck hardest, {top}, at {place_words(struck)}")
    text = "; ".join(said)
    return text[:1].upper() + text[1:]
