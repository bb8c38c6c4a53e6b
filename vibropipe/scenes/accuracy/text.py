"""What a race of methods shows, in sentences made from its numbers."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    format_number,
)
from vibropipe.scenes.accuracy.summary import (
    ACCURACIES,
    failures,
    orders,
    sound,
    time_to_reach,
    worst_error,
)
from vibropipe.words.measurements import Outcome
from vibropipe.words.wording import count, series

# for one method, for several
OUTCOME_WORDS = {
    Outcome.MISSED_IMPACT: ("misses impacts", "miss impacts"),
    Outcome.FELL_THROUGH: ("falls through a support", "fall through a support"),
    Outcome.DID_NOT_END: ("does not end", "do not end"),
    Outcome.NOT_INSTALLED: ("was not installed", "were not installed"),
}
COARSE, FINE = ACCURACIES[1], ACCURACIES[3]


def describe_work_precision(dataset: xr.Dataset) -> str:
    """Say what is drawn, then what it shows."""
    return (
        f"Error against time per forcing period on one core, on "
        f"{count(dataset.sizes['motion'], 'motion')}; numbers at lines are orders of convergence, "
        f"crosses are runs that failed. {conclusion(dataset)}"
    )


def conclusion(dataset: xr.Dataset) -> str:
    """Draw the conclusion from a race: every number and every name in it comes from the data."""
    said = [
        exact_words(dataset),
        against_words(dataset),
        order_words(dataset),
        *failure_words(dataset),
    ]
    return " ".join(f"{text}." for text in said if text)


def has(dataset: xr.Dataset, method: str) -> bool:
    """Tell whether a method took part."""
    return method in dataset["method"].values


def exact_words(dataset: xr.Dataset) -> str:
    """Say how exact the exact method is and what it costs."""
    if not has(dataset, "exact"):
        return ""
    one = dataset.sel({"method": ["exact"]})
    errors, times = worst_error(one).values[:, 0, 0], one["time_per_period"].values[:, 0, 0]
    good = sound(one).values[:, 0, 0]
    if not good.any():
        return "The exact method got through none of the motions"
    worst = int(np.nanargmax(np.where(good, errors, -1.0)))
    return (
        f"The exact method errs by {format_number(float(np.median(errors[good])), 2)} (median), at most by "
        f"{format_number(float(errors[worst]), 2)} ({named(dataset, worst)}), in "
        f"{format_number(float(np.median(times[good])), 3)} ns per forcing period (median)"
    )


def named(dataset: xr.Dataset, place: int) -> str:
    """Name a motion."""
    return str(dataset["motion"].values[place]).replace("_", " ")


def against_words(dataset: xr.Dataset) -> str:
    """Compare the time of the exact method with what the others need for fewer digits."""
    if not has(dataset, "exact"):
        return ""
    said = [text for accuracy in (COARSE, FINE) if (text := needed_words(dataset, accuracy))]
    return ". ".join(said)


def needed_words(dataset: xr.Dataset, accuracy: float) -> str:
    """Say how much longer than exact each method takes for an error of ``accuracy``."""
    times = time_to_reach(dataset).sel(accuracy=accuracy)
    mine = times.sel({"method": "exact"}).values
    said, quicker = [], set[str]()
    for method in dataset["method"].values:
        theirs = times.sel({"method": method}).values
        both = np.isfinite(mine) & np.isfinite(theirs)
        if method == "exact" or not both.any():
            continue
        ratio = theirs[both] / mine[both]
        places = np.flatnonzero(both)[ratio < 1]
        quicker |= {f"{method} on {named(dataset, int(place))}" for place in places}
        often = count(int(both.sum()), "motion")
        said.append(f"{method} {format_number(float(np.median(ratio)), 2)} ({often})")
    if not said:
        return f"No other method gets to an error of {format_number(accuracy, 1)}"
    less = f"; less than exact needs {series(sorted(quicker))}" if quicker else ""
    return (
        f"For an error of {format_number(accuracy, 1)} the others take, as a multiple of the exact "
        f"method's time and on the motions where they get there: {series(said)}{less}"
    )


def order_words(dataset: xr.Dataset) -> str:
    """Say with which power of the step the errors of impact times fall."""
    found = orders(dataset)
    said = []
    for method in dataset["method"].values:
        values = found.sel({"method": method}).values
        values = values[np.isfinite(values)]
        if values.size:
            low, middle, high = (float(q) for q in np.quantile(values, [0, 0.5, 1]))
            said.append(f"{method} {middle:.1f} (from {low:.1f} to {high:.1f})")
    return f"Orders of convergence of the impact times: {series(said)}" if said else ""


def failure_words(dataset: xr.Dataset) -> list[str]:
    """Say which methods failed at every setting, on which motions and how."""
    together: dict[tuple[Outcome, tuple[str, ...]], list[str]] = {}
    for method, ways in failures(dataset).items():
        for outcome, motions in ways.items():
            together.setdefault((outcome, tuple(motions)), []).append(method)
    said = []
    for (outcome, where_all), methods in together.items():
        everywhere = len(where_all) == dataset.sizes["motion"]
        where = "" if everywhere else f" on {series(m.replace('_', ' ') for m in where_all)}"
        words = OUTCOME_WORDS[outcome][len(methods) > 1]
        said.append(f"{series(methods)} {words}{where}, at every setting tried")
    return said
