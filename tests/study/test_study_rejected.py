"""Each fault of a study has its message; all of them are told at once."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from study_texts import BASE, faults, scene_faults, study_of

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.scenes.keys.spelling import nearest
from vibropipe.study import StudyError, parse_study
from vibropipe.words.parameters import PARAMETERS


def test_message_names_file_key_value_allowed_and_nearest(tmp_path):
    told = faults(BASE.replace("h: 0.2", "h: -1").replace("tau_end", "tau_ned"), tmp_path)
    assert "exciter.h: found -1, allowed a finite number >= 0" in told
    unknown = next(line for line in told if line.startswith("scenes.forced.tau_ned"))
    assert "found an unknown key, allowed title, caption, exciter, figure, kind, tau_end" in unknown
    assert unknown.endswith("(did you mean 'tau_end'?)")


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        (
            "{kind: motin}",
            "s.kind: found 'motin', allowed motion, sweep, backbone, hard_cases, accuracy, effects (",
        ),
        (
            "{knd: motion}",
            "s.kind: found nothing, allowed motion, sweep, backbone, hard_cases, accuracy, effects (",
        ),
        ("3", "s: found 3, allowed a mapping with kind"),
        ("{kind: sweep}", "s.over: found nothing, allowed a mapping of grids"),
        ("{kind: sweep, over: {}}", "s.over: found an empty mapping, allowed a mapping of grids"),
        (
            "{kind: sweep, over: {x: [1]}}",
            "s.over.x: found an unknown key, allowed nu, f, h, l, del",
        ),
        ("{kind: sweep, over: {f: 3}}", "s.over.f: found 3, allowed a list of numbers, {values"),
        ("{kind: sweep, over: {f: []}}", "s.over.f: found an empty list, allowed at least one"),
        ("{kind: sweep, over: {f: [1, a]}}", "s.over.f[1]: found 'a', allowed a finite number"),
        ("{kind: sweep, over: {f: [2, 1]}}", "s.over.f: found 1.0 after 2.0, allowed increasing"),
        ("{kind: sweep, over: {f: [1, 1]}}", "s.over.f: found 1.0 after 1.0, allowed increasing"),
        ("{kind: sweep, over: {R1: [0, 2]}}", "s.over.R1: found 2.0, allowed a number from 0 to 1"),
        ("{kind: sweep, over: {l: [0, 2]}}", "s.over.l: found 0.0, allowed a finite number > 0"),
        (
            "{kind: sweep, over: {f: {start: 0, stop: 1, points: 1e12}}}",
            "s.over.f.points: found 1000000000000.0, allowed a whole number from 2 to 1e8",
        ),
        (
            "{kind: sweep, over: {f: {start: 0, stop: 1}}}",
            "s.over.f.points: found nothing, allowed a whole number",
        ),
        (
            "{kind: sweep, over: {f: {start: 0, stop: 1, points: 2, spacing: log}}}",
            "s.over.f: found start 0.0, allowed a start above 0 for log",
        ),
        (
            "{kind: sweep, over: {f: {start: 1, stop: 1.000000000000001, points: 90}}}",
            "s.over.f: found 90 points from 1.0 to 1.000000000000001, allowed points that",
        ),
        (
            "{kind: sweep, over: {f: {start: 0, stop: 1, points: 20000}, "
            "h: {start: 0, stop: 1, points: 20000}}}",
            "s.over: found 20000 x 20000 rows, allowed at most 1e8 rows in a scene",
        ),
        (
            "{kind: sweep, exciter: {f: 1}, over: {f: [1]}}",
            "s.exciter.f: found 1.0, allowed it left out here, since it is swept",
        ),
        (
            "{kind: sweep, over: {f: [1]}, start: {x0: 0}, follow: {along: f, direction: up}}",
            "s.start: found it beside follow, allowed either start or follow",
        ),
        (
            "{kind: sweep, over: {f: [1]}, follow: {along: nu, direction: up}}",
            "s.follow.along: found 'nu', allowed f",
        ),
        ("{kind: sweep, over: {f: [1]}, follow: }", "s.follow: found nothing, allowed a value, or"),
        (
            "{kind: sweep, over: {f: [1]}, solver: {method: newmark, steps_per_period: 9}}",
            "s.solver.method: found 'newmark', allowed exact",
        ),
        (
            "{kind: motion, solver: {method: newmark}}",
            "s.solver.steps_per_period: found nothing, al",
        ),
        (
            "{kind: motion, solver: {steps_per_period: 9}}",
            "s.solver.steps_per_period: found 9, allo",
        ),
        (
            "{kind: motion, solver: {accuracy: 0}}",
            "s.solver.accuracy: found 0, allowed a finite num",
        ),
        (
            "{kind: motion, solver: {accuracy: 1e-8, method: exact}}",
            "s.solver: found accuracy beside other keys, allowed either",
        ),
        ("{kind: motion, tau_end: 0}", "s.tau_end: found 0, allowed a finite number above 0 up to"),
        (
            "{kind: motion, tau_end: 1e9, settle_periods: 1}",
            "s.tau_end: found a motion until tau =",
        ),
        (
            "{kind: motion, tau_end: 1e9, samples_per_period: 1000}",
            "s.samples_per_period: found 1.59e+11 samples, allowed at most 2e+08",
        ),
        (
            "{kind: motion, settle_periods: 1000000, solver: {method: newmark, "
            "steps_per_period: 1000000}}",
            "s.solver.steps_per_period: found 1e+12 steps, allowed at most 1e+11 steps",
        ),
        ("{kind: motion, outputs: []}", "s.outputs: found an empty list, allowed a list of harm"),
        ("{kind: motion, outputs: [motion, motion]}", "s.outputs: found motion, motion, allowed"),
        (
            "{kind: motion, outputs: [harmonic]}",
            "s.outputs[0]: found 'harmonic', allowed harmonics",
        ),
        (
            "{kind: motion, start: {x0: 0.6}}",
            "s.start.x0: found 0.6, allowed a number from -0.5 to 0",
        ),
        (
            "{kind: motion, exciter: {delta: 1}, start: {x0: 0}}",
            "s.start.x0: found 0.0, allowed a number from 0.5",
        ),
        (
            "{kind: motion, exciter: {delta: 1e20}}",
            "s.exciter.l: found l = 0.5: with delta = 1e+20",
        ),
        (
            "{kind: sweep, over: {delta: [0, 0.6]}, start: {x0: 0}}",
            "s.start.x0: found 0.0, allowed a number from 0.09999999999999998 to 0.5",
        ),
        (
            "{kind: sweep, over: {delta: [0, 2]}, start: {x0: 0}}",
            "s.start.x0: found 0.0, allowed supports that share a place for one start",
        ),
        ("{kind: motion, harmonics: 1.5}", "s.harmonics: found 1.5, allowed a whole number from 1"),
        ("{kind: motion, harmonics: true}", "s.harmonics: found true, allowed a whole number"),
        (
            "{kind: sweep, over: {nu: [1]}, figure: {pictures: [map]}}",
            "s.figure.pictures: found a map of one swept parameter, allowed a map over two or more",
        ),
        (
            "{kind: motion, figure: {backbone: s}}",
            "s.figure.backbone: found an unknown key, allowed pictures, show, periods",
        ),
        ("{kind: backbone}", "s: found no grid, allowed delta_over_l and tau_bar, or amplitude"),
        ("{kind: backbone, tau_bar: [1]}", "s.delta_over_l: found nothing, allowed a grid"),
        ("{kind: backbone, tau_bar: [0], delta_over_l: [0]}", "s.tau_bar: found 0.0, allowed numb"),
        ("{kind: backbone, tau_bar: [1], delta_over_l: [1]}", "s.delta_over_l: found 1.0, allowed"),
        ("{kind: backbone, amplitude: [1], tau_bar: [1]}", "s.tau_bar: found it beside amplitude"),
        (
            "{kind: backbone, amplitude: [1], exciter: {R1: 1}}",
            "s.exciter.R1: found 1.0, allowed l",
        ),
        (
            "{kind: backbone, amplitude: [1], figure: {periods: 3}}",
            "s.figure.periods: found an unknown key, allowed no key here",
        ),
        (
            "{kind: backbone, tau_bar: [1], delta_over_l: [0], exciter: {l: 1}}",
            "s.exciter.l: found 1.0, allowed no exciter",
        ),
    ],
)
def test_each_fault_has_its_message_and_no_other(tmp_path, scene, told):
    (line,) = scene_faults(scene, tmp_path)
    assert line.startswith(f"scenes.{told}")


def test_follow_begins_where_its_rows_begin(tmp_path):
    # Upwards the first row is delta = 0, where the default start lies between the supports.
    scene = "{kind: sweep, over: {delta: [0, 0.6]}, follow: {along: delta, direction: up}}"
    study_of(f"title: T\nexciter: {{l: 0.5}}\nscenes: {{s: {scene}}}", tmp_path)


def test_l_is_needed_somewhere(tmp_path):
    (line,) = scene_faults("{kind: motion}", tmp_path, exciter="{}")
    assert line.startswith("scenes.s.exciter.l: found nothing, allowed a finite number > 0 (in the")
    study_of("title: T\nscenes: {s: {kind: sweep, over: {l: [1, 2]}}}", tmp_path)
    study_of("title: T\nscenes: {s: {kind: backbone, delta_over_l: [0], tau_bar: [4]}}", tmp_path)


def test_what_is_drawn_under_a_sweep_must_be_a_backbone_over_amplitude(tmp_path):
    sweep = "      delta: [0, 0.01]\n    figure: {backbone: %s}\n"
    text = BASE.replace("      delta: [0, 0.01]\n", sweep)
    for spelled in (text, text.replace("backbone: %s", "beside: %s")):  # as it was called once
        assert study_of(spelled % "free", tmp_path).scene("response").figure.backbone == "free"
    (line,) = faults(text % "fre", tmp_path)
    assert line == (
        "scenes.response.figure.backbone: found 'fre', allowed a backbone scene over amplitude "
        "(free) (did you mean 'free'?)"
    )
    (line,) = faults(text % "forced", tmp_path)
    assert "found 'forced', allowed a backbone scene over amplitude (free)" in line


def test_all_faults_are_told_at_once(tmp_path):
    text = """\
