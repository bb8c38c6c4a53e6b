"""Certificates of scenes: what is stored, what the report says of it, and what is refused."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.jobs.report_data import report_data
from vibropipe.jobs.solving import is_of
from vibropipe.scenes.certificate import STATEMENT, proof_of
from vibropipe.scenes.certificate_page import (
    CERTIFICATE_PICTURE,
    bounds_table,
    certificate_answer,
    describe_certificate,
    draw_certificate,
    limits_text,
    title_certificate,
)
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, study_of_text
from vibropipe.words.proofs import REFUSED

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
WITHIN = {"R1": 0.01, "R2": 0.01, "delta": 0.002}
MOTION = """
title: T
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, delta: 0.01, R1: 0.7, R2: 0.7}
scenes:
  s: {kind: motion, tau_end: 20, prove: {within: {R1: 0.01, R2: 0.01, delta: 0.002}}}
"""


def solved(text: str):
    study = study_of_text(text, "study")
    scene = study.scene("s")
    return study, kind_of(scene).solve(scene)


def test_all_motions_within_the_tolerances_lie_in_the_tube() -> None:
    n = 64
    tube = vp.prove(EXCITER, WITHIN, stretches=n)
    samples = 512
    stretch = np.arange(samples) * n // samples
    generator = np.random.default_rng(1)
    for _ in range(12):
        off = {name: most * generator.uniform(-1, 1) for name, most in WITHIN.items()}
        exciter = replace(EXCITER, **{name: getattr(EXCITER, name) + d for name, d in off.items()})
        motion = vp.simulate(exciter, 200 * exciter.period, samples_per_period=samples)
        x = motion.displacement.values[-samples - 1 : -1]
        assert (tube.displacement_low.values[stretch] <= x).all()
        assert (x <= tube.displacement_high.values[stretch]).all()
    alone = vp.prove(EXCITER, stretches=n)
    width = (alone.displacement_high - alone.displacement_low).values
    # what the mass covers in a stretch, at most its largest speed, and little more
    assert width.max() < 1.2 * abs(alone.impact_velocity_high).max() * EXCITER.period / n
    assert (width <= (tube.displacement_high - tube.displacement_low).values).all()


def test_the_tube_of_several_periods() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.5, f=1.3, h=0.15, R1=0.7, R2=0.6)
    steady = vp.steady_state(exciter)
    m = int(steady.period_multiple)
    assert m == 2
    tube = vp.prove(exciter, stretches=100)
    motion = motion_of(exciter, steady, samples_per_period=250)
    x = motion.displacement.values[: 250 * m]
    stretch = np.arange(250 * m) * 100 // (250 * m)
    assert (tube.displacement_low.values[stretch] <= x + 1e-12).all()
    assert (x - 1e-12 <= tube.displacement_high.values[stretch]).all()


def test_a_motion_has_its_proof_and_a_page() -> None:
    study, data = solved(MOTION)
    proof, alone = proof_of(data), vp.prove(EXCITER, WITHIN)
    for name in ("impact_velocity_low", "spectral_radius_high", "within", "uniqueness_radius"):
        assert np.array_equal(proof[name], alone[name])
    assert data.attrs[STATEMENT] == alone.attrs["statement"]
    report = report_data(study, {"s": data}, {})
    texts = {answer["lead"]: answer["rest"] for answer in report["answers"]}
    told = texts["Proved: every exciter within the limits keeps the orbit."]
    assert told == "The limits are R₁, R₂ ± 0.01 and δ ± 0.002; all else is exact."
    (group,) = [each for each in report["groups"] if each["heading"] == "What is certain?"]
    assert [item["type"] for item in group["items"]][:2] == ["figure", "table"]
    mean = group["items"][1]["rows"][0]
    assert mean[0] == "mean displacement"
    names = [row[0] for row in group["items"][1]["rows"]]
    supports = alone["impact_support"].values.tolist()
    assert names[2 : 2 + len(supports)] == [
        f"velocity before impact {n}, support {support}" for n, support in enumerate(supports, 1)
    ]
    low, high = (float(cell.replace("\u2212", "-")) for cell in mean[1:])
    assert low <= float(alone.displacement_mean_low)
    assert float(alone.displacement_mean_high) <= high


@pytest.mark.slow
def test_the_first_figure_of_a_later_scene_stands_under_its_title() -> None:
    keys = (
        "tau_end: 20, prove: {within: {delta: 0.001}}, figure: {pictures: [certificate, portrait]}"
    )
    later = f"  t: {{kind: motion, title: Another look, {keys}}}\n"
    study = study_of_text(MOTION + later, "study")
    data = {name: kind_of(scene).solve(scene) for name, scene in study.scenes.items()}
    headings = [group["heading"] for group in report_data(study, data, {})["groups"]]
    assert headings == ["What is certain?", "Another look"]


def test_only_the_proof_stands_under_its_question() -> None:
    # the first scene is drawn without its motion, the later one has a picture after its certificate
    keys = "tau_end: 20, prove: {within: {delta: 0.001}}, figure: {pictures:"
    scenes = f"""
  r: {{kind: motion, title: First, tau_end: 20}}
  t: {{kind: motion, title: Second, {keys} [panels, certificate, portrait]}}}}
