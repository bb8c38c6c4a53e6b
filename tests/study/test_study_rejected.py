"""Each fault of a study has its message; all faults are reported at once."""

import re

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from study_texts import BASE, faults, scene_faults, study_of

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.study import StudyError, parse_study
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.spelling import nearest


def test_message_names_file_key_value_allowed_and_nearest(tmp_path):
    told = faults(BASE.replace("h: 0.2", "h: -1").replace("tau_end", "tau_ned"), tmp_path)
    assert "exciter.h: must be a finite number >= 0, got -1" in told
    unknown = next(line for line in told if line.startswith("scenes.forced.tau_ned"))
    choices = "title, caption, exciter, physical, figure, ties, kind, tau_end"
    assert f": is an unknown key; must be one of {choices}" in unknown
    assert unknown.endswith("(did you mean 'tau_end'?)")


# Scenes, and beneath each, indented, its one message.
FAULTS = """\
{kind: motin}
    s.kind: must be one of motion, sweep, branch, boundary, basins, design, identify, backbone, hard_cases,
    accuracy, effects, got 'motin' (did you mean 'motion'?)
{knd: motion}
    s.kind: is required (one of motion, sweep, branch, boundary, basins, design, identify, backbone, hard_cases,
    accuracy, effects) (is 'knd' meant to be it?)
3
    s: must be a mapping with kind (one of motion, sweep, branch, boundary, basins, design, identify, backbone,
    hard_cases, accuracy, effects) and its keys, got 3
{kind: sweep}
    s.over: is required (a mapping of grids by parameter, at least one)
{kind: sweep, over: {}}
    s.over: must be a mapping of grids by parameter, at least one, got an empty mapping
{kind: sweep, over: {x: [1]}}
    s.over.x: is an unknown key; must be one of nu, f, h, l, delta, R1, R2, k1, k2, h1, h2, contact_1, contact_2,
    load, friction, friction_ratio, f2, phi2, mass_ratio, housing_friction_1, housing_friction_2, housing_load,
    shaker, wear_exponent, x0, v0 (did you mean 'x0'?)
{kind: sweep, over: {x0: [0, 0.9]}}
    s.over.x0: must be a number from -0.5 to 0.5 (between the supports), got 0.9
{kind: sweep, over: {x0: [0, 0.4], l: [0.3, 1]}}
    s.over.x0: must be a number from -0.3 to 0.3 (between the supports), got 0.4
{kind: sweep, over: {x0: [0, 0.1]}, start: {x0: 0.1}}
    s.start.x0: must be left out, since x0 is swept, got 0.1
{kind: sweep, over: {v0: [0, 0.1]}, start: {v0: 0.0}}
    s.start.v0: must be left out, since v0 is swept, got 0.0
{kind: sweep, over: {x0: [0, 0.1], nu: [1, 2]}, follow: {along: nu, direction: up}}
    s.follow: must be left out when x0 is swept, since a followed row starts from its neighbour
{kind: sweep, over: {nu: [1, 2]}, figure: {show: [lyapunov_exponent]}}
    s.figure.show: must leave out lyapunov_exponent unless outputs have lyapunov, got 'lyapunov_exponent'
{kind: sweep, over: {f: 3}}
    s.over.f: must be a list of numbers, {values: [...]} or {start, stop, points}, got 3
{kind: sweep, over: {f: []}}
    s.over.f: must have at least one number, got an empty list
{kind: sweep, over: {f: [1, a]}}
    s.over.f[1]: must be a finite number, got 'a'
{kind: sweep, over: {f: [2, 1]}}
    s.over.f: must be increasing numbers, each once, got 1.0 after 2.0 (if 2.1 is meant, write it with a point)
{kind: sweep, over: {f: [1, 1]}}
    s.over.f: must be increasing numbers, each once, got 1.0 after 1.0 (if 1.1 is meant, write it with a point)
{kind: sweep, over: {R1: [0, 2]}}
    s.over.R1: must be a number from 0 to 1, got 2.0 (if 0.2 is meant, write it with a point)
{kind: sweep, over: {l: [0, 2]}}
    s.over.l: must be a finite number > 0, got 0.0 (if 0.2 is meant, write it with a point)
{kind: sweep, over: {f: {start: 0, stop: 1, points: 1e12}}}
    s.over.f.points: must be a whole number from 2 to 1e8, got 1000000000000.0
{kind: sweep, over: {f: {start: 0, stop: 1, points: 1}}}
    s.over.f.points: must be a whole number from 2 to 1e8, got 1 (one value is written as a list, such as [0.5])
{kind: boundary, of: [fold], over: {nu: [1, 2]}}
    s.over: must be a mapping of pairs [low, high] by parameter, exactly two, got a mapping of 1
{kind: boundary, of: [fold], over: {nu: {start: 1, stop: 2}, f: [1, 2]}}
    s.over.nu: must be two increasing numbers, [low, high], got a mapping
{kind: design, vary: {R1: 0.4}, target: {displacement_mean: 0}}
    s.vary.R1: must be two increasing numbers, [low, high], got 0.4
{kind: sweep, over: {f: {start: 0, stop: 1}}}
    s.over.f.points: is required (a whole number from 2 to 1e8)
{kind: sweep, over: {f: {start: 0, stop: 1, points: 2, spacing: log}}}
    s.over.f: must have start above 0 for log spacing, got start 0.0
{kind: sweep, over: {f: {start: 1, stop: 1.000000000000001, points: 90}}}
    s.over.f: must have points that are distinct floating-point numbers, got 90 points from 1.0 to
    1.000000000000001
{kind: sweep, over: {f: {start: 0, stop: 1, points: 20000}, h: {start: 0, stop: 1, points: 20000}}}
    s.over: must give at most 1e8 rows in a scene, got 20000 x 20000 rows
{kind: sweep, exciter: {m: 1}, over: {f: [1]}}
    s.exciter.m: is an unknown key (m has units: it stands under physical)
{kind: sweep, over: {F: [1]}}
    s.over.F: is an unknown key (F has units: it stands under physical)
{kind: sweep, exciter: {f: 1}, over: {f: [1]}}
    s.exciter.f: must be left out, since f is swept, got 1.0
{kind: sweep, over: {f: [1]}, start: {x0: 0}, follow: {along: f, direction: up}}
    s.start: must be left out when follow is given
{kind: sweep, over: {f: [1]}, follow: {along: nu, direction: up}}
    s.follow.along: must be a swept parameter (f), got 'nu'
{kind: sweep, over: {f: [1]}, follow: }
    s.follow: must have a value or be left out, got nothing
{kind: sweep, over: {f: [1]}, solver: {method: newmark, steps_per_period: 9}}
    s.solver.method: must be exact, or left out for an accuracy, since steady states are found in closed form, got
    'newmark'
{kind: motion, solver: {method: newmark}}
    s.solver.steps_per_period: is required (a whole number from 1 to 1e8), since method is newmark
{kind: motion, solver: {steps_per_period: 9}}
    s.solver.steps_per_period: must be left out unless method is newmark, got 9
{kind: motion, solver: {accuracy: 0}}
    s.solver.accuracy: must be a number from 1e-15 to 0.1, got 0
{kind: motion, solver: {accuracy: 1e-8, method: exact}}
    s.solver: must have accuracy alone, which selects method and steps_per_period, got accuracy with method
{kind: motion, tau_end: 0}
    s.tau_end: must be a number above 0 up to 1e9, got 0
{kind: motion, tau_end: 1e9, settle_periods: 1}
    s.tau_end: must end the motion at tau = 1e+09 or before, got tau = 1000000006
{kind: motion, tau_end: 1e9, samples_per_period: 1000}
    s.samples_per_period: must give at most 2e+07 samples in a record, got 1.59e+11 samples
{kind: motion, settle_periods: 1000000, solver: {method: newmark, steps_per_period: 1000000}}
    s.solver.steps_per_period: must give at most 1.5e+08 steps, got 1e+12 steps
{kind: motion, outputs: []}
    s.outputs: must be a list of harmonics, impacts, motion, stability, energy, power, frame, subharmonics,
    poincare, lyapunov, sensitivity, got an empty list
{kind: motion, outputs: [motion, motion]}
    s.outputs: must have each name once, got motion, motion
{kind: motion, outputs: [harmonic]}
    s.outputs[0]: must be one of harmonics, impacts, motion, stability, energy, power, frame, subharmonics,
    poincare, lyapunov, sensitivity, got 'harmonic' (did you mean 'harmonics'?)
{kind: motion, start: {x0: 0.6}}
    s.start.x0: must be a number from -0.5 to 0.5 (between the supports), got 0.6
{kind: motion, exciter: {delta: 1}, start: {x0: 0}}
    s.start.x0: must be a number from 0.5 to 1.5 (between the supports), got 0.0
{kind: motion, exciter: {delta: 1e20}}
    s.exciter.l: must be at least 1e-15 |delta| so that the supports are distinct floating-point numbers, got l =
    0.5, delta = 1e+20
{kind: sweep, over: {delta: [0, 0.6]}, start: {x0: 0}}
    s.start.x0: must be a number from 0.1 to 0.5 (between the supports), got 0.0
{kind: sweep, over: {delta: [0, 2]}, start: {x0: 0}}
    s.start.x0: must lie between the supports in every row, but no value does on this grid; split the sweep
{kind: motion, harmonics: 1.5}
    s.harmonics: must be a whole number from 1 to 1000, got 1.5
{kind: motion, harmonics: true}
    s.harmonics: must be a whole number from 1 to 1000, got true
{kind: sweep, over: {nu: [1]}, figure: {pictures: [map]}}
    s.figure.pictures: must leave out map unless two or more parameters are swept, got a map of one swept
    parameter
{kind: sweep, over: {nu: {start: 1, stop: 2, points: 9}, f: {start: 1, stop: 2, points: 8}}, figure: {pictures:
  [map, curves]}}
    s.figure.pictures: must leave out curves unless all grids but the finest have at most 7 values, got curves for
    8 values
{kind: motion, outputs: [impacts], figure: {pictures: [impacts, panels]}}
    s.figure.pictures: must leave out panels unless outputs have motion and samples_per_period is above 0, got
    panels of a motion without samples
{kind: sweep, over: {nu: [1]}, figure: {pictures: [portrait]}}
    s.figure.pictures: must leave out portrait unless outputs have motion, got 'portrait'
{kind: sweep, over: {nu: [1]}, outputs: [poincare], figure: {show: [poincare_velocity]}}
    s.figure.show: must leave out poincare_velocity unless pictures have bifurcation, got 'poincare_velocity'
{kind: sweep, over: {nu: [1]}, outputs: [impacts], figure: {show: [energy_input]}}
    s.figure.show: must leave out energy_input unless outputs have energy, got 'energy_input'
{kind: sweep, over: {nu: [1]}, outputs: [energy], figure: {show: [energy_friction]}}
    s.figure.show: must leave out energy_friction unless friction is above 0, got 'energy_friction'
{kind: motion, figure: {pictures: [spectrum]}}
    s.figure.pictures: must leave out spectrum unless outputs have harmonics, got 'spectrum'
{kind: backbone, amplitude: [1], figure: {show: [tau_bar]}}
    s.figure.show: must name quantities of a backbone over amplitude (one of displacement_mean, velocity_mean,
    displacement_amplitude, velocity_amplitude), got 'tau_bar'
{kind: backbone, tau_bar: [1], delta_over_l: [0], figure: {show: [velocity_mean]}}
    s.figure.show: must name quantities of a backbone of eq. (10) (tau_bar or omega_bar), got 'velocity_mean'
{kind: backbone, exciter: {l: 0.5, delta: 0.75}, amplitude: [0.25, 1]}
    s.amplitude: must be numbers above 0.25 (the equilibrium lies beyond a support), got 0.25
{kind: backbone, exciter: {l: 0.5, delta: -0.75}, amplitude: [0.125, 1]}
    s.amplitude: must be numbers above 0.25 (the equilibrium lies beyond a support), got 0.125
{kind: motion, figure: {backbone: s}}
    s.figure.backbone: is an unknown key; must be one of pictures, together, heads, show, periods
{kind: backbone}
    s: must have the grids delta_over_l and tau_bar, or amplitude, got no grid
{kind: backbone, tau_bar: [1]}
    s.delta_over_l: is required (a grid), unless amplitude is given
{kind: backbone, tau_bar: [0], delta_over_l: [0]}
    s.tau_bar: must be numbers above 0, got 0.0
{kind: backbone, tau_bar: [1], delta_over_l: [1]}
    s.delta_over_l: must be numbers between -1 and 1, got 1.0
{kind: backbone, amplitude: [1], tau_bar: [1]}
    s.tau_bar: must not be combined with amplitude
{kind: backbone, amplitude: [1], exciter: {R1: 1}}
    s.exciter.R1: must be left out, since free motion has neither force nor loss (l and delta are allowed), got
    1.0
{kind: backbone, amplitude: [1], figure: {periods: 3}}
    s.figure.periods: is an unknown key; must be together or show
{kind: backbone, tau_bar: [1], delta_over_l: [0], exciter: {l: 1}}
    s.exciter.l: must be left out, since the curves depend on delta_over_l and tau_bar alone, got 1.0
"""


