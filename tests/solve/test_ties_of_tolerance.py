"""Ties among scattered parameters: what is tied follows, against parts computed by hand and untied derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.solve.design.scattered_parts import scattered

EXCITER = vp.Exciter(l=0.5, nu=1.0, delta=0.01, f=-1.0, R1=0.7)
TIES = {"R2": "R1", "zeta": 0.1, "h": "2 * zeta"}
SIGMA = {"R1": 0.002, "zeta": 0.001}


def made(R: float, zeta: float) -> vp.Exciter:
    return vp.Exciter(l=0.5, nu=1.0, delta=0.01, f=-1.0, R1=R, R2=R, h=2 * zeta)


@pytest.fixture(scope="module")
def spread():
    return vp.tolerance(
        EXCITER, SIGMA, samples=64, ties=TIES, subject_to={"impact_velocity_max_1": "< 0.9548"}
    )


def test_derivatives_are_sums_of_those_by_each_parameter(spread):
    orbit = vp.steady_state(made(0.7, 0.1), outputs=["harmonics", "impacts", "sensitivity"])
    for name in ("displacement_mean", "impact_velocity_max"):
        by = orbit[f"{name}_sensitivity"]
        both = by.sel(parameter="R1") + by.sel(parameter="R2")
        got = spread[f"{name}_sensitivity"]
        np.testing.assert_allclose(got.sel(parameter="R1"), both, rtol=1e-9, atol=1e-12)
        twice = 2 * by.sel(parameter="h")
        np.testing.assert_allclose(got.sel(parameter="zeta"), twice, rtol=1e-9, atol=1e-12)
    assert (float(spread.R2), float(spread.h), float(spread.zeta)) == (0.7, 0.2, 0.1)
    assert spread.attrs["ties"] == "R2 = R1; zeta = 0.1; h = 2 * zeta"
    assert (float(spread.R1_std), float(spread.zeta_std)) == (0.002, 0.001)


def test_parts_are_those_computed_by_hand(spread):
    parts = [made(0.7 + 0.002 * a, 0.1 + 0.001 * b) for a, b in scattered(2, 64)]
    struck = [vp.steady_state(part).impact_velocity_max.values for part in parts]
    std = np.std(struck, axis=0, ddof=1)
    np.testing.assert_allclose(
        spread.impact_velocity_max_std.sel(estimate="samples"), std, rtol=1e-9
    )
    kept = np.mean([first < 0.9548 for first, _second in struck])
    assert 0.0 < kept < 1.0
    assert float(spread["yield"]) == kept
    moved = vp.steady_state(made(0.706, 0.1)).impact_velocity_max
    off = spread.impact_velocity_max_deviation.sel(parameter="R1", side="above")
    own = vp.steady_state(made(0.7, 0.1)).impact_velocity_max
    np.testing.assert_allclose(off, moved - own, rtol=1e-9)


def test_without_a_tie_that_follows_all_is_as_without_ties():
    plain = vp.tolerance(made(0.7, 0.1), {"f": 0.002}, samples=32)
    tied = vp.tolerance(EXCITER, {"f": 0.002}, samples=32, ties=TIES)
    xr_equal = tied.drop_vars("zeta", errors="ignore").drop_attrs(deep=False)
    assert xr_equal.equals(plain.drop_attrs(deep=False))


def test_the_tied_force_of_an_unbalance_follows_the_frequency():
    exciter = vp.Exciter(l=5.0, nu=1.5, h=0.2)
    ties = {"f": "0.2 * nu**2"}
    found = vp.tolerance(exciter, {"nu": 0.001}, samples=16, ties=ties)

    def amplitude(nu: float) -> float:
        return 0.2 * nu**2 / np.hypot(1 - nu**2, 0.2 * nu)

    slope = (amplitude(1.5 + 1e-5) - amplitude(1.5 - 1e-5)) / 2e-5
    got = found.displacement_amplitude_sensitivity.sel(harmonic=1, parameter="nu")
    assert float(got) == pytest.approx(slope, rel=1e-8)


@pytest.mark.parametrize(
    ("tolerances", "ties", "message"),
    [
        ({"R2": 0.1}, {"R2": "R1"}, "tolerances.R2: must be left out, since it is tied"),
        ({"R1": 0.1}, {"R1": 0.5}, "tolerances.R1: must be left out, since it is tied"),
        ({"zeta": 0.1}, {"h": "2 * zeta"}, "ties.zeta: must have its value as a tie, since it scatters"),
        ({"f": 0.1}, {"h": "2 * zeta"}, "ties.h: must have a value for zeta: give it in tolerances or by a tie"),
        ({"R1": 0.1}, {"f": "2 * nu"}, "f: must be left out, since it is tied"),
        ({"zeta": -0.1}, {"zeta": 0.1, "h": "2 * zeta"}, "tolerances.zeta: must be a finite number > 0"),
        ({"R1": 0.1}, {"R2": "R1 + 1"}, "ties.R2: must be a number from 0 to 1, got 1.7 at R1 = 0.7"),
        ({"zeta": 0.1}, {"zeta": 0.1, "h": "sqrt(zeta - 0.0999)"}, "ties.h: must have a finite value at all"),
    ],
)  # fmt: skip
def test_wrong_ties_are_refused(tolerances, ties, message):
    with pytest.raises(vp.ParameterError, match=message.replace("(", r"\(").replace("*", r"\*")):
        vp.tolerance(EXCITER, tolerances, samples=16, ties=ties)


def test_a_place_along_what_is_tied_is_refused():
    exciter = vp.Exciter(l=0.5, nu=3.0, h=0.2)
    with pytest.raises(vp.ParameterError, match="ties: must leave out nu, since grazing_nu_down"):
        vp.tolerance(
            exciter, {"h": 0.01}, samples=16, ties={"f": "0.05 * nu**2"},
            subject_to={"grazing_nu_down": "> 1"},
        )  # fmt: skip
