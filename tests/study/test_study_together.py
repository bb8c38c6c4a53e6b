"""What a study must not leave to silence: frequencies, restitutions, units, heads of tables, what pictures show."""

import math

import pytest
from study_texts import faults, study_of

from vibropipe.jobs.report_data import warning_answers
from vibropipe.jobs.terminal_tables import plan_text
from vibropipe.study.tables import Files, _read

BASE = {"m": "0.35 kg", "C": "6 N/mm", "H": "4.583 N s/m", "F": "12 N", "l": "4 mm"}
KINDS = {
    "motion": "",
    "sweep": ", over: {h: [0.1, 0.2]}",
    "branch": ", along: {h: {from: 0.1, to: 0.2}}",
    "boundary": ", of: [fold], over: {h: [0.1, 0.2], delta: [0, 0.1]}",
    "basins": ", over: {x0: [0, 0.1], v0: [0, 1]}",
    "design": ", vary: {R1: [0.4, 0.7]}, target: {displacement_mean: 0}",
    "identify": ", vary: {R1: [0.4, 0.7]}, measured: {h: [0.1, 0.2, 0.3], displacement_mean: [0, 1, 2]}",
}


def plain(scene, exciter):
    return f"title: T\nexciter: {exciter}\nscenes:\n  s: {scene}\n"


def with_units(scene, numbers="{R1: 0.6, R2: 0.75}", **physical):
    entries = ", ".join(f"{name}: {value}" for name, value in {**BASE, **physical}.items())
    return f"title: T\nphysical: {{{entries}}}\nexciter: {numbers}\nscenes:\n  s: {scene}\n"


@pytest.mark.parametrize("force", ["f: 1", "f2: 0.2"])
@pytest.mark.parametrize(("kind", "keys"), KINDS.items())
def test_a_force_without_a_frequency_is_refused(tmp_path, kind, keys, force):
    lines = faults(plain(f"{{kind: {kind}{keys}}}", f"{{l: 0.5, {force}}}"), tmp_path)
    said = "scenes.s.exciter.nu: is required (a finite number > 0), since there is a force"
    assert said in lines


def test_a_force_that_is_swept_needs_a_frequency_and_one_that_is_not_there_none(tmp_path):
    (line,) = faults(plain("{kind: sweep, over: {f: [1, 2]}}", "{l: 0.5}"), tmp_path)
    assert "exciter.nu: is required" in line
    (line,) = faults(with_units("{kind: motion}"), tmp_path)
    assert line.startswith("scenes.s.physical.omega: is required (a frequency > 0 with its unit")
    study_of(plain("{kind: sweep, over: {nu: [1, 2]}}", "{l: 0.5, f: 1}"), tmp_path)
    study_of(plain("{kind: motion, start: {v0: 1}}", "{l: 0.5}"), tmp_path)
    study_of(plain("{kind: backbone, amplitude: [1]}", "{l: 0.5, f: 1}"), tmp_path)


@pytest.mark.parametrize("h1", ["0", "5"])
def test_a_restitution_beside_stiffness_and_damping_is_refused(tmp_path, h1):
    exciter = f"{{l: 0.5, nu: 1, R1: 0.7, k1: 200, h1: {h1}}}"
    (line,) = faults(plain("{kind: motion}", exciter), tmp_path)
    assert "exciter.h1: must be left out beside R1 below 1, since R1 and k1 give it" in line
    scene = study_of(plain("{kind: motion}", "{l: 0.5, nu: 1, R1: 0.7, k1: 200}"), tmp_path).scenes[
        "s"
    ]
    assert "h1" not in scene.resolved_exciter()
    over = "{kind: sweep, over: {R1: [0.5, 0.7]}}"
    (line,) = faults(plain(over, "{l: 0.5, nu: 1, k1: 200, h1: 5}"), tmp_path)
    assert "h1: must be left out beside R1" in line


def test_with_units_it_is_refused_in_their_words(tmp_path):
    text = with_units("{kind: motion}", omega="20 Hz", C1="600 N/mm", H1="5 N s/m")
    (line,) = faults(text, tmp_path)
    assert "physical.H1: must be left out beside R1 below 1, since R1 and C1 give it" in line
    assert line.endswith("got '5 N s/m'")
    along = "{kind: branch, along: {C1: {from: 600 N/mm, to: 700 N/mm}}}"
    (line,) = faults(with_units(along, omega="20 Hz"), tmp_path)
    assert "exciter.R1: must be left out where C1 or H1 vary: state the damping H1" in line