def listed(text: str) -> list[tuple[str, str]]:
    """Return the scenes of a text with their messages, which may run over several lines."""
    parts = (re.split(r"\n {4}", each) for each in re.split(r"\n(?=\S)", text.strip()))
    return [(scene.replace("\n ", ""), " ".join(told)) for scene, *told in parts]


@pytest.mark.parametrize(("scene", "told"), listed(FAULTS))
def test_each_fault_has_its_message_and_no_other(tmp_path, scene, told):
    (line,) = scene_faults(scene, tmp_path)
    assert line == f"scenes.{told}"


def test_follow_begins_where_its_rows_begin(tmp_path):
    # Upwards the first row is delta = 0, where the default start lies between the supports.
    scene = "{kind: sweep, over: {delta: [0, 0.6]}, follow: {along: delta, direction: up}}"
    study_of(f"title: T\nexciter: {{l: 0.5}}\nscenes: {{s: {scene}}}", tmp_path)


def test_l_is_needed_somewhere(tmp_path):
    (line,) = scene_faults("{kind: motion}", tmp_path, exciter="{}")
    where = "in the scene or in the study"
    assert line == f"scenes.s.exciter.l: is required (a finite number > 0), {where}"
    study_of("title: T\nscenes: {s: {kind: sweep, over: {l: [1, 2]}}}", tmp_path)
    study_of("title: T\nscenes: {s: {kind: backbone, delta_over_l: [0], tau_bar: [4]}}", tmp_path)


