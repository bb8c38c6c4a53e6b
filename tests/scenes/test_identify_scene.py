"""Scenes of identification, and tables that studies take from CSV files."""

import re

import numpy as np
import pytest
from drawing import draw, picture_of
from helpers.sensors import record_by_solve_ivp

import vibropipe as vp
from vibropipe.report.parts import Row
from vibropipe.scenes.identify.pictures import twin_texts
from vibropipe.scenes.identify.report import (
    REPORT,
    answers,
    correlation_text,
    found_table,
    least_and_best_known,
    tables,
)
from vibropipe.scenes.registry import kind_of
from vibropipe.study import StudyError, load_study, study_of_text
from vibropipe.words.designs import FitResult, FoundResult, Twin

TRUE = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, delta=0.03, R1=0.75, R2=0.65)
STUDY = """
title: Measured
exciter: {l: 0.5, nu: 1, f: -0.7, h: 0.2, R1: 0.75, R2: 0.65}
scenes:
  found:
    kind: identify
    measured: tables/response.csv
    vary: {delta: [0, 0.1]}
    samples: 8
"""
WANTED = """
title: Wanted
exciter: {l: 0.5, nu: 1, f: -0.7, h: 0.2}
scenes:
  found: {kind: design, vary: {delta: [-0.1, 0.1]}, target: {displacement: wanted.csv}}
"""
PHYSICAL = """
title: Measured
physical: {m: 2 kg, C: 8 N/mm, H: 25 N s/m, F: 40 N, l: 8 mm}
scenes:
  found: {kind: identify, measured: m.csv, vary: {delta: [0 mm, 1 mm]}, noise: {displacement_mean: 20 um}}
"""


RECORD = """
title: Recorded
physical: {m: 2 kg, C: 8 N/mm, H: 25 N s/m, F: 40 N, l: 8 mm}
scenes:
  found:
    kind: identify
    measured: m.csv
    vary: {delta: [-1 mm, 1 mm], R1: [0.5, 0.9], R2: [0.5, 0.9]}
    blanking: 1 ms
    samples: 16
"""
SINE = "time (s),displacement (mm)\n" + "".join(
    f"{n * 2e-3!r},{float(np.sin(0.14 * n))!r}\n" for n in range(400)
)


def load(folder, text, **tables):
    (folder / "mine.yaml").write_text(text)
    (folder / "tables").mkdir(exist_ok=True)
    for name, table in tables.items():
        (folder / f"{name}.csv").write_text(table)
    return load_study(folder / "mine.yaml")


def response(nu):
    values = vp.sweep(TRUE, over={"nu": nu}).displacement_mean.values
    return "".join(f"{a!r},{b!r}\n" for a, b in zip(nu.tolist(), values.tolist(), strict=True))


def test_parameters_are_found_from_a_file(tmp_path):
    table = "# measured on the bench\nν, displacement_mean\n" + response(np.linspace(0.9, 1.1, 4))
    study = load(tmp_path, STUDY, **{"tables/response": table})
    scene = study.scenes["found"]
    assert len(scene.measured["nu"]) == 4
    dataset = kind_of(scene).solve(scene)
    # 1e-13: what least squares ask of a step.
    assert float(dataset.delta) == pytest.approx(0.03, abs=1e-9)
    figure = draw("identify", dataset)
    assert len(figure.axes) == 2
    # Between two frequencies nothing is known, so no line joins them.
    assert {line.get_linestyle() for line in figure.axes[1].lines} == {"None"}
    caption = picture_of("identify", dataset).describe(dataset, None, {})
    assert "crosses: with the parameters" in caption
    assert "δ = 0.03" in caption
    (table_found,) = tables({"found": dataset})
    assert table_found.rows[0][0] == "δ"
    assert "4 measurements" in table_found.note
    # Four numbers do not tell their noise.
    (answer,) = answers({"found": dataset})["found"]
    assert answer.lead == "Whether the measurements are explained is not known."
    assert REPORT.side({"found": dataset}).rows[1] == Row("δ", "0.03")


