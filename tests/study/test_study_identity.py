"""The fingerprint of a scene covers the keys that its data depend on, and no others."""

import json

import pytest
import yaml
from study_texts import BASE, study_of

from vibropipe.study import canonical_text, fingerprint, parse_study


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
