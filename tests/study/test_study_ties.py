"""The key `ties`: rows are those of the call in Python, names of one's own vary, and faults are told in words."""

import numpy as np
import pytest
import xarray as xr
from study_texts import faults, study_of

import vibropipe as vp
from vibropipe.scenes.registry import kind_of
from vibropipe.scenes.sweep.cut import join, recompute, store

STUDY = """\
title: T
exciter: {{l: 1, delta: 0.1, R1: 0.7}}
ties: {{R2: R1{shared}}}
scenes:
  s:
    kind: sweep
    over: {{{over}}}
    outputs: [harmonics, impacts, sensitivity]
    ties: {{{own}}}
"""
OVER = "ζeta: [0.02, 0.05], ν: [0.9, 1.2]".replace("ζeta", "zeta")
OWN = "f: 0.5 * ν**2, h: 2 * zeta"


def text(over=OVER, own=OWN, shared="", follow="", **changed):
    whole = STUDY.format(over=over, own=own, shared=shared)
    for old, new in changed.items():
        whole = whole.replace(old, new)
    return whole + (f"    follow: {follow}\n" if follow else "")


def test_a_scene_is_the_sweep_in_python(tmp_path):
    scene = study_of(text(), tmp_path).scenes["s"]
    solved = kind_of(scene).solve(scene)
    ties = {"R2": "R1", "f": "0.5 * nu**2", "h": "2 * zeta"}
    over = {"zeta": [0.02, 0.05], "nu": [0.9, 1.2]}
    outputs = ("harmonics", "impacts", "sensitivity")
    exciter = vp.Exciter(l=1, delta=0.1, R1=0.7)
    expected = vp.sweep(exciter, over, outputs=outputs, ties=ties, effects=scene.called_effects())
    xr.testing.assert_identical(solved, expected)
    assert {"damping", "forcing"} <= {*scene.called_effects()}


@pytest.mark.parametrize(
    "physical", ["", "physical: {m: 2 kg, C: 8 N/mm, l: 8 mm, delta: 0.8 mm}\n"]
)
def test_files_are_cut_joined_and_verified(tmp_path, physical):
    whole = text(follow="{along: zeta, direction: up}")
    if physical:
        whole = physical + whole.replace("l: 1, delta: 0.1, ", "").replace(
            "0.5 * ν", "0.004 * ν"
        ).replace("ν: [0.9, 1.2]", "omega: [50 rad/s, 70 rad/s]")
    scene = study_of(whole, tmp_path).scenes["s"]
    store(scene, tmp_path / "whole.nc", {})
    for shard in (1, 2):
        store(scene, tmp_path / f"{shard}.nc", {}, (shard, 2))
    join(scene, [tmp_path / "2.nc", tmp_path / "1.nc"], tmp_path / "joined.nc", {})
    datasets = [xr.open_dataset(tmp_path / f"{name}.nc") for name in ("whole", "joined")]
    xr.testing.assert_identical(*datasets)
    assert datasets[0].zeta.attrs["long_name"] == "zeta"
    assert not recompute(tmp_path / "joined.nc", scene, 4, np.random.default_rng(0)).differences
    moved = study_of(whole.replace("2 * zeta", "2.1 * zeta"), tmp_path).scenes["s"]
    assert recompute(tmp_path / "joined.nc", moved, 4, np.random.default_rng(0)).differences


def test_the_fingerprint_knows_the_ties(tmp_path):
    first, *others = (
        study_of(each, tmp_path).scenes["s"].fingerprint()
        for each in (
            text(),
            text(own="h: 2 * zeta, R2: R1, f: 0.5 * nu**2"),
            text(own="h: 2*zeta, f: 0.5 * nu**2"),
            text(own="h: 2 * zeta, f: 0.6 * nu**2"),
            text(shared=", load: 0.1"),
        )
    )
    assert others[0] == first
    assert len({first, *others}) == 4


