"""`effects` of a scene: stated, rejected, or derived from the parameters; a housing that slides."""

import pytest
from study_texts import scene_faults, study_of

from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.study import StudyError, fingerprint, study_of_text

FORCED = "{l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}"
ALL = "damping, forcing, support_1, support_2, restitution, rest"


def effects_in(scene, folder, exciter=FORCED):
    study = study_of(f"title: T\nexciter: {exciter}\nscenes:\n  s: {scene}\n", folder)
    return set(study.scene("s").called_effects())


@pytest.mark.parametrize(
    ("scene", "called_for"),
    [
        ("{kind: motion}", set(ALL.split(", "))),
        ("{kind: motion, exciter: {f: 0}, start: {v0: 0.4}}", {"damping"}),
        ("{kind: motion, exciter: {f: 0.02}}", {"damping", "forcing"}),
        ("{kind: sweep, over: {f: [0.01, 0.02]}}", {"damping", "forcing"}),
        ("{kind: backbone, amplitude: [0.1, 1]}", {"support_1", "support_2"}),
        # by its own length a motion stays off; the steady state that is asked too does not
        ("{kind: motion, exciter: {f: 0.1, h: 0, R1: 1, R2: 1}, tau_end: 4}", {"forcing"}),
        (
            "{kind: motion, exciter: {f: 0.1, h: 0, R1: 1, R2: 1}, tau_end: 4, outputs: [energy]}",
            {"forcing", "support_1", "support_2"},
        ),
        # bounds are proven for the exact motion
        (
            "{kind: motion, exciter: {f: 0}, solver: {method: newmark, steps_per_period: 99}}",
            {"damping", "support_1", "support_2", "restitution"},
        ),
    ],
)
def test_what_a_scene_calls_for(scene, called_for, tmp_path):
    exciter = "{l: 0.5}" if "backbone" in scene else FORCED
    assert effects_in(scene, tmp_path, exciter) == called_for


def test_stated_effects_stand(tmp_path):
    assert effects_in(f"{{kind: motion, exciter: {{f: 0}}, effects: [{ALL}]}}", tmp_path) == set(
        ALL.split(", ")
    )


@pytest.mark.parametrize(
    ("left_out", "found"),
    [
        ("damping", ("damping unless h = 0", "h = 0.2")),
        ("forcing", ("forcing unless f = 0", "f = 1.0")),
        (
            "restitution",
            ("restitution unless R = 1 on the supports included", "R1 = 0.7, R2 = 0.7"),
        ),
        (
            "rest",
            (
                "rest unless |f| < l - |delta|",
                "a force of f = 1.0 that can press the mass on a support",
            ),
        ),
    ],
)
@pytest.mark.parametrize("kind", ["motion", "sweep, over: {nu: [1, 2]}"])
def test_a_contradiction_is_told_at_the_start(kind, left_out, found, tmp_path):
    names = [name for name in ALL.split(", ") if name != left_out]
    scene = f"{{kind: {kind}, effects: [{', '.join(names)}]}}"
    (told,) = scene_faults(scene, tmp_path, FORCED)
    must, values = found
    assert told == f"scenes.s.effects: must include {must}, got {', '.join(names)} with {values}"


def test_the_restitution_of_a_support_left_out_is_a_contradiction(tmp_path):
    names = ALL.replace("support_1, ", "")
    scene = f"{{kind: motion, exciter: {{R1: 0.5}}, effects: [{names}]}}"
    assert scene_faults(scene, tmp_path, FORCED) == [
        "scenes.s.exciter.R1: must be left out unless effects include support_1, got 0.5"
    ]
    # inherited from the study it says nothing of this scene
    assert "support_1" not in effects_in(f"{{kind: motion, effects: [{names}]}}", tmp_path)


@pytest.mark.parametrize(
    ("effects", "found"),
    [
        ("[damping, dampin]", "did you mean 'damping'?"),
        ("[damping, damping]", "must have each name once, got damping, damping"),
        ("damping", "must be a list of damping, forcing, "),
        ("", "must have a value or be left out, got nothing"),
    ],
)
def test_bad_lists_are_refused(effects, found, tmp_path):
    told = scene_faults(f"{{kind: motion, effects: {effects}}}", tmp_path, FORCED)
    assert any(found in line for line in told), told


def test_the_plan_lists_effects(tmp_path):
    text = f"title: T\nexciter: {FORCED}\nscenes:\n  s: {{kind: motion}}\n"
    text += "  t: {kind: motion, exciter: {f: 0.02}}\n"
    head, first, second = plan_text(study_of(text, tmp_path)).splitlines()[1:4]
    place = head.index("effects")
    assert first[place:].startswith("all ")
    assert second[place:].startswith("damping forcing ")


def test_the_order_of_effects_changes_no_fingerprint(tmp_path):
    texts = [
        f"title: T\nexciter: {FORCED}\nscenes:\n  s: {{kind: motion, effects: [{names}]}}\n"
        for names in (ALL, ", ".join(reversed(ALL.split(", "))))
    ]
    one, two = (fingerprint(study_of(text, tmp_path), "s") for text in texts)
    assert one == two


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
