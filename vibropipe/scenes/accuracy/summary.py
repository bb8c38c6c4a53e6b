"""What a race of methods comes to: time to reach an accuracy, orders of convergence, failures."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.words.measurements import Outcome

ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
ERRORS = ("error_end", "error_impact_tau", "error_impact_velocity", "error_harmonics")
# Errors between which an order is read off: below rounding enters, above steps are too coarse.
CLEAN = (1e-12, 5e-2)
MIN_POINTS, MAX_POINTS = 3, 4


def worst_error(dataset: xr.Dataset) -> xr.DataArray:
    """Largest of the errors of each run, over (motion, method, setting); nan where it has none."""
    columns = np.stack([dataset[name].values for name in ERRORS])
    known = np.isfinite(columns).any(axis=0)
    worst = np.where(known, np.nanmax(np.where(known, columns, 0.0), axis=0), np.nan)
    return dataset["error_end"].copy(data=worst)


def sound(dataset: xr.Dataset) -> xr.DataArray:
    """Whether each run got through, with every impact."""
    return dataset["outcome"] == int(Outcome.OK)


def time_to_reach(dataset: xr.Dataset) -> xr.DataArray:
    """Least time per forcing period, in ns, with an error of at most each of ACCURACIES.

    Over (motion, method, accuracy); nan where no sound run of the method is that accurate.
    """
    error, time = worst_error(dataset), dataset["time_per_period"]
    least = [
        time.where(sound(dataset) & (error <= accuracy)).min("setting") for accuracy in ACCURACIES
    ]
    joined = xr.concat(least, xr.DataArray(list(ACCURACIES), dims="accuracy", name="accuracy"))
    return joined.transpose("motion", "method", "accuracy")


def orders(dataset: xr.Dataset, error: str = "error_impact_tau") -> xr.DataArray:
    """Power of the step with which an error falls, over (motion, method), by least squares.

    From the MAX_POINTS finest sound runs of the methods in steps whose error is within CLEAN; nan
    for fewer than MIN_POINTS of them, and for methods that are set by a tolerance. Where no support
    is struck, the end state stands for impacts.
    """
    end, setting = dataset["error_end"].values, dataset["setting_value"].values
    values = dataset[error].values
    values = np.where(np.isnan(values), end, values)
    good = sound(dataset).values & (values > CLEAN[0]) & (values < CLEAN[1])
    found = np.full(values.shape[:2], np.nan)
    for place in np.ndindex(found.shape):
        kept = np.flatnonzero(good[place] & (setting[place[1]] > 1))[-MAX_POINTS:]
        if kept.size >= MIN_POINTS:
            steps, errors = np.log(setting[place[1]][kept]), np.log(values[place][kept])
            found[place] = -np.polyfit(steps, errors, 1)[0]
    return xr.DataArray(found, {n: dataset[n] for n in ("motion", "method")}, ("motion", "method"))


def failures(dataset: xr.Dataset) -> dict[str, dict[Outcome, list[str]]]:
    """For each method the motions on which all its settings failed, by how the last one failed."""
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
