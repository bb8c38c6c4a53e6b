"""Scenes of kinds accuracy and hard_cases: valid and invalid keys, their motions, a choice of cases."""

import re

import pytest
from study_texts import study_of

from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import solve_scene
from vibropipe.scenes.accuracy import keys
from vibropipe.study import StudyError, fingerprint
from vibropipe.words.measurements import OWN_METHODS, Passed

RACE = """
title: Cost
exciter: {{l: 0.5, nu: 1, f: 1}}
scenes:
  race:
    kind: accuracy
    exciter: {{h: 0.1}}
    {more}
    motions:
      plain: {{}}
      own: {{exciter: {{h: 2, l: 1}}, start: {{x0: 0.7}}, periods: 3}}
"""


@pytest.fixture
def race(tmp_path):
    return lambda more="methods: [newmark, exact]", text=RACE: study_of(
        text.format(more=more), tmp_path
    )


def test_a_motion_takes_its_own_parameters_then_the_scenes_then_the_studys(race):
    scene = race().scene("race")
    plain, own = scene.exciter_of("plain"), scene.exciter_of("own")
    assert (plain["l"], plain["f"], plain["h"], plain["R1"]) == (0.5, 1, 0.1, 1)
    assert (own["l"], own["f"], own["h"]) == (1, 1, 2)


def test_a_race_is_a_motion_by_a_method_at_a_setting(race):
    scene = race("methods: [newmark, exact, RK45]").scene("race")
    assert scene.row_count == 2 * (6 + 1 + 3)
    assert plan_scene(scene).rows == scene.row_count


def test_methods_that_are_not_installed_are_told(race, monkeypatch):
    scene = race("methods: [newmark, exact, heyoka, solve_nivp]").scene("race")
    monkeypatch.setattr(keys, "is_installed", lambda method: method in OWN_METHODS)
    told = "newmark, exact; not installed: heyoka, solve_nivp"
    assert plan_scene(scene).method == scene.method_text() == told
    monkeypatch.setattr(keys, "is_installed", lambda method: True)
    assert scene.method_text() == "newmark, exact, heyoka, solve_nivp"


def test_data_depend_on_motions_and_settings(race):
    one = fingerprint(race(), "race")
    assert one == fingerprint(
        race(text=RACE.replace("plain: {{}}", "plain: {{start: {{x0: 0}}}}")), "race"
    )
    assert one != fingerprint(race("methods: [newmark]"), "race")
    assert one != fingerprint(race(text=RACE.replace("periods: 3", "periods: 4")), "race")


@pytest.mark.parametrize(
    ("more", "change", "said"),
    [
        ("methods: [newmark, RK46]", None, ", got 'RK46'"),
        ("methods: [exact, exact]", None, "scenes.race.methods: must have each name once, got exact, exact"),
        ("tolerances: [0]", None, "tolerances[0]"),
        ("accuracies: [1e-16]", None, "accuracies[0]"),
        ("accuracies: [1e-3, 0.001]", None, "accuracies: must have each name once"),
        ("steps_per_period: [1.5]", None, "a whole number from 1"),
        ("repeats: 0", None, "scenes.race.repeats"),
        ("repeat: 3", None, "did you mean 'repeats'?"),
        ("", ("h: 2,", "h: -2,"), "scenes.race.motions.own.exciter.h: must be a finite number >= 0, got -2"),
        ("", ("x0: 0.7", "x0: 1.7"), "scenes.race.motions.own.start.x0: must be a finite number from -1"),
        ("", ("x0: 0.7", "x0: 1.7"), "(between the supports), got 1.7"),
        ("", ("l: 0.5, ", ""), "scenes.race.motions.plain.exciter.l: is required (a finite number > 0), in the motion"),
        ("", ("periods: 3", "period: 3"), "scenes.race.motions.own.period: is an unknown key; must be "),
        ("", ("periods: 3", "period: 3"), "did you mean 'periods'?"),
        ("", ("h: 2,", "nu: 1e-9,"), "periods: must end the motion at tau = 1e+09 or before, got tau = "),
        ("", ("own:", "Own:"), "a name of a-z"),
    ],
)  # fmt: skip
def test_mistakes_are_reported_with_their_path(race, more, change, said):
    text = RACE.replace(*change) if change else RACE
    with pytest.raises(StudyError, match=re.escape(said)) as caught:
        race(more, text)
    assert len(caught.value.problems) == 1


def cases(tmp_path, scene: str, more: str = ""):
    return study_of(f"title: T\n{more}scenes:\n  s: {scene}\n", tmp_path)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ("cases: [grazing_fre]", ", got 'grazing_fre'"),
        ("cases: [grazing_fre]", "did you mean 'grazing_free'?"),
        ("cases: [split, split]", "scenes.s.cases: must have each name once, got split, split"),
        ("exciter: {h: 1}", "must be left out, since each case has its own exciter, got 1.0"),
        ("exciter: {h: 1}", "s.exciter.h: must be left out"),
        ("tau_end: 1", "scenes.s.tau_end: is an unknown key; must be "),
    ],
)
def test_what_is_refused(tmp_path, keys, told):
    with pytest.raises(StudyError, match=re.escape(told)):
        cases(tmp_path, f"{{kind: hard_cases, {keys}}}")


def test_data_depend_on_the_cases_alone(tmp_path):
    plain = cases(tmp_path, "{kind: hard_cases}")
    shared = cases(tmp_path, "{kind: hard_cases}", "exciter: {l: 3, h: 1}\n")
    few = cases(tmp_path, "{kind: hard_cases, cases: [split]}")
    assert fingerprint(plain, plain.scene("s")) == fingerprint(shared, shared.scene("s"))
    assert fingerprint(plain, plain.scene("s")) != fingerprint(few, few.scene("s"))


def test_a_few_cases_are_solved_alone(tmp_path):
    few = cases(tmp_path, "{kind: hard_cases, cases: [plastic_for_ever, start_on_support]}")
    found = solve_scene(few, "s")
    # in the order of the list of all cases
    assert found.case.values.tolist() == ["start_on_support", "plastic_for_ever"]
    assert (
        found.attrs["method"]
        == "exact, newmark 8, newmark 60, newmark 2000 steps per forcing period"
    )
    assert found.attrs["kind"] == "hard_cases"
    assert (found.passed == Passed.PASSED).all()
    assert plan_scene(few.scene("s")).size == "2 cases"