def test_what_is_drawn_under_a_sweep_must_be_a_backbone_over_amplitude(tmp_path):
    sweep = "      delta: [0, 0.01]\n    figure: {backbone: %s}\n"
    text = BASE.replace("      delta: [0, 0.01]\n", sweep)
    for spelled in (text, text.replace("backbone: %s", "beside: %s")):  # as it was called once
        assert study_of(spelled % "free", tmp_path).scene("response").figure.backbone == "free"
    (line,) = faults(text % "fre", tmp_path)
    assert line == (
        "scenes.response.figure.backbone: must be a backbone scene over amplitude (free), got 'fre' "
        "(did you mean 'free'?)"
    )
    (line,) = faults(text % "forced", tmp_path)
    assert "must be a backbone scene over amplitude (free), got 'forced'" in line


def test_all_faults_are_reported_at_once(tmp_path):
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
    paths = [re.split(": (?:must|is) ", line)[0] for line in faults(text, tmp_path)]
    assert sorted(paths) == [
        *("descripton", "exciter.R1", "exciter.q", "scenes.'a b'", "scenes.b.delta_over_l"),
        *("scenes.b.tau_bar", "scenes.m", "scenes.m.harmonics", "scenes.m.solver.steps_per_period"),
        *("scenes.m.start.x0", "scenes.n.outputs[0]", "scenes.n.over.f", "scenes.t.kind", "title"),
    ]


