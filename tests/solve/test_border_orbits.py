"""Unstable orbits between basins, against branches and the motions beside them."""

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.solve.basins.section_map import SectionMap

THREE = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.61, f=1.66, h=0.02, R1=0.8, R2=0.8)
# Beside a stable orbit of nine forcing periods there is an unstable one.
NINE = vp.Exciter(l=0.5, nu=3.559, f=0.591, h=0.06534, R1=0.8764, R2=0.8764)
PAPER = vp.Exciter(l=0.5, nu=2.5, f=-1.0, h=0.2, R1=0.7, R2=0.7)


def basins_of(exciter, n=40, velocity=2.0, phase=0.0):
    xs = np.linspace(exciter.lower, exciter.upper, n)
    return vp.basins(exciter, xs, np.linspace(-velocity, velocity, n), phase=phase, starts=256)


def points_of(basins, orbit):
    own = basins.border_point_orbit.values == orbit
    return np.column_stack(
        [basins.border_point_displacement.values[own], basins.border_point_velocity.values[own]]
    )


def nearest_attractor(basins, state):
    """Return the attractor that has a state among its states at the section."""
    away = np.hypot(
        basins.poincare_displacement.values - state[0], basins.poincare_velocity.values - state[1]
    ).min(axis=1)
    assert away.min() < 1e-7
    return int(away.argmin())


@pytest.mark.parametrize(
    ("exciter", "multiples"), [(THREE, [1, 3]), (SYMMETRIC, [1] * 3), (PAPER, [1]), (NINE, [9])]
)
def test_starts_on_either_side_settle_on_either_attractor(exciter, multiples):
    """Of NINE the orbit of nine periods: a third basin has strips beside the others."""
    basins, section = basins_of(exciter), SectionMap(exciter)
    sought = np.flatnonzero(np.isin(basins.border_orbit_multiple, multiples))
    assert basins.border_orbit_multiple.values[sought].tolist() == multiples
    for orbit in sought:
        points, m = points_of(basins, orbit), int(basins.border_orbit_multiple[orbit])
        assert len(points) == m
        images, _contacts = section.images(points, m)
        np.testing.assert_allclose(images, points, atol=1e-9)
        multipliers, vectors = np.linalg.eig(section.jacobian(points[0], m))
        found = basins.border_orbit_multiplier.values[orbit]
        np.testing.assert_allclose(np.sort(abs(multipliers))[::-1], abs(found), rtol=1e-6)
        # One multiplier leads away from the orbit: its stable set is a line that separates.
        assert abs(found[0]) > 1 > abs(found[1])
        away = np.real(vectors[:, np.argmax(abs(multipliers))])
        late = [section.sections(points[0] + sign * 1e-7 * away, 3000)[-1] for sign in (1, -1)]
        settled = {nearest_attractor(basins, state) for state in late}
        assert settled == {*basins.border_orbit_attractor.values[orbit].tolist()}


def test_the_unstable_branch_of_a_fold_is_the_border():
    """Continuation of the two-sided orbit round its fold passes the same orbit."""
    basins = basins_of(PAPER)
    (point,) = points_of(basins, 0)
    strong = int(basins.impacts_per_orbit.sum("support").values.argmax())
    x0, v0 = (basins[f"poincare_{n}"].values[strong, 0] for n in ("displacement", "velocity"))
    branch = vp.branch(PAPER, "nu", (2.4, 4.0), x0=x0, v0=v0, at=[2.5])
    at = np.flatnonzero((branch.nu.values == 2.5) & (branch.stable.values == 0))
    assert at.size == 1
    section = SectionMap(PAPER)
    state = np.array([branch.displacement_strobe[at].item(), branch.velocity_strobe[at].item()])
    np.testing.assert_allclose(state, point, atol=1e-9)
    np.testing.assert_allclose(
        branch.floquet_multiplier[at[0]], basins.border_orbit_multiplier[0], rtol=1e-6
    )
    assert section.images(state[None], 1)[0] == pytest.approx(state[None], abs=1e-9)


def test_another_phase_of_the_start_has_the_same_orbits():
    now, later = basins_of(PAPER), basins_of(PAPER, phase=0.3)
    for name in ("displacement", "velocity"):
        name = f"border_point_{name}"
        np.testing.assert_allclose(now[name], later[name], atol=1e-9)


def test_one_attractor_has_no_border():
    alone = basins_of(vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7), n=10)
    assert alone.sizes["attractor_id"] == 1
    assert alone.sizes["border_orbit"] == 0
