"""Captions of the pictures of a backbone, written from its data."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import format_number, regime_name, sentences
from vibropipe.scenes.backbone.amplitude_frequency import parts
from vibropipe.words.units import plain_units
from vibropipe.words.vocabulary import PLAIN_SYMBOLS, held_name
from vibropipe.words.wording import series


def describe_backbone(dataset: xr.Dataset) -> str:
    """Return the caption of the curves of eq. (10), with the periods where they end."""
    ends = []
    period = held_name(dataset, "tau_bar")
    for position, value in enumerate(dataset["delta_over_l"].values):
        drawn = np.isfinite(dataset["velocity_over_l"].isel(delta_over_l=position).values)
        if drawn.any() and not drawn.all():
            longest = float(dataset[period].values[drawn].max())
            offset = f"{PLAIN_SYMBOLS['delta_over_l']} = {format_number(float(value))}"
            ends.append(f"{shown_value(dataset[period], longest)} at {offset}")
    return sentences(
        "Relative velocity before the impact on support 1 by eq. (10), against the period (left) "
        "and the frequency (right) of free vibration with impacts on both supports",
        f"The largest period with impacts on both supports is {series(ends)}" if ends else "",
        "Markers: simulated motions" if f"simulated_{period}" in dataset else "",
    )


def describe_amplitude_frequency(dataset: xr.Dataset) -> str:
    """Return the caption over amplitude: which supports are struck, up to which frequency."""
    amplitude, frequency = dataset["amplitude"].values, dataset["eigenfrequency"].values
    texts: list[str] = []
    for code, piece in parts(dataset["regime"].values):
        end = shown_value(dataset["amplitude"], amplitude[piece][-1], 3)
        until = f"{'then ' if texts else ''}up to A = {end}"
        reaches = shown_value(dataset["eigenfrequency"], frequency[piece][-1], 3)
        name = regime_name(code)
        if name == "no_impact":
            texts.append(f"{until} no support is reached and the frequency is {reaches}")
        elif name == "two_sided":
            texts.append(f"{until} both supports are struck and the frequency rises to {reaches}")
        else:
            texts.append(
                f"{until} only support {name[-1]} is struck and the frequency rises to {reaches}"
            )
    text = series(texts)
    return sentences(
        "Constant part and first harmonics of displacement (left) and velocity (right) of the free "
        "motion against its frequency",
        text[:1].upper() + text[1:],
        symmetry_text(dataset),
    )


def symmetry_text(dataset: xr.Dataset) -> str:
    """Write whether the constant part and the even harmonics vanish."""
    mean = np.abs(dataset["displacement_mean"].values)
    largest = float(np.nanmax(dataset["displacement_amplitude"].values))
    top = int(np.nanargmax(mean))
    if mean[top] <= ROUNDING * largest:
        return "By symmetry the constant part and the even harmonics vanish"
    at = shown_value(dataset["eigenfrequency"], dataset["eigenfrequency"].values[top], 3)
    largest_text = shown_value(dataset["displacement_mean"], mean[top], 3)
    return f"The constant part is largest, {largest_text}, at the frequency {at}"


def shown_value(array: xr.DataArray, value: float, digits: int = 4) -> str:
    """Write a value of an array with the units that it states."""
    units = str(array.attrs.get("units", "1"))
    tail = "" if units == "1" else f" {plain_units(units)}"
    return format_number(float(value), digits) + tail
