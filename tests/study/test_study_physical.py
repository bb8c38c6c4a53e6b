"""Studies with units: what they mean, and what is wrong with them."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
import study_texts

import vibropipe as vp
from vibropipe.study import Study, StudyError, fingerprint, json_schema, study_of_text
from vibropipe.words import vocabulary

TEXT = """
title: With units
physical: {m: 2 kg, C: 8 N/mm, H: 40 N s/m, l: 8 mm, F: 120 N, omega: 55 rad/s}
exciter: {R1: 0.7, R2: 0.6}
scenes:
  sweep: {kind: sweep, over: {omega: {start: 20 rad/s, stop: 200 rad/s, points: 9}, delta: [0, 1 mm]}}
  motion: {kind: motion, tau_end: 0.5 s, start: {x0: 5 mm, v0: 0.1 m/s}, physical: {omega: 9 Hz}}
  free: {kind: backbone, amplitude: [1 mm, 20 mm]}
  curves: {kind: backbone, delta_over_l: [0], tau_bar: [40 ms, 50 ms]}
  races: {kind: accuracy, motions: {one: {physical: {omega: 60 rpm}}, two: {}}}
"""
P = math.sqrt(4000)


def study_with(*changes: tuple[str, str], text: str = TEXT) -> Study:
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return study_of_text(text, "units")


def faults(*changes: tuple[str, str]) -> list[str]:
    with pytest.raises(StudyError) as caught:
        study_with(*changes)
    return str(caught.value).replace("the study units: ", "").splitlines()


def test_a_study_with_units_is_that_without_by_equations_2_to_4() -> None:
    scenes = study_with().scenes
    expected = vp.Exciter.from_physical(
        m=2, C=8000, H=40, l=0.008, F=120, omega="9 Hz", R1=0.7, R2=0.6
    )
    motion = scenes["motion"]
    assert motion.resolved_exciter() == expected.stated()
    assert (motion.tau_end, motion.start.x0) == (0.5 * P, 0.005)
    assert motion.start.v0 == pytest.approx(0.1 / P, rel=1e-15)
    sweep = scenes["sweep"].over_arrays()
    assert sweep["nu"] * P == pytest.approx([20.0 + 22.5 * n for n in range(9)], rel=1e-15)
    assert sweep["delta"].tolist() == [0.0, 0.001]
    assert scenes["free"].over_arrays()["amplitude"].tolist() == [0.001, 0.02]
    assert scenes["curves"].over_arrays()["tau_bar"] == pytest.approx([0.04 * P, 0.05 * P])
    races = scenes["races"]
    assert races.exciter_of("one")["nu"] * P == pytest.approx(2 * math.pi)
    assert races.exciter_of("two")["nu"] * P == pytest.approx(55)
    assert {scene.mass_and_stiffness for scene in scenes.values()} == {(2.0, 8000.0)}


def test_units_are_free_and_mean_the_same() -> None:
    other = study_with(
        ("2 kg", "2000 g"), ("8 N/mm", "8000 N/m"), ("l: 8 mm", "l: 8e-3 m"), ("120 N", "0.12 kN"),
        ("omega: 55 rad/s}", "ω: 55 rad/s}"), ("0.5 s", "500 ms"), ("5 mm", "0.5 cm"), ("[1 mm, ", "[1000 um, "),
    )  # fmt: skip
    study = study_with()
    for name in study.scenes:
        assert fingerprint(other, name) == fingerprint(study, name)


@pytest.mark.parametrize("name", ["along", "over", "vary", "tolerance"])
def test_scenes_and_motions_may_have_the_names_of_keys(name):
    named = study_with(("sweep: {kind", f"{name}: {{kind"), ("{one:", f"{{{name}:"))
    plain = study_with()
    assert named.scenes[name].data_keys() == plain.scenes["sweep"].data_keys()
    physical = named.scenes["races"].motions[name].physical
    assert physical == plain.scenes["races"].motions["one"].physical


def test_mass_and_dimensions_are_part_of_the_fingerprint(monkeypatch) -> None:
    # The same numbers without units, from another mass and stiffness: stored in other units.
    study = study_with()
    heavier = study_with(
        ("2 kg", "8 kg"), ("8 N/mm", "32 N/mm"), ("40 N", "160 N"), ("120 N", "480 N")
    )
    assert heavier.scenes["sweep"].resolved_exciter() == study.scenes["sweep"].resolved_exciter()
    assert fingerprint(heavier, "sweep") != fingerprint(study, "sweep")
    before = fingerprint(study, "sweep")
    changed = replace(vocabulary.quantity("residual"), dimension="length")
    monkeypatch.setitem(vocabulary.QUANTITIES, "residual", changed)
    assert fingerprint(study, "sweep") != before


def test_bare_numbers_of_tau_end_are_seconds_and_its_default_is_without_unit() -> None:
    assert study_with(("0.5 s", "0.5")).scenes["motion"].tau_end == 0.5 * P
    assert study_with((" tau_end: 0.5 s,", "")).scenes["motion"].tau_end == 60.0


LENGTH = "a length > 0 with its unit, such as 8 mm"
FREQUENCY = "a frequency > 0 with its unit, such as 55 rad/s"
SWEPT = "scenes.sweep.over.omega"


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("l: 8 mm", "l: 8", f"physical.l: must be {LENGTH}, got 8 (it has no unit)"),
        ("l: 8 mm", "l: 8 mmm", f"physical.l: must be {LENGTH}, got '8 mmm' ('mmm' is no unit that is known)"),
        ("l: 8 mm", "l: 8 N", f"physical.l: must be {LENGTH}, got '8 N' (N is no unit of length)"),
        ("l: 8 mm", "l: -8 mm", f"physical.l: must be {LENGTH}, got '-8 mm'"),
        ("physical: {m:", "physikal: {m:",
         "physikal: is an unknown key; must be one of title, question, description, answers, table, hero, "
         "exciter, ties, physical, units, scenes (did you mean 'physical'?)"),
        ("l: 8 mm", "l: 8,5 mm", "physical.l: must be a number, got '8,5 mm' (write 8.5 mm, with a point)"),
        ("tau_end: 0.5 s,", "tau_end: 0,5 s,",
         "scenes.motion.tau_end: must be a number, got '0,5 s' (write 0.5 s, with a point)"),
        ("[0, 1 mm]", "[-1,5 mm, 1 mm]",
         "scenes.sweep.over.delta[0]: must be a length with its unit, such as 8 mm, got -1 (if -1.5 mm is meant, write "
         "it with a point)"),
        ("m: 2 kg, ", "", "physical.m: is required (a mass > 0 with its unit, such as 2 kg)"),
        ("{R1: 0.7", "{l: 0.5, R1: 0.7", "exciter.l: must be left out: give l with its unit in physical, got 0.5"),
        ("{R1: 0.7", "{nu: 1, R1: 0.7", "exciter.nu: must be left out: give omega with its unit in physical, got 1"),
        ("start: 20 rad/s", "start: 20", f"{SWEPT}.start: must be {FREQUENCY}, got 20 (it has no unit)"),
        ("start: 20 rad/s", "start: 20 1/s",
         f"{SWEPT}.start: must be {FREQUENCY}, got '20 1/s' (1/s may count radians or cycles: write rad/s, Hz or rpm)"),
        ("start: 20 rad/s", "start: 300 rad/s",
         f"{SWEPT}: must have start below stop, got start 300 rad/s, stop 200 rad/s"),
        ("start: 20 rad/s", "start: -20 rad/s", f"{SWEPT}.start: must be {FREQUENCY}, got '-20 rad/s'"),
        ("{start: 20 rad/s, stop: 200 rad/s, points: 9}", "20 rad/s",
         f"{SWEPT}: must be a list of numbers, {{values: [...]}} or {{start, stop, points}}, got '20 rad/s'"),
        ("over: {omega", "over: {nu",
         "scenes.sweep.over.nu: is an unknown key; must be one of omega, F, H, l, delta, C1, C2, H1, H2, load, "
         "friction, F2, phi2, M, D1, D2, P, shaker, R1, R2, contact_1, contact_2, friction_ratio, "
         "wear_exponent (with its unit, nu is "
         "omega)"),
        ("delta: [0, 1 mm]", "m: [1 kg]",
         "scenes.sweep.over.m: has one value, under `physical`, and does not vary; must be one of omega, F, H, l, "
         "delta, C1, C2, H1, H2, load, friction, F2, phi2, M, D1, D2, P, shaker, R1, R2, contact_1, contact_2, "
         "friction_ratio, wear_exponent"),
        ("[0, 1 mm]", "[1 mm, 0]",
         "scenes.sweep.over.delta: must be increasing numbers, each once, got 0 after 1 mm"),
        ("start: 20 rad/s, stop: 200 rad/s", "start: 30 Hz, stop: 3 Hz",
         f"{SWEPT}: must have start below stop, got start 30 Hz, stop 3 Hz"),
        ("start: 20 rad/s, stop: 200 rad/s, points: 9", "start: 3 Hz, stop: 3.00000000000001 Hz, points: 9",
         f"{SWEPT}: must have points that are distinct floating-point numbers, got 9 points from 3 Hz to "
         "3.00000000000001 Hz"),
        ("[0, 1 mm]", "{values: [2 mm, 1 mm]}",
         "scenes.sweep.over.delta.values: must be increasing numbers, each once, got 1 mm after 2 mm"),
        ("{kind: sweep,", "{kind: sweep, physical: {omega: 9 Hz},",
         "scenes.sweep.physical.omega: must be left out, since omega is swept, got '9 Hz'"),
        ("{kind: sweep,", "{kind: sweep, follow: {along: F, direction: up},",
         "scenes.sweep.follow.along: must be a swept parameter (omega, delta), got 'F'"),
        ("x0: 5 mm", "x0: 5",
         "scenes.motion.start.x0: must be a length with its unit, such as 8 mm, got 5 (it has no unit)"),
        ("x0: 5 mm", "x0: 9 mm",
         "scenes.motion.start.x0: must be a number from -8 to 8 mm (between the supports), got '9 mm'"),
        ("0.5 s", "5 mm",
         "scenes.motion.tau_end: must be a number in s or a time > 0 with its unit, such as 0.5 s, got '5 mm' (mm is "
         "no unit of time)"),
        ("physical: {omega: 9 Hz}", "physical: {m: 2 kg}",
         "scenes.motion.physical.m: is an unknown key; must be one of omega, F, H, l, delta, C1, C2, H1, H2, "
         "load, friction, F2, phi2, M, D1, D2, P, shaker, m_e, e, slope, gravity (did you mean 'M'?)"),
        ("omega: 55 rad/s}", "omega: 55 rad/s, R1: 1}",
         "physical.R1: is an unknown key; must be one of omega, F, H, l, delta, C1, C2, H1, H2, load, friction, "
         "F2, phi2, M, D1, D2, P, shaker, m_e, e, slope, gravity, m, C (R1 has no units: it stands under exciter)"),
        ("one: {physical: {omega: 60 rpm}}", "one: {physical: {omega: 60 rpm, R2: 1}}",
         "scenes.races.motions.one.physical.R2: is an unknown key; must be one of omega, F, H, l, delta, C1, C2, H1, "
         "H2, load, friction, F2, phi2, M, D1, D2, P, shaker, m_e, e, slope, gravity (R2 has no units: it "
         "stands under exciter)"),
        ("{R1: 0.7", "{omega: 55 rad/s, R1: 0.7",
         "exciter.omega: is an unknown key; must be one of R1, R2, contact_1, contact_2, friction_ratio, "
         "wear_exponent (omega has units: it stands under physical)"),
        ("{R1: 0.7", "{r1: 0.7",
         "exciter.r1: is an unknown key; must be one of R1, R2, contact_1, contact_2, friction_ratio, "
         "wear_exponent (did you mean 'R1'?)"),
        ("{kind: sweep,", "{kind: sweep, follow: {direction: up},",
         "scenes.sweep.follow.along: is required (omega or F or H or l or delta or R1 or R2 or C1 or C2 or H1 or H2 or "
         "load or friction or friction_ratio or F2 or phi2 or M or D1 or D2 or P or shaker or "
         "wear_exponent)"),
        ("one: {physical: {omega: 60 rpm}}", "one: {physical: {omega: 60}}",
         f"scenes.races.motions.one.physical.omega: must be {FREQUENCY}, got 60 (it has no unit)"),
    ],
)  # fmt: skip
def test_each_misuse_is_told_alone_and_in_the_words_of_the_file(
    old: str, new: str, fault: str
) -> None:
    assert faults((old, new)) == [fault]


@pytest.mark.parametrize(
    ("scene", "fault"),
    [
        ("{kind: boundary, of: [fold], over: {omega: [-3 Hz, 3 Hz], F: [20 N, 200 N]}}",
         f"over.omega[0]: must be {FREQUENCY}, got '-3 Hz'"),
        ("{kind: boundary, of: [fold], over: {omega: {start: 3 Hz, stop: 9 Hz}, F: [20 N, 200 N]}}",
         "over.omega: must be two increasing numbers, [low, high], got a mapping"),
        ("{kind: sweep, physical: {D1: 1 N}, over: {omega: [3 Hz, 5 Hz], M: {start: 1 kg, stop: 2 kg, points: 3}}}",
         "over.M: must be a list of values: [0.5 kg, 1 kg], got a mapping"),
        ("{kind: branch, along: {omega: {to: [3 Hz, 5 Hz]}}}",
         f"along.omega.from: is required ({FREQUENCY})"),
        ("{kind: sweep, over: {omega: {stop: 5 Hz, points: 3}}}",
         f"over.omega.start: is required ({FREQUENCY})"),
        ("{kind: motion, ramp: {omega: {from: 3 Hz, to: 5 Hz}}}",
         "ramp.omega.within: is required (a time > 0 with its unit, such as 0.5 s)"),
        ("{kind: motion, physical: {omega: 9 Hz}, ramp: {omega: {from: 3 Hz, to: 5 Hz, within: 9 s}}}",
         "physical.omega: must be left out, since omega is changed by ramp, got '9 Hz'"),
        ("{kind: design, vary: {omega: [3 Hz, 30 Hz]}, target: {displacement_mean: 0 mm}, start: {x0: 9 mm}}",
         "start.x0: must be a number from -8 to 8 mm (between the supports), got '9 mm'"),
        ("{kind: boundary, of: [fold], over: {omega: 3 Hz, F: [20 N, 200 N]}}",
         "over.omega: must be two increasing numbers, [low, high], got '3 Hz'"),
        ("{kind: design, vary: {omega: 3}, target: {displacement_mean: 0 mm}}",
         "vary.omega: must be two increasing numbers, [low, high], got 3"),
        ("{kind: basins, over: {x0: {start: -9 mm, stop: 9 mm, points: 4}, v0: [0 m/s, 1 m/s]}}",
         "over.x0: must be numbers from -8 to 8 mm (between the supports), got -9 mm"),
        ("{kind: branch, along: {omega: {from: 3 Hz, to: 5 Hz}}, at: [5 Hz, 4 Hz]}",
         "at: must be increasing numbers, each once, got 4 Hz after 5 Hz"),
        ("{kind: design, vary: {omega: [3 Hz, 30 Hz]}, subject_to: {impact_velocity_max_1: < 1,5 m/s}}",
         "subject_to.impact_velocity_max_1: must be a number, got '< 1,5 m/s' (write \"< 1.5 m/s\", with a point)"),
        ("{kind: design, vary: {omega: [3 Hz, 30 Hz]}, subject_to: {impact_velocity_max_1: '> 0,5 m/s, < 1 m/s'}}",
         'subject_to.impact_velocity_max_1: must be bounds in quotes, such as "< 0.8" or "> 0.1, < 0.8"; with units '
         "\"< 0.8 m/s\", got '> 0,5 m/s, < 1 m/s' (write \"> 0.5 m/s, < 1 m/s\", with a point)"),
        ("{kind: design, vary: {omega: [3 Hz, 30 Hz]}, target: {displacement_mean: 0 mm}, tolerance: {delta: -1 mm}}",
         f"tolerance.delta: must be {LENGTH}, got '-1 mm'"),
    ],
)  # fmt: skip
def test_faults_of_each_kind_quote_what_the_file_says(scene: str, fault: str) -> None:
    head, _ = TEXT.split("scenes:")
    with pytest.raises(StudyError) as caught:
        study_of_text(f"{head}scenes:\n  odd: {scene}\n", "units")
    assert str(caught.value) == f"the study units: scenes.odd.{fault}"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("points: 9", "pionts: 9",
         ["points: is required (a whole number from 2 to 1e8)",
          "pionts: is an unknown key; must be one of start, stop, points, spacing (did you mean 'points'?)"]),
        ("points: 9", "points: 9, scale: log",
         ["scale: is an unknown key; must be one of start, stop, points, spacing"]),
    ],
)  # fmt: skip
def test_an_unknown_key_of_a_grid_is_told_by_its_name_not_by_a_unit(
    old: str, new: str, told: list[str]
) -> None:
    assert faults((old, new)) == [f"{SWEPT}.{each}" for each in told]


def test_a_misspelt_key_of_a_study_comes_before_the_faults_that_it_does_not_explain() -> None:
    slip, other = faults(("physical: {m:", "physikal: {m:"), ("x0: 5 mm", "x0: 5"))
    assert slip.startswith("physikal: is an unknown key; ")
    assert other.startswith("scenes.motion.start.x0: must be a length with its unit")


def test_a_missing_length_is_asked_for_in_physical() -> None:
    lines = faults(("l: 8 mm, ", ""))
    assert (
        lines[0] == f"scenes.sweep.physical.l: is required ({LENGTH}), in the scene or in the study"
    )


def test_units_without_physical_are_told() -> None:
    plain = TEXT.replace("physical: {m", "# {m").replace(
        "physical: {omega: 9 Hz}", "exciter: {l: 8 mm}"
    )
    with pytest.raises(StudyError) as caught:
        study_of_text(plain.replace("physical: {omega: 60 rpm}", ""), "units")
    text = str(caught.value)
    hint = "(no unit belongs here: quantities with units go with `physical`)"
    assert f"scenes.motion.exciter.l: must be a finite number > 0, got '8 mm' {hint}" in text
    assert f"scenes.motion.start.x0: must be a finite number, got '5 mm' {hint}" in text
    with pytest.raises(StudyError) as caught:
        study_of_text(TEXT.replace("physical: {m", "# {m"), "units")
    must = "must be left out, since the study has no physical with m and C"
    assert f"scenes.motion.physical: {must}" in str(caught.value)


def test_the_schema_takes_units() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    yaml = pytest.importorskip("yaml")
    schema, tree = json_schema(), yaml.safe_load(TEXT)
    jsonschema.validate(tree, schema)
    shipped = Path(__file__).parents[2] / "config" / "study.schema.json"
    assert json.loads(shipped.read_text(encoding="utf-8")) == schema
    for old, new in (("l: 8 mm", "l: 8"), ("over: {omega", "over: {mass"), ("x0: 5 mm", "x0: mm")):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(yaml.safe_load(TEXT.replace(old, new)), schema)


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        (
            "{kind: identify, vary: {H: [90 N s/m, 1 N s/m]}, measured: {omega: [5 Hz]}}",
            "s.vary.H: must be two increasing numbers, [low, high], got [90 N s/m, 1 N s/m]",
        ),
        (
            "{kind: boundary, over: {omega: [1 Hz, 9 Hz], F: {start: 1 N, stop: 2 m}}}",
            "s.over.F.stop: must be a force with its unit, such as 120 N, got '2 m' (m is no unit of force)",
        ),
        (
            "{kind: boundary, over: {omega: [1 Hz, 9 Hz], F: }}",
            "s.over.F: must be two increasing numbers, [low, high], got nothing",
        ),
        (
            "{kind: sweep, over: {C1: [95 N/mm, 12 N/mm]}}",
            "s.over.C1: must be increasing numbers, each once, got 12 N/mm after 95 N/mm",
        ),
    ],
)
def test_rules_of_a_grid_are_told_in_its_own_numbers(scene: str, told: str) -> None:
    """What a key takes is the rule of its model, and no number stands for one that is no quantity."""
    head = TEXT.partition("scenes:")[0]
    with pytest.raises(StudyError) as caught:
        study_of_text(f"{head}scenes:\n  s: {scene}\n", "units")
    lines = str(caught.value).replace("the study units: ", "").splitlines()
    assert f"scenes.{told}" in lines
    assert sum("over" in line or "vary" in line for line in lines) == 1


@pytest.mark.parametrize("key", ["start", "stop", "values", "from", "to", "within", "points", "l"])
def test_a_part_of_a_grid_at_the_top_of_a_study_is_refused_in_words(key: str) -> None:
    (line,) = faults(("exciter:", f"{key}: 3\nexciter:"))
    assert line.startswith(f"{key}: ")


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ("{kind: motion, effects: [forcing]}", "effects: must include damping unless H = 0, got forcing"),
        ("{kind: motion, ramp: {F: {from: 5 N, to: 10 N, within: 1 s}}}",
         "ramp: must name the frequency, which alone has a ramp, got F"),
        ("{kind: basins, over: {omega: [17 Hz, 18 Hz], x0: [0 mm], v0: [0 m/s]}, prove: true}",
         "prove: must be left out with omega in over: the knocks of one exciter are proved, got true"),
        ("{kind: identify, measured: {time: [0 s, 1 s, 2 s], displacment: [0 mm]}, vary: {R1: [0.5, 0.9]}}",
         "measured.displacment: must be a quantity of a steady state, such as displacement_mean or "
         "impact_velocity_max_1, got 'displacment' (did you mean 'displacement'?)"),
    ],
)  # fmt: skip
def test_faults_are_told_in_the_names_of_the_study(scene: str, told: str, tmp_path: Path) -> None:
    text = f"""
title: T
physical: {{m: 1.5 kg, C: 12 N/mm, H: 20 N s/m, F: 60 N, l: 5 mm, omega: 18 Hz}}
scenes:
  s: {scene}
"""
    assert study_texts.faults(text, tmp_path) == [f"scenes.s.{told}"]
