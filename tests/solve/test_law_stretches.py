"""All stretches of a law: against closed forms over the whole range, against sweeps, and against the law itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

SYMMETRIC = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
ONE_SIDED = vp.Exciter(l=0.5, nu=1.0, f=0.3, h=0.1, delta=0.1, R1=0.6, R2=0.75)
RUBBED = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, k1=60.0, h1=1.0, R2=0.75, friction=0.1)
SLOW = vp.Exciter(l=0.5, nu=1.0, f=0.4, h=0.03, delta=-0.3, R1=0.8, R2=0.8)


def crossings(
    branch: xr.Dataset, along: str, value: float, support: int
) -> list[tuple[float, bool]]:
    """Return impact velocity on a support of all stretches at a value between points, and stability of these points."""
    found = []
    velocities = branch.impact_velocity_max.sel(support=support).values
    for n in np.unique(branch.branch_id.values):
        own = np.flatnonzero(branch.branch_id.values == n)
        at = branch[along].values[own]
        for i in np.flatnonzero((at[:-1] - value) * (at[1:] - value) < 0.0):
            share = (value - at[i]) / (at[i + 1] - at[i])
            first, last = velocities[own[i]], velocities[own[i + 1]]
            beside = {bool(flag) for flag in branch.stable.values[own[i : i + 2]]}
            found += [(float(first + share * (last - first)), flag) for flag in beside]
    return sorted(found)


def is_near_bifurcation(branch: xr.Dataset, value: float) -> bool:
    """Return whether a value is so close to a bifurcation that points beside it tell little."""
    return bool((np.abs(branch.bifurcation_nu.values - value) < 5e-3).any())


@pytest.mark.parametrize(
    ("law", "exciter", "support"),
    [((1, 1, 1), SYMMETRIC, 1), ((1, 0, 1), ONE_SIDED, 2), ((3, 1, 0), SLOW, 1)],
)
def test_they_are_all_orbits_in_closed_form(law, exciter, support):
    branch = vp.branch(exciter, "nu", (0.3, 5.0), law=law, harmonics=1, max_step=0.01)
    laws = np.column_stack([branch.period_multiple, branch.impacts_per_orbit])
    assert (laws == law).all()
    compared = 0
    for nu in np.linspace(0.31, 4.99, 200):
        if is_near_bifurcation(branch, nu):
            continue
        at = replace(exciter, nu=nu)
        orbits = (
            vp.symmetric_orbit(at) if law == (1, 1, 1) else vp.one_sided_orbit(at, support, law[0])
        )
        there = np.flatnonzero(orbits.admissible.values == 1)
        expected = sorted(
            (float(abs(orbits.impact_velocity[n, -1])), bool(orbits.stable[n])) for n in there
        )
        found = crossings(branch, "nu", nu, support)
        for speed, is_stable in expected:
            near = [each for each in found if abs(each[0] - speed) < 2e-3]
            assert near, (nu, speed)
            assert any(each[1] == is_stable for each in near), (nu, speed)
            compared += 1
        if law != (1, 1, 1):  # asymmetric ones have no closed form
            assert len({speed for speed, _stable in found}) == len(expected), nu
    assert compared > 20


@pytest.mark.parametrize(
    ("exciter", "law"), [(SYMMETRIC, (1, 1, 1)), (ONE_SIDED, (1, 0, 1)), (RUBBED, (1, 1, 1))]
)
def test_what_settles_from_other_starts_lies_on_a_stable_stretch(exciter, law):
    within = (0.4, 2.4)
    branch = vp.branch(exciter, "nu", within, law=law, harmonics=1)
    over = {"nu": np.linspace(0.411, 2.383, 60), "x0": [-0.3, 0.2], "v0": [-0.7, 0.4]}
    rows = vp.sweep(exciter, over, outputs=("impacts",)).stack(row=tuple(over))
    compared = 0
    for n in np.flatnonzero(rows.period_multiple.values == law[0]):
        row = rows.isel(row=n)
        if tuple(row.impacts_per_orbit.values) != law[1:]:
            continue
        if is_near_bifurcation(branch, float(row.nu)):
            continue
        support = 1 if law[1] else 2
        speed = float(row.impact_velocity_max.sel(support=support))
        found = crossings(branch, "nu", float(row.nu), support)
        assert any(abs(each - speed) < 5e-3 and is_stable for each, is_stable in found), float(
            row.nu
        )
        compared += 1
    assert compared > 10


def test_both_mirror_images_beyond_a_pitchfork_are_stretches():
    branch = vp.branch(SYMMETRIC, "nu", (0.3, 3.0), law=(1, 1, 1), harmonics=1)
    means = [
        float(
            branch.displacement_mean[branch.branch_id == n][
                int(np.abs(branch.nu.values[branch.branch_id.values == n] - 1.25).argmin())
            ]
        )
        for n in np.unique(branch.branch_id.values)
        if branch.nu[branch.branch_id == n].min() < 1.25 < branch.nu[branch.branch_id == n].max()
    ]
    assert sorted(np.sign(np.round(means, 9))) == [-1, 0, 1]
    assert abs(sum(means)) < 1e-3


def test_the_exciters_own_value_may_lie_elsewhere_and_a_start_is_refused():
    far = vp.branch(replace(SYMMETRIC, nu=9.0), "nu", (0.8, 1.1), law=(1, 1, 1), harmonics=1)
    near = vp.branch(SYMMETRIC, "nu", (0.8, 1.1), law=(1, 1, 1), harmonics=1)
    assert (far.nu.values == near.nu.values).all()
    assert far.attrs["law"] == "(1; 1, 1)"
    for beside in ({"x0": 0.1}, {"v0": 0.0}, {"switch": ("flip",)}):
        with pytest.raises(vp.ParameterError, match="must be left out beside law"):
            vp.branch(SYMMETRIC, "nu", (0.8, 1.1), law=(1, 1, 1), **beside)


@pytest.mark.parametrize("law", [(1, 1), (0, 1, 1), (1, 1.5, 1), "111", (1, -1, 0), (True, 1, 1)])
def test_what_is_no_law_is_refused(law):
    with pytest.raises(vp.ParameterError, match=r"law: must be .*a period multiple from 1 to 32"):
        vp.branch(SYMMETRIC, "nu", (0.8, 1.1), law=law)


def test_a_law_without_orbits_is_told():
    with pytest.raises(
        vp.ParameterError,
        match=r"law: must have orbits in the range of nu, got \(1; 5, 0\), of which none",
    ):
        vp.branch(SYMMETRIC, "nu", (2.0, 3.0), law=(1, 5, 0))


@pytest.mark.slow
def test_a_boundary_keeps_the_curves_of_a_law():
    box = {
        "of": ("grazing", "fold"),
        "along": ("nu", "f"),
        "within": ((0.7, 2.0), (0.3, 1.2)),
        "lines": 4,
    }
    all_of = vp.boundary(ONE_SIDED, **box)
    own = vp.boundary(ONE_SIDED, **box, law=(1, 0, 1))
    laws = np.column_stack([all_of.period_multiple, all_of.impacts_per_orbit])
    # (1; 0, 1) begins where the motion without impacts touches support 2, which is the nearer one
    touches = (laws == (1, 0, 0)).all(axis=1)
    is_kept = (laws == (1, 0, 1)).all(axis=1) | touches
    assert 0 < touches.sum() < is_kept.sum() < is_kept.size
    np.testing.assert_array_equal(own.nu, all_of.nu[is_kept])
    assert own.attrs["law"] == "(1; 0, 1)"