def test_ties_of_a_scene_take_the_place_of_those_of_the_study_and_of_its_parameters(tmp_path):
    scene = study_of(text(own=f"{OWN}, R2: R1**2", delta="load: 0.2, delta"), tmp_path).scenes["s"]
    assert scene.resolved_exciter()["R2"] == 0.7**2
    scene = study_of(text(own=f"{OWN}, load: 0.3", delta="load: 0.2, delta"), tmp_path).scenes["s"]
    assert scene.resolved_exciter()["load"] == 0.3


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"own": "h: 2 * eta", "over": "nu: [1, 2]"}, "scenes.s.ties.h: must have a value for eta: give it in over"),
        ({"own": "h: nu", "over": "nu: [1, 2], zeta: [1]"}, "scenes.s.over.zeta: is an unknown key"),
        ({"own": "h: 2 * zeta, f: nu^2"}, "scenes.s.ties.f: must be a number or text with arithmetic"),
        ({"own": "h: [1]"}, "scenes.s.ties.h: must be a number or arithmetic of numbers and names"),
        ({"own": "h: 2 * zeta, hh: nu, f: hh, hh: 1"}, "scenes.s.ties.hh: must occur once"),
        ({"shared": ", h: 2 * kappa", "own": "f: zeta"}, "ties.h: must have a value for kappa"),
        ({"shared": ", f: load, load: f", "own": "h: zeta"}, "ties.f: must not go round in a circle: f from load"),
        ({"shared": ", zeta: 1"}, "scenes.s.over.zeta: must be left out, since it is tied"),
        ({"own": "h: 2 * zeta, nu: 1"}, "scenes.s.over.nu: must be left out, since it is tied"),
        ({"delta": "R2: 0.5, delta"}, "scenes.s.exciter.R2: must be left out, since it is tied"),
        ({"own": "h: nu - zeta - 1"}, "scenes.s.ties.h: must be a finite number >= 0, got -0.12"),
        ({"over": "nu: [1, 2], zeta: [1]", "own": "h: log(zeta - 1)"}, "scenes.s.ties.h: must be a finite"),
        ({"over": "nu: [1, 2]", "own": "h: omega"}, "scenes.s.ties.h: must not have omega as a name of one's own"),
        ({"own": "h: 2 * zeta, 3h: 1"}, "scenes.s.ties: must have keys that are each a parameter"),
    ],
)  # fmt: skip
def test_ties_that_cannot_hold_are_refused(tmp_path, changes, told):
    found = faults(text(**changes), tmp_path)
    assert any(line.startswith(told) for line in found), found


def test_one_fault_is_told_once(tmp_path):
    assert len(faults(text(own="h: 2 * eta, f: 0.5 * nu**2", over="nu: [1, 2]"), tmp_path)) == 1


@pytest.mark.slow
def test_a_design_and_a_fit_are_those_in_python(tmp_path):
    nu = [1.0, 1.1, 1.2, 1.3]
    whole = f"""\
title: T
exciter: {{l: 1, delta: 0.1, R1: 0.7}}
ties: {{R2: R1}}
scenes:
  wanted:
    kind: design
    vary: {{zeta: [0.02, 0.1], nu: [1, 1.3]}}
    target: {{displacement_amplitude_1: 0.6}}
    ties: {{f: 0.5 * nu**2, h: 2 * zeta}}
    samples: 16
  found:
    kind: identify
    vary: {{a: [0.4, 0.6]}}
    measured: {{nu: {nu}, displacement_amplitude_1: [0.5, 0.6, 0.7, 0.8]}}
    ties: {{f: a * nu**2, h: 0.1}}
    samples: 8
"""
    scenes = study_of(whole, tmp_path).scenes
    exciter = vp.Exciter(l=1, delta=0.1, R1=0.7)
    ties = {"R2": "R1", "f": "0.5 * nu**2", "h": "2 * zeta"}
    vary, target = {"zeta": (0.02, 0.1), "nu": (1, 1.3)}, {"displacement_amplitude_1": 0.6}
    expected = vp.design(exciter, vary, target, samples=16, ties=ties)
    xr.testing.assert_identical(kind_of(scenes["wanted"]).solve(scenes["wanted"]), expected)
    measured = {"nu": nu, "displacement_amplitude_1": [0.5, 0.6, 0.7, 0.8]}
    ties = {"R2": "R1", "f": "a * nu**2", "h": 0.1}
    expected = vp.identify(exciter, measured, {"a": (0.4, 0.6)}, samples=8, ties=ties)
    solved = kind_of(scenes["found"]).solve(scenes["found"])
    xr.testing.assert_identical(solved, expected)
    assert {"forcing", "damping"} <= {*scenes["wanted"].called_effects()}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("zeta: [0.1, 0.2]", "zeta: [0.1, 0.2], h: [0, 1]", "scenes.s.vary.h: must be left out, since it is tied"),
        ("zeta: [0.1, 0.2]", "zeta: [-0.1, 0.2]", "scenes.s.ties.h: must be a finite number >= 0, got -0.2"),
        ("zeta: [0.1, 0.2]", "zeta: [0.1, 0.2], eta: [0, 1]", "scenes.s.vary.eta: is an unknown key"),
        ("R2: R1", "R2: nu", "scenes.s.ties.R2: must have a value for nu: give it in vary or by a tie"),
        ("samples: 16", "tolerance: {zeta: 0.1}", "scenes.s.tolerance.zeta: is an unknown key"),
    ],
)  # fmt: skip
def test_a_design_refuses_ties_that_cannot_hold(tmp_path, old, new, told):
    whole = """\
title: T
exciter: {l: 1, delta: 0.1, R1: 0.7}
scenes:
  s:
    kind: design
    vary: {zeta: [0.1, 0.2]}
    target: {displacement_mean: 0}
    ties: {h: 2 * zeta, R2: R1}
    samples: 16
"""
    found = faults(whole.replace(old, new), tmp_path)
    assert any(line.startswith(told) for line in found), found


