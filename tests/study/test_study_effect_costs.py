"""Scenes of kind effects: valid and invalid keys, the effects of their motions, and the study in `config/`."""

import math
from pathlib import Path

import pytest
from study_texts import study_of

from vibropipe.jobs.plan import plan_scene
from vibropipe.physics.effects import effect_names, effects_of
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import largest_start
from vibropipe.study import StudyError, load_study
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.parameters import EFFECT_NAMES

TEXT = """
title: Cost
exciter: {l: 0.5, f: 1.5, nu: 0.3, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  costs:
    kind: effects
    motions:
      full: {group: Motions}
      free: {exciter: {f: 0, h: 0, R1: 1, R2: 1}, start: {v0: 0.6}, periods: 3, title: free}
      row: {of: row, outputs: [harmonics], group: Rows}
      other: {of: row, outputs: [], against: row, kernel: all}
"""
SHIPPED = Path(__file__).parents[2] / "config" / "effects.yaml"


@pytest.fixture
def study(tmp_path):
    return lambda text=TEXT: study_of(text, tmp_path)


def effects_of_motion(scene, name):
    """Return the effects that the parameters of one motion require."""
    timed, values = scene.motions[name], scene.exciter_of(name)
    span = math.inf if timed.of == "row" else timed.periods * Exciter(**values).period
    start = largest_start(values, timed.start.x0), timed.start.v0
    return effect_names(effects_of(values, *start, span), values)


def test_motions_call_for_their_own_effects(study):
    scene = study().scene("costs")
    assert len(effects_of_motion(scene, "full")) == 6
    assert effects_of_motion(scene, "free") == ("support_1", "support_2")
    assert scene.row_count == plan_scene(scene).rows == 4


def test_a_ratio_is_of_the_first_of_its_sort_unless_another_is_named(study):
    scene = study().scene("costs")
    assert {name: scene.reference_of(name) for name in scene.motions} == {
        "full": "full", "free": "full", "row": "row", "other": "row",
    }  # fmt: skip


def test_something_is_compared(study):
    alone = TEXT[: TEXT.index("      free:")]
    both = alone + "      row: {of: row}\n"
    for text, names in ((alone, "full"), (both, "full, row")):
        with pytest.raises(StudyError, match=f"must have a motion, or a row, .* got {names}"):
            study(text)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[harmonics]", "[motions]"), "motions.row.outputs[0]: must be "),
        (("{group: Motions}", "{outputs: [energy]}"), "outputs[0]: must be impacts or motion, got 'energy'"),
        (("against: row", "against: full"), "motions.other.against: must be a row of this scene ("),
        (("against: row", "against: full"), "), got 'full'"),
        (("against: row", "against: rov"), "did you mean 'row'?"),
        (("of: row,", "of: raw,"), "motions.row.of: must be motion or row, got 'raw'"),
        (("kernel: all", "kernel: full"), "motions.other.kernel: must be own or all, got 'full'"),
        (("periods: 3", "periods: 0"), "motions.free.periods: must be a whole number from 1 to 1e6, got 0"),
        (("v0: 0.6", "x0: 0.6"), "(between the supports), got 0.6"),
        (("kind: effects", "kind: effect"), "did you mean 'effects'?"),
    ],
)  # fmt: skip
def test_mistakes_are_reported_with_their_path(study, change, said):
    text = TEXT.replace(*change, 1)
    assert text != TEXT
    with pytest.raises(StudyError) as caught:
        study(text)
    assert said in str(caught.value), str(caught.value)


def test_the_shipped_study_prices_each_of_the_thirteen_effects_and_each_output():
    scene = load_study(SHIPPED).scene("effects")
    present = {name: set(effects_of_motion(scene, name)) for name in scene.motions}
    base = present["figure_6"]
    for effect in ("damping", "forcing", "restitution"):
        assert any(effect not in effects for effects in present.values())
    assert base - present["one_support"] <= {"support_1"}
    assert present["conservative"] == {"support_1", "support_2"}
    assert not {"support_1", "support_2"} & present["row_no_impact"]
    for effect in ("load", "soft", "friction", "second_harmonic", "housing"):
        assert any(effects - base == {effect} for effects in present.values())
    assert set().union(*present.values()) == set(EFFECT_NAMES)
    assert {output for motion in scene.motions.values() for output in motion.outputs} == set(
        OUTPUTS
    )
    assert [n for n in scene.motions if scene.reference_of(n) == n] == ["figure_6", "row"]
