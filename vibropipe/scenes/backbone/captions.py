"""Captions of the pictures of a backbone, written from its data."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import format_number, regime_name, sentences
from vibropipe.scenes.backbone.amplitude_frequency import parts
from vibropipe.words.vocabulary import PLAIN_SYMBOLS
from vibropipe.words.wording import series


def describe_backbone(dataset: xr.Dataset) -> str:
    """Return the caption of the curves of eq. (10), with the periods where they end."""
    ends = []
    for position, value in enumerate(dataset["delta_over_l"].values):
        drawn = np.isfinite(dataset["velocity_over_l"].isel(delta_over_l=position).values)
        if drawn.any() and not drawn.all():
            longest = float(dataset["tau_bar"].values[drawn].max())
            ends.append(
                f"{format_number(longest)} at {PLAIN_SYMBOLS['delta_over_l']} = {format_number(float(value))}"
            )
    return sentences(
        "Relative velocity before the impact on support 1 by eq. (10), against the period (left) "
        "and the frequency (right) of free vibration with impacts on both supports",
        f"The largest period with impacts on both supports is {series(ends)}" if ends else "",
        "Markers: simulated motions" if "simulated_tau_bar" in dataset else "",
    )


def describe_amplitude_frequency(dataset: xr.Dataset) -> str:
    """Return the caption over amplitude: which supports are struck, up to which frequency."""
    amplitude, frequency = dataset["amplitude"].values, dataset["eigenfrequency"].values
    texts: list[str] = []
    for code, piece in parts(dataset["regime"].values):
        until = (
            f"{'then ' if texts else ''}up to A = {format_number(float(amplitude[piece][-1]), 3)}"
        )
        reaches = format_number(float(frequency[piece][-1]), 3)
        name = regime_name(code)
        if name == "no_impact":
            texts.append(f"{until} no support is reached and the frequency is 1")
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
    at = format_number(float(dataset["eigenfrequency"].values[top]), 3)
    return (
        f"The constant part is largest, {format_number(float(mean[top]), 3)}, at the frequency {at}"
    )
