"""Branches of orbits with a housing that slides, or that rest on supports: against motions and sweeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from housings import FREE, RUBBED, SECTION, STRUCK, SYMMETRIC, section_map

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation, BranchEnd
from vibropipe.words.regimes import Regime

SOFT = vp.Exciter(
    nu=0.738, f=0.589, h=0.346, l=0.3, delta=0.041, R2=0.84, mass_ratio=0.274, k1=804.0, h1=0.4,
    housing_friction_1=0.364, housing_friction_2=1.092, housing_load=-0.257,
)  # fmt: skip
# A pair of multipliers meets the unit circle along nu.
TURNING = vp.Exciter(
    l=1.0, nu=0.883, f=1.365, h=0.0062, delta=0.049, R1=0.92, R2=0.8, mass_ratio=2.19,
    housing_friction_1=0.0777, housing_friction_2=0.2332, housing_load=0.0536,
)  # fmt: skip
CASES = {
    "struck": (STRUCK, "nu", (0.9, 1.2)),
    "heavier": (STRUCK, "mass_ratio", (0.2, 1.2)),
    "friction up": (STRUCK, "housing_friction_1", (0.1, 0.6)),
    "friction down": (STRUCK, "housing_friction_2", (0.2, 0.8)),
    "pulled": (STRUCK, "housing_load", (-0.2, 0.2)),
    "soft": (SOFT, "k1", (300.0, 1500.0)),
    "symmetric": (SYMMETRIC, "f", (0.6, 1.2)),
    "rubbed": (RUBBED, "friction", (0.02, 0.4)),
    "free": (FREE, "f", (0.5, 1.5)),
}


@pytest.fixture(scope="module")
def branches():
    return {
        name: vp.branch(exciter, along, to, harmonics=1)
        for name, (exciter, along, to) in CASES.items()
    }


def kinds(branch):
    return [Bifurcation(int(kind)).name for kind in branch.bifurcation_kind]


@pytest.mark.parametrize("case", CASES)
def test_points_are_orbits_stable_or_not(branches, case):
    """Motions from points, some between bifurcations, return after their periods, but for what grows."""
    (exciter, along, to), branch = CASES[case], branches[case]
    assert float(branch[along].min()) >= to[0]
    assert float(branch[along].max()) <= to[1]
    assert np.unique(branch.status.values).tolist() == [0]
    growth = 1.0 + np.abs(branch.floquet_multiplier.values).max(axis=1) ** 2
    assert (branch.residual.values / growth).max() < 1e-11
    mild = np.flatnonzero(growth < 1e6)
    for i in mild[np.linspace(0, mild.size - 1, 12).astype(int)]:
        at = replace(exciter, **{along: float(branch[along][i])})
        state = np.array([float(branch[name][i]) for name in SECTION])
        end = section_map(at, state, int(branch.period_multiple[i]))
        np.testing.assert_allclose(end, state, atol=1e-10 * growth[i])


@pytest.mark.parametrize("case", CASES)
def test_branches_pass_the_ends_of_laws(branches, case):
    branch = branches[case]
    if case != "soft":
        assert kinds(branch).count("CHANGE") >= 2
    reasons = {BranchEnd(int(each)).name for each in branch.end_reason.values}
    assert reasons <= {"GOES_ON"}
    for name in ("housing_velocity_mean", "housing_velocity_max", "housing_slip_share"):
        assert np.isfinite(branch[name].values).all()


def test_stable_points_are_the_steady_states_of_a_sweep():
    nu = np.linspace(0.95, 1.2, 26)
    branch = vp.branch(STRUCK, "nu", (0.9, 1.25), at=nu, harmonics=1)
    rows = vp.sweep(STRUCK, {"nu": nu}, follow=("nu", "down"), harmonics=1, outputs=("stability",))
    compared = 0
    for i, value in enumerate(nu):
        at = np.flatnonzero((branch.nu.values == value) & (branch.stable.values == 1))
        means = branch.housing_velocity_mean.values[at]
        if int(rows.period_multiple[i]) != 1 or not at.size:
            continue
        compared += 1
        best = at[np.abs(means - float(rows.housing_velocity_mean[i])).argmin()]
        for name in (
            "housing_velocity_mean",
            "housing_velocity_max",
            "housing_slip_share",
            *SECTION,
        ):
            assert float(branch[name][best]) == pytest.approx(float(rows[name][i]), abs=1e-9), name
        found = np.sort_complex(branch.floquet_multiplier.values[best])
        expected = np.sort_complex(rows.floquet_multiplier.values[i])
        np.testing.assert_allclose(found, expected, atol=1e-7)
    assert compared >= 20


def test_a_neimark_sacker_bifurcation_has_a_pair_on_the_unit_circle_by_differences():
    between = 0.93241  # of a flip and this bifurcation
    branch = vp.branch(TURNING, "nu", (0.85, 0.95), at=(between,), harmonics=1)
    (index, *_more) = np.flatnonzero(branch.bifurcation_kind == Bifurcation.NEIMARK_SACKER)
    point = int(branch.bifurcation_point[index])
    exciter = replace(TURNING, nu=float(branch.nu[point]))
    state = np.array([float(branch[name][point]) for name in SECTION])
    m, step = int(branch.period_multiple[point]), 1e-7
    matrix = np.empty((3, 3))
    for j in range(3):
        change = step * np.eye(3)[j]
        ahead, behind = (section_map(exciter, state + sign * change, m) for sign in (1.0, -1.0))
        matrix[:, j] = (ahead - behind) / (2.0 * step)
    values = np.linalg.eigvals(matrix)
    pair = values[np.abs(values.imag) > 0.1]
    assert pair.size == 2
    # The map bends where the housing stops: differences converge with the step alone.
    np.testing.assert_allclose(np.abs(pair), 1.0, atol=2e-6)
    assert branch.nu.values[point - 1] == between
    assert branch.stable.values[[point - 1, point + 1]].tolist() == [1, 0]
    pair = branch.floquet_multiplier.values[point + 1]
    assert abs(pair[0]) == pytest.approx(abs(pair[1]))
    assert abs(pair[0].imag) > 0.1


def test_a_symmetric_orbit_does_not_progress_and_its_asymmetric_children_do_opposite_ways():
    branch = vp.branch(SYMMETRIC, "f", (0.6, 1.2), switch=["pitchfork"], harmonics=1)
    assert "PITCHFORK" in kinds(branch)
    own = branch.branch_id.values == 0
    mean = branch.housing_velocity_mean.values
    growth = 1.0 + np.abs(branch.floquet_multiplier.values).max(axis=1) ** 2
    assert (np.abs(mean) / growth)[own].max() < 1e-12
    one, two = (mean[branch.branch_id.values == number] for number in (1, 2))
    assert np.abs(one).max() > 1e-3
    assert np.abs(one).max() == pytest.approx(np.abs(two).max(), rel=1e-6)
    assert one[np.abs(one).argmax()] * two[np.abs(two).argmax()] < 0.0


def test_a_housing_that_friction_holds_has_the_branch_of_a_fixed_one():
    held = replace(FREE, f=0.6, housing_friction_1=9.0, housing_friction_2=9.0)
    fixed = replace(FREE, f=0.6, mass_ratio=0.0, housing_friction_1=0.0, housing_friction_2=0.0)
    wanted = np.linspace(0.5, 0.75, 6)
    one, two = (vp.branch(each, "f", (0.45, 0.8), at=wanted, harmonics=1) for each in (fixed, held))
    assert not two.housing_slip_share.values.any()
    for value in wanted:
        i, j = (int(np.flatnonzero(each.f.values == value)[0]) for each in (one, two))
        for name in ("displacement_strobe", "velocity_strobe"):
            assert float(two[name][j]) == pytest.approx(float(one[name][i]), abs=1e-13)
        expected = np.append(np.sort_complex(one.floquet_multiplier.values[i]), 0.0)
        found = two.floquet_multiplier.values[j]
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), atol=1e-13)


def test_derivatives_along_a_branch_are_the_slopes_of_its_quantities():
    wanted = np.linspace(1.0, 1.04, 9)
    told = vp.branch(STRUCK, "nu", (0.95, 1.05), at=wanted, outputs=["sensitivity"])
    inner = told.isel(point=[int(np.flatnonzero(told.nu.values == each)[0]) for each in wanted])
    for name in ("housing_velocity_mean", "housing_slip_share", "velocity_strobe"):
        by = inner[f"{name}_sensitivity"].sel(parameter="nu").values[4]
        # of fourth order
        own = inner[name].values
        step = wanted[5] - wanted[4]
        slope = (8 * (own[5] - own[3]) - (own[6] - own[2])) / (12 * step)
        assert by == pytest.approx(slope, rel=1e-5)


def test_what_is_not_followed_is_refused_in_words():
    loose = replace(STRUCK, housing_friction_1=0.0, housing_friction_2=0.0)
    with pytest.raises(
        vp.ParameterError, match="housing_friction_1: must be above 0, or housing_fr"
    ):
        vp.branch(loose, "nu", (0.9, 1.2))
    rests = replace(SYMMETRIC, nu=0.3, l=0.5, housing_friction_1=0.5, housing_friction_2=0.5)
    with pytest.raises(vp.ParameterError, match="pushes a held housing off without end"):
        vp.branch(rests, "nu", (0.29, 0.31))


CHATTERING = vp.Exciter(l=0.5, nu=1.04, f=1.956, h=0.274, delta=0.413, R1=0.275, R2=0.345)
SYMMETRIC_RESTS = vp.Exciter(l=0.5, nu=1.1, f=2.0, h=0.1, R1=0.3, R2=0.3)
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
    assert int(vp.steady_state(SYMMETRIC_RESTS).regime) == Regime.WITH_REST

    def folds(value: float) -> xr.Dataset:
        told = vp.branch(
            replace(SYMMETRIC_RESTS, **{name: value}), "nu", 1.3, tolerance={name: 1e-3}
        )
        return told.isel(bifurcation=told.bifurcation_kind == Bifurcation.FOLD)

    own, step = getattr(SYMMETRIC_RESTS, name), 1e-5
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
