"""Motions that an exciter with a housing that slides settles on: forwards and backwards, each start by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.jobs.report_data import report_data
from vibropipe.scenes.registry import kind_of
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
