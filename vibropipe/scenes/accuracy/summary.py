"""Summary of work-precision data: time to reach an accuracy, orders of convergence, failures."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.words.measurements import Outcome

ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
ERRORS = ("error_end", "error_impact_tau", "error_impact_velocity", "error_harmonics")
# Errors from which an order is fitted: smaller ones contain rounding, larger ones are not asymptotic.
CLEAN = (1e-12, 5e-2)
MIN_POINTS, MAX_POINTS = 3, 4


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
    """Return which runs finished with all impacts."""
    return dataset["outcome"] == int(Outcome.OK)


def time_to_reach(dataset: xr.Dataset) -> xr.DataArray:
    """Return the shortest time per forcing period (ns) with an error of at most each of ACCURACIES.

    The result is over (motion, method, accuracy); nan where no successful run is that accurate.
    """
    error, time = worst_error(dataset), dataset["time_per_period"]
    least = [
        time.where(succeeded(dataset) & (error <= accuracy)).min("setting")
        for accuracy in ACCURACIES
    ]
    joined = xr.concat(least, xr.DataArray(list(ACCURACIES), dims="accuracy", name="accuracy"))
    return joined.transpose("motion", "method", "accuracy")


def error_of_order(dataset: xr.Dataset) -> str:
    """Return the error from which orders are fitted: that of the impact times, unless the data lack it."""
    return "error_impact_tau" if "error_impact_tau" in dataset else errors_in(dataset)[0]


def orders(dataset: xr.Dataset) -> xr.DataArray:
    """Return orders of convergence over (motion, method), fitted by least squares.

    The fit uses the MAX_POINTS finest successful runs with an error within CLEAN. The result is nan for
    fewer than MIN_POINTS of them and for methods with a tolerance. Without impacts, the error of the
    end state is used, if the data have it.
    """
    values, setting = dataset[error_of_order(dataset)].values, dataset["setting_value"].values
    if "error_end" in dataset:
        values = np.where(np.isnan(values), dataset["error_end"].values, values)
    good = succeeded(dataset).values & (values > CLEAN[0]) & (values < CLEAN[1])
    order = np.full(values.shape[:2], np.nan)
    for index in np.ndindex(order.shape):
        kept = np.flatnonzero(good[index] & (setting[index[1]] > 1))[-MAX_POINTS:]
        if kept.size >= MIN_POINTS:
            steps, errors = np.log(setting[index[1]][kept]), np.log(values[index][kept])
            order[index] = -np.polyfit(steps, errors, 1)[0]
    return xr.DataArray(order, {n: dataset[n] for n in ("motion", "method")}, ("motion", "method"))


def failures(dataset: xr.Dataset) -> dict[str, dict[Outcome, list[str]]]:
    """Return {method: {outcome of its last setting: motions on which all its settings failed}}."""
    methods: dict[str, dict[Outcome, list[str]]] = {}
    for method in dataset["method"].values:
        runs = dataset.sel({"method": method})["outcome"]
        for motion in dataset["motion"].values:
            codes = runs.sel(motion=motion).values
            tried = codes[codes != Outcome.NOT_TRIED]
            if tried.size and (tried != Outcome.OK).all():
                outcome = Outcome(int(tried[-1]))
                methods.setdefault(str(method), {}).setdefault(outcome, []).append(str(motion))
    return methods
