"""What to see in the pictures of a motion, said from its data."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    IMPACTS_NOT_ASKED,
    NO_SUPPORT_STRUCK,
    REGIME_WORDS,
    SAMPLES_NOT_ASKED,
    departure,
    format_number,
    regime_name,
    sentences,
    times,
)
from vibropipe.scenes.motion.impacts import has_events
from vibropipe.words.wording import series


def describe_motion(dataset: xr.Dataset) -> str:
    """Say how often and how hard a motion strikes, where it grazes and rests, how exact it is."""
    shown = (
        "Displacement and velocity"
        if float(dataset["f"]) == 0.0
        else "Force, displacement and velocity"
    )
    begin, end = float(dataset["tau"][0]), float(dataset["tau"][-1])
    return sentences(
        f"{shown} over τ = {format_number(begin)} … {format_number(end)}",
        impacts_words(dataset),
        grazing_words(dataset),
        rest_words(dataset, shaded=True),
        steady_words(dataset),
        exact_words(dataset),
    )


def describe_impacts(dataset: xr.Dataset) -> str:
    """Say how often and how hard a motion strikes that has no samples."""
    drawn = has_events(dataset)
    return sentences(
        "Velocity before each impact against τ; no samples of the motion were asked for"
        if drawn
        else SAMPLES_NOT_ASKED,
        impacts_words(dataset),
        grazing_words(dataset),
        rest_words(dataset, shaded=drawn),
        steady_words(dataset),
    )


def impacts_words(dataset: xr.Dataset) -> str:
    """Count the impacts on each support, with the hardest."""
    if "impact_tau" not in dataset:
        return IMPACTS_NOT_ASKED
    struck = []
    for support in (1, 2):
        at = dataset["impact_support"].values == support
        if at.any():
            hardest = float(np.abs(dataset["impact_velocity"].values[at]).max())
            struck.append(
                f"support {support} is struck {times(int(at.sum()))} at up to {format_number(hardest)}"
            )
    text = series(struck)
    return text[0].upper() + text[1:] if text else NO_SUPPORT_STRUCK


def grazing_words(dataset: xr.Dataset) -> str:
    """Name the supports that are touched at zero velocity."""
    touched = dataset["grazing_support"].values if "grazing_support" in dataset else np.empty(0)
    said = []
    for support in (1, 2):
        at = touched == support
        if at.any():
            first = format_number(float(dataset["grazing_tau"].values[at][0]))
            said.append(
                f"support {support} is only grazed, touched at zero velocity, "
                f"{times(int(at.sum()))} (first at τ = {first})"
            )
    text = series(said)
    return text[:1].upper() + text[1:]


def rest_words(dataset: xr.Dataset, shaded: bool) -> str:
    """Say how often the mass rests and for how long at most, and whether the picture shades it."""
    if not dataset.sizes.get("rest"):
        return ""
    longest = float(np.max(dataset["rest_end"].values - dataset["rest_start"].values))
    length = "for ever" if np.isinf(longest) else f"for up to {format_number(longest)}"
    text = f"The mass rests on a support {times(dataset.sizes['rest'])}, {length}"
    return f"{text} (shaded)" if shaded else text


def steady_words(dataset: xr.Dataset) -> str:
    """Name the steady state that the motion settles on, where it was asked for."""
    if "regime" not in dataset or dataset["regime"].ndim:
        return ""
    regime = REGIME_WORDS[regime_name(int(dataset["regime"]))]
    multiple = int(dataset["period_multiple"])
    if multiple == 0:
        return f"The motion that settles is {regime}"
    every = "every forcing period" if multiple == 1 else f"every {multiple} forcing periods"
    stable = ""
    if "stable" in dataset:
        stable = " and is stable" if int(dataset["stable"]) else " and is unstable"
    return f"The motion that settles ({regime}) repeats {every}{stable}"


def exact_words(dataset: xr.Dataset) -> str:
    """Compare the motion with the exact one drawn under it."""
    if "displacement_exact" not in dataset:
        return ""
    method = str(dataset.attrs.get("method", "this method"))
    return (
        f"The wide pale line under the curve is the exact motion; {method} departs from it "
        f"by at most {format_number(departure(dataset), 2)} in displacement"
    )
