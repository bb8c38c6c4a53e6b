"""Branches of orbits that rest on rigid supports: followed from law to law, against marches and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.regimes import Regime

CHATTERING = vp.Exciter(l=0.5, nu=1.04, f=1.956, h=0.274, delta=0.413, R1=0.275, R2=0.345)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.1, f=2.0, h=0.1, R1=0.3, R2=0.3)
PRESSED = vp.Exciter(l=0.5, nu=1.0, f=0.1, h=0.1, delta=-1.2, R1=0.3, R2=0.3)


@pytest.fixture(scope="module")
def chattering():
    return vp.branch(CHATTERING, "nu", (0.73, 1.35), at=[0.8, 0.95, 1.2])


def test_a_branch_passes_the_onset_of_a_second_rest_and_never_goes_back(chattering) -> None:
    """Impacts on support 1 grow without end towards it, and their laws follow each other ever faster."""
    assert (np.diff(chattering.nu.values) > 0.0).all()
    assert (chattering.regime == Regime.WITH_REST).all()
    assert set(chattering.bifurcation_kind.values.tolist()) == {Bifurcation.CHANGE}
    on_first = chattering.rests_per_orbit.sel(support=1).values
    (onset,) = np.flatnonzero(np.diff(on_first))
    below, above = chattering.nu.values[onset : onset + 2]
    assert on_first[onset] == 1.0
    assert above - below < 1e-5
    for nu, rests in ((below - 1e-6, 1), (above + 1e-6, 0)):
        steady = vp.steady_state(replace(CHATTERING, nu=float(nu)))
        assert steady.rests_per_orbit.sel(support=1).item() == rests


def test_laws_that_are_passed_together_leave_no_step_back() -> None:
    """Where the last impact of a law has no speed the tangent lies across the parameter, and its sign is rounding."""
    exciter = vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.05, R1=0.3, R2=0.2)
    branch = vp.branch(exciter, "nu", (0.5, 0.9), outputs=("impacts",))
    assert (np.diff(branch.nu.values) > 0.0).all()
    assert branch.rests_per_orbit.sum("support").values[[0, -1]].tolist() == [2.0, 1.0]


@pytest.mark.parametrize("nu", [0.8, 0.95, 1.2])
def test_points_are_steady_states(nu: float, chattering) -> None:
    at = chattering.isel(point=int(np.flatnonzero(chattering.nu.values == nu)[0]))
    steady = vp.steady_state(replace(CHATTERING, nu=nu))
    for name in ("displacement_strobe", "velocity_strobe", "impact_velocity_max"):
        np.testing.assert_allclose(at[name].values, steady[name].values, atol=1e-9)
    np.testing.assert_array_equal(at.rests_per_orbit, steady.rests_per_orbit)
    assert at.stable.item() == 1


def test_a_mass_that_is_pressed_all_the_time_is_released_where_the_force_reaches_the_pull() -> None:
    over_f = vp.branch(PRESSED, "f", (0.05, 1.5))
    assert over_f.bifurcation_kind.values[0] == Bifurcation.CHANGE
    assert over_f.bifurcation_f.values[0] == pytest.approx(0.7, abs=1e-13)
    over_delta = vp.branch(PRESSED, "delta", -0.55)
    assert over_delta.bifurcation_delta.values[0] == pytest.approx(-0.6, abs=1e-13)
    assert (over_f.floquet_multiplier.values[over_f.f.values < 0.7] == 0.0).all()


@pytest.mark.parametrize("name", ["f", "h", "l"])
def test_the_place_of_a_fold_beyond_the_rests_has_its_derivatives(name: str) -> None:
    assert int(vp.steady_state(SYMMETRIC).regime) == Regime.WITH_REST

    def folds(value: float) -> xr.Dataset:
        told = vp.branch(replace(SYMMETRIC, **{name: value}), "nu", 1.3, tolerance={name: 1e-3})
        return told.isel(bifurcation=told.bifurcation_kind == Bifurcation.FOLD)

    own, step = getattr(SYMMETRIC, name), 1e-5
    first = folds(own).isel(bifurcation=0)
    ends = [float(folds(own + change).bifurcation_nu[0]) for change in (step, -step)]
    slope = (ends[0] - ends[1]) / (2.0 * step)
    assert first.bifurcation_nu_sensitivity.item() == pytest.approx(slope, rel=1e-6)


def resting_exciters(number: int):
    rng, found = np.random.default_rng(7), []
    while len(found) < number:
        nu, f, h, delta = rng.uniform([0.3, 0.1, 0.0, -0.8], [2.0, 2.0, 0.3, 0.8]).tolist()
        one, two = rng.uniform(0.0, 0.7, 2).tolist()
        exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=h, delta=delta, R1=one, R2=two)
        if int(vp.steady_state(exciter, v0=0.1).regime) == Regime.WITH_REST:
            found.append(exciter)
    return found


@pytest.mark.filterwarnings("ignore::vibropipe.words.status.UnsolvedWarning")
def test_points_of_all_laws_return_when_rigid_supports_are_marched() -> None:
    """The march of rigid supports shares neither its step nor its events with that by pieces."""
    laws = set()
    for exciter, along in zip(resting_exciters(12), ("nu", "f", "delta", "l") * 3, strict=True):
        own = getattr(exciter, along)
        branch = vp.branch(exciter, along, (own - 0.1 * abs(own), own + 0.1 * abs(own)), v0=0.1)
        for i in np.linspace(0, branch.sizes["point"] - 1, 15).astype(int):
            point = branch.isel(point=i)
            moved = replace(exciter, **{along: float(point[along])})
            x, v = float(point.displacement_strobe), float(point.velocity_strobe)
            tau_end = int(point.period_multiple) * moved.period
            motion = vp.simulate(moved, tau_end, x, v, samples_per_period=0)
            grows = 1.0 + float(np.nanmax(np.abs(point.floquet_multiplier)))
            assert abs(float(motion.displacement_end) - x) < 2e-9 * grows, (exciter, along, i)
            assert abs(float(motion.velocity_end) - v) < 2e-9 * grows, (exciter, along, i)
            laws.add(tuple(point.impacts_per_orbit.values) + tuple(point.rests_per_orbit.values))
    assert len(laws) > 20
