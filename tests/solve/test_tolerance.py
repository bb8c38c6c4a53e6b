"""Tolerances: first order against samples, closed forms and large samples of the true model."""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
SIGMA = {"delta": 0.0005, "R1": 0.002, "f": 0.002}


@pytest.fixture(scope="module")
def spread():
    return vp.tolerance(EXCITER, SIGMA, samples=1024)


def test_the_linear_motion_has_its_closed_form():
    # Amplitude |f| / sqrt((1 - nu^2)^2 + h^2 nu^2) without impacts, by f alone.
    exciter = vp.Exciter(l=5.0, nu=0.7, f=0.2, h=0.1)
    spread = vp.tolerance(exciter, {"f": 1e-3}, samples=64)
    gain = 1 / np.hypot(1 - 0.49, 0.07)
    first = spread.sel(harmonic=1, estimate="first_order")
    assert float(first.displacement_amplitude_std) == pytest.approx(1e-3 * gain, rel=1e-8)
    assert float(first.displacement_amplitude_worst) == pytest.approx(3e-3 * gain, rel=1e-8)
    alone = spread.displacement_amplitude_deviation.sel(harmonic=1, parameter="f")
    assert alone.values == pytest.approx([-3e-3 * gain, 3e-3 * gain], rel=1e-8)
    assert float(spread.law_change_share) == 0
    # None of n: the upper end of Wilson's interval is z^2 / (n + z^2).
    assert float(spread.law_change_high) == pytest.approx(1.96**2 / (64 + 1.96**2), rel=1e-4)


def test_both_estimates_agree_for_small_tolerances(spread):
    for name in ("displacement_mean", "impact_velocity_max", "displacement_amplitude"):
        std = spread[f"{name}_std"]
        assert np.allclose(std.sel(estimate="samples"), std.sel(estimate="first_order"), rtol=0.02)


def test_sensitivities_are_those_of_new_marches(spread):
    for name in SIGMA:
        value = getattr(EXCITER, name)
        over = vp.sweep(EXCITER, over={name: [value - 1e-5, value + 1e-5]})
        for quantity in ("displacement_mean", "impact_velocity_max"):
            slope = over[quantity].diff(name).squeeze(name) / 2e-5
            found = spread[f"{quantity}_sensitivity"].sel(parameter=name)
            assert np.allclose(found, slope, rtol=1e-5)


def test_the_loss_by_friction_has_its_spread():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7, friction=0.05)
    spread = vp.tolerance(exciter, {"friction": 1e-3}, samples=64)
    ends = [vp.steady_state(replace(exciter, friction=0.05 + step)) for step in (-1e-4, 1e-4)]
    slope = float(ends[1].energy_friction - ends[0].energy_friction) / 2e-4
    assert float(spread.energy_friction_sensitivity[0]) == pytest.approx(slope, rel=1e-4)
    std = spread.energy_friction_std
    assert float(std.sel(estimate="first_order")) == pytest.approx(1e-3 * abs(slope), rel=1e-4)
    assert float(std.sel(estimate="samples")) == pytest.approx(1e-3 * abs(slope), rel=0.1)


def test_without_friction_there_is_no_loss_by_it(spread):
    assert not [name for name in spread.variables if str(name).startswith("energy_friction")]


def test_contributions_are_shares(spread):
    assert np.allclose(spread.impact_velocity_max_contribution.sum("parameter"), 1)
    assert str(spread.displacement_mean_contribution.idxmax("parameter").item()) == "delta"


def test_a_law_that_changes_is_counted():
    # Just below the first impact of the linear motion, f = l sqrt((1 - nu^2)^2 + h^2 nu^2): half the samples strike.
    first = 0.5 * np.hypot(1 - 0.49, 0.07)
    linear = vp.steady_state(vp.Exciter(l=5.0, nu=0.7, f=first, h=0.1))
    start = float(linear.displacement_strobe), float(linear.velocity_strobe)
    exciter = vp.Exciter(l=0.5, nu=0.7, f=first * (1 - 1e-7), h=0.1, R1=0.7, R2=0.7)
    spread = vp.tolerance(exciter, {"f": 1e-4}, *start, samples=512)
    assert float(spread.law_change_low) < 0.5 < float(spread.law_change_high)
    assert float(spread.law_change_corners) == 0.5