def test_a_fault_is_not_reported_again_by_its_consequences(tmp_path):
    # R1 = 2 is reported once, not again in each scene that uses it.
    (line,) = faults(BASE.replace("R1: 0.7", "R1: 2"), tmp_path)
    assert line == "exciter.R1: must be a number from 0 to 1, got 2"
    # Without a valid l, starts between the supports are not checked.
    (line,) = faults(BASE.replace("l: 0.5", "l: half"), tmp_path)
    assert line == "exciter.l: must be a finite number > 0, got 'half'"


@pytest.mark.parametrize(
    "value", [".nan", ".inf", "-.inf", "1e999", "true", "", "abc", "[1]", "{}"]
)
@pytest.mark.parametrize("name", ["nu", "f", "h", "l", "delta", "R1", "R2"])
def test_parameters_refuse_what_is_no_finite_number(tmp_path, name, value):
    exciter = f"{{l: 1, {name}: {value}}}" if name != "l" else f"{{l: {value}}}"
    (line,) = scene_faults("{kind: motion}", tmp_path, exciter=exciter)
    assert line.startswith(f"exciter.{name}: must be {PARAMETERS[name].range.text}, got ")


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
    assert ": is an unknown key; must be one of nu, f, h, l, delta, R1, R2, k1, " in line
    assert line.endswith(f"({hint})")