@pytest.mark.parametrize(
    ("physical", "said"),
    [
        ({"l": "4 m"}, "warning: s: l: the nearer support is 4 m away, but the mass swings by 0.02 m"),
        ({"C": "6 N/m"}, "warning: s: F: the force holds the spring 2 m from its equilibrium, 500 times l"),
        ({"F": "12 kN"}, "warning: s: F: the force holds the spring 2 m from its equilibrium, 500 times l"),
        ({}, None),
    ],
)  # fmt: skip
def test_the_plan_warns_of_lengths_that_cannot_be_meant(tmp_path, physical, said):
    scene = "{kind: sweep, over: {omega: {start: 10 Hz, stop: 60 Hz, points: 5}}}"
    last = plan_text(study_of(with_units(scene, **physical), tmp_path)).splitlines()[-1]
    assert last.startswith(said) if said else "warning" not in last


@pytest.mark.parametrize(
    ("exciter", "scene", "is_idle"),
    [
        ("", "{kind: sweep, over: {nu: [0.8, 1.2]}}", True),
        ("", "{kind: branch, along: {nu: {from: 1, to: 2}}}", True),
        (", f: 0.1", "{kind: sweep, over: {nu: [0.8, 1.2]}}", False),
        ("", "{kind: sweep, over: {nu: [0.8, 1.2], f: [0, 0.1]}}", False),
        ("", "{kind: sweep, over: {nu: [0.8, 1.2]}, ties: {f: 0.1 * nu}}", False),
        ("", "{kind: sweep, over: {h: [0.1, 0.2]}}", False),
    ],
)
def test_a_frequency_that_varies_without_a_force_is_warned_of(tmp_path, exciter, scene, is_idle):
    other = "{kind: motion, tau_end: 9, exciter: {nu: 1}}"
    head = f"title: t\nexciter: {{l: 0.5, h: 0.1{exciter}}}\n"
    text = f"{head}scenes:\n  s: {scene}\n  t: {other}\n"
    study = study_of(text, tmp_path)
    words = "no force acts, so that nothing depends on the frequency that varies"
    assert (f"warning: s: {words}" in plan_text(study)) == is_idle
    assert [each["lead"] for each in warning_answers(study)] == (
        [f"In s: {words}."] if is_idle else []
    )


@pytest.mark.parametrize(
    ("key", "value", "hint"),
    [
        ("H", "40 Ns/m", "(did you mean 40 N s/m?)"),
        ("omega", "9 hz", "(did you mean 9 Hz?)"),
        ("omega", "540 RPM", "(did you mean 540 rpm?)"),
        ("C", "8 N/MM", "(did you mean 8 N/mm?)"),
        ("m", "350 gr", "(did you mean 350 g?)"),  # not grains
        ("F", "12 lb", "(did you mean 12 lbf?)"),
        ("zeta", "0.1", "(a damping ratio is written as H = 2 zeta sqrt(m C))"),
        ("ζ1", "0.1", "(a damping ratio is written as H1 = 2 zeta sqrt(m C1))"),
    ],
)
def test_other_spellings_are_refused_with_the_usual_one(tmp_path, key, value, hint):
    text = with_units("{kind: motion}", **{"omega": "20 Hz", key: value})
    assert faults(text, tmp_path)[0].endswith(hint)


def test_a_damping_ratio_is_not_taken_for_an_offset(tmp_path):
    (line,) = faults(plain("{kind: motion}", "{l: 0.5, zeta: 0.1}"), tmp_path)
    assert line.endswith("(a damping ratio is written as h = 2 zeta)")


