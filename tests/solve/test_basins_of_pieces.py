"""Attractors, basins and their borders with soft supports, dry friction or a housing that slides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.jobs.report_data import report_data
from vibropipe.scenes.registry import kind_of
from vibropipe.solve.basins.section_map import SectionMap
from vibropipe.study import StudyError, study_of_text

# It is its own mirror image: what goes forwards goes backwards from the mirrored start.
PAIR = vp.Exciter(
    l=0.5, nu=1.6, f=1.0, h=0.1, R1=0.7, R2=0.7, mass_ratio=0.3,
    housing_friction_1=0.15, housing_friction_2=0.15,
)  # fmt: skip


def test_forwards_and_backwards_are_told_apart() -> None:
    found = vp.attractors(PAIR, starts=100)
    assert found.sizes["attractor_id"] == 2
    back, forth = found.housing_velocity_mean.values
    assert back == pytest.approx(-forth, rel=1e-10)
    assert forth > 0.01
    assert float(found.basin_share.sum()) == 1.0
    assert (found.basin_share_low < found.basin_share).all()
    assert np.isfinite(found.poincare_displacement).all()


def test_each_start_settles_where_it_does_alone() -> None:
    x0, v0 = np.linspace(-0.5, 0.5, 5), np.linspace(-1, 1, 4)
    found = vp.basins(PAIR, x0, v0)
    assert found.attractor.shape == (5, 4)
    for x in x0:
        for v in v0:
            alone = vp.steady_state(PAIR, x0=float(x), v0=float(v))
            number = int(found.attractor.sel(x0=x, v0=v))
            speed = float(found.housing_velocity_mean[number])
            assert speed == pytest.approx(float(alone.housing_velocity_mean), abs=1e-10)
            assert int(found.periods_to_attractor.sel(x0=x, v0=v)) == int(alone.periods_to_settle)
    shares = [float((found.attractor == number).mean()) for number in (0, 1)]
    assert shares == found.basin_share.values.tolist()
    assert set(np.unique(found.border)) <= {0, 1}


def test_a_continuum_of_motions_has_no_attractor() -> None:
    # friction that is the same both ways brakes no drift of a housing that turns round in time
    free = replace(PAIR, nu=2.0, housing_friction_1=0.0, housing_friction_2=0.0)
    assert abs(vp.steady_state(free).floquet_multiplier).max() == pytest.approx(1.0, abs=1e-9)
    found = vp.attractors(free, starts=20)
    assert found.sizes["attractor_id"] == 0


def test_chatter_of_any_number_of_counted_impacts_is_one_motion() -> None:
    slow = vp.Exciter(
        l=0.4, nu=0.5, f=1.2, h=0.2, R1=0.6, R2=0.6, mass_ratio=0.3, housing_friction_1=0.05,
        housing_friction_2=0.2,
    )  # fmt: skip
    found = vp.attractors(slow, starts=100)
    assert found.sizes["attractor_id"] == 1
    assert found.rests_per_orbit.all()
    robot = vp.Exciter.from_physical(
        m=0.2, M=0.5, C=8e3, H=4, l=3e-3, F=20, omega="10 Hz", R1=0.6, R2=0.6, D1=1.5, D2=4
    )
    assert vp.attractors(robot, starts=100).sizes["attractor_id"] == 1


STUDY = """
title: T
exciter: {l: 0.5, nu: 1.6, f: 1, h: 0.1, R1: 0.7, R2: 0.7, mass_ratio: 0.3, housing_friction_1: 0.15,
  housing_friction_2: 0.15}
scenes:
  s:
    kind: basins
    over: {x0: {start: -0.5, stop: 0.5, points: 12}, v0: {start: -1, stop: 1, points: 10}}