@pytest.mark.slow
def test_first_order_is_that_of_ten_thousand_random_samples():
    spread = vp.tolerance(EXCITER, SIGMA)
    generator = np.random.default_rng(1)
    from vibropipe.solve.rows.points import solve_points

    rows = np.tile(np.array(EXCITER.parameters()), (10_000, 1))
    for name, sigma in SIGMA.items():
        column = list(EXCITER.parameters()._fields).index(name)
        rows[:, column] += sigma * generator.standard_normal(10_000)
    points = solve_points(rows, (None, 0.0), ("harmonics", "impacts"), 3)
    for name in ("displacement_mean", "impact_velocity_max"):
        drawn = np.std(points.variables[name][1], axis=0)
        for estimate in spread.estimate.values:
            # The standard deviation of a standard deviation of n samples is 1 / sqrt(2 n) of it.
            assert np.allclose(spread[f"{name}_std"].sel(estimate=estimate), drawn, rtol=0.03)


@pytest.mark.parametrize(
    ("tolerances", "message"),
    [
        ({}, "tolerances: must have at least one parameter"),
        ({"mass": 0.1}, "tolerances: must have keys among nu, f"),
        ({"R1": -0.1}, "tolerances.R1: must be a finite number > 0"),
    ],
)
def test_wrong_tolerances_are_refused(tolerances, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.tolerance(EXCITER, tolerances)


def test_a_chaotic_motion_has_no_tolerance():
    chaotic = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=-0.1285714, R1=0.7, R2=0.7)
    with pytest.raises(vp.ParameterError, match="settles on a stable orbit"):
        vp.tolerance(chaotic, SIGMA)


def test_contacts_with_soft_supports_have_a_spread():
    soft = vp.Exciter(l=0.5, nu=0.8, f=0.9, h=0.1, k1=200.0, k2=300.0, h1=3.0, h2=3.0)
    sigma = {"k1": 0.5, "f": 0.001}
    spread = vp.tolerance(soft, sigma, samples=256)
    for name in ("support_force_max", "contact_duration_max", "support_depth_max"):
        std = spread[f"{name}_std"]
        assert np.allclose(std.sel(estimate="samples"), std.sel(estimate="first_order"), rtol=0.05)
    over = vp.sweep(soft, over={"k1": [199.999, 200.001]}, outputs=("impacts",))
    slope = over.support_force_max.diff("k1").squeeze("k1") / 0.002
    found = spread.support_force_max_sensitivity.sel(parameter="k1")
    assert np.allclose(found, slope, rtol=1e-4, atol=1e-6)
    assert "support_force_max_std" not in vp.tolerance(EXCITER, {"f": 0.001}, samples=16)


def test_the_yield_of_a_linear_motion_has_its_closed_form():
    # A_1 = f gain: the share below a bound is that of f below it, a normal distribution
    exciter = vp.Exciter(l=5.0, nu=0.7, f=0.2, h=0.1)
    gain = 1 / np.hypot(1 - 0.49, 0.07)
    bounds = {"displacement_amplitude_1": f"< {gain * 0.201}", "displacement_mean": (-1e-3, 1e-3)}
    spread = vp.tolerance(exciter, {"f": 1e-3}, samples=4096, subject_to=bounds)
    below = NormalDist(0.2, 1e-3).cdf(0.201)
    assert float(spread["yield"]) == pytest.approx(below, abs=1e-3)
    assert spread.yield_low < below < spread.yield_high
    each = spread.displacement_amplitude_yield.values
    assert each[0] == spread["yield"]
    assert np.isnan(each[1:]).all()
    assert float(spread.displacement_mean_yield) == 1.0
    assert float(spread.law_yield) == 1.0
    assert "share of scattered parts" in spread.displacement_amplitude_yield.attrs["long_name"]
    # The bound sorts parts without error, by the amplitude or by f; damping is the same in all and sorts none.
    assert spread.attrs["foretold_by"] in {"f", "displacement_amplitude_1"}
    assert float(spread.f_sort_threshold) == pytest.approx(0.201, abs=5e-6)
    assert float(spread.displacement_amplitude_sort_threshold[0]) == pytest.approx(
        gain * 0.201, abs=1e-5
    )
    assert float(spread.f_sort_area) == 0.0
    assert float(spread.f_sort_wrong) <= 1 / 2048


