"""Scenes of kind accuracy: valid and invalid keys, and the exciter of each motion."""

import pytest
from study_texts import study_of

from vibropipe.jobs.plan import plan_scene
from vibropipe.scenes.accuracy import keys
from vibropipe.study import StudyError, fingerprint
from vibropipe.words.measurements import OWN_METHODS

TEXT = """
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
def study(tmp_path):
    return lambda more="methods: [newmark, exact]", text=TEXT: study_of(
        text.format(more=more), tmp_path
    )


def test_a_motion_takes_its_own_parameters_then_the_scenes_then_the_studys(study):
    scene = study().scene("race")
    plain, own = scene.exciter_of("plain"), scene.exciter_of("own")
    assert (plain["l"], plain["f"], plain["h"], plain["R1"]) == (0.5, 1, 0.1, 1)
    assert (own["l"], own["f"], own["h"]) == (1, 1, 2)


def test_a_race_is_a_motion_by_a_method_at_a_setting(study):
    scene = study("methods: [newmark, exact, RK45]").scene("race")
    assert scene.row_count == 2 * (6 + 1 + 3)
    assert plan_scene(scene).rows == scene.row_count


def test_methods_that_are_not_installed_are_told(study, monkeypatch):
    scene = study("methods: [newmark, exact, heyoka, solve_nivp]").scene("race")
    monkeypatch.setattr(keys, "is_installed", lambda method: method in OWN_METHODS)
    told = "newmark, exact; not installed: heyoka, solve_nivp"
    assert plan_scene(scene).method == scene.method_text() == told
    monkeypatch.setattr(keys, "is_installed", lambda method: True)
    assert scene.method_text() == "newmark, exact, heyoka, solve_nivp"


def test_data_depend_on_motions_and_settings(study):
    one = fingerprint(study(), "race")
    assert one == fingerprint(
        study(text=TEXT.replace("plain: {{}}", "plain: {{start: {{x0: 0}}}}")), "race"
    )
    assert one != fingerprint(study("methods: [newmark]"), "race")
    assert one != fingerprint(study(text=TEXT.replace("periods: 3", "periods: 4")), "race")


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
def test_mistakes_are_reported_with_their_path(study, more, change, said):
    text = TEXT.replace(*change) if change else TEXT
    with pytest.raises(StudyError) as caught:
        study(more, text)
    assert said in str(caught.value), str(caught.value)
    assert len(caught.value.problems) == 1