KINDS = {
    "motion": "tau_end: 20",
    "branch": "along: {nu: {from: 1, to: 1.2}}",
    "boundary": "of: [fold], over: {nu: [1, 2], delta: [0, 0.1]}",
    "basins": "over: {x0: [0, 0.1], v0: [0, 1]}",
    "sweep": "over: {nu: [1, 2]}",
    "design": "vary: {nu: [1, 2]}, target: {displacement_mean: 0}",
}


def of_kind(kind, exciter, ties, keys=None):
    scene = f"{{kind: {kind}, {keys or KINDS[kind]}, ties: {{h: 2 * zeta, zeta: 0.05}}}}"
    return f"title: T\nexciter: {{l: 1, R1: 0.7, {exciter}}}\nties: {{{ties}}}\nscenes:\n  s: {scene}\n"


@pytest.mark.parametrize("kind", KINDS)
def test_scenes_of_a_study_share_its_ties(tmp_path, kind):
    scene = study_of(of_kind(kind, "nu: 1, load: 0.1", "R2: R1, f: 0.5"), tmp_path).scenes["s"]
    resolved = scene.resolved_exciter()
    assert {name: resolved[name] for name in ("R1", "R2", "f", "h")} == {
        "R1": 0.7,
        "R2": 0.7,
        "f": 0.5,
        "h": 0.1,
    }
    if not scene.FOLLOWS_TIES:  # its data are those of the numbers
        plain = study_of(of_kind(kind, "nu: 1, load: 0.1, R2: 0.7, f: 0.5", ""), tmp_path).scenes[
            "s"
        ]
        assert plain.fingerprint() == scene.fingerprint()
        other = study_of(of_kind(kind, "nu: 1, load: 0.1, f: 0.5", "R2: R1**2"), tmp_path).scenes[
            "s"
        ]
        assert other.fingerprint() != scene.fingerprint()


@pytest.mark.parametrize(
    ("kind", "keys", "told"),
    [
        ("boundary", "of: [fold], over: {f: [1, 2], delta: [0, 0.1]}", "scenes.s.over.f: must be left out, since it"),
        ("boundary", "of: [fold], over: {nu: [1, 2], mu: [0, 1]}", "scenes.s.over.mu: is an unknown key; must be "),
        ("basins", "over: {nu: [1, 2], x0: [0, 0.1], v0: [0, 1]}", "scenes.s.over.nu: must be left out"),
        ("branch", "along: {f: {from: 1, to: 1.2}}", "scenes.s.along.f: must be left out, since it is tied"),
        ("motion", "tau_end: 20, exciter: {f: 2}", "scenes.s.exciter.f: must be left out, since it is tied"),
        ("accuracy", "motions: {one: {}}", "scenes.s.kind: must be one of "),
    ],
)  # fmt: skip
def test_what_is_tied_does_not_vary_where_no_tie_follows(tmp_path, kind, keys, told):
    found = faults(of_kind(kind, "nu: 1", "f: 0.5 * nu**2", keys), tmp_path)
    assert any(line.startswith(told) for line in found), found


def test_a_motion_has_the_tied_parameters(tmp_path):
    scene = study_of(of_kind("motion", "nu: 1.1", "R2: R1, f: 0.5 * nu**2"), tmp_path).scenes["s"]
    exciter = vp.Exciter(l=1, R1=0.7, R2=0.7, nu=1.1, f=0.5 * 1.1**2, h=0.1)
    expected = vp.simulate(exciter, tau_end=20)
    np.testing.assert_array_equal(kind_of(scene).solve(scene).displacement, expected.displacement)