def test_nearest_word_keeps_silent_when_nothing_is_near():
    assert nearest("temperature", ["nu", "f", "delta"]) is None


def test_unknown_scene_names_the_nearest(tmp_path):
    with pytest.raises(
        StudyError, match=r"scene: must be one of forced, .*, got 'fored' .*mean 'forced'"
    ):
        study_of(BASE, tmp_path).scene("fored")


@settings(max_examples=200)
@given(
    st.sampled_from(["nu", "f", "h", "l", "delta", "R1", "R2"]),
    st.one_of(st.floats(), st.floats(-2, 2), st.sampled_from([0.0, -0.0, 1.0, 1e308, 5e-324])),
)
@example("delta", 1e300)
@example("R1", -0.0)
def test_a_study_takes_exactly_what_the_exciter_takes(name, value):
    """A study accepts the values of a parameter that `Exciter` accepts, and no others."""
    tree = {
        "title": "T",
        "scenes": {"s": {"kind": "sweep", "exciter": {"l": 1.0, "nu": 1.0}, "over": {}}},
    }
    scene = tree["scenes"]["s"]
    scene["over"] = {"h" if name != "h" else "f": [0.0]}
    scene["exciter"][name], scene["start"] = value, {"x0": 0.0}
    try:
        exciter = Exciter(**{"l": 1.0, name: value})
        exciter.check_start(0.0, 0.0)
    except ParameterError:
        with pytest.raises(
            StudyError, match=rf"scenes\.s\.(exciter\.({name}|l)|start\.x0): must be"
        ):
            parse_study(tree)
    else:
        assert parse_study(tree).scene("s").resolved_exciter()[name] == value