def measured(factor, high=0.1, **noise):
    """The dataset and the answers on a response whose means are measured with a factor."""
    nu = np.linspace(0.9, 1.1, 12)
    means = factor * vp.sweep(TRUE, over={"nu": nu}).displacement_mean.values
    table = {"nu": nu, "displacement_mean": means}
    known = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.75, R2=0.65)
    dataset = vp.identify(known, table, {"delta": (0.0, high)}, noise=noise, samples=16)
    return dataset, answers({"found": dataset})["found"]


def test_good_data_are_explained_in_words_and_numbers():
    dataset, (answer, found) = measured(1.0, displacement_mean=1e-4)
    assert answer.lead == "The measurements are explained within their noise."
    assert found.lead.startswith("δ = 0.030000 ± 2.1 × 10⁻⁵.")
    title = picture_of("identify", dataset).title(dataset, None, {})
    assert title == "The fit of the mean displacement leaves no more than noise"
    assert "Chi-square per degree of freedom is " in answer.rest


@pytest.mark.parametrize("factor", [10.0, 1e-3, 0.0])
def test_hopeless_data_are_never_called_explained(factor):
    dataset, found = measured(factor, displacement_mean=1e-6)
    lead = "No parameters were found that explain the measurements."
    assert found[0].lead == (lead if factor else "The measurements are not explained.")
    assert ("Searched from 64 samples: more may find others." in found[0].rest) == bool(factor)
    everything = " ".join(
        [*(f"{answer.lead} {answer.rest}" for answer in found), tables({"found": dataset})[0].note]
    )
    assert "explained" not in everything.replace("not explained", "")
    (row,) = tables({"found": dataset})[0].rows
    assert row[2] == "–"
    assert row[4] in ("–", "ended at its range", "not determined")
    caption = picture_of("identify", dataset).describe(dataset, None, {})
    assert "Nearest: δ" in caption
    assert "explain" not in caption
    if factor == 0.0:
        assert (
            "All values of the mean displacement are equal, as of a dead sensor." in found[0].rest
        )


def test_noise_from_few_measurements_is_no_estimate_to_rely_on():
    dataset, _ = measured(1.0, displacement_mean=1e-4)
    dataset = dataset.assign(fit_result=np.int8(FitResult.NOT_JUDGED)).assign_attrs(
        noise="estimated"
    )
    answer, *_ = answers({"found": dataset})["found"]
    assert answer.rest.endswith("for more than a rough estimate of their noise: give it.")
    caption = picture_of("identify", dataset).describe(dataset, None, {})
    assert "Roughly estimated noise: " in caption


def test_a_parameter_at_an_end_of_its_range_is_named():
    _, found = measured(1.0, high=0.02, displacement_mean=1e-4)
    assert found[1].lead.startswith("δ ended at its range: widen it")


def test_what_is_not_determined_is_named():
    nu = np.linspace(0.6, 0.8, 12)
    table = {"nu": nu, "displacement_amplitude_1": 0.2 / np.hypot(1 - nu**2, 0.1 * nu)}
    noise = {"displacement_amplitude_1": 1e-4}
    vary = {"f": (0.1, 0.3), "R2": (0.5, 0.9)}
    dataset = vp.identify(
        vp.Exciter(l=5.0, nu=1.0, f=0.2, h=0.1), table, vary, noise=noise, samples=16
    )
    _, blind, known = answers({"found": dataset})["found"]
    assert known.lead.startswith("f = 0.200000 ± 1.5 × 10⁻⁵.")
    assert blind.lead == "The measurements do not determine R₂."
    assert tables({"found": dataset})[0].rows[1][2:] == [
        "∞",
        "0.5 … 0.9",
        "not determined",
        "–",
        "–",
    ]


def test_a_changed_file_is_another_scene(tmp_path):
    before = load(tmp_path, WANTED, wanted="phase;displacement\n0;0.1\n0.5;-0.2\n").scenes["found"]
    assert before.target == {"displacement": [[0.0, 0.1], [0.5, -0.2]]}
    after = load(tmp_path, WANTED, wanted="phase;displacement\n0;0.1\n0.5;-0.25\n").scenes["found"]
    assert before.fingerprint() != after.fingerprint()


def test_a_dataset_has_the_tables_of_its_study(tmp_path):
    table = "# on the bench\nphase;displacement\n0;0.1\n0.5;-0.2\n"
    study = load(tmp_path, WANTED, wanted=table)
    again = study_of_text(study.text, "mine")
    assert study.text.startswith(WANTED.rstrip())
    assert again.fingerprints == study.fingerprints


