"""Valid studies, the values read from them, and the fingerprints of their scenes."""

import json
import math

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from study_texts import BASE, study_of

from vibropipe.physics.exciter import Exciter
from vibropipe.study import canonical_text, fingerprint, parse_study
from vibropipe.study.yaml_reader import read_text


def test_resolves_parameters_from_scene_then_study_then_effect_absent(tmp_path):
    text = BASE.replace("tau_end: 20", "exciter: {delta: 0.1, R1: 0.9}")
    scene = study_of(text, tmp_path).scene("forced")
    assert scene.resolved_exciter() == {
        **{"nu": 1.0, "f": -1.0, "h": 0.2, "delta": 0.1, "R1": 0.9, "R2": 0.7, "l": 0.5}
    }
    bare = study_of("title: T\nscenes: {s: {kind: motion, exciter: {l: 2}}}", tmp_path)
    absent = Exciter(l=2.0).stated()
    assert bare.scene("s").resolved_exciter() == absent


def test_sweep_gives_arrays_in_the_order_written(tmp_path):
    scene = study_of(BASE, tmp_path).scene("response")
    over = scene.over_arrays()
    assert list(over) == ["nu", "delta"]
    np.testing.assert_array_equal(over["nu"], np.linspace(0.5, 1.5, 11))
    np.testing.assert_array_equal(over["delta"], [0, 0.01])
    assert scene.row_count == 22
    assert scene.follow_pair() is None
    assert scene.resolved_exciter()["nu"] == 0.5  # not the study's: it is swept


def test_grid_forms_and_log_spacing(tmp_path):
    text = BASE.replace("[0, 0.01]", "{values: [0, 1E-2]}").replace(
        "points: 11", "points: 11, spacing: log"
    )
    over = study_of(text, tmp_path).scene("response").over_arrays()
    np.testing.assert_array_equal(over["delta"], [0, 0.01])
    np.testing.assert_allclose(np.diff(np.log(over["nu"])), math.log(3) / 10, rtol=1e-12)
    assert over["nu"][0] == 0.5
    assert over["nu"][-1] == 1.5


def test_time_is_counted_on_through_the_settling(tmp_path):
    text = BASE.replace("tau_end: 20", "settle_periods: 3\n    exciter: {nu: 2}\n    tau_end: 20")
    begin, end = study_of(text, tmp_path).scene("forced").tau_span()
    assert begin == pytest.approx(3 * math.pi, rel=1e-15)
    assert end == begin + 20


def test_solver_becomes_arguments_of_simulate(tmp_path):
    for written, arguments in (
        (
            "{method: newmark, steps_per_period: 200}",
            {"method": "newmark", "steps_per_period": 200},
        ),
        ("{accuracy: 1e-8}", {"accuracy": 1e-8}),
        ("{}", {"method": "exact"}),
    ):
        study = study_of(BASE.replace("tau_end: 20", f"solver: {written}"), tmp_path)
        assert study.scene("forced").solver.arguments() == arguments


def test_free_motion_has_neither_force_nor_loss(tmp_path):
    text = BASE + "  curve: {kind: backbone, delta_over_l: [0, 0.5], tau_bar: [4, 5]}\n"
    study = study_of(text, tmp_path)
    lossless = {"nu": 1, "f": 0, "h": 0, "delta": 0, "R1": 1, "R2": 1}
    assert study.scene("free").resolved_exciter() == {**lossless, "l": 0.5}
    assert study.scene("curve").resolved_exciter() == {**lossless, "l": 1}


def test_greek_is_welcome(tmp_path):
    greek = (
        BASE.replace("nu:", "ν:").replace("delta:", "δ:").replace("R1", "R₁").replace("R2", "R₂")
    )
    greek = greek.replace("tau_end", "τ_end") + "    harmonics: 3\n"
    greek = greek.replace(
        "    kind: sweep\n", "    kind: sweep\n    follow: {along: ν, direction: up}\n"
    )
    study = study_of(greek, tmp_path)
    assert study.scene("response").follow_pair() == ("nu", "up")
    plain = study_of(BASE, tmp_path, "plain")
    for name in ("forced", "free"):
        assert fingerprint(study, name) == fingerprint(plain, name)


@pytest.mark.parametrize("written", ["1e-3", "1E-3", "+0.001", ".001", "1.0e-3"])
def test_numbers_in_every_spelling(tmp_path, written):
    study = study_of(BASE.replace("h: 0.2", f"h: {written}"), tmp_path)
    assert study.scene("forced").resolved_exciter()["h"] == 1e-3


def test_numbers_that_another_reader_took_for_text():
    tree = {"title": "T", "exciter": {"l": "5e-1"}, "scenes": {"s": {"kind": "motion"}}}
    assert parse_study(tree).scene("s").resolved_exciter()["l"] == 0.5


def test_anchors_stand_for_what_they_name(tmp_path):
    text = BASE.replace("delta: [0, 0.01]", "delta: &offsets [0, 0.01]").replace(
        "amplitude: [0.1, 0.4, 0.6]", "delta_over_l: *offsets\n    tau_bar: [4, 5]"
    )
    assert study_of(text, tmp_path).scene("free").over_arrays()["delta_over_l"].tolist() == [
        0,
        0.01,
    ]


