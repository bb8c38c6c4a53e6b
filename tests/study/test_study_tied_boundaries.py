"""Scenes of boundaries with ties: data of the call in Python, picture, axes, caption, units, and faults."""

import numpy as np
import pytest
from drawing import caption, draw
from study_texts import faults, study_of

import vibropipe as vp
from vibropipe.jobs.report_data import report_data
from vibropipe.scenes.registry import kind_of

STUDY = """\
title: T
exciter: {l: 0.5, R1: 0.7, h: 0.15}
ties: {R2: R1, f: me * nu**2}
scenes:
  s:
    kind: boundary
    of: [grazing, {impact_velocity_max_1: 0.8}]
    over: {nu: [0.8, 1.4], me: [0.2, 0.8]}
    lines: 2
"""
PHYSICAL = """\
title: T
physical: {m: 0.5 kg, C: 50 N/m, l: 5 mm, H: 0.5 N s/m}
exciter: {R1: 0.7}
ties: {R2: R1, f: 0.004 * me * nu**2}
scenes:
  s:
    kind: boundary
    of: [grazing]
    over: {omega: [9 rad/s, 15 rad/s], me: [0.2, 0.8]}
    lines: 2
"""


def test_a_scene_has_the_curves_of_the_call(tmp_path):
    study = study_of(STUDY, tmp_path)
    scene = study.scenes["s"]
    dataset = kind_of(scene).solve(scene)
    expected = vp.boundary(
        vp.Exciter(l=0.5, h=0.15, R1=0.7), ["grazing", {"impact_velocity_max_1": 0.8}], ("nu", "me"),
        [(0.8, 1.4), (0.2, 0.8)], 2, ties={"R2": "R1", "f": "me * nu**2"},
    )  # fmt: skip
    assert dataset.sizes["point"] > 20
    for name in ("nu", "me", "f", "boundary_kind", "impact_velocity_max"):
        np.testing.assert_array_equal(dataset[name], expected[name])
    np.testing.assert_array_equal(dataset.me.attrs["box"], [0.2, 0.8])
    (ax,) = draw("boundary", dataset, scene.figure).axes
    assert ax.get_ylabel() == "me"
    assert ax.get_ylim() == (0.2, 0.8)
    text = caption(scene, dataset, {})
    assert "over ν and me" in text
    assert "Tied: R2 = R1, f = me * nu**2." in text
    assert report_data(study, {"s": dataset}, {})


def test_curves_in_units_are_those_without(tmp_path):
    scene = study_of(PHYSICAL, tmp_path).scenes["s"]
    dataset = kind_of(scene).solve(scene)
    p = 10.0  # sqrt(C / m) in 1/s
    plain = vp.boundary(
        vp.Exciter(l=0.005, h=0.1, R1=0.7), "grazing", ("nu", "me"), [(0.9, 1.5), (0.2, 0.8)], 2,
        ties={"R2": "R1", "f": "0.004 * me * nu**2"},
    )  # fmt: skip
    assert dataset.sizes["point"] > 20
    np.testing.assert_allclose(dataset.omega, plain.nu * p, rtol=1e-11)
    np.testing.assert_allclose(dataset.F, plain.f * 50.0, rtol=1e-11)
    np.testing.assert_allclose(dataset.me, plain.me, rtol=1e-11)
    assert dataset.me.attrs["units"] == "1"
    np.testing.assert_allclose(dataset.omega.attrs["box"], [9.0, 15.0])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "me: [0.2, 0.8]",
            "mee: [0.2, 0.8]",
            "scenes.s.over.mee: is an unknown key; must be one of",
        ),
        ("me: [0.2, 0.8]", "f: [0.2, 0.8]", "scenes.s.over.f: must be left out, since it is tied"),
        ("f: me * nu**2", "f: me * nu**2, R1: me", "scenes.s.exciter.R1: must be left out"),
        ("R2: R1", "R2: 2 * me", "ties.R2: must be a number from 0 to 1, got 1.0"),
        (
            "R2: R1",
            "R2: R1, friction: me - 0.5",
            "ties.friction: must be a finite number >= 0, got -0.3 at",
        ),
    ],
)
def test_faults_say_where_they_are(tmp_path, old, new, told):
    found = faults(STUDY.replace(old, new), tmp_path)
    assert [line for line in found if line.startswith(told)] == found


def test_data_move_with_their_ties(tmp_path):
    one = study_of(STUDY, tmp_path).scenes["s"].fingerprint()
    other = study_of(STUDY.replace("R2: R1", "R2: R1**2"), tmp_path).scenes["s"].fingerprint()
    assert one != other
