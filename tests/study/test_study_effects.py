"""`effects` of a scene: stated, rejected, or derived from the parameters."""

import pytest
from study_texts import scene_faults, study_of

from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.study import fingerprint

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