NUMBERS = st.floats(-1e6, 1e6).map(lambda value: value + 0.0)


@settings(max_examples=100)
@given(
    st.lists(NUMBERS, min_size=1, max_size=20, unique=True).map(sorted),
    st.floats(0.01, 10),
    st.floats(-0.4, 0.4),
    st.sets(st.sampled_from(["harmonics", "impacts", "motion", "stability", "energy"]), min_size=1),
)
def test_numbers_pass_through_yaml_to_the_last_bit(values, nu, x0, outputs):
    scene = {
        "kind": "sweep",
        "over": {"f": values},
        "start": {"x0": x0},
        "outputs": sorted(outputs),
    }
    tree = {"title": "T", "exciter": {"l": 0.5, "nu": nu}, "scenes": {"s": scene}}
    again, problems = read_text(yaml.safe_dump(tree), "text")
    assert not problems
    read = parse_study(again)
    assert read.scene("s").over_arrays()["f"].tolist() == values
    assert read.scene("s").resolved_exciter()["nu"] == nu
    assert read.scene("s").start.x0 == x0
    assert canonical_text(read) == canonical_text(parse_study(tree))


def edited(edit):
    tree = yaml.safe_load(BASE)
    edit(tree, tree["scenes"])
    return parse_study(tree)


SAME = {
    "title": lambda t, s: t.update(title="Another"),
    "description": lambda t, s: t.update(description="More"),
    "question": lambda t, s: t.update(question="Why?"),
    "hero": lambda t, s: t.update(hero={"scene": "response"}),
    "caption": lambda t, s: s["response"].update(caption="See"),
    "scene title": lambda t, s: s["response"].update(title="See"),
    "figure": lambda t, s: s["response"].update(figure={"beside": "free"}),
    "swept elsewhere": lambda t, s: t["exciter"].update(nu=3),
    "default written out": lambda t, s: s["response"].update(
        harmonics=3, start={"x0": 0, "v0": 0.0}
    ),
    "minus zero": lambda t, s: s["response"].update(start={"x0": -0.0}),
    "own exciter": lambda t, s: s["response"].update(exciter={"f": -1.0}),
    "text": lambda t, s: t["exciter"].update(h="2e-1"),
    "order": lambda t, s: t.update(exciter=dict(reversed(t["exciter"].items()))),
    "order of outputs": lambda t, s: s["response"].update(
        outputs=["stability", "impacts", "harmonics"]
    ),
    "another scene": lambda t, s: s["forced"].update(tau_end=30),
    "a scene more": lambda t, s: s.update(more={"kind": "motion"}),
}
DIFFERENT = {
    "shared": lambda t, s: t["exciter"].update(h=0.3),
    "own": lambda t, s: s["response"].update(exciter={"R1": 0.6}),
    "last digit": lambda t, s: t["exciter"].update(h=0.2 + 2**-55),
    "points": lambda t, s: s["response"]["over"]["nu"].update(points=12),
    "spacing": lambda t, s: s["response"]["over"]["nu"].update(spacing="log"),
    "order of dimensions": lambda t, s: s["response"].update(
        over=dict(reversed(s["response"]["over"].items()))
    ),
    "start": lambda t, s: s["response"].update(start={"v0": 0.1}),
    "follow": lambda t, s: s["response"].update(follow={"along": "nu", "direction": "up"}),
    "harmonics": lambda t, s: s["response"].update(harmonics=4),
    "outputs": lambda t, s: s["response"].update(outputs=["impacts"]),
    "solver": lambda t, s: s["response"].update(solver={"accuracy": 1e-9}),
}


@pytest.mark.parametrize("name", SAME)
def test_fingerprint_stays_when_the_data_stay(name):
    before, after = edited(lambda t, s: None), edited(SAME[name])
    assert fingerprint(before, "response") == fingerprint(after, "response")


@pytest.mark.parametrize("name", DIFFERENT)
def test_fingerprint_changes_with_the_data(name):
    before, after = edited(lambda t, s: None), edited(DIFFERENT[name])
    assert fingerprint(before, "response") != fingerprint(after, "response")
    if name not in ("shared", "last digit"):
        assert fingerprint(before, "forced") == fingerprint(after, "forced")


def test_free_motion_does_not_depend_on_force_and_loss():
    before, after = edited(lambda t, s: None), edited(lambda t, s: t["exciter"].update(h=0.3, f=2))
    moved = edited(lambda t, s: t["exciter"].update(l=0.6))
    assert fingerprint(before, "free") == fingerprint(after, "free")
    assert fingerprint(before, "free") != fingerprint(moved, "free")


def test_text_of_a_study_knows_titles_and_ignores_comments(tmp_path):
    plain = study_of(BASE, tmp_path)
    remarked = study_of("# remark\n" + BASE.replace("0.7", "0.70"), tmp_path, "remarked")
    renamed = study_of(BASE.replace("A study", "B"), tmp_path, "renamed")
    assert canonical_text(plain) == canonical_text(remarked)
    assert canonical_text(plain) != canonical_text(renamed)
    assert json.loads(canonical_text(plain, "forced"))["tau_end"] == 20
