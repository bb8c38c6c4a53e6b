"""A housing that slides in a study: scenes that compute it, and words of those that do not."""

import pytest

from vibropipe.study import StudyError, study_of_text

STUDY = """
title: T
exciter: {l: 0.3, nu: 2, f: 0.9, h: 0.1, R1: 0.5, R2: 0.5, mass_ratio: 0.8, housing_friction_1: 0.1}
scenes: {s: {kind: %s}}
"""
UNITS = """
title: T
physical: {m: 0.2 kg, M: 0.5 kg, C: 8 N/mm, l: 3 mm, F: 20 N, omega: 40 Hz, D1: 1.5 N, D2: 4 N, P: 1 N}
scenes: {s: {kind: sweep, over: {M: [0.5 kg, 1 kg]}}}
"""
LEFT_OUT = "must be left out with mass_ratio above 0: it is not computed for a housing that slides"


@pytest.mark.parametrize(
    "scene",
    [
        "motion",
        "motion, outputs: [motion, impacts, harmonics, energy]",
        "sweep, over: {nu: [1, 2]}, outputs: [sensitivity, stability]",
        "sweep, over: {nu: [1, 2]}, figure: {show: [housing_velocity_mean]}",
        "sweep, over: {mass_ratio: [0.1, 0.2]}, follow: {along: mass_ratio, direction: up}",
        "boundary, of: [fold], over: {nu: [2, 3], f: [0.5, 1]}",
        "basins, over: {x0: [0, 0.1], v0: [0, 1]}",
        "design, vary: {delta: [-0.1, 0.1]}, target: {housing_velocity_mean: 0.01}",
        "branch, along: {nu: {from: 2, to: 3}}, figure: {show: [housing_velocity_mean]}",
    ],
)
def test_motions_and_sweeps_compute_it(scene: str) -> None:
    assert "housing" in study_of_text(STUDY % scene, "s").scene("s").called_effects()


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ("motion, solver: {accuracy: 1e-6}", f"solver.accuracy: {LEFT_OUT}, got 1e-06"),
        (
            "sweep, over: {nu: [1, 2]}, solver: {accuracy: 1e-6}",
            f"solver.accuracy: {LEFT_OUT}, got 1e-06",
        ),
        (
            "design, vary: {nu: [1, 2]}, target: {housing_slip_share: 0.5}, exciter: {mass_ratio: 0, "
            "housing_friction_1: 0}",
            "mass_ratio: must be above 0, since housing_slip_share is wanted: a housing with 0 is fixed",
        ),
        ("motion, exciter: {mass_ratio: 0}", "housing_friction_1: must be 0 where mass_ratio = 0"),
        ("motion, exciter: {mass_ratio: -1}", "mass_ratio: must be a finite number >= 0, got -1"),
    ],
)
def test_what_is_not_computed_is_refused_in_words(scene: str, said: str) -> None:
    with pytest.raises(StudyError) as refused:
        study_of_text(STUDY % scene, "s")
    assert said in str(refused.value)


def test_a_study_in_units_has_the_mass_of_the_housing() -> None:
    scene = study_of_text(UNITS, "s").scene("s")
    assert scene.over_arrays()["mass_ratio"].tolist() == [0.2, 0.4]
    exciter = scene.resolved_exciter()
    assert exciter["housing_friction_2"] == 4.0 / 8e3
    assert exciter["housing_load"] == 1.0 / 8e3


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "M: 0.5 kg, ",
            "",
            "physical.D1: must be left out without M, the mass of the housing, which is fixed "
            "then, got '1.5 N'",
        ),
        (
            "kind: sweep, over: {M: [0.5 kg, 1 kg]}",
            "kind: accuracy, motions: {a: {}}",
            "physical.M: must be left out: a housing that slides is not computed here, got '0.5 kg'",
        ),
        (
            "}}}",
            "}, solver: {accuracy: 1e-6}}}",
            "solver.accuracy: must be left out with M above 0: it is not computed for a housing that slides",
        ),
    ],
)
def test_with_units_faults_are_told_in_the_words_of_the_file(old: str, new: str, said: str) -> None:
    text = UNITS.replace(old, new).replace("over: {M: [0.5 kg, 1 kg]", "over: {F: [10 N, 20 N]")
    with pytest.raises(StudyError) as refused:
        study_of_text(text, "s")
    assert said in str(refused.value)


def test_a_deviation_of_the_mass_is_that_of_its_ratio() -> None:
    target = "target: {impact_velocity_max_1: 0.1 m/s}"
    design = f"{{kind: design, vary: {{delta: [-1 mm, 1 mm]}}, {target}, tolerance: {{M: 5 g}}}}"
    text = UNITS.replace("{kind: sweep, over: {M: [0.5 kg, 1 kg]}}", design)
    # m/M^2 times the deviation
    off = study_of_text(text, "s").scene("s").tolerance["mass_ratio"]
    assert off == pytest.approx(0.2 / 0.5**2 * 0.005)
    with pytest.raises(StudyError, match=r"tolerance.M: must be left out beside vary.M"):
        study_of_text(text.replace("vary: {", "vary: {M: [0.4 kg, 1 kg], "), "s")
    with pytest.raises(StudyError, match=r"tolerance.M: must be left out without physical.M"):
        study_of_text(
            text.replace("M: 0.5 kg, ", "").replace("D1: 1.5 N, D2: 4 N, P: 1 N", "D1: 0 N"), "s"
        )
