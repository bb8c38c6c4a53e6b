"""Time to reach an accuracy, orders and failures of small datasets with known answers."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from vibropipe.scenes.accuracy.summary import (
    failures,
    orders,
    time_to_reach,
    worst_error,
)
from vibropipe.words.measurements import Outcome
from vibropipe.words.vocabulary import describe

DIMS = ("motion", "method", "setting")


def made(error, time, outcome=None, setting=None) -> xr.Dataset:
    """Return work-precision data of one motion from (method, setting) arrays."""
    error, time = np.array(error, float)[None], np.array(time, float)[None]
    outcome = (
        np.zeros(error.shape, np.int8) if outcome is None else np.array(outcome, np.int8)[None]
    )
    setting = np.full(error.shape[1:], np.nan) if setting is None else np.array(setting, float)
    nothing = np.full(error.shape, np.nan)
    data = {
        "error_end": (DIMS, error),
        "error_impact_tau": (DIMS, error / 2),
        "error_impact_velocity": (DIMS, nothing),
        "error_harmonics": (DIMS, nothing),
        "time_per_period": (DIMS, time),
        "outcome": (DIMS, outcome),
        "setting_value": (DIMS[1:], setting),
    }
    names = [f"m{i}" for i in range(error.shape[1])]
    return describe(xr.Dataset(data, {"motion": ["one"], "method": names}))


def test_the_worst_error_is_the_largest_that_is_known():
    ds = made([[1e-3, np.nan]], [[1, 1]])
    ds["error_harmonics"][0, 0, 0] = 0.5
    ds["error_impact_tau"][0, 0, 1] = np.nan
    np.testing.assert_array_equal(worst_error(ds).values, [[[0.5, np.nan]]])


def test_the_time_to_reach_is_the_least_of_those_accurate_enough():
    ds = made([[1e-1, 1e-3, 1e-5], [1e-9, 1e-9, 1e-12]], [[1, 10, 100], [70, 50, 60]])
    times = time_to_reach(ds).values[0]
    np.testing.assert_array_equal(times[0], [10, 100, np.nan, np.nan, np.nan])
    np.testing.assert_array_equal(times[1], [50, 50, 50, 50, 60])


def test_failed_runs_reach_nothing():
    failed = [[Outcome.MISSED_IMPACT, Outcome.OK]]
    ds = made([[1e-9, 1e-3]], [[1, 5]], failed)
    np.testing.assert_array_equal(time_to_reach(ds).values[0, 0], [5] + [np.nan] * 4)


@pytest.mark.parametrize("power", [1, 2, 4])
def test_an_order_is_the_power_of_the_step(power):
    steps = np.array([[16.0, 64, 256, 1024]])
    ds = made(1e-2 * (16 / steps) ** power, [[1, 2, 3, 4]], setting=steps)
    assert float(orders(ds)[0, 0]) == pytest.approx(power)


def test_errors_at_rounding_and_coarse_steps_do_not_spoil_an_order():
    steps = np.array([[4.0, 16, 64, 256, 1024, 4096]])
    error = np.array([[0.9, 1e-3, 1e-3 / 16, 1e-3 / 256, 1e-3 / 4096, 1e-14]])
    ds = made(error, [[1] * 6], setting=steps)
    assert float(orders(ds)[0, 0]) == pytest.approx(2)


def test_tolerances_and_lone_points_have_no_order():
    ds = made([[1e-3, 1e-5, 1e-7], [1e-3, 1e-4, np.nan]], [[1, 2, 3]] * 2,
              setting=[[1e-3, 1e-5, 1e-7], [10, 100, np.nan]])  # fmt: skip
    assert np.isnan(orders(ds)).all()


def test_failures_are_those_of_every_setting_tried():
    none, fell, miss = Outcome.NOT_TRIED, Outcome.FELL_THROUGH, Outcome.MISSED_IMPACT
    ds = made(
        np.ones((3, 3)), np.ones((3, 3)), [[fell, miss, none], [fell, Outcome.OK, none], [none] * 3]
    )
    assert failures(ds) == {"m0": {miss: ["one"]}}
