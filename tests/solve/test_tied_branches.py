"""Branches along which tied parameters follow: against exciters by hand, closed forms, and the parameter shaker."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.physics.ties import Ties
from vibropipe.solve.branch.problem import problem_of, seed_of_steady_state, with_ties
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.bifurcations import Bifurcation

BASE = vp.Exciter(l=1, nu=0.98, R1=0.7)
TIES = {"R2": "R1", "f": "0.4 * nu**2", "h": "2 * zeta", "zeta": 0.05}
ALONG: dict[str, tuple[Any, dict[str, Any]]] = {
    "nu": ((0.9, 1.3), TIES),
    "R1": ((0.6, 0.8), TIES),
    "zeta": ((0.08, 0.03), {name: text for name, text in TIES.items() if name != "zeta"}),
}
OUTPUTS = ("impacts", "stability", "harmonics", "energy", "power", "sensitivity")


def by_hand(nu: float = 0.98, R1: float = 0.7, zeta: float = 0.05) -> vp.Exciter:
    return vp.Exciter(l=1, nu=nu, R1=R1, R2=R1, f=0.4 * nu**2, h=2 * zeta)


def places(branch: xr.Dataset, along: str, kind: str) -> np.ndarray:
    is_kind = branch.bifurcation_kind.values == Bifurcation[kind.upper()]
    return np.unique(branch[f"bifurcation_{along}"].values[is_kind].round(12))


@pytest.fixture(scope="module")
def branches() -> dict[str, xr.Dataset]:
    return {
        along: vp.branch(BASE, along, to, ties=ties, outputs=OUTPUTS, v0=0.1, switch=("pitchfork",))
        for along, (to, ties) in ALONG.items()
    }


@pytest.mark.parametrize("along", ALONG)
def test_points_are_the_steady_states_of_exciters_by_hand(branches, along):
    branch = branches[along]
    stable = np.flatnonzero((branch.stable.values == 1) & (branch.status.values == 0))
    assert stable.size > 10
    for point in stable[:: max(1, stable.size // 6)]:
        row = branch.isel(point=point)
        exciter = by_hand(**{along: float(row[along])})
        for name in {"R2", "f", "h"} & {*branch.coords}:
            assert float(row[name]) == getattr(exciter, name)
        x, v = float(row.displacement_strobe), float(row.velocity_strobe)
        alone = steady_state(exciter, x, v)
        for name in ("displacement_amplitude", "impact_velocity_max", "energy_input"):
            held = alone[name] if name != "displacement_amplitude" else alone[name][:6]
            np.testing.assert_allclose(row[name], held, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("along", ALONG)
def test_the_pitchfork_of_the_tied_exciter_is_that_of_its_closed_form(along):
    # R2 = R1 keeps the exciter symmetric, along R1 as well.
    to, ties = ALONG[along]
    found = vp.branch(BASE, along, sorted(to), law=(1, 1, 1), ties=ties)
    assert found.attrs["law"] == "(1; 1, 1)"
    assert found.attrs["ties"] == "; ".join(f"{name} = {text}" for name, text in ties.items())
    found_places = places(found, along, "pitchfork")
    assert found_places.size
    for place in found_places:
        exciter = by_hand(**{along: place})
        closed = vp.symmetric_orbit_boundaries(replace(exciter, f=0.0), [exciter.nu])
        assert closed.pitchfork_f.item() == pytest.approx(exciter.f, rel=1e-9)


@pytest.mark.parametrize("along", ALONG)
def test_derivatives_are_differences_between_exciters_by_hand(branches, along):
    branch, step = branches[along], 1e-6
    assert not {"R2", "f", "h"} & {*branch.parameter.values}
    row = branch.isel(point=np.flatnonzero(branch.stable.values == 1)[5])
    x, v = float(row.displacement_strobe), float(row.velocity_strobe)
    for by in ("nu", "R1", *(["zeta"] if along == "zeta" else [])):
        own = {name: float(row[name]) for name in ("nu", "R1", "zeta") if name in row.coords}
        ends = [
            steady_state(by_hand(**{**own, by: own[by] + move}), x, v) for move in (-step, step)
        ]
        for name in ("displacement_amplitude", "impact_velocity_max", "energy_input"):
            exact = row[f"{name}_sensitivity"].sel(parameter=by).values
            low, high = (end[name].values for end in ends)
            slope = ((high - low) / (2 * step))[: exact.size] if exact.ndim else (high - low) / 2e-6
            known = np.isfinite(exact)  # harmonics that are zero have no derivative
            assert known.any()
            np.testing.assert_allclose(exact[known], slope[known], rtol=2e-4, atol=1e-5)


CASES: dict[str, tuple[vp.Exciter, str, Any, dict[str, Any]]] = {
    "impacts": (BASE, "nu", (0.9, 1.3), TIES),
    "own": (BASE, "zeta", (0.05, 0.03), ALONG["zeta"][1]),
    "acts": (BASE, "R1", (0.6, 0.8), {"R2": "R1", "shaker": "0.5 * R1", "h": 0.1}),
    "soft": (
        vp.Exciter(l=1, nu=1.1, k1=20.0, friction=0.01, h=0.1), "nu", (1.0, 1.3),
        {"k2": "k1", "f": "0.6 * nu**2", "h1": "0.3 * nu", "h2": "h1"},
    ),
    "friction": (
        vp.Exciter(l=1, nu=1.1, f=0.8, h=0.1), "mu", (0.01, 0.04), {"friction": "mu", "R1": "0.8 - mu"},
    ),
    "housing": (
        vp.Exciter(l=1, nu=1.0, f=1.5, h=0.1, R1=0.7, R2=0.7), "a", (0.2, 0.25),
        {"mass_ratio": "a", "housing_load": "0.1 * a", "housing_friction_1": 0.3, "housing_friction_2": 0.1},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_tangents_are_differences_of_points(case):
    exciter, along, to, given = CASES[case]
    ties = Ties(given)
    start, end, own = with_ties(exciter, along, to, ties)
    problem, signs = problem_of(start, along, end, (), 0.02, ties, own)
    seed = seed_of_steady_state(start, problem, signs, steady_state(start, v0=0.1, harmonics=1))
    curve, point = seed.curve, seed.point
    assert isinstance(curve, LawCurve)
    assert curve.tied is not None
    step = 1e-5 * (problem.high - problem.low)
    ends = []
    for move in (-step, step):
        moved = point.u.copy()
        moved[-1] += move
        ends.append(curve.settle(moved).u)
    slope = (ends[1] - ends[0]) / (2 * step)
    expected = point.tangent / point.tangent[-1]
    np.testing.assert_allclose(
        slope * curve.weights, expected * curve.weights, rtol=1e-6, atol=1e-6
    )


def test_an_unbalance_by_a_tie_is_that_of_the_parameter_shaker() -> None:
    given: dict[str, Any] = {"to": (0.9, 1.6), "outputs": OUTPUTS, "v0": 0.1}
    plain = vp.Exciter(l=1, nu=1.2, h=0.1, R1=0.7, R2=0.7, delta=0.1)
    tied = vp.branch(plain, "nu", ties={"f": "0.4 * nu**2"}, **given)
    shaken = vp.branch(replace(plain, shaker=0.4), "nu", **given)
    np.testing.assert_allclose(tied.bifurcation_nu, shaken.bifurcation_nu, rtol=1e-11)
    assert tied.sizes["point"] == shaken.sizes["point"]
    for name in ("nu", "displacement_amplitude", "impact_velocity_max", "power_input"):
        np.testing.assert_allclose(tied[name], shaken[name], rtol=1e-9, atol=1e-11)
    by_tie = tied.power_input_sensitivity.sel(parameter="nu")
    by_shaker = shaken.power_input_sensitivity.sel(parameter="nu")
    np.testing.assert_allclose(by_tie, by_shaker, rtol=1e-5, atol=1e-8)
    load = float(tied.power_input.max()) / 1.2
    torque = {"no_load": 2.0, "stall": 2.0 * load}
    speeds, expected = vp.motor(tied, torque), vp.motor(shaken, torque)
    assert speeds.sizes["crossing"] > 0
    np.testing.assert_allclose(speeds.nu, expected.nu, rtol=1e-9)
    np.testing.assert_array_equal(speeds.speed_is_stable, expected.speed_is_stable)
    np.testing.assert_allclose(speeds.jump_nu, expected.jump_nu, rtol=1e-9)
    np.testing.assert_allclose(speeds.jump_to_nu, expected.jump_to_nu, rtol=1e-7)


def test_a_motion_without_impacts_touches_where_its_closed_form_does() -> None:
    ties = {"f": "0.5 * a", "h": "0.1 * a"}
    branch = vp.branch(vp.Exciter(l=1, nu=1.3), "a", (0.1, 3.0), ties=ties)
    (place,) = places(branch, "a", "grazing")[:1]
    amplitude = 0.5 * place / abs(1 - 1.3**2 + 0.1j * place * 1.3)
    assert amplitude == pytest.approx(1.0, rel=1e-11)


def test_an_orbit_with_rests_is_followed_with_what_is_tied() -> None:
    exciter = vp.Exciter(l=1, nu=0.3, delta=0.9, R1=0.3)
    branch = vp.branch(exciter, "nu", 0.32, ties={"R2": "R1", "f": "4 * nu", "h": 0.1})
    assert (branch.rests_per_orbit.sum("support") > 0).all()
    for point in range(0, branch.sizes["point"], 20):
        row = branch.isel(point=point)
        nu = float(row.nu)
        alone = steady_state(vp.Exciter(l=1, nu=nu, delta=0.9, R1=0.3, R2=0.3, f=4 * nu, h=0.1))
        np.testing.assert_allclose(
            row.displacement_amplitude, alone.displacement_amplitude[:6], rtol=1e-9, atol=1e-12
        )


def test_places_scatter_with_what_follows_a_parameter() -> None:
    ties, step = {"R2": "R1", "f": "0.4 * nu**2"}, 1e-6
    exciter = vp.Exciter(l=1, nu=1.0, h=0.1, R1=0.7)
    branch = vp.branch(exciter, "nu", 0.9, v0=0.1, ties=ties, tolerance={"R1": 0.01, "h": 0.01})
    (at,) = np.flatnonzero(branch.bifurcation_kind.values == Bifurcation.PITCHFORK)
    for name in ("R1", "h"):
        ends = [
            places(
                vp.branch(
                    replace(exciter, **{name: getattr(exciter, name) + move}), "nu", 0.9, v0=0.1,
                    ties=ties,
                ), "nu", "pitchfork",
            )
            for move in (-step, step)
        ]  # fmt: skip
        slope = float(ends[1][0] - ends[0][0]) / (2 * step)
        exact = branch.bifurcation_nu_sensitivity.sel(parameter=name).values[at]
        assert exact == pytest.approx(slope, rel=1e-4)


@pytest.mark.parametrize(
    ("along", "to", "ties", "told"),
    [
        ("nu", 1.2, {"f": "0.4 * R2", "R2": "f"}, "ties.f: must not go round in a circle"),
        ("R1", 0.9, {"R2": "2 * R1", "f": 0.4}, "ties.R2: must be a number from 0 to 1, got 1.4"),
        ("nu", 1.2, {"f": "zeta"}, "ties.f: must have a value for zeta: give it in along or by a tie"),
        ("f", 1.2, {"f": "nu"}, "along.f: must be left out, since it is tied"),
        ("zeta", 0.2, {"h": "2 * zeta"}, "to: must be two numbers: zeta from the first to the second"),
        ("zeta", (0.1, -0.2), {"h": "2 * zeta"}, "ties.h: must be"),
        ("eta", (0.1, 0.2), {"h": "2 * zeta", "zeta": 0.1}, "along: must be one of "),
        ("nu", 1.2, {"R1": 0.7}, "R1: must be left out, since it is tied"),
        ("zeta", (0.2, 0.8), {"contact_1": "zeta"}, "ties.contact_1: must"),
    ],
)  # fmt: skip
def test_what_cannot_be_tied_is_refused(along, to, ties, told):
    with pytest.raises(vp.ParameterError) as caught:
        vp.branch(BASE, along, to, ties=ties)
    assert str(caught.value).startswith(told), caught.value


def test_a_tolerance_is_not_of_what_is_tied() -> None:
    with pytest.raises(
        vp.ParameterError, match=r"tolerance.R2: must be left out, since it is tied"
    ):
        vp.branch(BASE, "nu", 1.2, ties=TIES, tolerance={"R2": 0.1})