descripton: x
exciter: {R₁: 1.5, q: 1}
scenes:
  a b: {kind: motion}
  m: {kind: motion, exciter: {l: 0.5, delta: 1}, start: {x0: 0}, harmonics: three, solver: {method: newmark}}
  m: {kind: motion, exciter: {l: 1}}
  t: {kind: motio}
  n: {kind: sweep, exciter: {l: 1}, over: {f: [2, 1]}, outputs: [x]}
  b: {kind: backbone, delta_over_l: [0, 1], tau_bar: !!float 3}
"""
    paths = [line.split(": found")[0] for line in faults(text, tmp_path)]
    assert sorted(paths) == [
        *("descripton", "exciter.R1", "exciter.q", "scenes.'a b'", "scenes.b.delta_over_l"),
        *("scenes.b.tau_bar", "scenes.m", "scenes.m.harmonics", "scenes.m.solver.steps_per_period"),
        *("scenes.m.start.x0", "scenes.n.outputs[0]", "scenes.n.over.f", "scenes.t.kind", "title"),
    ]


def test_a_fault_is_not_told_again_by_what_follows_from_it(tmp_path):
    # R1 = 2 is wrong once, not once more in each scene that takes it.
    (line,) = faults(BASE.replace("R1: 0.7", "R1: 2"), tmp_path)
    assert line == "exciter.R1: found 2, allowed a number from 0 to 1"
    # Without a readable l nothing is said of starts between the supports.
    (line,) = faults(BASE.replace("l: 0.5", "l: half"), tmp_path)
    assert line == "exciter.l: found 'half', allowed a finite number > 0"


@pytest.mark.parametrize(
    "value", [".nan", ".inf", "-.inf", "1e999", "true", "", "abc", "[1]", "{}"]
)
@pytest.mark.parametrize("name", ["nu", "f", "h", "l", "delta", "R1", "R2"])
def test_parameters_refuse_what_is_no_finite_number(tmp_path, name, value):
    exciter = f"{{l: 1, {name}: {value}}}" if name != "l" else f"{{l: {value}}}"
    (line,) = scene_faults("{kind: motion}", tmp_path, exciter=exciter)
    assert line.startswith(f"exciter.{name}: found ")
    assert f"allowed {PARAMETERS[name].range.text}" in line


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("v", "did you mean 'nu'?"),
        ("υ", "did you mean 'nu'?; some of its letters only look right"),
        ("ѵ", "did you mean 'nu'?; some of its letters only look right"),
        ("𝜈", "did you mean 'nu'?; some of its letters only look right"),
        ("∂", "did you mean 'delta'?; some of its letters only look right"),
        ("һ", "did you mean 'h'?; some of its letters only look right"),
        ("Ｒ1", "did you mean 'R1'?; some of its letters only look right"),
        ("r1", "did you mean 'R1'?"),
        ("R_2", "did you mean 'R2'?"),
        ("detla", "did you mean 'delta'?"),
    ],
)
def test_look_alikes_are_refused_with_a_hint(tmp_path, key, hint):
    (line,) = scene_faults("{kind: motion}", tmp_path, exciter=f"{{l: 1, {key}: 0.5}}")
    assert ": found an unknown key, allowed nu, f, h, l, delta, R1, R2 (" in line
    assert line.endswith(f"({hint})")


def test_nearest_word_keeps_silent_when_nothing_is_near():
    assert nearest("temperature", ["nu", "f", "delta"]) is None


def test_unknown_scene_names_the_nearest(tmp_path):
    with pytest.raises(StudyError, match=r"no scene 'fored', allowed forced, .*mean 'forced'"):
        study_of(BASE, tmp_path).scene("fored")


@settings(max_examples=200)
@given(
    st.sampled_from(["nu", "f", "h", "l", "delta", "R1", "R2"]),
    st.one_of(st.floats(), st.floats(-2, 2), st.sampled_from([0.0, -0.0, 1.0, 1e308, 5e-324])),
)
@example("delta", 1e300)
@example("R1", -0.0)
def test_a_study_takes_exactly_what_the_exciter_takes(name, value):
    """The rules of parameters are those of `Exciter`, and the schema says no less than they do."""
    tree = {"title": "T", "scenes": {"s": {"kind": "sweep", "exciter": {"l": 1.0}, "over": {}}}}
    scene = tree["scenes"]["s"]
    scene["over"] = {"h" if name != "h" else "f": [0.0]}
    scene["exciter"][name], scene["start"] = value, {"x0": 0.0}
    try:
        exciter = Exciter(**{"l": 1.0, name: value})
        exciter.check_start(0.0, 0.0)
    except ParameterError:
        with pytest.raises(StudyError, match=rf"scenes\.s\.(exciter\.({name}|l)|start\.x0): found"):
            parse_study(tree)
    else:
        assert parse_study(tree).scene("s").resolved_exciter()[name] == value