def test_sorting_rules_with_units_are_those_without():
    exciter = vp.Exciter.from_physical(
        m="2 kg", C="8 N/mm", H="25 N s/m", F="-8 kN", omega="10 Hz", l="500 mm", R2=0.7
    )
    p = np.sqrt(8000 / 2)
    given = {"omega": f"{0.002 * p} rad/s", "F": f"{0.002 * 8000} N"}
    bound = float(vp.steady_state(exciter).impact_velocity_max[0])
    bounds = [{"impact_velocity_max_1": end} for end in (f"< {bound * p} m/s", f"< {bound}")]
    found = vp.tolerance(exciter, given, samples=256, subject_to=bounds[0])
    plain = vp.tolerance(
        replace(exciter, nu=exciter.nu),
        {"nu": 0.002, "f": 0.002},
        samples=256,
        subject_to=bounds[1],
    )
    assert 0.1 < float(found["yield"]) < 0.9
    for name, same, size in (
        ("omega", "nu", p), ("F", "f", 8000), ("impact_velocity_max", "impact_velocity_max", p),
    ):  # fmt: skip
        ours, theirs = found[f"{name}_sort_threshold"], plain[f"{same}_sort_threshold"]
        assert np.allclose(ours, theirs * size, rtol=1e-9, equal_nan=True)
        assert np.array_equal(found[f"{name}_sort_wrong"], plain[f"{same}_sort_wrong"])
    assert found.omega_sort_threshold.attrs["units"] == "rad s-1"
    assert "nu_sort_threshold" not in found


def test_what_foretells_is_named_as_the_dataset_names_it():
    plain = xr.Dataset(
        {"mass_ratio_sort_threshold": 0.4, "mass_ratio_sort_area": 0.9},
        attrs={"foretold_by": "nu; displacement_phase_3; no single quantity"},
    )
    found = vp.to_physical(plain, "2 kg", "8 N/mm")
    assert found.attrs["foretold_by"] == "omega; displacement_phase_3; no single quantity"
    # The part with the larger m/M has the smaller mass M of the housing.
    assert float(found.M_sort_threshold) == pytest.approx(5.0)
    assert float(found.M_sort_area) == pytest.approx(0.1)


def test_the_yield_is_that_of_a_sweep_over_the_parameter():
    # by f alone: the share of f between those at which the bound, and the law, begin and end
    found = vp.tolerance(
        EXCITER, {"f": 0.02}, samples=2048, subject_to={"impact_velocity_max_1": "< 0.97, > 0.92"}
    )
    f = np.linspace(-1.06, -0.94, 2401)
    rows = vp.sweep(EXCITER, over={"f": f})
    centre = rows.isel(f=1200)
    law = (rows.period_multiple == centre.period_multiple) & (rows.regime == centre.regime)
    law &= (rows.impacts_per_orbit == centre.impacts_per_orbit).all("support")
    v = rows.impact_velocity_max.isel(support=0)
    kept = (law & (v < 0.97) & (v > 0.92)).values
    weights = np.exp(-0.5 * ((f + 1) / 0.02) ** 2)
    assert 0.05 < kept.mean() < 0.95
    assert float(found["yield"]) == pytest.approx(weights[kept].sum() / weights.sum(), abs=5e-3)


def test_one_sided_bounds_of_phases_count_parts(spread):
    phase = float(spread.displacement_phase[0])
    for bound, share in (("> {:.6f}", 1.0), ("< {:.6f}", 0.0)):
        bounds = {"displacement_phase_1": bound.format(phase - 0.5)}
        found = vp.tolerance(EXCITER, SIGMA, samples=64, subject_to=bounds)
        assert float(found["yield"]) == share


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ({"displacement_mean_std": "< 1"}, "must be a quantity of the motion"),
        ({"f": "< 1"}, "must be a quantity of the motion"),
        ({"impact_velocity": "< 1"}, "impact_velocity"),
        ({"displacement_mean": "small"}, "must be a bound such as"),
    ],
)
def test_wrong_bounds_are_told(bounds, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.tolerance(EXCITER, SIGMA, samples=64, subject_to=bounds)


@pytest.mark.parametrize("name", ["impact_velocity_max_1", "impulse_per_period_1"])
def test_parts_that_never_strike_exceed_no_largest_velocity(name: str) -> None:
    exciter = vp.Exciter(l=1.0, nu=0.5, f=0.3, h=0.1, R1=0.7, R2=0.7)
    found = vp.tolerance(exciter, {"f": 0.01}, samples=64, subject_to={name: "< 0.8"})
    assert float(found["yield"]) == 1.0
    if name == "impact_velocity_max_1":
        none = vp.tolerance(exciter, {"f": 0.01}, samples=64, subject_to={name: "> 0.1"})
        assert float(none["yield"]) == 0.0


@pytest.mark.parametrize("name", ["mass_ratio", "housing_load", "housing_friction_1"])
def test_a_fixed_housing_does_not_scatter(name):
    told = (
        rf"tolerance.*\.{name}: must be left out where mass_ratio is 0: the housing is fixed then"
    )
    with pytest.raises(vp.ParameterError, match=told):
        vp.tolerance(EXCITER, {name: 0.01})
    if name != "mass_ratio":
        with pytest.raises(vp.ParameterError, match=rf"vary\.{name}: must be left out where"):
            vp.design(EXCITER, {name: (0.0, 1.0)}, target={"impact_velocity_max_1": 0.8})
