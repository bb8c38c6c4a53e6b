"""Pictures of a backbone: over amplitude, alone or with forced motions, or the curves of eq. (10)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    format_number,
    frequency,
    plain_symbol,
    plain_value,
    scalar_parameters,
    sentences,
)
from vibropipe.report.findings import value_text
from vibropipe.scenes.backbone.curves import (
    draw_amplitude_frequency,
    draw_backbone,
    drawn_kinds,
    first_strikes,
    has_simulated,
    longest_period,
)
from vibropipe.scenes.backbone.keys import BackboneFigure
from vibropipe.scenes.backbone.overlay import draw_overlay
from vibropipe.scenes.kind import Picture, showing
from vibropipe.words.parameters import or_default
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import PLAIN_SYMBOLS, held_name
from vibropipe.words.wording import series

PARAMETERS_OF_FREE = ("l", "delta", "load")


def describe_backbone(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the curves of eq. (10), with the periods where they end."""
    ends = []
    period = held_name(dataset, "tau_bar")
    for position, value in enumerate(dataset["delta_over_l"].values):
        drawn = np.isfinite(dataset["velocity_over_l"].isel(delta_over_l=position).values)
        if drawn.any() and not drawn.all():
            longest = longest_period(dataset, float(value))
            offset = f"{PLAIN_SYMBOLS['delta_over_l']} = {format_number(float(value))}"
            ends.append(f"{value_text(dataset[period], longest)} at {offset}")
    names = {"tau_bar": "the period", "omega_bar": "the frequency"}
    against = series(sided([words for name, words in names.items() if not show or name in show]))
    return sentences(
        f"Relative velocity before the impact on support 1 by eq. (10), against {against} of free vibration with "
        "impacts on both supports",
        f"Both supports are struck at every period below {series(ends)}" if ends else "",
        "Markers: simulated motions" if has_simulated(dataset) else "",
    )


def sided(words: Sequence[str]) -> list[str]:
    """Return the words of two panels with the side on which each is; of one alone, its words."""
    if len(words) < 2:
        return [*words]
    return [f"{text} ({side})" for text, side in zip(words, ("left", "right"), strict=True)]


