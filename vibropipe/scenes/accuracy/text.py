"""Captions and conclusions from work-precision data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number, sentences
from vibropipe.scenes.accuracy.summary import (
    ACCURACIES,
    error_of_order,
    errors_in,
    failures,
    of_errors,
    orders,
    succeeded,
    time_to_reach,
    worst_error,
)
from vibropipe.words.measurements import Outcome
from vibropipe.words.wording import count, series

# Texts for one method and for several.
OUTCOME_TEXT = {
    Outcome.MISSED_IMPACT: ("misses impacts", "miss impacts"),
    Outcome.FELL_THROUGH: ("falls through a support", "fall through a support"),
    Outcome.DID_NOT_END: ("does not finish", "do not finish"),
    Outcome.NOT_INSTALLED: ("was not installed", "were not installed"),
}
# What an error is of.
ERROR_TEXT = {
    "error_end": "end state",
    "error_impact_tau": "impact times",
    "error_impact_velocity": "impact velocities",
    "error_harmonics": "harmonics",
}
COARSE, FINE = ACCURACIES[1], ACCURACIES[3]  # accuracies at which times are compared


def error_text(dataset: xr.Dataset, show: Collection[str]) -> str:
    """Write which error is drawn, if it is not the largest of all."""
    texts = [ERROR_TEXT[name] for name in errors_in(of_errors(dataset, show))] if show else []
    return (
        "error"
        + (f" of {series(texts)}" if texts else "")
        + (" (the largest)" if texts[1:] else "")
    )


def left_out_text(dataset: xr.Dataset, show: Collection[str]) -> str:
    """Write which motions have no error that is drawn."""
    drawn = of_errors(dataset, show)["motion"].values
    names = [str(n).replace("_", " ") for n in dataset["motion"].values if n not in drawn]
    return f" Left out, without this error: {series(names)}." if names else ""


def describe_work_precision(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption: what is plotted, then the conclusion."""
    text, left_out = error_text(dataset, show).capitalize(), left_out_text(dataset, show)
    dataset = of_errors(dataset, show)
    return (
        f"{text} against time per forcing period on one core, for "
        f"{count(dataset.sizes['motion'], 'motion')}; numbers: orders of convergence; "
        f"crosses: failed runs.{left_out} {conclusion(dataset)}"
    )


def conclusion(dataset: xr.Dataset) -> str:
    """Return the conclusion from the data as one text."""
    return sentences(*conclusions(dataset))


def conclusions(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the sentences of the conclusion: errors, times, orders of convergence and failures."""
    return (
        exact_text(dataset),
        *(time_ratio_text(dataset, accuracy) for accuracy in (COARSE, FINE)),
        order_text(dataset),
        *failure_text(dataset),
    )


def exact_text(dataset: xr.Dataset) -> str:
    """Write error and time of the exact method."""
    if "exact" not in dataset["method"].values:
        return ""
    one = dataset.sel({"method": ["exact"]})
    errors, times = worst_error(one).values[:, 0, 0], one["time_per_period"].values[:, 0, 0]
    good = succeeded(one).values[:, 0, 0] & np.isfinite(errors)
    if not good.any():
        return "The exact method finished none of the motions"
    worst = int(np.nanargmax(np.where(good, errors, -1.0)))
    return (
        f"The exact method has a median error of {format_number(float(np.median(errors[good])), 2)} (largest: "
        f"{format_number(float(errors[worst]), 2)}, {motion_name(dataset, worst)}) and takes "
        f"{format_number(float(np.median(times[good])), 3)} ns per forcing period (median)"
    )


def motion_name(dataset: xr.Dataset, index: int) -> str:
    """Return the name of a motion, without underscores."""
    return str(dataset["motion"].values[index]).replace("_", " ")


def time_ratio_text(dataset: xr.Dataset, accuracy: float) -> str:
    """Write the times of the methods to reach an accuracy, relative to that of the exact method."""
    if "exact" not in dataset["method"].values:
        return ""
    times = time_to_reach(dataset).sel(accuracy=accuracy)
    exact = times.sel({"method": "exact"}).values
    ratios, faster = [], set[str]()
    for method in dataset["method"].values:
        other = times.sel({"method": method}).values
        both = np.isfinite(exact) & np.isfinite(other)
        if method == "exact" or not both.any():
            continue
        ratio = other[both] / exact[both]
        indices = np.flatnonzero(both)[ratio < 1]
        faster |= {f"{method} on {motion_name(dataset, int(index))}" for index in indices}
        n_motions = count(int(both.sum()), "motion")
        ratios.append(f"{method} {format_number(float(np.median(ratio)), 2)} ({n_motions})")
    if not ratios:
        return f"No other method reaches an error of {format_number(accuracy, 1)}"
    exceptions = f"; faster than exact: {series(sorted(faster))}" if faster else ""
    return (
        f"Time to reach an error of {format_number(accuracy, 1)} relative to the exact method (median over "
        f"the motions that reach it): {series(ratios)}{exceptions}"
    )


def order_text(dataset: xr.Dataset) -> str:
    """Write the orders of convergence of the impact times, or of the error that stands for them."""
    by_method, what = orders(dataset), ERROR_TEXT[error_of_order(dataset)]
    texts = []
    for method in dataset["method"].values:
        values = by_method.sel({"method": method}).values
        values = values[np.isfinite(values)]
        if values.size:
            low, middle, high = (float(q) for q in np.quantile(values, [0, 0.5, 1]))
            texts.append(f"{method} {middle:.1f} (from {low:.1f} to {high:.1f})")
    return f"Orders of convergence of the {what}: {series(texts)}" if texts else ""


def failure_text(dataset: xr.Dataset) -> list[str]:
    """Return a sentence on each way in which methods failed at every setting, with the motions."""
    groups: dict[tuple[Outcome, tuple[str, ...]], list[str]] = {}
    for method, outcomes in failures(dataset).items():
        for outcome, motions in outcomes.items():
            groups.setdefault((outcome, tuple(motions)), []).append(method)
    texts = []
    for (outcome, names), methods in groups.items():
        everywhere = len(names) == dataset.sizes["motion"]
        where = "" if everywhere else f" on {series(name.replace('_', ' ') for name in names)}"
        text = OUTCOME_TEXT[outcome][len(methods) > 1]
        setting = "" if outcome == Outcome.NOT_INSTALLED else ", at every tested setting"
        texts.append(f"{series(methods)} {text}{where}{setting}")
    return texts