def test_columns_with_units_are_read_in_si(tmp_path):
    rows = "10,1.5\n11,1.25\n"
    study = load(tmp_path, PHYSICAL, m=f"omega (Hz),displacement_mean [mm]\n{rows}")
    scene = study.scenes["found"]
    # omega over sqrt(C/m); displacements without units are in metres.
    np.testing.assert_allclose(scene.measured["nu"], 2 * np.pi * np.array([10, 11]) / 4000**0.5)
    np.testing.assert_allclose(scene.measured["displacement_mean"], [1.5e-3, 1.25e-3])
    assert scene.noise["displacement_mean"] == pytest.approx(2e-5)


@pytest.mark.parametrize(
    ("text", "table", "message"),
    [
        (WANTED, None, "path of a CSV file from the folder of the study, got 'wanted.csv' (No such"),
        (WANTED, "phase,x\n0,1\n", r"columns (phase and displacement), then .* got 'phase,x' in"),
        (WANTED, "phase,displacement\n0,1 mm\n", "2 numbers with a point in each line, .* '0,1 mm'"),
        (WANTED, "phase;displacement\n0;0,1\n", "2 numbers with a point in each line, .* '0;0,1'"),
        (WANTED, "phase,displacement\n", "1 to 99999 lines of numbers"),
        (WANTED, "phase,displacement (mm)\n0,1\n", "list of pairs"),
        (WANTED, "time (s),displacement\n0,1\n", "in place of time: time after a rising zero of the force, over the"),
        (RECORD, "time (s),displacement (mm)\n0,1\n1,2\n", "must have at least 32 samples of a record, got 2"),
        (RECORD, "time (mm),displacement (mm)\n0,1\n1,2\n", "measured.time.*mm is no unit of time"),
        (RECORD, "time (s),displacement (s)\n0,1\n1,2\n", "measured.displacement.*s is no unit of length"),
        (RECORD.replace("F: 40 N", "F: 40 N, omega: 12 Hz"), SINE, "physical.omega: must be .* is at 11.*Hz.*12 Hz"),
        (RECORD.replace("blanking: 1 ms", "sign: up"), SINE, "sign: must be"),
        (RECORD.replace("1 ms", "1 mm"), SINE, "blanking: must be a .*time"),
        (PHYSICAL, "omega,displacement_mean (mm)\n9,1\n", "measured.omega.*a frequency .* (it has no unit"),
        (PHYSICAL, "omega (Hz),displacement_mean (kg)\n9,1\n", "measured.displacement_mean: .* kg"),
        (PHYSICAL, "omega (Hz),displacement_men (mm)\n9,1\n", "displacement_men: must be a quantity .* such as"),
        (PHYSICAL, "phase,displacement (mm)\n0,1\n0.5,2\n", "measured quantities as keys"),
        (PHYSICAL, "omega (Hz),displacement_mean (mm)\n9,1\n", r"more numbers than parameters to be found (1)"),
    ],
)  # fmt: skip
def test_bad_tables_are_refused_in_words(tmp_path, text, table, message):
    name = "wanted" if text is WANTED else "m"
    with pytest.raises(StudyError) as error:
        load(tmp_path, text, **({name: table} if table is not None else {}))
    line = str(error.value)
    assert re.search(message.replace("(", r"\(").replace(")", r"\)"), line), line


