"""Summary of work-precision data: error of each run, time to an error, price of a digit; names and marks of methods."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vibropipe.figures.canvas import hairlines, power_ticks, time_ticks
from vibropipe.figures.claims import at_most
from vibropipe.figures.palette import METHODS, MethodStyle
from vibropipe.figures.text import format_number
from vibropipe.report.methods import CRUDE
from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import drawn_by
from vibropipe.words.wording import capitalised

NS = 1e-9
STYLES: Mapping[str, MethodStyle] = {
    **METHODS,
    **{name: METHODS[name.lower()] for name in ("RK45", "DOP853", "Radau")},
    "solve_nivp": METHODS["nivp"],
}
# Names in sentences and tables.
NAMES = {
    "crude": CRUDE,
    "newmark": "Newmark's method",
    "exact": "the exact method",
    "RK45": "scipy's RK45",
    "DOP853": "scipy's DOP853",
    "Radau": "scipy's Radau",
    "heyoka": "heyoka",
    "solve_nivp": "solve-nivp",
}
TIME_UNITS = ((1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns"))
LEAST_ERROR = 1e-16


def capital(text: str) -> str:
    """Return a text with a capital letter, unless it begins with a name that has none."""
    return text if text.startswith(("scipy", "heyoka", "solve")) else capitalised(text)


def time_text(nanoseconds: float) -> str:
    """Write a time in the unit that people use, to two digits: 0.23 µs, 1.5 ms."""
    size, unit = next((s for s in TIME_UNITS if nanoseconds >= 0.1 * s[0]), TIME_UNITS[-1])
    return f"{format_number(float(f'{nanoseconds / size:.2g}'), 4)} {unit}"


def error_text(error: float) -> str:
    """Write an error, rounded up to two digits, as a percentage from 1 % on."""
    if error >= 0.01:
        return f"{at_most(100 * error, 2)} %"
    return at_most(error, 2).removeprefix("1 × ")


def multiple_text(ratio: float, rounded: Callable[[float], float] = np.round) -> str:
    """Write a multiple to two digits, with commas: 1.1, 54, 4,400; rounded as a function does."""
    unit = 10.0 ** (int(np.floor(np.log10(ratio))) - 1)
    value = unit * float(rounded(ratio / unit * (1 + 1e-12)))
    return f"{value:.2g}" if ratio < 10 else f"{value:,.0f}"


def error_axis(ax: Axes, exponents: Iterable[int], worst: float) -> None:
    """Let an axis of errors grow more accurate to the right."""
    ax.set(xscale="log", xlim=(worst, LEAST_ERROR / 5))
    power_ticks(ax, "x", exponents)


def time_axis(ax: Axes, low: float, high: float) -> None:
    """Let an axis show times in seconds, with hairlines."""
    ax.set(yscale="log", ylim=(low, high))
    inside = range(int(np.ceil(np.log10(low))), int(np.floor(np.log10(high))) + 1)
    time_ticks(ax, "y", inside)
    hairlines(ax, "y")


def time_span(dataset: xr.Dataset) -> tuple[float, float]:
    """Return limits of the times (s) of a dataset, with room."""
    times = dataset["time_per_period"].values * NS
    times = times[np.isfinite(times)]
    return (times.min() / 3, times.max() * 3) if times.size else (1e-8, 1e-3)


def motion_title(name: object) -> str:
    """Return the name of a motion in words: figure_6 is that of the paper."""
    text = str(name).replace("_", " ")
    number = text.removeprefix("figure ")
    return f"figure {number} of the paper" if number != text and number.isdigit() else text


def motion_subject(name: object) -> str:
    """Return the same as the beginning of a sentence: The motion of figure 6 of the paper."""
    title = motion_title(name)
    return f"The motion of {title}" if title.startswith("figure ") else capitalised(title)


ERRORS = drawn_by("accuracy")
# Largest error of a run that counts as having solved its motion at all.
LARGEST_ERROR = 1.0

Floats = NDArray[np.float64]


def of_errors(dataset: xr.Dataset, show: Collection[str]) -> xr.Dataset:
    """Return the data with the errors to show alone (default: all), of the motions that have one of them.

    A motion without impacts, for example, has no error of impact times. If no motion has an error, all are kept.
    """
    if not show:
        return dataset
    dataset = dataset.drop_vars([name for name in ERRORS if name not in show])
    has_error = np.isfinite(worst_error(dataset).values).any(axis=(1, 2))
    return dataset.isel(motion=has_error) if has_error.any() else dataset


def errors_in(dataset: xr.Dataset) -> list[str]:
    """Return the names of the errors that the data have."""
    return [name for name in ERRORS if name in dataset]


def worst_error(dataset: xr.Dataset) -> xr.DataArray:
    """Return the largest of the errors of each run, over (motion, method, setting); nan if it has none."""
    columns = np.stack([dataset[name].values for name in errors_in(dataset)])
    is_known = np.isfinite(columns).any(axis=0)
    worst = np.where(is_known, np.nanmax(np.where(is_known, columns, 0.0), axis=0), np.nan)
    return dataset[errors_in(dataset)[0]].copy(data=worst)


def succeeded(dataset: xr.Dataset) -> xr.DataArray:
    """Return which runs finished with all impacts, and no error as large as the motion."""
    return (dataset["outcome"] == int(Outcome.OK)) & (worst_error(dataset) < LARGEST_ERROR)


def failed(dataset: xr.Dataset) -> xr.DataArray:
    """Return which of the runs that were tried did not succeed."""
    return (dataset["outcome"] != int(Outcome.NOT_TRIED)) & ~succeeded(dataset)


def curve(dataset: xr.Dataset, method: str) -> tuple[Floats, Floats]:
    """Return errors and times (ns) of the successful runs of a method on one motion, in the order of its settings."""
    one = dataset.sel({"method": method})
    good = succeeded(one).values & np.isfinite(one["time_per_period"].values)
    return np.asarray(worst_error(one).values, float)[good], one["time_per_period"].values[good]


def time_to_error(error: Floats, time: Floats, wanted: float) -> float:
    """Return the shortest time with an error, interpolated between settings on logarithmic axes; nan if none has it.

    Between a setting that is not accurate enough and the next that is, error and time follow a power law.
    """
    reached = np.flatnonzero(error <= wanted)
    if not reached.size:
        return float("nan")
    times = [float(time[reached].min())]
    for k in reached[reached > 0]:
        if error[k - 1] > wanted:
            part = np.log(wanted / error[k - 1]) / np.log(error[k] / error[k - 1])
            times.append(float(np.exp(np.interp(part, [0, 1], np.log(time[[k - 1, k]])))))
    return min(times)


def times_to_errors(dataset: xr.Dataset, wanted: Sequence[float]) -> dict[str, list[float]]:
    """Return the time (ns) of each method to each error on one motion, nan where no setting has it."""
    return {
        str(method): [time_to_error(*curve(dataset, str(method)), error) for error in wanted]
        for method in dataset["method"].values
    }


def price_of_digit(error: Floats, time: Floats) -> float:
    """Return how the time grows for a tenth of the error, over the last runs; nan if none has ten times the last error.

    Runs before these are left out: what a coarse run costs beside its steps is not the price of a digit.
    """
    coarser = np.flatnonzero(error >= 10 * error[-1]) if error.size else np.empty(0, int)
    if not coarser.size:
        return float("nan")
    first = int(coarser[-1])
    digits = np.log10(error[first] / error[-1])
    return float((time[-1] / time[first]) ** (1.0 / digits))
