"""Errors, times to an error and prices of digits of small datasets with known answers."""

import numpy as np
import pytest
import xarray as xr

from vibropipe.scenes.accuracy.summary import (
    curve,
    price_of_digit,
    succeeded,
    time_to_error,
    times_to_errors,
    worst_error,
)
from vibropipe.scenes.accuracy.text import answers
from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import describe

DIMS = ("motion", "method", "setting")


def made(error, time, outcome=None) -> xr.Dataset:
    """Return work-precision data of one motion from (method, setting) arrays."""
    error, time = np.array(error, float)[None], np.array(time, float)[None]
    outcome = (
        np.zeros(error.shape, np.int8) if outcome is None else np.array(outcome, np.int8)[None]
    )
    nothing = np.full(error.shape, np.nan)
    data = {
        "error_end": (DIMS, error),
        "error_impact_tau": (DIMS, error / 2),
        "error_impact_velocity": (DIMS, nothing),
        "error_harmonics": (DIMS, nothing),
        "time_per_period": (DIMS, time),
        "outcome": (DIMS, outcome),
    }
    names = [f"m{i}" for i in range(error.shape[1])]
    return describe(xr.Dataset(data, {"motion": ["one"], "method": names}))


def test_the_worst_error_is_the_largest_that_is_known():
    ds = made([[1e-3, np.nan]], [[1, 1]])
    ds["error_harmonics"][0, 0, 0] = 0.5
    ds["error_impact_tau"][0, 0, 1] = np.nan
    np.testing.assert_array_equal(worst_error(ds).values, [[[0.5, np.nan]]])


def test_a_run_succeeds_with_all_impacts_and_an_error_below_the_motion():
    failed = [[Outcome.MISSED_IMPACT, Outcome.OK, Outcome.OK]]
    ds = made([[1e-9, 1e-3, 1.5]], [[1, 5, 7]], failed)
    assert succeeded(ds).values[0, 0].tolist() == [False, True, False]
    error, time = curve(ds.isel(motion=0), "m0")
    assert (error.tolist(), time.tolist()) == ([1e-3], [5.0])


@pytest.mark.parametrize("power", [1, 2, 4])
def test_times_are_interpolated_by_the_power_law_of_a_method(power):
    steps = np.array([16.0, 64, 256])
    error = 1e-2 * (16 / steps) ** power
    wanted = 1e-2 / 8**power  # of 128 steps
    assert time_to_error(error, 10 * steps, wanted) == pytest.approx(1280)
    # an error that the first setting has already costs that setting, and one that none has nothing
    assert time_to_error(error, 10 * steps, 0.5) == 160
    assert np.isnan(time_to_error(error, 10 * steps, 1e-12))


def test_the_time_to_an_error_is_the_least_where_errors_are_not_monotonous():
    error, time = np.array([1e-1, 1e-4, 1e-2, 1e-5]), np.array([1.0, 10.0, 20.0, 40.0])
    assert time_to_error(error, time, 1e-4) == 10.0
    assert times_to_errors(made([error], [time]).isel(motion=0), [1e-4]) == {"m0": [10.0]}


def test_the_price_of_a_digit_is_the_growth_of_time_for_a_tenth_of_the_error():
    steps = np.array([16.0, 64, 256])
    assert price_of_digit(1 / steps**2, steps) == pytest.approx(np.sqrt(10))
    assert price_of_digit(1 / steps, steps) == pytest.approx(10)
    # 50 steps of time are spent beside the steps: the last digit costs its steps and little else
    steps = 16.0 * 2.0 ** np.arange(11)
    digits = np.log10(16)
    last = (50 + steps[-1]) / (50 + steps[-3])
    assert price_of_digit(1 / steps**2, 50 + steps) == pytest.approx(last ** (1 / digits))
    assert price_of_digit(1 / steps**2, 50 + steps) == pytest.approx(np.sqrt(10), rel=0.01)
    for error in ([], [1e-3], [1e-3, 2e-4], [1e-3, 1.0]):
        assert np.isnan(price_of_digit(np.array(error), np.ones(len(error))))


def test_a_race_without_the_exact_method_says_who_leaves_the_least_error():
    race = made([[1e-2, 1e-4], [1e-3, np.nan]], [[3e3, 8e5], [1e3, 1e9]])
    race = race.assign_coords(method=["newmark", "RK45"])
    (answer,) = answers(race)
    assert answer.lead.startswith("Newmark's method leaves the least error: ")
    assert answer.rest == "That run takes 0.8 ms a period."
    (lost,) = answers(
        race.assign(
            error_end=race["error_end"] * np.nan, error_impact_tau=race["error_end"] * np.nan
        )
    )
    assert lost.lead == "No method solves this motion."
