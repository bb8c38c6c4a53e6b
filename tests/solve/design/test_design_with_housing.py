"""Designs and tolerances of exciters with a housing that slides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.designs import DesignResult

STRUCK = vp.Exciter(
    nu=1.02, f=0.882, h=0.403, l=1.0, delta=-0.19, R1=0.3, R2=0.55, mass_ratio=0.585,
    housing_friction_1=0.292, housing_friction_2=0.438,
)  # fmt: skip


def test_a_wanted_progression_is_met_by_the_motion_from_the_start():
    ranges = {"housing_friction_2": (0.3, 0.6), "delta": (-0.25, -0.15)}
    found = vp.design(
        STRUCK, ranges, {"housing_velocity_mean": 0.08}, {"impact_velocity_max_1": "< 1"},
        samples=32, designs=3,
    )  # fmt: skip
    assert (found.design_result == DesignResult.MET).all()
    best = found.isel(design=0)
    exciter = replace(STRUCK, **{name: float(best[name]) for name in ranges})
    own = vp.steady_state(exciter, outputs=["impacts"])
    assert float(own.housing_velocity_mean) == pytest.approx(0.08, rel=1e-8)
    assert float(own.impact_velocity_max[0]) < 1.0
    assert "housing" in found.attrs["effects"]


def test_a_design_creeps_as_fast_as_the_best_of_a_grid():
    ranges = {"nu": (1.0, 1.2)}
    found = vp.design(STRUCK, ranges, minimise="-housing_velocity_mean", samples=16, designs=1)
    grid = vp.sweep(STRUCK, {"nu": np.linspace(1.0, 1.2, 81)})
    best = float(grid.housing_velocity_mean.where(grid.period_multiple > 0).max())
    assert best <= float(found.housing_velocity_mean[0]) + 1e-9
    assert float(found.housing_velocity_mean[0]) < best + 1e-3


def test_scattered_parts_creep_as_first_order_says():
    sigma = {"R1": 1e-3, "mass_ratio": 2e-3, "housing_friction_1": 1e-3}
    told = vp.tolerance(STRUCK, sigma, samples=256)
    first, sampled = told.housing_velocity_mean_std.values
    assert sampled == pytest.approx(first, rel=0.03)
    by = told.housing_velocity_mean_sensitivity.sel(parameter="mass_ratio")
    moved = replace(STRUCK, mass_ratio=STRUCK.mass_ratio + 1e-4)
    near = float(vp.steady_state(moved).housing_velocity_mean - told.housing_velocity_mean) / 1e-4
    assert float(by) == pytest.approx(near, rel=1e-2)
    assert float(told.law_change_share) == 0


def test_a_progression_is_not_wanted_of_a_housing_that_is_fixed():
    held = replace(STRUCK, mass_ratio=0.0, housing_friction_1=0.0, housing_friction_2=0.0)
    with pytest.raises(vp.ParameterError) as refused:
        vp.design(held, {"nu": (1.0, 1.2)}, {"housing_velocity_mean": 0.1})
    assert str(refused.value) == (
        "mass_ratio: must be above 0, since housing_velocity_mean is wanted: a housing with 0 is "
        "fixed, got 0.0"
    )


def test_a_measured_progression_identifies_the_friction_on_the_ground():
    measured = vp.sweep(STRUCK, {"nu": np.linspace(1.05, 1.2, 7)}, outputs=["impacts"])
    table = {
        "nu": measured.nu.values,
        "housing_velocity_mean": measured.housing_velocity_mean.values,
    }
    ranges = {"housing_friction_1": (0.2, 0.4), "mass_ratio": (0.4, 0.8)}
    start = replace(STRUCK, housing_friction_1=0.25, mass_ratio=0.7)
    found = vp.identify(start, table, ranges, samples=32)
    for name in ranges:
        assert float(found[name]) == pytest.approx(getattr(STRUCK, name), rel=1e-6)
