"""Part of the report on backbones: what the free motion without losses does."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import xarray as xr

from vibropipe.figures.text import REGIME_TEXT, format_number, regime_name
from vibropipe.report.findings import Finding, point_text, symbol_text, value_text
from vibropipe.report.table import Datasets
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.wording import series


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each backbone."""
    return [
        Finding((law_text(data) if "velocity_over_l" in data else amplitude_text(data),), name)
        for name, data in datasets.items()
    ]


def law_text(dataset: xr.Dataset) -> str:
    """Write for which periods both supports are struck, for each offset."""
    velocity = dataset["velocity_over_l"]
    (dim,) = velocity.dims[-1:]
    axis = dataset[dim]
    texts = []
    for row in velocity.transpose(..., dim):
        kept = axis.values[np.isfinite(row.values) & (row.values > 0)]
        if kept.size:
            low, high = format_number(float(kept.min())), value_text(axis, kept.max())
            texts.append(f"{low} … {high} ({point_text(row, velocity.dims[:-1])})")
    return (
        f"Free motions strike both supports at {symbol_text(axis)} = {series(texts)}"
        if texts
        else ""
    )


def amplitude_text(dataset: xr.Dataset) -> str:
    """Write the range of the eigenfrequency for each regime along the amplitude."""
    if "eigenfrequency" not in dataset or "amplitude" not in dataset.dims:
        return ""
    ordered = dataset.sortby("amplitude")
    frequency, amplitude = ordered["eigenfrequency"], ordered["amplitude"]
    texts, first = [], 0
    for code, rows in groupby(ordered["regime"].values.tolist()):
        last = first + len(list(rows)) - 1
        part = frequency.values[first : last + 1]
        low, high = format_number(float(part.min())), value_text(frequency, part.max())
        span = f"from {low} to {high}" if format_number(float(part.max())) != low else high
        texts.append(
            f"{span} up to amplitude {value_text(amplitude, amplitude.values[last])} "
            f"({REGIME_TEXT[regime_name(code)]})"
        )
        first = last + 1
    return f"With increasing amplitude the eigenfrequency is {series(texts)}"


REPORT = ReportPart(findings=findings, rank=2)
