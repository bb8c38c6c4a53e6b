"""Ties in designs, fits and tolerances: what is tied follows, and so do derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.physics.ties import Ties
from vibropipe.solve.design.goals import goals_of
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.design.scattered_parts import scattered

EXCITER = vp.Exciter(l=1.0, delta=0.1)
TIES = {"R2": "R1", "f": "0.5 * nu**2", "h": "2 * zeta"}
VARY = {"zeta": (0.01, 0.1), "R1": (0.5, 0.8), "nu": (1.0, 1.3)}
WANTED = ("displacement_amplitude_1", "impact_velocity_max_1", "energy_input")


def by_hand(zeta: float, R1: float, nu: float) -> vp.Exciter:
    return vp.Exciter(l=1.0, delta=0.1, nu=nu, R1=R1, R2=R1, f=0.5 * nu**2, h=2 * zeta)


def column(rows: xr.Dataset, name: str) -> np.ndarray:
    variable, _, number = name.rpartition("_")
    return rows[variable].values[..., int(number) - 1] if number.isdigit() else rows[name].values


@pytest.fixture(scope="module")
def target() -> dict[str, float]:
    state = vp.steady_state(by_hand(0.04, 0.65, 1.15), outputs=("harmonics", "impacts", "energy"))
    return {name: float(column(state, name)) for name in WANTED}


@pytest.fixture(scope="module")
def designs(target: dict[str, float]) -> xr.Dataset:
    return vp.design(
        EXCITER, VARY, target, ties=TIES, samples=128, tolerance={"R1": 1e-3, "R2": 1e-3}
    )


def test_designs_meet_what_a_tied_exciter_has(
    designs: xr.Dataset, target: dict[str, float]
) -> None:
    assert int(designs.design_result[0]) == 0
    assert designs.attrs["vary"] == "nu R1 zeta"
    assert designs.attrs["ties"] == "R2 = R1; f = 0.5 * nu**2; h = 2 * zeta"
    for n in range(designs.sizes["design"]):
        one = designs.isel(design=n)
        exciter = by_hand(*(float(one[name]) for name in VARY))
        assert {name: float(one[name]) for name in TIES} == {n: getattr(exciter, n) for n in TIES}
        state = vp.steady_state(exciter, outputs=("harmonics", "impacts", "energy"))
        for name, wanted in target.items():
            if int(one.design_result) == 0:
                assert float(column(one, name)) == pytest.approx(wanted, rel=1e-9)
            assert float(column(one, name)) == float(column(state, name))
    for name, ends in VARY.items():
        assert (float(designs[f"{name}_lower"]), float(designs[f"{name}_upper"])) == ends


def test_parts_scatter_in_each_parameter_by_itself(designs: xr.Dataset) -> None:
    one = designs.isel(design=0)
    exciter = by_hand(*(float(one[name]) for name in VARY))
    alone = vp.tolerance(exciter, {"R1": 1e-3, "R2": 1e-3})
    np.testing.assert_allclose(
        one.impact_velocity_max_std, alone.impact_velocity_max_std, rtol=1e-6
    )
    assert list(designs.parameter.values) == ["R1", "R2"]


def test_derivatives_by_shares_are_those_of_differences() -> None:
    ends = {name: VARY[name] for name in ("nu", "R1", "zeta")}
    goals = goals_of(dict.fromkeys(WANTED, 1.0), None, None, {})
    base = by_hand(0.01, 0.5, 1.0)
    problem = Problem(base, ends, goals, None, 0.0, ties=Ties(TIES))
    share = np.array([0.5, 0.4, 0.3])
    row = problem.parameters(share[None])[0]
    point = problem.from_start(row[None])
    _, _, slopes = problem.linearised(row, point.states[0], problem.columns)
    exact, step = problem.by_shares(share, slopes), 1e-5
    for n in range(share.size):
        moved = share + step * np.array([[-1.0], [1.0]]) * np.eye(3)[n]
        low, high = problem.read(problem.from_start(problem.parameters(moved)))
        np.testing.assert_allclose(exact[:, n], (high - low) / (2 * step), rtol=1e-5)
    assert problem.ranges == {
        "nu": (1.0, 1.3), "R1": (0.5, 0.8), "R2": (0.5, 0.8), "f": (0.5, 0.5 * 1.3**2), "h": (0.02, 0.2),
    }  # fmt: skip


@pytest.mark.slow
def test_a_quantity_is_least_along_the_tie() -> None:
    """With f = 0.5 nu^2 the least impact velocity lies elsewhere than with f of the lower end."""
    exciter, vary = vp.Exciter(l=1.0, delta=0.1, h=0.1, R1=0.6), {"nu": (1.05, 1.4)}
    ties = {"R2": "R1", "f": "0.5 * nu**2"}
    found = vp.design(exciter, vary, minimise="impact_velocity_max_1", ties=ties, samples=32).isel(
        design=0
    )
    rows = vp.sweep(exciter, {"nu": np.linspace(1.05, 1.4, 141)}, ties=ties)
    least = np.nanmin(rows.impact_velocity_max.values[rows.stable.values == 1, 0])
    assert float(found.impact_velocity_max[0]) <= least * (1 + 1e-6)


def test_what_a_tie_does_not_reach_is_left_out() -> None:
    """sqrt has no value for nu between 0.8 and 0.9, and the best motion without the tie lies there."""
    exciter = vp.Exciter(l=1.0, f=0.5, delta=0.1, R1=0.6, R2=0.6)
    ties = {"h": "0.1 + 0.3 * sqrt((nu - 0.8) * (nu - 0.9))"}
    found = vp.design(
        exciter, {"nu": (0.7, 1.2)}, minimise="-displacement_amplitude_1", ties=ties, samples=64
    )
    assert not ((found.nu > 0.8) & (found.nu < 0.9)).any()
    assert np.isfinite(found.h).all()


def test_a_fit_finds_names_of_ones_own() -> None:
    nu = np.linspace(1.0, 1.3, 13)
    ties = {"R2": "R1", "f": "a * nu**2", "h": "2 * zeta"}
    over = {"nu": nu, "zeta": [0.04], "a": [0.5], "R1": [0.65]}
    rows = vp.sweep(EXCITER, over, ties=ties).isel(zeta=0, a=0, R1=0)
    names = ("displacement_mean", "displacement_amplitude_1")
    measured = {"nu": nu, **{name: column(rows, name) for name in names}}
    found = vp.identify(
        EXCITER, measured, {"zeta": (0.01, 0.1), "a": (0.4, 0.6), "R1": (0.5, 0.8)},
        noise=dict.fromkeys(names, 1e-6), samples=64, ties=ties,
    )  # fmt: skip
    assert {*found.parameter.values} == {"R1", "a", "zeta"}
    for name, value in (("zeta", 0.04), ("a", 0.5), ("R1", 0.65), ("R2", 0.65), ("h", 0.08)):
        assert float(found[name]) == pytest.approx(value, rel=1e-5), name
    np.testing.assert_allclose(found.f, 0.5 * nu**2, rtol=1e-5)
    assert found.f.dims == ("measurement",)
    assert float(found.zeta_std) < 1e-4


@pytest.mark.parametrize(
    ("vary", "more", "message"),
    [
        ({"zeta": (0.1, 0.2), "h": (0.1, 0.2)}, {}, "vary.h: must be left out, since it is tied"),
        ({"R1": (0.1, 0.2)}, {}, "ties.f: must have a value for nu: give it in vary or by a tie"),
        ({"nu": (1, 2)}, {}, "ties.h: must have a value for zeta: give it in vary"),
        ({"nu": (1, 2), "zeta": (0.2, 0.1)}, {}, "vary.zeta: must be a pair of increasing"),
        ({"nu": (1, 2), "zeta": (-0.2, 0.1)}, {}, "ties.h: must be a finite number >= 0, got -0.4 at zeta = -0.2"),
        ({"nu": (1, 2), "eta": (0, 1)}, {}, r"vary: must have keys among .*, got 'eta'"),
        ({"nu": (1, 2), "zeta": (0, 1)}, {"minimise": "displacement_mean_sensitivity_R1"},
         "ties: must leave out R1, since displacement_mean_sensitivity_R1 is wanted"),
        ({"nu": (1, 2), "zeta": (0, 1)}, {"tolerance": {"zeta": 0.1}}, "tolerance: must have keys among"),
    ],
)  # fmt: skip
def test_searches_refuse_ties_that_cannot_hold(vary: Any, more: Any, message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.design(EXCITER, vary, **{"target": {"displacement_mean": 0.1}, **more}, ties=TIES)


SCATTERED = vp.Exciter(l=0.5, nu=1.0, delta=0.01, f=-1.0, R1=0.7)
SCATTERED_TIES = {"R2": "R1", "zeta": 0.1, "h": "2 * zeta"}
SIGMA = {"R1": 0.002, "zeta": 0.001}


def made(R: float, zeta: float) -> vp.Exciter:
    return vp.Exciter(l=0.5, nu=1.0, delta=0.01, f=-1.0, R1=R, R2=R, h=2 * zeta)


@pytest.fixture(scope="module")
def spread():
    return vp.tolerance(
        SCATTERED,
        SIGMA,
        samples=64,
        ties=SCATTERED_TIES,
        subject_to={"impact_velocity_max_1": "< 0.9548"},
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
    tied = vp.tolerance(SCATTERED, {"f": 0.002}, samples=32, ties=SCATTERED_TIES)
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
        vp.tolerance(SCATTERED, tolerances, samples=16, ties=ties)


def test_a_place_along_what_is_tied_is_refused():
    exciter = vp.Exciter(l=0.5, nu=3.0, h=0.2)
    with pytest.raises(vp.ParameterError, match="ties: must leave out nu, since grazing_nu_down"):
        vp.tolerance(
            exciter, {"h": 0.01}, samples=16, ties={"f": "0.05 * nu**2"},
            subject_to={"grazing_nu_down": "> 1"},
        )  # fmt: skip
