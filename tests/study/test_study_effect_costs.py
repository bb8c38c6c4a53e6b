"""Scenes of kind effects: valid and invalid keys, the effects of their motions, and the study in `config/`."""

from __future__ import annotations

from pathlib import Path

import pytest

from vibropipe.jobs.plan import plan_scene
from vibropipe.study import StudyError, load_study

TEXT = """
title: Cost
exciter: {l: 0.5, f: 1.5, nu: 0.3, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  costs:
    kind: effects
    motions:
      full: {}
      free: {exciter: {f: 0, h: 0, R1: 1, R2: 1}, start: {v0: 0.6}, periods: 3, at_most: 0.05}
      row: {of: row, outputs: [harmonics]}
      other: {of: row, outputs: [], against: row}
"""
SHIPPED = Path(__file__).parents[2] / "config" / "effects.yaml"


@pytest.fixture
def study(tmp_path):
    def load(text=TEXT):
        file = tmp_path / "cost.yaml"
        file.write_text(text)
        return load_study(file)

    return load


def test_motions_call_for_their_own_effects(study):
    scene = study().scene("costs")
    assert len(scene.effects_of("full")) == 6
    assert scene.effects_of("free") == ("support_1", "support_2")
    assert scene.row_count == plan_scene(scene).rows == 4
    assert scene.full == "full"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("full: {}", "full: {exciter: {h: 0}}"), "motions.full.exciter: must call for all effects, got a motion with"),
        (("full: {}", "full: {exciter: {h: 0}}"), "got a motion without damping"),
        (("full: {}", "ful: {}"), "scenes.costs.full: must be a motion of this scene (ful, "),
        (("full: {}", "ful: {}"), "), got 'full' (did you mean 'ful'?)"),
        (("[harmonics]", "[motion]"), "motions.row.outputs[0]: must be one of harmonics, "),
        (("[harmonics]", "[motion]"), ", got 'motion'"),
        (("full: {}", "full: {outputs: [energy]}"), "outputs[0]: must be impacts or motion, got 'energy'"),
        (("against: row", "against: full"), "motions.other.against: must be a row of this scene ("),
        (("against: row", "against: full"), "), got 'full'"),
        (("against: row", "against: rov"), "did you mean 'row'?"),
        (("of: row,", "of: raw,"), "motions.row.of: must be motion or row, got 'raw'"),
        (("at_most: 0.05", "at_most: 0"), "motions.free.at_most: must be a number above 0 up to 1e6, got 0"),
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


def test_the_shipped_study_leaves_out_each_effect_and_aims_at_what_is_promised():
    scene = load_study(SHIPPED).scene("effects")
    present = {name: set(scene.effects_of(name)) for name in scene.motions}
    everything = present["all_effects"]
    for effect in ("rest", "damping", "restitution", "forcing"):
        assert effect not in present[f"no_{effect}"]
    assert everything - present["one_sided"] == {"support_1"}
    assert present["conservative"] == {"support_1", "support_2"}
    assert not {"support_1", "support_2"} & present["row_no_impact"]
    targets = {n: (m.at_most, m.against) for n, m in scene.motions.items() if m.at_most is not None}
    assert targets == {
        "no_forcing": (0.7, None),
        "one_sided": (0.9, None),
        "conservative": (1 / 20, None),
        "impacts_alone": (1 / 5, "motion_sampled"),
        "row_harmonics": (1.15, "row_settled"),
        "row_stability": (1.15, "row_settled"),
        "row_no_impact": (1 / 50, "row_usual"),
    }
