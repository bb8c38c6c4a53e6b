"""Captions of the pictures of a motion, written from its data."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.claims import at_most
from vibropipe.figures.motion_words import stability_text, window_text
from vibropipe.figures.regime_words import regime_clause, regime_text
from vibropipe.figures.text import (
    NO_IMPACTS,
    NO_SAMPLES,
    NO_SUPPORT_STRUCK,
    clock,
    departure,
    format_number,
    is_forced,
    parameters_text,
    plain_symbol,
    scalar_parameters,
    sentences,
    times,
    times_of,
    with_units,
)
from vibropipe.scenes.motion.impacts import has_events, is_sampled
from vibropipe.scenes.motion.panels import panel_names, window
from vibropipe.words.parameters import or_default
from vibropipe.words.wording import capitalised, count, series

PANEL_WORDS = {"housing_velocity": "velocity of the housing"}
SAME = 1e-3  # relative difference of speeds that are told as one


def describe_motion(
    dataset: xr.Dataset, show: Collection[str] = (), periods: float | None = None
) -> str:
    """Return the caption of the curves: impacts, grazings, rests, steady state, deviation from exact."""
    curves = capitalised(series(PANEL_WORDS.get(name, name) for name in panel_names(dataset, show)))
    time = dataset[clock(dataset)]
    first, last = window(dataset, periods)
    span = f"{format_number(first)} … {format_number(last)}"
    begin = with_units(time, format_number(float(time[0])))
    rest = f", the end of a record from {begin}" if first > float(time[0]) else ""
    return sentences(
        f"{curves} over {plain_symbol(clock(dataset))} = {with_units(time, span)}{rest}",
        f"In the whole record: {impacts_text(dataset)}" if rest else impacts_text(dataset),
        grazing_text(dataset),
        rest_text(dataset, is_shaded=True),
        steady_text(dataset),
        exact_text(dataset),
        marks_text([dataset]),
        parameters_text(dataset),
    )


def describe_together(datasets: Sequence[xr.Dataset]) -> str:
    """Return the caption of motions on common axes: the parameters that all share, and the marks."""
    values = [scalar_parameters(dataset) for dataset in datasets]
    first = datasets[0]
    differ = [n for n in values[0] if any(or_default(each, n) != values[0][n] for each in values)]
    return sentences(
        f"All: {parameters_text(first, differ)}",
        "Above each column: in which parameters it differs",
        marks_text(datasets),
    )


def marks_text(datasets: Sequence[xr.Dataset]) -> str:
    """Write which mark is an impact on which support, of those that some motions strike."""
    struck = {
        int(s) for each in datasets if "impact_support" in each for s in each["impact_support"]
    }
    marks = {1: "up (orange) on support 1", 2: "down (blue) on support 2"}
    ways = ", ".join(marks[support] for support in sorted(struck))
    hatched = "hatched: beyond the supports"
    return f"Triangles: velocity before an impact, {ways}; {hatched}" if ways else ""


def seen_text(dataset: xr.Dataset) -> str:
    """Write what is seen of a motion, as a title: which supports are struck, how hard, and where it rests."""
    if "impact_support" not in dataset:
        return ""
    velocity, supports = dataset["impact_velocity"], dataset["impact_support"].values
    speeds = {s: np.abs(velocity.values[supports == s]) for s in (1, 2)}
    struck = {support: each for support, each in speeds.items() if each.size}
    grazed = [
        s for s in (1, 2) if "grazing_support" in dataset and s in dataset["grazing_support"].values
    ]
    tails = [f"support {s} is grazed" for s in grazed]
    if dataset.sizes.get("rest"):
        # Without a contact that it ends, a rest for good lasts from the beginning.
        lies = not struck and not grazed and bool(np.isinf(dataset["rest_end"].values).all())
        on = f"lies on support {int(dataset['rest_support'].values[0])} all the time"
        tails.append(f"the mass {on}" if lies else "the mass rests at times")
    hard = with_units(velocity, speeds_text(list(struck.values())))
    tops = {format_number(float(each.max())) for each in struck.values()}
    if not struck or not any(each.max() for each in struck.values()):
        text = f"{NO_SUPPORT_STRUCK} with a velocity" if struck else NO_SUPPORT_STRUCK
    elif len(struck) == 2:
        who = "Both supports" if len(tops) == 1 else "Supports 1 and 2"
        text = f"{who} are struck, {hard}"
    else:
        text = f"Only support {next(iter(struck))} is struck, {hard}"
    return "; ".join([text, *tails])


def speeds_text(speeds: Sequence[NDArray[np.float64]]) -> str:
    """Write the largest speeds on each support, and whether they are those of all impacts."""
    tops = " and ".join(dict.fromkeys(format_number(float(each.max())) for each in speeds))
    is_same = all(each.max() - each.min() <= SAME * each.max() for each in speeds)
    return f"at {tops}" if is_same else f"hardest at {tops}"


def describe_impacts(dataset: xr.Dataset) -> str:
    """Return the caption of the impacts of a motion: impacts, grazings, rests, steady state."""
    drawn = has_events(dataset)
    unsampled = "" if is_sampled(dataset) else "; samples of the motion are not stored"
    reason = "" if is_sampled(dataset) else NO_SAMPLES
    return sentences(
        f"Velocity before each impact against {plain_symbol(clock(dataset))}{unsampled}"
        if drawn
        else reason,
        impacts_text(dataset),
        grazing_text(dataset),
        rest_text(dataset, is_shaded=drawn),
        steady_text(dataset),
        parameters_text(dataset),
    )


def impacts_text(dataset: xr.Dataset) -> str:
    """Write the number of impacts on each support."""
    if "impact_support" not in dataset:
        return NO_IMPACTS
    rested = np.unique(dataset["rest_support"]) if "rest_support" in dataset else np.empty(0)
    if rested.size == 2:
        return "Impacts, with rests, on both supports"
    clauses = []
    for support in (1, 2):
        at = dataset["impact_support"].values == support
        if not at.any():
            continue
        if not dataset["impact_velocity"].values[at].any():
            # a motion that starts at rest on a soft support
            contacts = count(int(at.sum()), "contact")
            clauses.append(f"{contacts} with support {support}, without velocity")
            continue
        impacts = count(int(at.sum()), "impact")
        if support in rested:
            impacts = "impacts, with rests,"
        clauses.append(f"{impacts} on support {support}")
    return capitalised(series(clauses)) or NO_SUPPORT_STRUCK


def grazing_text(dataset: xr.Dataset) -> str:
    """Write the number of grazings on each support and the time of the first."""
    grazed = dataset["grazing_support"].values if "grazing_support" in dataset else np.empty(0)
    clauses = []
    for support in (1, 2):
        at = grazed == support
        if at.any():
            tau = times_of(dataset, "grazing")
            first = with_units(tau, format_number(float(tau.values[at][0])))
            clauses.append(
                f"support {support} is grazed (contact at zero velocity) {times(int(at.sum()))}, "
                f"first at {plain_symbol(clock(dataset))} = {first}"
            )
    return capitalised(series(clauses))


def rest_text(dataset: xr.Dataset, is_shaded: bool) -> str:
    """Write the number of rests and the longest duration, and whether they are shaded."""
    if not dataset.sizes.get("rest"):
        return ""
    lengths = dataset["rest_end"].values - dataset["rest_start"].values
    ended = lengths[np.isfinite(lengths)]
    clauses = []
    if ended.size:
        clauses.append(f"for up to {with_units(dataset['rest_end'], at_most(ended.max(), 4))}")
    if ended.size < lengths.size:
        clauses.append(
            "at last until the end of the record" if clauses else "until the end of the record"
        )
    text = f"The mass rests on a support {times(lengths.size)}, {series(clauses)}"
    return f"{text} (shaded)" if is_shaded else text


def steady_text(dataset: xr.Dataset) -> str:
    """Write regime, period multiple and stability of the steady state, if the data have one."""
    if "regime" not in dataset or dataset["regime"].ndim:
        return ""
    regime = regime_text(int(dataset["regime"]))
    multiple = int(dataset["period_multiple"])
    if multiple == 0:
        window = window_text(dataset)
        return f"No periodic steady state was found: the motion is {regime} {window}".rstrip()
    parts = [regime_clause(regime)]
    if is_forced(dataset):
        parts.append(f"repeats after {count(multiple, 'forcing period')}")
    if "stable" in dataset:
        parts.append(f"is {stability_text(dataset)}")
    return f"The steady state {series(parts)}"


def exact_text(dataset: xr.Dataset) -> str:
    """Write the largest deviation from the exact motion drawn under the curve."""
    if "displacement_exact" not in dataset:
        return ""
    return (
        "Pale line: exact solution; the displacement by Newmark's method differs from it "
        f"by at most {with_units(dataset['displacement'], at_most(departure(dataset), 2))}"
    )
