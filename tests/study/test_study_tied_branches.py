"""Scenes of branches and boundaries with ties: data of the call in Python, pictures, tables, units and faults."""

import numpy as np
import pytest
import xarray as xr
from drawing import caption, draw
from study_texts import faults, study_of

import vibropipe as vp
from vibropipe.figures.line_names import NAME
from vibropipe.jobs.report_data import report_data
from vibropipe.scenes.registry import kind_of

BRANCHES = """\
title: T
exciter: {l: 0.5, R1: 0.7}
ties: {R2: R1, f: 0.3 * nu**2, h: 2 * zeta}
scenes:
  s:
    kind: branch
    along: {nu: {from: 1.05, to: 1.6}}
    over: {zeta: [0.08, 0.1]}
    start: {v0: 0.1}
"""
TIES = {"R2": "R1", "f": "0.3 * nu**2", "h": "2 * zeta"}


def text(
    along: str = "nu: {from: 1.05, to: 1.6}", over: str = "zeta: [0.08, 0.1]", more: str = ""
) -> str:
    whole = BRANCHES.replace("nu: {from: 1.05, to: 1.6}", along) + more
    return whole.replace(
        "    over: {zeta: [0.08, 0.1]}\n", f"    over: {{{over}}}\n" if over else ""
    )


def test_a_further_name_of_ones_own_has_a_branch_at_each_value(tmp_path):
    study = study_of(text(), tmp_path)
    scene = study.scenes["s"]
    dataset = kind_of(scene).solve(scene)
    exciter = vp.Exciter(l=0.5, R1=0.7, nu=1.05)
    for zeta in (0.08, 0.1):
        alone = vp.branch(exciter, "nu", 1.6, v0=0.1, harmonics=3, ties={**TIES, "zeta": zeta})
        own = dataset.isel(point=dataset.zeta.values == zeta)
        for name in ("nu", "f", "displacement_amplitude", "impact_velocity_max"):
            np.testing.assert_array_equal(own[name], alone[name])
        assert (own.h.values == 2 * zeta).all()
    assert dataset.attrs["ties"] == "R2 = R1; f = 0.3 * nu**2; h = 2 * zeta"
    assert dataset.zeta.attrs["long_name"] == "zeta"
    figure = draw("branch", dataset, scene.figure)
    written = {each.get_text() for ax in figure.axes for each in ax.texts if each.get_gid() == NAME}
    assert written == {"zeta = 0.08", "zeta = 0.1"}
    assert "R₂ = R₁, f = 0.3 · ν², h = 2 · zeta" in caption(scene, dataset, {})
    assert report_data(study, {"s": dataset}, {})


@pytest.mark.parametrize("more", ["", "    law: [1, 1, 1]\n"])
def test_a_name_of_ones_own_is_followed(tmp_path, more):
    along = "zeta: {within: [0.03, 0.1]}" if more else "zeta: {from: 0.03, to: 0.1}"
    whole = text(along, "", more).replace("R1: 0.7}", "R1: 0.7, nu: 1.05}")
    study = study_of(whole.replace("    start: {v0: 0.1}\n", "") if more else whole, tmp_path)
    scene = study.scenes["s"]
    dataset = kind_of(scene).solve(scene)
    options = {"law": (1, 1, 1)} if more else {"v0": 0.1}
    exciter = vp.Exciter(l=0.5, R1=0.7, nu=1.05)
    expected = vp.branch(exciter, "zeta", (0.03, 0.1), harmonics=3, ties=TIES, **options)
    xr.testing.assert_identical(dataset.drop_vars("from_rest"), expected)
    figure = draw("branch", dataset, scene.figure)
    assert figure.axes[-1].get_xlabel() == "zeta"
    assert report_data(study, {"s": dataset}, {})
    assert {"damping", "forcing", "restitution"} <= {*scene.called_effects()}


def test_what_follows_the_further_parameter_varies_over_its_branches(tmp_path):
    whole = text(over="R1: [0.6, 0.7]").replace("R1: 0.7", "nu: 1.05")
    whole = whole.replace("2 * zeta", "0.2").replace("nu: 1.05}", "}").replace(", }", "}")
    scene = study_of(whole, tmp_path).scenes["s"]
    dataset = kind_of(scene).solve(scene)
    np.testing.assert_array_equal(dataset.R1, dataset.R2)
    assert {*dataset.R2.values.tolist()} == {0.6, 0.7}