@pytest.mark.slow
def test_a_record_is_a_file_with_times(tmp_path):
    """Parameters, twin and sensors of a record are told in words, and the study states no frequency."""
    true = vp.Exciter(
        l=8e-3, nu=70 / 4000**0.5, f=5e-3, h=25 / 16000**0.5, delta=6e-4, R1=0.75, R2=0.65
    )
    noise = {"displacement": 1e-5, "velocity": 1e-5}
    record, _force = record_by_solve_ivp(true, noise, seed=3, offset=1e-3)
    p = 4000**0.5
    # The sensor ends at 9 mm.
    columns = [
        record["tau"] / p * 1e3,
        np.minimum(record["displacement"] * 1e3, 9.0),
        record["velocity"] * p,
    ]
    rows = "".join(
        f"{t!r},{x!r},{v!r}\n" for t, x, v in zip(*(c.tolist() for c in columns), strict=True)
    )
    scene = load(tmp_path, RECORD, m=f"Time (ms),displacement (mm),velocity (m/s)\n{rows}").scenes[
        "found"
    ]
    np.testing.assert_allclose(scene.measured["tau"], record["tau"], atol=1e-9)
    np.testing.assert_allclose(scene.measured["velocity"], record["velocity"], atol=1e-12)
    assert scene.blanking == pytest.approx(1e-3 * p)
    dataset = kind_of(scene).solve(scene)
    for name, value in (("omega", 70.0), ("delta", 6e-4), ("R1", 0.75), ("R2", 0.65)):
        assert abs(float(dataset[name]) - value) < 4.5 * float(dataset[f"{name}_std"]), name
    assert "nu" not in scene.data_exciter()
    told = answers({"found": dataset})["found"]
    assert told[0].lead == "The measurements are explained within their noise."
    assert told[1].lead.startswith("With the sensors reversed, the mirror image fits as well: ω = ")
    assert "δ = −0.000" in told[1].lead
    n_clipped = int((columns[1] == 9.0).sum())
    assert n_clipped > 20
    (table,) = tables({"found": dataset})
    n = dataset.sizes["measurement"]
    assert (
        f"{n_clipped} of {n} samples of displacement at a limit of the sensor or next to an"
        in table.note
    )
    assert len(draw("identify", dataset).axes) == 3
    assert "mirror image fits as well" in picture_of("identify", dataset).describe(
        dataset, None, {}
    )


def test_soft_supports_and_friction_are_called_for(tmp_path):
    text = STUDY.replace("R2: 0.65}", "R2: 0.65, k1: 100, friction: 0.01}")
    table = "nu,displacement_mean\n0.9,0.01\n1,0.02\n1.1,0.02\n"
    scene = load(tmp_path, text, **{"tables/response": table}).scenes["found"]
    assert {"soft", "friction"} <= {*scene.called_effects()}


def test_twins_that_fit_worse_are_said_to() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.75, R2=0.65)
    measured = {"phase": [0.0, 0.2, 0.4, 0.6, 0.8], "displacement": [0.4, 0.2, -0.3, -0.4, 0.1]}
    found = vp.identify(exciter, measured, {"delta": (0, 0.1)}, samples=8)
    attrs = dict(found["delta"].attrs)
    twins = found.drop_dims("twin", errors="ignore").assign(
        delta_twin=("twin", [0.05, 0.06], attrs), twin_kind=("twin", [Twin.OTHER, Twin.OTHER]),
        twin_excess=("twin", [0.0, 4.4]), fit_result=int(FitResult.NOT_JUDGED),
    )  # fmt: skip
    texts = [text.partition(":")[0] for text in twin_texts(twins)]
    assert texts == [
        "Other parameters fit no worse",
        "Other parameters fit worse by no more than noise",
    ]


@pytest.mark.parametrize(
    ("twin", "state"), [(0.05, "determined up to twins"), (0.0201, "determined")]
)
def test_a_parameter_with_another_value_that_fits_as_well_is_not_just_determined(
    twin: float, state: str
) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.75, R2=0.65)
    measured = {"phase": [0.0, 0.2, 0.4, 0.6, 0.8], "displacement": [0.4, 0.2, -0.3, -0.4, 0.1]}
    found = vp.identify(exciter, measured, {"delta": (0, 0.1)}, samples=8)
    attrs = dict(found["delta"].attrs)
    twins = found.drop_dims("twin", errors="ignore").assign(
        delta=((), 0.02, attrs), delta_std=0.001, delta_twin=("twin", [twin], attrs),
        twin_kind=("twin", [Twin.OTHER]), twin_excess=("twin", [0.0]),
        fit_result=int(FitResult.EXPLAINED),
        parameter_result=("parameter", [FoundResult.DETERMINED]),
    )  # fmt: skip
    assert found_table("fit", twins).rows[0][4] == state
    assert bool(least_and_best_known(twins)) == (state == "determined")


@pytest.mark.parametrize(
    ("value", "text"), [(-0.004, "0.00"), (-0.006, "−0.01"), (1.0, "1.00"), (-1.0, "−1.00")]
)
def test_no_correlation_is_minus_zero(value: float, text: str) -> None:
    assert correlation_text(value) == text
