"""The jump of a motion as a goal of a scene, with units: from the keys to the pictures and the answers."""

import re

import numpy as np
import pytest
from drawing import picture_of
from figures.figure_text import words

import vibropipe as vp
from vibropipe.scenes.design.data import goals, wanted_parts
from vibropipe.scenes.design.report import answers
from vibropipe.scenes.registry import kind_of
from vibropipe.solve.physical import in_units
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.bifurcations import Bifurcation

GIVEN = {"m": "2 kg", "C": "8 N/mm", "H": "40 N s/m", "l": "8 mm", "omega": "10 Hz"}
STUDY = """
title: The jump at 25 Hz
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 90 N, omega: 10 Hz}
exciter: {R1: 0.7, R2: 0.75}
scenes:
  jump:
    kind: design
    vary: {F: [60 N, 120 N], delta: [0.5 mm, 3 mm]}
    target: {fold_omega_up: 25 Hz}
    subject_to: {grazing_omega_up: "> 12 Hz", impact_velocity_max_1: "< 1.5 m/s"}
    allow: {fold_omega_up: 0.1 Hz}
    tolerance: {F: 0.2 N, delta: 0.02 mm}
    samples: 32
    designs: 1
"""
ALONE = STUDY.replace('grazing_omega_up: "> 12 Hz", ', "")


@pytest.fixture(scope="module")
def dataset():
    scene = study_of_text(ALONE, "jump").scenes["jump"]
    assert scene.target == {"fold_nu_up": pytest.approx(2 * np.pi * 25 / np.sqrt(8e3 / 2))}
    return kind_of(scene).solve(scene)


@pytest.mark.slow
def test_the_branch_of_the_design_has_its_fold_there(dataset):
    best = dataset.isel(design=0)
    made = vp.Exciter.from_physical(
        **GIVEN, F=float(best.F), delta=float(best.delta), R1=0.7, R2=0.75
    )
    found = vp.branch(made, "omega", "40 Hz", harmonics=1)
    folds = found.bifurcation_omega.values[found.bifurcation_kind.values == Bifurcation.FOLD]
    assert folds[0] / (2 * np.pi) == pytest.approx(25.0, rel=1e-8)
    assert float(best.fold_omega_up) == pytest.approx(folds[0], rel=1e-9)
    assert best.fold_omega_up.attrs["units"] == "rad s-1"
    # The deviations at three standard deviations are of branches followed anew.
    off = float(best.fold_omega_up_deviation.sel(parameter="F", side="above"))
    more = vp.Exciter.from_physical(
        **GIVEN, F=float(best.F) + 0.6, delta=float(best.delta), R1=0.7, R2=0.75
    )
    moved = vp.branch(more, "omega", "40 Hz", harmonics=1)
    (i,) = np.flatnonzero(moved.bifurcation_kind.values == Bifurcation.FOLD)[:1]
    assert float(moved.bifurcation_omega[i]) - folds[0] == pytest.approx(off, rel=1e-6)


def test_pictures_and_tables_have_the_jump_in_hertz(dataset):
    shown = in_units(dataset, "Hz")
    wanted = "frequency of excitation at the first fold on the way up"
    assert wanted in [part.words(shown) for part in wanted_parts(shown)]
    assert (wanted, "25 ± 0.1 Hz") in [tuple(goal) for goal in goals(shown)]
    assert re.search(f"{wanted} = 2[45][.\\d]* Hz", answers({"jump": shown})["jump"][0].rest)
    for name in ("designs", "tornado", "sensitivities"):
        text = words(picture_of("design", shown, name).draw(shown, None, {}))
        assert "first fold" in text.replace("\n", " "), name


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("target: {fold_omega_up: 25 Hz}", "target: {fold_omega_up: 25}",
         "target.fold_omega_up: must be a frequency"),
        ("target: {fold_omega_up: 25 Hz}", "target: {fold_nu_up: 25 mm}",
         "must be a frequency"),
        ("target: {fold_omega_up: 25 Hz}", "target: {folds_omega_up: 25 Hz}",
         "target.folds_omega_up: must be a quantity of a steady state"),
        ('"< 1.5 m/s"', '"< 1.5 m/s", fold_omega_up: "< 20 Hz"',
         "subject_to.fold_omega_up: must agree with target"),
        ("allow: {fold_omega_up: 0.1 Hz}", "allow: {fold_omega_down: 0.1 Hz}",
         "allow: must have the targets as keys"),
        ("exciter: {R1: 0.7,", 'ties: {R1: "0.5 + 0.1 * nu"}\nexciter: {',
         "since fold_nu_up is wanted, along nu alone"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_named(old, new, message):
    assert old in ALONE
    with pytest.raises(StudyError, match=re.escape(message)):
        study_of_text(ALONE.replace(old, new), "jump")


def test_places_are_least_and_bounded_in_a_study_with_units():
    text = STUDY.replace("    target: {fold_omega_up: 25 Hz}\n", "").replace(
        "    allow: {fold_omega_up: 0.1 Hz}\n", "    minimise: -fold_omega_up\n"
    )
    scene = study_of_text(text, "jump").scenes["jump"]
    assert scene.minimise == ["-fold_nu_up"]
    assert scene.subject_to["grazing_nu_up"].startswith("> 1.19")
