"""Summary of work-precision data: error of each run, time to an error, price of a digit."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import drawn_by

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


def curve(dataset: xr.Dataset, method: str) -> tuple[Floats, Floats]:
    """Return errors and times (ns) of the successful runs of a method on one motion, in the order of its settings."""
    one = dataset.sel({"method": method})
    good = succeeded(one).values & np.isfinite(one["time_per_period"].values)
    return worst_error_of(one)[good], one["time_per_period"].values[good]


def worst_error_of(one: xr.Dataset) -> Floats:
    """Return the errors of a single motion and method."""
    return np.asarray(worst_error(one).values, float)


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
    """Return how the time grows for a tenth of the error, from the first run to the last; nan without a trade."""
    if error.size < 2 or not error[-1] < 0.1 * error[0]:
        return float("nan")
    digits = np.log10(error[0] / error[-1])
    return float((time[-1] / time[0]) ** (1.0 / digits))