"""


def test_a_study_has_basins_with_a_housing() -> None:
    study = study_of_text(STUDY, "study")
    scene = study.scene("s")
    data = kind_of(scene).solve(scene)
    assert data.sizes["attractor_id"] == 2
    report = report_data(study, {"s": data}, {})
    assert report["answers"]
    for picture in kind_of(scene).pictures_of(data):
        picture.draw(data, scene.figure, {"s": data})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("kind: basins", "kind: basins\n    phase: 0.5", "s.phase: must be left out with mass_rat"),
        ("points: 10}", "points: 10}, nu: [1, 2]", "s.over.nu: must be left out with mass_ratio"),
    ],
)
def test_what_is_not_computed_is_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        study_of_text(STUDY.replace(old, new), "study")


FORCED = {"l": 0.5, "nu": 1.8, "f": 0.8, "h": 0.2, "R1": 0.7, "R2": 0.7}
SOFT = vp.Exciter(**FORCED | {"R1": 1.0}, delta=-0.05, k1=200.0, h1=3.0, friction=0.15)
BOTH_SOFT = vp.Exciter(l=0.5, nu=2.3, f=0.6, h=0.05, k1=300.0, k2=300.0, h1=3.0, h2=3.0)
# The mass sticks at the section: near motions slide there.
HELD_AT_SECTION = vp.Exciter(**{**FORCED, "nu": 0.6, "f": 0.7, "h": 0.05}, friction=0.35)
HELD_FOR_EVER = vp.Exciter(**{**FORCED, "nu": 1.0, "f": 1.0}, friction=1.2)
VELOCITIES = np.linspace(-2.0, 2.0, 9)


@pytest.mark.parametrize(
    ("exciter", "x0", "count"),
    [
        (SOFT, np.linspace(-0.55, 0.6, 7), 2),
        pytest.param(BOTH_SOFT, np.linspace(-0.7, 0.7, 7), 2, marks=pytest.mark.slow),
        pytest.param(HELD_AT_SECTION, np.linspace(-0.5, 0.5, 7), 1, marks=pytest.mark.slow),
    ],
    ids=["one soft", "both soft", "held at section"],
)
def test_each_start_settles_on_its_attractor(
    exciter: vp.Exciter, x0: np.ndarray, count: int
) -> None:
    ds = vp.basins(exciter, x0, VELOCITIES, starts=128)
    assert ds.sizes["attractor_id"] == count
    assert (ds.attractor >= 0).all()
    for i, j in ((0, 0), (1, 6), (3, 4), (4, 2), (6, 8)):
        one = vp.steady_state(exciter, x0=x0[i], v0=VELOCITIES[j], outputs=[])
        own = ds.sel(attractor_id=int(ds.attractor[i, j]))
        away = np.hypot(
            own.poincare_displacement - float(one.displacement_strobe),
            own.poincare_velocity - float(one.velocity_strobe),
        )
        assert float(away.min()) < 1e-9
    mirrored = vp.basins(exciter.mirrored(), -x0[::-1], VELOCITIES, starts=128)
    order = [
        int(np.abs(mirrored.displacement_strobe.values + float(x)).argmin())
        for x in ds.displacement_strobe
    ]
    assert (np.array(order)[ds.attractor.values] == mirrored.attractor.values[::-1, ::-1]).all()


def test_a_border_has_its_unstable_orbit() -> None:
    x0 = np.linspace(-0.55, 0.45, 9)
    ds = vp.basins(SOFT, x0, VELOCITIES, starts=128)
    assert ds.sizes["border_orbit"] == 1
    assert abs(ds.border_orbit_multiplier.values[0, 0]) > 1.0
    x, v = float(ds.border_point_displacement[0]), float(ds.border_point_velocity[0])
    after = vp.simulate(SOFT, SOFT.period, x, v, samples_per_period=0)
    assert float(after.displacement_end) == pytest.approx(x, abs=1e-10)
    assert float(after.velocity_end) == pytest.approx(v, abs=1e-10)


def test_places_where_friction_holds_the_mass_attract_nothing() -> None:
    ds = vp.basins(HELD_FOR_EVER, [-0.1, 0.0, 0.3], [0.0, 0.5], starts=16)
    assert ds.sizes["attractor_id"] == 0
    assert (ds.attractor == -1).all()


def test_a_motion_appears_where_friction_no_longer_holds_the_mass() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.4, h=0.1, R1=0.7, R2=0.7, friction=0.3)
    start, over = np.linspace(-0.4, 0.4, 3), {"f": [0.2, 0.4]}
    found = vp.basins(exciter, start, start, starts=64, over=over)
    # Carried down it went on as the mass that is held, to the last value.
    assert found.bifurcation_f.values == pytest.approx([0.3], abs=2e-4)


def test_a_start_beyond_a_soft_support_stays_there() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.0, k1=300.0, friction=200.0)
    assert float(vp.steady_state(exciter, x0=0.6).displacement_strobe) == 0.6
    with pytest.raises(vp.ParameterError, match="between the supports"):
        vp.steady_state(exciter, x0=-0.6)


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
