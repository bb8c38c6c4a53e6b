"""Quantities of a sweep that are rounding, and what is shown of rows without an orbit."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from figures.sample_datasets import sweep

import vibropipe as vp
from vibropipe.scenes.sweep.captions import describe_quantities, describe_sweep
from vibropipe.scenes.sweep.curves import draw_sweep
from vibropipe.scenes.sweep.maps import draw_quantity_maps, map_series, without_orbit_texts
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.scenes.sweep.titles import quantities_title
from vibropipe.words.regimes import Regime


@pytest.fixture(scope="module")
def symmetric() -> xr.Dataset:
    """Return a map of symmetric orbits, whose means are rounding."""
    exciter = vp.Exciter(l=0.5, h=0.1, R1=0.7, R2=0.7)
    over = {"nu": np.linspace(1.2, 1.6, 9), "f": np.linspace(0.5, 0.6, 9)}
    return vp.sweep(exciter, over)


def test_maps_of_rounding_are_zero(symmetric: xr.Dataset) -> None:
    assert 0.0 < abs(symmetric.displacement_mean).max() < 1e-14
    told = describe_quantities(symmetric)
    assert "and 0 (mean displacement)." in told
    assert "× 10⁻" not in told
    assert "blue negative" not in told
    figure = draw_quantity_maps(symmetric)
    assert all(abs(end) > 1e-3 or end == 0.0 for ax in figure.axes for end in ax.get_ylim())
    # nor do orbits with such means have the largest one beside a motion without an orbit, which has one
    chaos = symmetric.copy(deep=True)
    chaos["regime"][4, 4] = Regime.APERIODIC
    chaos["displacement_mean"][4, 4] = 0.1
    chaos["displacement_mean"][4, 5] = 2e-16
    assert "mean" not in quantities_title(chaos, ["impact_velocity_max", "displacement_mean"])


def test_a_largest_mean_beside_aperiodic_motion_is_one_of_the_displacement(
    symmetric: xr.Dataset,
) -> None:
    chaos = symmetric.copy(deep=True)
    chaos["regime"][4, 4] = Regime.APERIODIC
    chaos["displacement_mean"][4, 5] = 0.2
    title = "On the grid, orbits have the largest mean displacement beside aperiodic motion"
    assert quantities_title(chaos, ["displacement_mean"]) == title
    chaos["impact_velocity_max"][4, 5] = 9.0
    both = quantities_title(chaos)
    assert "strike hardest and have the largest mean beside" in both


def test_curves_of_rounding_alone_are_not_scaled_to_it(symmetric: xr.Dataset) -> None:
    (ax, *_) = draw_sweep(symmetric.isel(f=0), show=["displacement_mean"]).axes
    assert min(abs(end) for end in ax.get_ylim()) > 1e-3
    exciter = vp.Exciter(
        l=0.5, f=0.5, h=0.1, R1=0.7, R2=0.7, mass_ratio=0.4, housing_friction_1=5.0, housing_friction_2=5.0,
    )  # fmt: skip
    held = vp.sweep(exciter, {"nu": np.linspace(1.2, 1.6, 9)})
    assert 0.0 <= abs(held.housing_velocity_mean).max() < 1e-14 < held.housing_velocity_max.max()
    (ax, *_) = draw_sweep(held, show=["housing_velocity_mean"]).axes
    assert min(abs(end) for end in ax.get_ylim()) > 1e-3


def test_largest_values_in_a_window_are_no_averages() -> None:
    chaos = sweep(30, f=np.linspace(0.05, 2, 25)).copy(deep=True)
    chaos["regime"][3, 4:6] = Regime.APERIODIC
    chaos = chaos.assign(support_force_max=chaos["displacement_mean"])
    shown = [Series("displacement_mean"), Series("support_force_max")]
    _, text = without_orbit_texts(chaos, shown)
    assert text == "Without an orbit: the largest value and the average in a window"
    line = chaos.isel(f=4)
    assert "averages" not in describe_sweep(line)
    assert "no periodic orbit that was found (dots: in a window)" in describe_sweep(line)


def test_a_map_without_impacts_is_of_what_changes_over_it() -> None:
    exciter = vp.Exciter(l=50.0, h=0.1, R1=0.7, R2=0.7)
    free = vp.sweep(exciter, over={"nu": [0.5, 1.0, 1.5], "f": [0.2, 0.4]})
    assert [each.name for each in map_series(free)] == ["displacement_amplitude"]
    assert [each.name for each in map_series(free, ["displacement_mean"])] == ["displacement_mean"]


def test_quantities_without_a_value_or_zero_have_no_scale() -> None:
    """Friction holds the mass in all rows, at rest."""
    held = vp.Exciter(l=0.5, nu=1.0, h=0.1, R1=0.7, R2=0.7, friction=0.5)
    over = {"f": [0.1, 0.2, 0.3], "nu": [0.8, 1.0]}
    maps = draw_quantity_maps(vp.sweep(held, over=over))
    assert len(maps.axes) == 2
    for ax, text in zip(maps.axes, ("no impact", "0"), strict=True):
        assert text in [each.get_text() for each in ax.texts]
    curves = draw_sweep(vp.sweep(held, over={"f": over["f"]}))
    amplitudes, mean, struck, impacts = curves.axes[:4]
    assert [ax.get_ylim()[0] for ax in (amplitudes, impacts)] == [0.0, 0.0]
    assert [list(ax.get_yticks()) for ax in (amplitudes, mean, struck, impacts)] == [
        [0.0],
        [0.0],
        [],
        [0.0],
    ]
