"""Scenes of hard cases: valid and invalid keys, and a choice of cases."""

import pytest
from study_texts import study_of

from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import solve_scene
from vibropipe.study import StudyError, fingerprint
from vibropipe.words.measurements import Passed


def study(tmp_path, scene: str, more: str = ""):
    return study_of(f"title: T\n{more}scenes:\n  s: {scene}\n", tmp_path)


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ("{kind: hard_cases, cases: [grazing_fre]}", ", got 'grazing_fre'"),
        (
            "{kind: hard_cases, cases: [split, split]}",
            "scenes.s.cases: must have each name once, got split, split",
        ),
        (
            "{kind: hard_cases, exciter: {h: 1}}",
            "s.exciter.h: must be left out, since each case has its own exciter, got 1.0",
        ),
        ("{kind: hard_cases, tau_end: 1}", "scenes.s.tau_end: is an unknown key; must be "),
    ],
)
def test_what_is_refused(tmp_path, scene, told):
    with pytest.raises(StudyError) as error:
        study(tmp_path, scene)
    assert told in str(error.value)
    if "fre]" in scene:
        assert "did you mean 'grazing_free'?" in str(error.value)


def test_data_depend_on_the_cases_alone(tmp_path):
    plain = study(tmp_path, "{kind: hard_cases}")
    shared = study(tmp_path, "{kind: hard_cases}", "exciter: {l: 3, h: 1}\n")
    few = study(tmp_path, "{kind: hard_cases, cases: [split]}")
    assert fingerprint(plain, plain.scene("s")) == fingerprint(shared, shared.scene("s"))
    assert fingerprint(plain, plain.scene("s")) != fingerprint(few, few.scene("s"))


def test_a_few_cases_are_solved_alone(tmp_path):
    few = study(tmp_path, "{kind: hard_cases, cases: [plastic_for_ever, start_on_support]}")
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