"""
    study = study_of_text(MOTION[: MOTION.index("  s:")] + scenes[1:], "study")
    data = {name: kind_of(scene).solve(scene) for name, scene in study.scenes.items()}
    groups = report_data(study, data, {})["groups"]
    assert [
        (each["heading"], each["follows"], [i["picture"] for i in each["items"] if "picture" in i])
        for each in groups
        if any("picture" in item for item in each["items"])
    ] == [("Second", False, ["panels", "portrait"]), ("What is certain?", True, ["certificate"])]


def test_limits_have_the_units_of_their_parameters() -> None:
    text = """
title: T
physical: {m: 0.35 kg, C: 6 N/mm, H: 4.583 N s/m, F: 12 N, l: 4 mm, omega: 20 Hz}
exciter: {R1: 0.6, R2: 0.75}
scenes:
  s: {kind: motion, tau_end: 0.2 s, prove: {within: {R1: 0.01, delta: 0.02 mm, omega: 0.1 Hz}}}
"""
    study, data = solved(text)
    shown = study.shown({"s": data})["s"]
    assert limits_text(proof_of(shown)) == "R₁ ± 0.01, δ ± 0.02 mm and ω/2π ± 0.1 Hz"
    plain = vp.Exciter.from_physical(
        m=0.35, C="6 N/mm", H=4.583, F=12, l="4 mm", omega="20 Hz", R1=0.6, R2=0.75
    )
    p = np.sqrt(6000 / 0.35)
    within = {"R1": 0.01, "delta": 2e-5, "nu": 0.2 * np.pi / p}
    alone = vp.to_physical(vp.prove(plain, within), 0.35, 6000)
    for end in ("low", "high"):
        ours, theirs = (each[f"impact_velocity_{end}"] for each in (proof_of(data), alone))
        assert ours.values == pytest.approx(theirs.values, rel=1e-12)


@pytest.mark.slow
def test_a_motion_with_a_soft_support_and_friction_has_its_events_and_its_depth() -> None:
    text = MOTION.replace("R1: 0.7", "k1: 200, h1: 8, friction: 0.02").replace("R1: 0.01, ", "")
    _study, dataset = solved(text)
    proof = proof_of(dataset)
    assert proof is not None
    assert title_certificate(dataset) == "Proved: every exciter within the limits keeps the orbit"
    caption = describe_certificate(dataset)
    assert "it is a motion of just these events (" in caption
    assert "turn, " in caption
    assert "contact with support 1" in caption
    table = bounds_table("s", dataset)
    assert table is not None
    assert "has all its events within" in table.note
    figure = draw_certificate(dataset)
    tube = figure.axes[0]
    support = float(proof["l"] + proof["delta"])
    assert float(proof.displacement_high.max()) > support + 0.01
    assert tube.get_ylim()[1] > float(proof.displacement_high.max())


def test_what_is_disproved_is_said() -> None:
    study, data = solved(MOTION.replace("R1: 0.01, R2: 0.01, delta: 0.002", "R1: 0.28"))
    told = certificate_answer(data)
    assert told.lead.startswith("Disproved: an exciter within the limits does not keep")
    assert told.rest.startswith("The limits are R₁ ± 0.28; all else is exact. The mass leaves")
    assert "supports at R₁ = 0.98" in told.rest
    figures = [i for g in report_data(study, {"s": data}, {})["groups"] for i in g["items"]]
    assert any(item["title"] == told.lead.rstrip(".") for item in figures)
    assert CERTIFICATE_PICTURE.draw(data, None, {}).get_size_inches()[1] < 1


def test_what_is_not_decided_is_said(monkeypatch) -> None:
    monkeypatch.setattr("vibropipe.scenes.certificate.PARTS", 2)
    _study, data = solved(MOTION.replace("R1: 0.01, R2: 0.01, delta: 0.002", "R1: 0.1, R2: 0.1"))
    told = certificate_answer(data)
    assert told.lead.startswith("Not decided: whether each exciter within the limits keeps")
    assert " boxes were examined, as many as are allowed" in told.rest
    assert "at least" not in CERTIFICATE_PICTURE.describe(data, None, {})


def test_a_motion_without_impacts_has_no_proof_but_a_reason() -> None:
    _study, data = solved(MOTION.replace("f: -1", "f: 0.05"))
    assert proof_of(data) is None
    assert "must strike a support" in data.attrs[REFUSED]
    assert certificate_answer(data).lead == "Nothing is proved."


def test_without_the_package_the_report_says_what_is_missing(monkeypatch) -> None:
    for name in [*sys.modules]:
        if name == "flint" or name.startswith(("flint.", "vibropipe.proof.")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "flint", None)
    _study, data = solved(MOTION)
    assert "pip install 'vibropipe[proof]'" in certificate_answer(data).rest


def test_a_table_has_the_rows_without_the_proof() -> None:
    _study, data = solved(MOTION)
    assert not [column for column in vp.table(data) if column.startswith("proof")]


def test_a_dataset_without_the_package_is_made_again_with_it(tmp_path) -> None:
    missing = {REFUSED: "python-flint: is required for proofs and not installed: pip ..."}
    for attrs, is_made in (({}, True), (missing, False), ({REFUSED: "no orbit"}, True)):
        path = tmp_path / f"{len(str(attrs))}.nc"
        xr.Dataset(attrs={"study_hash": "a", **attrs}).to_netcdf(path)
        path.with_suffix(".json").write_text("{}")
        assert is_of(path, {"study_hash": "a"}) == is_made


def test_without_the_key_the_identity_of_a_scene_is_as_before() -> None:
    text = MOTION.replace(", prove: {within: {R1: 0.01, R2: 0.01, delta: 0.002}}", "")
    assert "prove" not in study_of_text(text, "study").scene("s").data_keys()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("delta: 0.002}", "mass_ratio: 0.002}", r"prove\.within: must be one of nu, f, .*, got mass_ratio"),
        ("delta: 0.002}", "k1: 0.002}", r"prove\.within\.k1: must be left out: support 1 is rigid"),
        ("R1: 0.01", "R1: 0.4", r"prove\.within\.R1: must keep R1 a number from 0 to 1, got 0.7"),
        ("R1: 0.01", "R1: 0", r"prove\.within\.R1: must be a finite number > 0"),
        ("h: 0.2", "h: 0.2, mass_ratio: 0.1", r"prove: must be left out: the mass_ratio of the exciter"),
        ("prove: {within", "figure: {pictures: [certificate]}, prove_: {within", "did you mean 'prove'"),
        (", prove: {within: {R1: 0.01, R2: 0.01, delta: 0.002}}", ", figure: {pictures: [certificate]}",
         "must leave out certificate unless the scene has the key prove"),
    ],
)  # fmt: skip
def test_what_cannot_be_proved_is_refused(old: str, new: str, message: str) -> None:
    assert old in MOTION
    with pytest.raises(StudyError, match=message):
        study_of_text(MOTION.replace(old, new), "study")


@pytest.mark.slow
def test_a_design_keeps_its_goals_within_the_tolerances() -> None:
    text = """
title: T
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R2: 0.7}
scenes:
  s:
    kind: design
    vary: {delta: [-0.1, 0.1], R1: [0.5, 0.9]}
    target: {displacement_mean: 0.02}
    subject_to: {impact_velocity_max_1: "< 1.2"}
    allow: {displacement_mean: 0.02}
    samples: 64
    designs: 1
    prove: {within: {delta: 0.0005, R1: 0.002}}
"""
    study, data = solved(text)
    assert "All of them keep what is wanted of the mean displacement" in str(
        report_data(study, {"s": data}, {})
    )
    proof = proof_of(data)
    assert (
        0.0
        <= float(proof.displacement_mean_low)
        < 0.02
        < float(proof.displacement_mean_high)
        <= 0.04
    )
    assert float(proof.delta) == float(data.delta[0])
