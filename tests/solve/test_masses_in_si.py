"""A mass M stands in SI for a ratio m/M: it falls where that rises, so what is derived from it has to follow."""

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

m = 0.35
GIVEN = {
    "m": m,
    "C": 6000.0,
    "H": 4.583,
    "F": 12.0,
    "l": 0.004,
    "omega": 188.5,
    "R1": 0.6,
    "R2": 0.75,
}
EXCITER = vp.Exciter.from_physical(**GIVEN, M=1.0, D1=0.5, D2=0.8)


def test_sensitivities_are_those_by_the_mass():
    told = vp.to_physical(
        vp.steady_state(EXCITER, outputs=["harmonics", "impacts", "sensitivity"]), EXCITER
    )
    of_mass = told.sel(parameter="M")
    for name in ("housing_velocity_mean", "impact_velocity_max"):
        above, below = (
            vp.to_physical(
                vp.steady_state(vp.Exciter.from_physical(**GIVEN, M=mass, D1=0.5, D2=0.8)), EXCITER
            )[name]
            for mass in (1.0001, 0.9999)
        )  # fmt: skip
        assert np.allclose(of_mass[f"{name}_sensitivity"], (above - below) / 2e-4, rtol=1e-5)


def test_deviations_of_the_mass_and_of_its_ratio_are_one():
    known = vp.tolerance(EXCITER, {"mass_ratio": 0.35**2 / m * 0.01, "R1": 0.01}, samples=64)
    told = vp.tolerance(EXCITER, {"M": "10 g", "R1": 0.01}, samples=64)
    assert float(told.M_std) == pytest.approx(0.01)
    assert told.M_std.attrs["units"] == "kg"
    assert np.allclose(vp.to_physical(known, EXCITER).M_std, 0.01)
    for name in ("impact_velocity_max_std", "housing_velocity_mean_contribution"):
        assert np.allclose(told[name], vp.to_physical(known, EXCITER)[name])
    # a part with a greater mass moves the quantity as its derivative says
    moved = told.housing_velocity_mean_deviation.sel(parameter="M", side="above")
    assert float(moved) == pytest.approx(
        0.03 * float(told.housing_velocity_mean_sensitivity.sel(parameter="M")), rel=0.05
    )


def test_what_is_derived_from_a_ratio_follows_the_mass():
    per_ratio = ("bifurcation", "parameter")
    dataset = xr.Dataset(
        {
            "mass_ratio_lower": 0.25,
            "mass_ratio_upper": 0.5,
            "mass_ratio_tolerance": ("design", [0.001, 0.002]),
            "bifurcation_mass_ratio": ("bifurcation", [0.35, 0.7]),
            "bifurcation_mass_ratio_std": ("bifurcation", [0.01, 0.02]),
            "bifurcation_mass_ratio_sensitivity": (per_ratio, [[1.0, 2.0], [3.0, 4.0]]),
            "parameter_covariance": (("parameter", "other_parameter"), [[4.0, 1.0], [1.0, 9.0]]),
        },
        {
            "mass_ratio": ("design", [0.35, 0.5]),
            "parameter": ["R1", "nu"],
            "other_parameter": ["R1", "nu"],
        },
        {"subject_to": "mass_ratio < 0.4"},
    )
    found = vp.to_physical(dataset, "0.35 kg", "0.35 N/m")
    assert np.allclose([found.M_lower, found.M_upper], [0.7, 1.4])
    assert np.allclose(found.M_tolerance, [0.35 / 0.35**2 * 0.001, 0.35 / 0.5**2 * 0.002])
    assert np.allclose(found.bifurcation_M, [1.0, 0.5])
    assert np.allclose(found.bifurcation_M_std, [0.01 * 0.35 / 0.35**2, 0.02 * 0.35 / 0.7**2])
    slopes = np.array([-0.35 / 0.35**2, -0.35 / 0.7**2])[:, None] * [[1.0, 2.0], [3.0, 4.0]]
    assert np.allclose(found.bifurcation_M_sensitivity, slopes)
    assert found.attrs["subject_to"] == "mass_ratio < 0.4"

    found = vp.to_physical(
        dataset.isel(design=0).assign_coords(
            parameter=["mass_ratio", "R1"], other_parameter=["mass_ratio", "R1"]
        ),
        "0.35 kg", "0.35 N/m",
    )  # fmt: skip
    by = -1.0 / 0.35
    assert np.allclose(found.parameter_covariance, [[4.0 * by**2, by], [by, 9.0]])
    assert list(found.other_parameter) == ["M", "R1"]


def test_a_deviation_of_a_mass_needs_one_mass():
    held = vp.Exciter.from_physical(**GIVEN)
    with pytest.raises(vp.ParameterError, match="M: must be left out: the housing is fixed"):
        vp.tolerance(held, {"M": "10 g"})
    with pytest.raises(vp.ParameterError, match="M: must be left out beside a range of mass_ratio"):
        vp.design(
            EXCITER,
            {"mass_ratio": (0.3, 0.4)},
            {"impact_velocity_max_1": "0.4 m/s"},
            tolerance={"M": "10 g"},
        )
