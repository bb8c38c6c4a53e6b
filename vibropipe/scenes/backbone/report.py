"""Part of the report on backbones: what the free motion without losses does."""

from __future__ import annotations

import xarray as xr

from vibropipe.figures.claims import rising_text
from vibropipe.report.findings import Finding, largest, symbol_text, value_text
from vibropipe.report.parts import answers_of
from vibropipe.report.table import Datasets
from vibropipe.scenes.backbone.limits import first_strikes, longest_period
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.vocabulary import held_name


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each backbone."""
    return [
        Finding(
            (law_text(data),)
            if "velocity_over_l" in data
            else (amplitude_text(data), frequency_text(data)),
            name,
        )
        for name, data in datasets.items()
    ]


def law_text(dataset: xr.Dataset) -> str:
    """Write for which periods both supports are struck."""
    period = dataset[held_name(dataset, "tau_bar")]
    limits = [longest_period(dataset, float(d)) for d in dataset["delta_over_l"].values]
    low, high = min(limits), max(limits)
    below = f"below {symbol_text(period)} = {value_text(period, high)}"
    if value_text(period, low) != value_text(period, high):
        offset = symbol_text(dataset["delta_over_l"])
        below = f"{below}, a limit that falls to {value_text(period, low)} with the offset {offset}"
    return f"Free motions strike both supports at every period {below}"


def amplitude_text(dataset: xr.Dataset) -> str:
    """Write from which amplitudes the supports are struck."""
    if "eigenfrequency" not in dataset or "amplitude" not in dataset.dims:
        return ""
    limits = first_strikes(dataset)
    near, far = (value_text(dataset["amplitude"], limit) for limit in limits)
    if limits[0] <= 0.0:
        return f"Free motions always strike one support, and both from the amplitude {far} on"
    if near == far:
        return f"Free motions strike both supports from the amplitude {near} on"
    return f"Free motions strike one support from the amplitude {near} on, and both from {far}"


def frequency_text(dataset: xr.Dataset) -> str:
    """Write how far the eigenfrequency rises."""
    if "eigenfrequency" not in dataset or "amplitude" not in dataset.dims:
        return ""
    frequency = dataset["eigenfrequency"]
    top = largest(frequency)
    rises = "" if top is None else rising_text(frequency, top, ("amplitude",))
    return (
        f"The eigenfrequency reaches {value_text(frequency, top)}, where {rises}" if rises else ""
    )


REPORT = ReportPart(
    "Free motion",
    "How does the mass move without force and losses?",
    answers_of(findings),
    rank=2,
)
