"""The units in which a study shows what it finds: as written, or as its key `units` has it; what it refuses."""

import pytest

from vibropipe.study import StudyError, canonical_text, fingerprint, study_of_text

TEXT = """
title: Half a distance of 8 in
physical: {m: 2 kg, C: 8 N/mm, C1: 1600 kN/m, H: 40 N s/m, l: 8 mm, F: 0.12 kN, load: -5 N, F2: 2 N, phi2: 30 deg}
exciter: {R1: 0.7, R2: 0.6}
UNITS
scenes:
  sweep:
    kind: sweep
    over: {omega: {start: 3 Hz, stop: 30 Hz, points: 9}, delta: [0, 1 mm, 0.2 cm]}
  motion:
    kind: motion
    tau_end: 0.5 s
    start: {x0: 5 mm, v0: 100 mm/s}
    physical: {omega: 55 rad/s}
"""


def study_with(units: str = ""):
    return study_of_text(TEXT.replace("UNITS", units), "shown")


def units_of(study) -> dict[str, str]:
    return dict(pair.split(": ") for pair in study.display_units.split("; "))


def test_units_are_those_of_most_keys_and_of_each_parameter_its_own():
    assert units_of(study_with()) == {
        "mass": "kg", "stiffness": "N/mm", "damping": "N s/m", "length": "mm", "force": "N",
        "frequency": "Hz", "time": "s", "velocity": "mm/s",
        "F": "kN", "C1": "kN/m", "phi2": "deg",
    }  # fmt: skip


def test_chosen_units_hold_for_all_of_their_dimension():
    units = units_of(study_with("units: {frequency: rpm, force: mN, velocity: m/s, angle: rad}"))
    assert (units["frequency"], units["force"], units["velocity"]) == ("rpm", "mN", "m/s")
    assert not {"F", "phi2"} & units.keys()
    assert units["length"] == "mm"


def test_units_change_the_report_but_no_data():
    one, other = study_with(), study_with("units: {frequency: rpm}")
    assert canonical_text(one) != canonical_text(other)
    assert all(fingerprint(one, name) == fingerprint(other, name) for name in one.scenes)


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ("{frequency: Hzz}", "must be a unit of frequency, such as Hz or kHz, got 'Hzz' (did you mean Hz?)"),
        ("{frequency: 1/s}", "(1/s may count radians or cycles: write rad/s, Hz or rpm)"),
        ("{length: m/s}", "must be a unit of length, such as m or cm, got 'm/s' (m/s is no unit of length)"),
        ("{length: MM}", "(did you mean mm?)"),
        ("{velocity: furlongs}", "got 'furlongs' (furlongs is no unit of velocity)"),
        ("{force: 3}", "units.force: must be a unit of force, such as N or mN, got 3"),
        ("{lenght: mm}", "units.lenght: is an unknown key"),
        ("mm", "units: must be a mapping"),
    ],
)  # fmt: skip
def test_bad_units_are_refused(units, message):
    with pytest.raises(StudyError) as caught:
        study_with(f"units: {units}")
    assert message in str(caught.value)


def test_units_are_for_a_study_with_units():
    text = "title: T\nunits: {length: mm}\nexciter: {l: 1}\nscenes: {a: {kind: motion, tau_end: 5}}"
    with pytest.raises(
        StudyError, match="units: must be left out, since the study has no physical"
    ):
        study_of_text(text, "plain")
