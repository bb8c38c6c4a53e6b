"""Branches of exciters with a housing that slides: against motions, sweeps, and multipliers by differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from housings import FREE, RUBBED, SECTION, STRUCK, SYMMETRIC, section_map

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation, BranchEnd

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
