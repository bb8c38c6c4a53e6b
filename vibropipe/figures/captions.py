"""What to see in a figure, said from its data in plain text.

A caption that the study's author wrote stands instead of these.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.amplitude_frequency import parts
from vibropipe.figures.impacts import has_events
from vibropipe.figures.options import Options
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.sweep import axis_and_rest, panels_of, row_kinds, swept
from vibropipe.figures.text import (
    CURVES_NOT_ASKED,
    IMPACTS_NOT_ASKED,
    NO_SUPPORT_STRUCK,
    PLAIN_SYMBOLS,
    REGIME_WORDS,
    SAMPLES_NOT_ASKED,
    UNRESOLVED_WORDS,
    number,
    plain_parameters,
    regime_name,
)
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.wording import count, series

FEW_VALUES = 8


def sentences(*parts: str) -> str:
    """Join what there is to say, each part a sentence without its full stop."""
    return " ".join(f"{part}." for part in parts if part)


def describe_motion(dataset: xr.Dataset, options: Options) -> str:
    """Say how often and how hard a motion strikes, where it grazes and rests, how exact it is."""
    shown = (
        "Displacement and velocity"
        if float(dataset["f"]) == 0.0
        else "Force, displacement and velocity"
    )
    begin, end = float(dataset["tau"][0]), float(dataset["tau"][-1])
    return sentences(
        f"{shown} over τ = {number(begin)} … {number(end)}",
        impacts_words(dataset),
        grazing_words(dataset),
        rest_words(dataset, shaded=True),
        steady_words(dataset),
        exact_words(dataset),
    )


def describe_impacts(dataset: xr.Dataset, options: Options) -> str:
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
                f"support {support} is struck {times(int(at.sum()))} at up to {number(hardest)}"
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
            first = number(float(dataset["grazing_tau"].values[at][0]))
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
    length = "for ever" if np.isinf(longest) else f"for up to {number(longest)}"
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
        f"by at most {number(departure(dataset), 2)} in displacement"
    )


def departure(dataset: xr.Dataset) -> float:
    """Return the largest difference in displacement from the exact motion."""
    return float(np.abs(dataset["displacement"] - dataset["displacement_exact"]).max())


def times(amount: int) -> str:
    """Write how often: once, twice, 7 times."""
    return {1: "once", 2: "twice"}.get(amount, f"{amount} times")


def describe_backbone(dataset: xr.Dataset, options: Options) -> str:
    """Say where the curves of eq. (10) end and how near the simulated motions lie."""
    ends = []
    for position, value in enumerate(dataset["delta_over_l"].values):
        drawn = np.isfinite(dataset["velocity_over_l"].isel(delta_over_l=position).values)
        if drawn.any() and not drawn.all():
            longest = float(dataset["tau_bar"].values[drawn].max())
            ends.append(
                f"{number(longest)} at {PLAIN_SYMBOLS['delta_over_l']} = {number(float(value))}"
            )
    return sentences(
        "Relative velocity before the impact on support 1 by eq. (10), against the period (left) "
        "and the frequency (right) of the free vibration; drawn where both supports are struck",
        f"The longest period drawn is {series(ends)}" if ends else "",
        "Markers: simulated motions" if "simulated_tau_bar" in dataset else "",
    )


def describe_amplitude_frequency(dataset: xr.Dataset, options: Options) -> str:
    """Say from which amplitude on each support is struck, and what that does to the frequency."""
    amplitude, frequency = dataset["amplitude"].values, dataset["eigenfrequency"].values
    said: list[str] = []
    for code, piece in parts(dataset["regime"].values):
        until = f"{'then ' if said else ''}up to A = {number(float(amplitude[piece][-1]), 3)}"
        reaches = number(float(frequency[piece][-1]), 3)
        name = regime_name(code)
        if name == "no_impact":
            said.append(f"{until} no support is reached and the frequency is 1 at any amplitude")
        elif name == "two_sided":
            said.append(f"{until} both supports are struck and the frequency grows to {reaches}")
        else:
            said.append(
                f"{until} only support {name[-1]} is struck, the frequency reaches {reaches}"
            )
    text = series(said)
    return sentences(
        "Constant part and first harmonics of displacement (left) and velocity (right) of the free "
        "motion against its frequency",
        text[:1].upper() + text[1:],
        even_words(dataset),
    )


def even_words(dataset: xr.Dataset) -> str:
    """Say whether the constant part and the even harmonics vanish."""
    mean = np.abs(dataset["displacement_mean"].values)
    largest = float(np.nanmax(dataset["displacement_amplitude"].values))
    top = int(np.nanargmax(mean))
    if mean[top] <= ROUNDING * largest:
        return "By symmetry the constant part and the even harmonics vanish"
    at = number(float(dataset["eigenfrequency"].values[top]), 3)
    return f"The constant part is largest, {number(float(mean[top]), 3)}, at the frequency {at}"


def describe_sweep(dataset: xr.Dataset, options: Options) -> str:
    """Say what is swept, where the first harmonic peaks, and which rows are no plain orbits."""
    along, rest = axis_and_rest(dataset)
    lines = series(f"{PLAIN_SYMBOLS[name]} = {grid_words(dataset[name].values)}" for name in rest)
    beside = "The wide grey line is the conservative exciter" if options.beside is not None else ""
    return sentences(
        f"Steady states against {PLAIN_SYMBOLS[along]}" + (f" for {lines}" if lines else ""),
        "" if panels_of(dataset) else CURVES_NOT_ASKED,
        peak_words(dataset) or hardest_words(dataset),
        odd_words(dataset),
        unresolved_words(dataset),
        beside,
    )


def grid_words(values: np.ndarray) -> str:
    """Write a grid: its values, or where there are many its ends and their number."""
    if values.size <= FEW_VALUES:
        return ", ".join(number(float(value)) for value in values)
    return f"{number(float(values.min()))} … {number(float(values.max()))} ({values.size} values)"


def peak_words(dataset: xr.Dataset) -> str:
    """Say where the first harmonic of displacement is largest."""
    if "displacement_amplitude" not in dataset:
        return ""
    first = dataset["displacement_amplitude"].isel(harmonic=0)
    if not bool(np.isfinite(first).any()):
        return ""
    return f"The first harmonic is largest, {number(float(first.max()))}, at {place_words(first)}"


def place_words(values: xr.DataArray) -> str:
    """Write the swept parameters where ``values`` is largest."""
    at = values.isel({str(k): int(v) for k, v in values.argmax(...).items()})
    return plain_parameters({str(name): float(at[name]) for name in values.dims})


def odd_words(dataset: xr.Dataset) -> str:
    """Count the rows that are drawn as marks or not at all."""
    kinds = row_kinds(dataset)
    drawn = bool(panels_of(dataset))
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


def describe_map(dataset: xr.Dataset, options: Options) -> str:
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
        f"{number(100 * float(amounts[n]) / total, 3)} % {REGIME_WORDS[regime_name(int(codes[n]))]}"
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
            top = number(float(struck.max()))
            said.append(f"support {support} is struck hardest, {top}, at {place_words(struck)}")
    text = "; ".join(said)
    return text[:1].upper() + text[1:]
