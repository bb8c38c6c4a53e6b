"""Part of the report on backbones: what the free motion without losses does."""

from __future__ import annotations

import xarray as xr

from vibropipe.report.findings import symbol_text, value_text
from vibropipe.report.parts import Answer, of_each
from vibropipe.scenes.backbone.curves import first_strikes, longest_period
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.vocabulary import held_name


def law_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return for which periods both supports are struck."""
    period = dataset[held_name(dataset, "tau_bar")]
    limits = [longest_period(dataset, float(d)) for d in dataset["delta_over_l"].values]
    low, high = (value_text(period, limit) for limit in (min(limits), max(limits)))
    symbol = symbol_text(period)
    if low == high:
        lead = "Free motions of every shorter period strike both supports."
        return [Answer(lead, f"The longest is {symbol} = {low}.")]
    lead = "Free motions strike both supports up to a longest period."
    offset = symbol_text(dataset["delta_over_l"])
    falls = f"It falls from {symbol} = {high} to {low} as {offset} grows in size."
    return [Answer(lead, falls)]


def amplitude_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return from which amplitudes the supports are struck."""
    limits = first_strikes(dataset)
    near, far = (value_text(dataset["amplitude"], limit) for limit in limits)
    lead, rest = f"Free motions strike both supports from amplitude {near} on.", ""
    if limits[0] <= 0.0:
        lead = "Free motions always strike one support."
        rest = f"They strike both from amplitude {far} on."
    elif near != far:
        lead = "Free motions strike one support before both."
        rest = f"One from amplitude {near} on, both from {far}."
    return [Answer(lead, rest)]


answers = of_each(
    lambda data: (law_answers if "velocity_over_l" in data else amplitude_answers)(data)
)
REPORT = ReportPart(
    "Free motion", "How does the mass move without force and losses?", answers, rank=2
)