HERO = BASE.replace("tau_end: 20", "tau_end: 20\n    figure: {pictures: [panels, portrait]}")


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        (
            "hero: {scene: forcd}",
            "hero.scene: must be a scene of the study (forced, response, free), got 'forcd' (did you mean 'forced'?)",
        ),
        (
            "hero: {scene: forced, picture: panel}",
            "hero.picture: must be one of the pictures in scenes.forced.figure.pictures (panels, portrait), got "
            "'panel' (did you mean 'panels'?)",
        ),
        (
            "hero: {scene: free, picture: curves}",
            "hero.picture: must be left out, or in scenes.free.figure.pictures, got 'curves'",
        ),
        ("hero: {picture: panels}", "hero.scene: is required"),
        (
            "hero: {scene: forced, size: 3}",
            "hero.size: is an unknown key; must be scene or picture",
        ),
        (
            f"question: {'a' * 111}",
            "question: must be one line of text, at most 110 characters, got",
        ),
    ],
)
def test_hero_and_question(keys, told, tmp_path):
    messages = faults(f"{keys}\n{HERO}", tmp_path)
    assert any(line.startswith(told) for line in messages), messages


@pytest.mark.parametrize(
    "keys", ["hero: {scene: forced, picture: portrait}", "hero: {scene: free}"]
)
def test_a_hero_that_is_drawn_is_accepted(keys, tmp_path):
    assert study_of(f"question: Why?\n{keys}\n{HERO}", tmp_path).question == "Why?"


TOGETHER = """title: One
exciter: {l: 0.5, nu: 1, f: -1}
scenes:
  a: {kind: motion, figure: {together: [b]}}
  b: {kind: motion}
  c: {kind: motion, outputs: [impacts]}
  free: {kind: backbone, amplitude: [0.1, 0.6], figure: {together: [line]}}
  line: {kind: sweep, over: {nu: [0.5, 1], f: [0.1, 0.2]}}
  wide: {kind: sweep, over: {nu: [0.5, 1], f: [0.1, 0.2], h: [0.1, 0.2]}}
  law: {kind: backbone, delta_over_l: [0], tau_bar: [1, 2]}
"""


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("[b]", "[c]"), "scenes.a.figure.together[0]: must be another motion with samples, not a ramp (b), got 'c'"),
        (("[b]", "[a]"), "scenes.a.figure.together[0]: must be another motion with samples, not a ramp (b), got 'a'"),
        (("[line]", "[wide]"), "scenes.free.figure.together[0]: must be a backbone over amplitude, or a sweep of the "
         "frequency and at most one more parameter, with harmonics (line), got 'wide'"),
        (("tau_bar: [1, 2]", "tau_bar: [1, 2], figure: {together: [free]}"),
         "scenes.law.figure.together: must be left out unless the scene runs over amplitude, got free"),
        (("samples", "samples"), ""),
        (("title: One", "title: One\nhero: {scene: b}"), "hero.scene: must name a scene with a picture of its own, not "
         "one that another draws together with itself, got 'b'"),
        (("title: One", "title: One\ntable: {title: T, head: [a, b], rows: [[x]]}"),
         "table.rows[0]: must have a text for each of the 2 columns, got 1 text"),
        (("title: One", "title: One\nanswers: [a, b, c, d]"),
         "answers: must have at most 3 entries, got a list of 4"),
        (("title: One", f"title: One\nanswers: [{'a' * 251}]"),
         "answers[0]: must be one line of text, at most 250 characters, got"),
    ],
)  # fmt: skip
def test_what_is_drawn_together_and_told_fits(change, told, tmp_path):
    text = TOGETHER.replace(*change)
    if not told:
        study = study_of(text, tmp_path)
        assert study.scenes["a"].figure.shown_scenes() == ("b",)
        return
    assert [line for line in faults(text, tmp_path) if line.startswith(told)], faults(
        text, tmp_path
    )


@pytest.mark.parametrize(
    ("scene", "key"),
    [
        ("{kind: basins, over: {x0: [0, 0.1], v0: {start: -1, stop: 1, points: 0}}}", "over.v0"),
        ("{kind: backbone, delta_over_l: [0], tau_bar: {start: 1, stop: 2, points: 0}}", "tau_bar"),
    ],
)
def test_a_key_with_a_fault_is_not_missing(scene, key, tmp_path):
    (told,) = scene_faults(scene, tmp_path)
    assert told == f"scenes.s.{key}.points: must be a whole number from 2 to 1e8, got 0"