def test_branches_with_units_are_those_without_in_si(tmp_path):
    whole = text("omega: {from: 21 rad/s, to: 30 rad/s}", "R1: [0.7]")
    whole = whole.replace("exciter: {l: 0.5, R1: 0.7}", "physical: {m: 2 kg, C: 800 N/m, l: 0.5 m}")
    whole = whole.replace("2 * zeta", "0.2").replace("start: {v0: 0.1}", "start: {v0: 2 m/s}")
    scene = study_of(whole, tmp_path).scenes["s"]
    dataset = kind_of(scene).solve(scene)
    np.testing.assert_allclose(dataset.F, 0.3 * 800 * (dataset.omega / 20) ** 2, rtol=1e-12)
    plain = vp.branch(
        vp.Exciter(l=0.5, R1=0.7, nu=1.05), "nu", 1.5, v0=0.1, ties={**TIES, "h": 0.2}
    )
    np.testing.assert_allclose(dataset.bifurcation_omega, 20 * plain.bifurcation_nu, rtol=1e-9)


@pytest.mark.parametrize(
    ("along", "over", "told"),
    [
        ("f: {from: 1, to: 1.2}", "zeta: [0.1]", "scenes.s.along.f: must be left out, since it is tied"),
        ("nu: {from: 1, to: 1.2}", "f: [0.1]", "scenes.s.over.f: must be left out, since it is tied"),
        ("nu: {from: 1, to: 1.2}", "zeta: [-0.1]", "ties.h: must be a finite number >= 0, got -0.2"),
        ("nu: {from: 1, to: 1.2}", "eta: [0.1]", "scenes.s.over.eta: is an unknown key"),
        ("zeta: {from: 0.1, to: [0.05, 0.2]}", "nu: [1]", "scenes.s.along.zeta.to: must be one number"),
        ("zeta: {from: 0.1, to: -0.05}", "nu: [1]", "ties.h: must be a finite number >= 0"),
        ("zeta: {from: 0.1}", "nu: [1]", "scenes.s.along.zeta.to: is required (a finite number)"),
        ("nu: {from: 1, to: 1.2}", "", "ties.h: must have a value for zeta"),
    ],
)  # fmt: skip
def test_ties_that_cannot_hold_are_refused(tmp_path, along, over, told):
    found = faults(text(along, over), tmp_path)
    assert any(line.startswith(told) for line in found), found


def test_a_name_of_ones_own_is_a_pure_number_also_where_a_study_has_units(tmp_path):
    units = BRANCHES.replace(
        "exciter: {l: 0.5, R1: 0.7}",
        "physical: {m: 1 kg, C: 4 N/mm, l: 5 mm, omega: 11 Hz}\nexciter: {R1: 0.7}",
    )
    tied = units.replace("f: 0.3 * nu**2, ", "f: 0.3, ").replace(
        "nu: {from: 1.05, to: 1.6}", "zeta: {from: 0.02, to: 0.3}"
    )
    scene = study_of(
        tied.replace("    over: {zeta: [0.08, 0.1]}\n    start: {v0: 0.1}\n", ""), tmp_path
    ).scenes["s"]
    assert kind_of(scene).plan(scene).size == "zeta from 0.02 to 0.3"


BOUNDARIES = """\
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


@pytest.mark.slow
def test_a_scene_has_the_curves_of_the_call(tmp_path):
    study = study_of(BOUNDARIES, tmp_path)
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
    assert "Tied: R₂ = R₁, f = me · ν²." in text
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
    found = faults(BOUNDARIES.replace(old, new), tmp_path)
    assert [line for line in found if line.startswith(told)] == found


def test_data_move_with_their_ties(tmp_path):
    one = study_of(BOUNDARIES, tmp_path).scenes["s"].fingerprint()
    other = study_of(BOUNDARIES.replace("R2: R1", "R2: R1**2"), tmp_path).scenes["s"].fingerprint()
    assert one != other