def test_the_minus_of_typeset_text_is_one(tmp_path):
    study = study_of(plain("{kind: motion, start: {v0: −1e−1}}", "{l: 0.5, delta: −0.1}"), tmp_path)
    assert study.exciter.delta == -0.1
    assert study.scenes["s"].start.v0 == -0.1
    study = study_of(with_units("{kind: motion}", omega="20 Hz", delta="−0.4 mm"), tmp_path)
    assert study.scenes["s"].resolved_exciter()["delta"] == pytest.approx(-4e-4)


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("phase (deg),displacement\n90,0.1\n", {"phase": [0.25], "displacement": [0.1]}),
        ("Phase;Displacement (mm)\n0.5;−2\n", {"phase": [0.5], "displacement": ["-2.0 mm"]}),
        (f"phase (rad),displacement\n{math.pi!r},1\n", {"phase": [0.5], "displacement": [1.0]}),
        ("phase (periods),displacement\n0.5,1\n", {"phase": [0.5], "displacement": [1.0]}),
        ("phase/deg;displacement / mm\n90;2\n", {"phase": [0.25], "displacement": ["2.0 mm"]}),
        ("Time (s),displacement\n0.5,1\n", {"time": ["0.5 s"], "displacement": [1.0]}),
        ("t/ms,acceleration (g)\n0.5,1\n", {"time": ["0.5 ms"], "acceleration": ["1.0 g"]}),
        ("φ (deg),displacement\n0.5,1\n", "must have phase in forcing periods"),
        ("phase_deg,displacement\n0.5,1\n", "must have phase in forcing periods"),
        ("phase (s),displacement\n0.5,1\n", "must have phase in forcing periods, without a unit, or phase (deg)"),
    ],
)  # fmt: skip
def test_heads_of_tables_are_converted_or_refused(tmp_path, text, columns):
    (tmp_path / "m.csv").write_text(text, encoding="utf-8")
    problems = []
    table = _read(Files(tmp_path), "m.csv", ("measured",), problems)
    if isinstance(columns, str):
        assert columns in problems[0].line("s")
    else:
        assert not problems
        assert table == columns


def test_a_measured_angle_may_have_a_unit_and_a_column_a_near_name(tmp_path):
    scene = "{kind: identify, vary: {delta: [0 mm, 1 mm]}, measured: m.csv}"
    table = "ω (Hz),displacement_phase_1 (deg)\n20,90\n21,80\n"
    (tmp_path / "m.csv").write_text(table, encoding="utf-8")
    measured = study_of(with_units(scene, omega="20 Hz"), tmp_path).scenes["s"].measured
    assert measured["displacement_phase_1"] == pytest.approx([math.pi / 2, math.pi / 2.25])
    for head in ("Omega", "frequency"):
        (tmp_path / "m.csv").write_text(table.replace("ω", head), encoding="utf-8")
        (line,) = faults(with_units(scene, omega="20 Hz"), tmp_path)
        assert line.endswith("(did you mean 'omega'?)")
    (tmp_path / "m.csv").write_text(table.replace("Hz", "hz"), encoding="utf-8")
    (line,) = faults(with_units(scene, omega="20 Hz"), tmp_path)  # of a column, not of each line
    assert line.endswith("got '20.0 hz' (did you mean 20.0 Hz?)")


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        ("sweep, over: {nu: [1, 2]}, figure: {pictures: [bifurcation], show: [displacement_mean]}",
         "must leave out displacement_mean unless pictures have curves or quantities"),
        ("sweep, over: {nu: [1, 2]}, figure: {pictures: [energy], show: [period_multiple]}, outputs: [energy]",
         "must leave out period_multiple unless pictures have curves or quantities"),
        ("motion, figure: {pictures: [spectrum], show: [force]}, outputs: [motion, harmonics]",
         "must be left out unless pictures have panels"),
        ("motion, figure: {show: [force]}, outputs: [impacts]", "must be left out unless pictures have panels"),
    ],
)  # fmt: skip
def test_what_no_picture_shows_is_refused(tmp_path, scene, said):
    (line,) = faults(plain(f"{{kind: {scene}}}", "{l: 0.5, nu: 1, f: 1}"), tmp_path)
    assert f"figure.show: {said}" in line


def test_an_exponent_is_shown_in_a_bifurcation_diagram(tmp_path):
    keys = "over: {nu: [1, 2]}, outputs: [lyapunov], figure: {pictures: [bifurcation], show: [lyapunov_exponent]}"
    study = study_of(plain(f"{{kind: sweep, {keys}}}", "{l: 0.5, f: 1}"), tmp_path)
    assert study.scenes["s"].figure.show == ["lyapunov_exponent"]