def describe_amplitude_frequency(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption over amplitude: what is drawn, and which supports are struck in which parts of a curve."""
    struck = {*dataset["regime"].values.tolist()}
    one = [support for support in (1, 2) if Regime[f"ONE_SIDED_{support}"] in struck]
    curves = series(sided(drawn_kinds(dataset, show)))
    return sentences(
        f"Free motion against its frequency: {curves}",
        "Dashed: no support is struck" if Regime.NO_IMPACT in struck else "",
        *(f"On grey: only support {support} is struck" for support in one),
        symmetry_text(dataset),
        ", ".join(plain_value(dataset[n]) for n in PARAMETERS_OF_FREE if n in dataset.coords),
    )


def describe_overlay(free: Sequence[xr.Dataset], forced: Sequence[xr.Dataset]) -> str:
    """Return the caption of free and forced motions on common axes."""
    same = [n for n in PARAMETERS_OF_FREE if n in free[0].coords]
    widths = ", ".join(
        f"{width} for {series(plain_value(data[n]) for n in same)}"
        for width, data in zip(("wide", *["thin"] * len(free)), free, strict=False)
    )
    texts = [
        "Amplitudes of harmonics, and the mean by its modulus where it is not 0",
        f"Grey: free motions without losses, {widths}"
        if len(free) > 1
        else "Grey: free motion without losses",
    ]
    if forced:
        axis = frequency(forced[0])
        others = [n for n in forced[0]["regime"].dims if n not in (axis, "direction")]
        shades = f", dark for large {plain_symbol(str(others[0]))}" if others else ""
        grid = np.diff(forced[0][axis].values)
        step = (
            f" in steps of {value_text(forced[0][axis], abs(grid[0]), 3)}"
            if np.ptp(grid) < 1e-9 * abs(grid[0])
            else ""
        )
        ways = list(forced[0]["direction"].values) if "direction" in forced[0].dims else []
        followed = f", followed {series(f'{way}wards' for way in ways)}" if ways else ""
        texts.append(f"Coloured: steady states{step}{followed}{shades}")
        gaps = any(bool((data["period_multiple"] == 0).any()) for data in forced)
        blue = " of the blue lines" if len(forced) > 1 else ""
        texts.append(f"Arrows: larger jumps{blue}")
        texts.append(f"Gaps: {'no periodic motion, or ' if gaps else ''}a jump")
    return sentences(*texts)


def amplitude_title(dataset: xr.Dataset) -> str:
    """Return how much faster than without impacts the free motion is; empty where it is not always, or not known."""
    near, _ = first_strikes(dataset)
    ordered = dataset.sortby("amplitude")
    frequencies, amplitudes = ordered["eigenfrequency"].values, ordered["amplitude"].values
    quiet, struck = frequencies[amplitudes <= near], frequencies[amplitudes > near]
    if not struck.size:
        return "Free motions of these amplitudes strike no support"
    if not quiet.size or not (struck > quiet[0]).all():
        return ""
    ratio = format_number(float(struck.max() / quiet[0]), 3)
    return f"With impacts the free motion is up to {ratio} times as fast as without"


def backbone_title(dataset: xr.Dataset) -> str:
    """Write how the velocity of impact changes with the period, by eq. (10)."""
    offsets = np.unique(np.abs(dataset["delta_over_l"].values))
    tail = ", and an offset shortens the range of periods" if offsets.size > 1 else ""
    return f"Shorter periods have harder impacts{tail}"


def symmetry_text(dataset: xr.Dataset) -> str:
    """Write whether the mean displacement and the even harmonics vanish."""
    mean = np.abs(dataset["displacement_mean"].values)
    largest = float(np.nanmax(dataset["displacement_amplitude"].values))
    top = int(np.nanargmax(mean))
    if mean[top] <= ROUNDING * largest:
        return "By symmetry the mean displacement and the even harmonics vanish"
    at = value_text(dataset["eigenfrequency"], dataset["eigenfrequency"].values[top], 3)
    largest_text = value_text(dataset["displacement_mean"], mean[top], 3)
    return (
        f"Of these motions the mean displacement is largest, {largest_text}, at the frequency {at}"
    )


def keywords(options: BackboneFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_characteristics`."""
    names = options.together if options is not None else []
    return {**showing(options, others), "together": [others[name] for name in names]}


def draw_characteristics(
    dataset: xr.Dataset, show: Collection[str], together: Collection[xr.Dataset]
) -> Figure:
    """Draw a backbone over amplitude, alone or with the scenes that lie along it."""
    if not together:
        return draw_amplitude_frequency(dataset, show)
    is_of_velocity = show and all(name.startswith("velocity") for name in show)
    name = "velocity" if is_of_velocity else "displacement"
    return draw_overlay(*free_and_forced(dataset, together), name)


def describe_characteristics(
    dataset: xr.Dataset, show: Collection[str], together: Collection[xr.Dataset]
) -> str:
    """Return the caption of the same."""
    if not together:
        return describe_amplitude_frequency(dataset, show)
    return describe_overlay(*free_and_forced(dataset, together))


def free_and_forced(
    dataset: xr.Dataset, together: Collection[xr.Dataset]
) -> tuple[list[xr.Dataset], list[xr.Dataset]]:
    """Return the backbones, that of the least offset first, and the sweeps among a backbone and others."""
    free = [dataset, *(other for other in together if "eigenfrequency" in other)]
    free.sort(key=lambda each: abs(or_default(scalar_parameters(each), "delta")))
    return free, [other for other in together if "eigenfrequency" not in other]


PICTURES = (
    Picture(
        "amplitude_frequency",
        draw_characteristics,
        describe_characteristics,
        lambda dataset: "eigenfrequency" in dataset,
        keywords,
        lambda dataset, show, together: "" if together else amplitude_title(dataset),
    ),
    Picture(
        "backbone",
        draw_backbone,
        describe_backbone,
        lambda dataset: "velocity_over_l" in dataset,
        keywords=showing,
        titled=lambda dataset, show: backbone_title(dataset),
    ),
)
