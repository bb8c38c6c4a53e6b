"""Proofs of whole sweeps and branches: each row as on its own, and none of a row that is wrong."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
import vibropipe.proof.rows
from vibropipe.figures.text import format_number
from vibropipe.jobs.solving import solve_scene, solve_to_file
from vibropipe.lab.bench_items import limit_threads
from vibropipe.proof.rows import ROWS_PER_PROCESS
from vibropipe.scenes.branch.report import proof_table
from vibropipe.scenes.certificate_page import proof_answer
from vibropipe.scenes.sweep.proofs import (
    describe_proofs,
    draw_proof_map,
    proof_regions,
    proof_title,
)
from vibropipe.store import load
from vibropipe.study import StudyError, load_study, study_of_text
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved, ProvedStable, Why

flint = pytest.importorskip("flint")

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)
OVER = {"nu": np.linspace(0.7, 1.2, 6), "f": [-0.05, -1.0]}


@pytest.fixture(scope="module")
def rows():
    return vp.sweep(EXCITER, OVER, outputs=["impacts", "stability"])


def test_rows_are_proved_as_each_is_alone(rows):
    seen = []
    proof = vp.prove(rows, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (12, 12)
    struck = (rows.impacts_per_orbit.sum("support") > 0) & (rows.period_multiple > 0)
    assert int(struck.sum()) == 5
    assert ((proof.why == Why.NOT_TRIED) == ~struck).all()
    for n in np.flatnonzero(struck[:, 1]):
        row = replace(EXCITER, nu=float(rows.nu[n]))
        alone = vp.prove(row)
        assert int(proof.proved[n, 1]) == int(alone.proved) == Proved.PROVED
        assert int(proof.proved_stable[n, 1]) == int(alone.proved_stable)
    assert proof.statement == "All 5 orbits are proved; 7 rows were not tried."


def test_a_row_whose_section_is_moved_is_not_proved(rows):
    moved = rows.assign(velocity_strobe=rows.velocity_strobe + 1e-3)
    proof = vp.prove(moved.isel(f=[1]))
    assert not (proof.proved == Proved.PROVED).any()
    assert (proof.why == Why.EXISTENCE).sum() == 5


def test_points_of_a_branch_have_the_stability_that_is_stored():
    branch = vp.branch(replace(EXCITER, f=-0.6), "f", -0.4)
    proof = vp.prove(branch)
    proved = proof.proved.values == Proved.PROVED
    assert np.delete(proved, branch.bifurcation_point.values).all()
    assert {*np.unique(proof.proved_stable.values[proved])} >= {ProvedStable.STABLE}
    np.testing.assert_array_equal(
        proof.proved_stable.values[proved] == ProvedStable.STABLE, branch.stable.values[proved] == 1
    )


def test_several_rows_have_no_tube_and_supports_that_pull(rows):
    with pytest.raises(vp.ParameterError, match="stretches: must be left out with several rows"):
        vp.prove(rows, stretches=8)
    with pytest.raises(vp.ParameterError, match=r"within\.R1: must keep R1 a number"):
        vp.prove(rows, within={"R1": 0.4})
    soft = vp.sweep(replace(EXCITER, R1=0.9, k1=50.0), {"nu": [0.9, 1.0]})
    assert vp.prove(soft).statement == "All 2 orbits are proved."
    with pytest.raises(vp.ParameterError, match="contact_1: must be pull"):
        vp.prove(vp.sweep(replace(EXCITER, R1=0.9, k1=50.0, contact_1=1.0), {"nu": [0.9, 1.0]}))


STUDY = """
title: T
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, delta: 0.01, R1: 0.7, R2: 0.7}
scenes: {rows: {kind: sweep, over: {nu: {start: 0.7, stop: 1.3, points: 7}}, prove: true}}
"""


def study_in(folder, text=STUDY):
    """Return a study, written into a folder."""
    (folder / "t.yaml").write_text(text, encoding="utf-8")
    return load_study(folder / "t.yaml")


def test_a_sweep_of_a_study_stores_and_tells_its_proofs(tmp_path):
    study = study_in(tmp_path)
    whole = solve_scene(study, "rows")
    expected = vp.prove(vp.sweep(EXCITER, {"nu": np.linspace(0.7, 1.3, 7)}))
    for name in ("proved", "why", "proved_stable"):
        np.testing.assert_array_equal(whole[name].values, expected[name].values)
    solve_to_file(study, "rows", tmp_path / "rows.nc", None, 1)
    stored = load(tmp_path / "rows.nc")
    assert stored.proved.dtype == np.int8
    np.testing.assert_array_equal(stored.proved.values, whole.proved.values)
    proved = int((whole.proved == Proved.PROVED).sum())
    answer = proof_answer(stored)
    assert answer.lead == f"All {proved} orbits are proved."
    left = 7 - proved
    of = f"{left} row{'s' if left > 1 else ''}"
    assert answer.rest == f"{of} without impacts, with rests or without an orbit, not tried."


def test_without_the_library_a_sweep_says_so(monkeypatch, tmp_path):
    def missing(*_, **__):
        raise ModuleNotFoundError("python-flint: is required for proofs and not installed")

    monkeypatch.setattr(vibropipe.proof.rows, "prove_orbit", missing)
    whole = solve_scene(study_in(tmp_path), "rows")
    assert "proved" not in whole
    assert proof_answer(whole).lead == "No orbit is proved."


@pytest.mark.parametrize(
    ("keys", "beyond"),
    [
        ("mass_ratio: 0.5", "mass_ratio"),
        ("R1: 0.7, k1: 50, contact_1: no_pull", "contact"),
        ("R1: 0.7, friction: 0.1, friction_ratio: 2", "friction_ratio"),
    ],
)
def test_what_is_not_covered_is_refused_when_the_study_is_read(keys, beyond):
    with pytest.raises(
        StudyError, match=f"prove: must be left out: the {beyond} of the exciter is"
    ):
        study_of_text(STUDY.replace("R1: 0.7", keys), "t")


def test_points_of_a_branch_of_a_study_are_proved(tmp_path):
    branch = "{kind: branch, along: {nu: {from: 1, to: 1.1}}, over: {f: [-1, -0.9]}, prove: true}"
    text = STUDY[: STUDY.index("scenes:")] + f"scenes: {{b: {branch}}}"
    whole = solve_scene(study_in(tmp_path, text.replace("f: -1, ", "")), "b")
    assert (whole.proved == Proved.PROVED).all()
    assert "point" in whole.proved.dims
    assert proof_answer(whole).lead == f"All {whole.sizes['point']} orbits are proved."


def test_bifurcations_of_a_branch_are_enclosed(tmp_path):
    branch = vp.branch(EXCITER, "nu", (0.7, 1.2))
    proof = vp.prove(branch)
    assert branch.bifurcation_kind.values.tolist() == [Bifurcation.GRAZING] * 2
    assert (proof.bifurcation_proved == Proved.PROVED).all()
    for k, point in enumerate(branch.bifurcation_point.values):
        alone = vp.prove_bifurcation(branch.isel(point=point).drop_dims("impact"), "grazing", "nu")
        assert float(proof.bifurcation_nu_low[k]) == float(alone.nu_low)
        assert float(proof.bifurcation_nu_high[k]) == float(alone.nu_high)
        assert float(proof.bifurcation_nu_high[k] - proof.bifurcation_nu_low[k]) < 1e-14
    text = STUDY[: STUDY.index("scenes:")].replace("nu: 1, ", "")
    text += "scenes: {b: {kind: branch, along: {nu: {from: 1, to: [0.7, 1.2]}}, prove: true}}"
    solve_to_file(study_in(tmp_path, text), "b", tmp_path / "b.nc", None, 1)
    table = proof_table("b", load(tmp_path / "b.nc"))
    expected = [["grazing", format_number(float(low), 10)] for low in proof.bifurcation_nu_low]
    assert [row[:2] for row in table.rows] == expected


def test_arguments_are_checked_before_rows_are_proved(rows):
    with pytest.raises(vp.ParameterError, match="harmonics: must be"):
        vp.prove(rows, harmonics=0)


def test_rows_that_are_disproved_are_told(rows):
    proof = vp.prove(rows)
    codes = proof.proved.copy(deep=True)
    codes[0, 0] = Proved.DISPROVED
    answer = proof_answer(rows.assign(proved=codes, why=proof.why))
    assert answer.rest.startswith("1 is disproved and 7 rows ")


@pytest.mark.slow
def test_rows_are_proved_alike_on_any_number_of_processes():
    rows = vp.sweep(EXCITER, {"nu": np.linspace(0.5, 1.3, 2 * ROWS_PER_PROCESS)})
    found, n = [], rows.sizes["nu"]
    for limited in (limit_threads(1), nullcontext()):
        seen = []
        with limited:
            found.append(vp.prove(rows, progress=lambda *counts, seen=seen: seen.append(counts)))
        assert seen == [(k + 1, n) for k in range(n)]
    assert found[0].identical(found[1])


MAP = """
title: T
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, delta: 0.01, R1: 0.7, R2: 0.7}
scenes:
  rows:
    kind: sweep
    over: {nu: {start: 0.4, stop: 1.5, points: 16}, f: {start: 0.05, stop: 1.5, points: 16}}
    outputs: [impacts]
    prove: true
"""


@pytest.mark.slow
def test_a_map_shows_what_is_proved(tmp_path):
    study = study_of_text(MAP, "t")
    assert study.scene("rows").figure.pictures == ["map", "quantities", "proved"]
    whole = solve_scene(study_in(tmp_path, MAP), "rows")
    codes, regions = proof_regions(whole)
    tried = int((whole.why != Why.NOT_TRIED).sum())
    amounts = {region.name: region.amount for region in regions}
    assert amounts["proved_stable"] == int((whole.proved == Proved.PROVED).sum())
    assert amounts["not_tried"] == whole.proved.size - tried
    assert sum(amounts.values()) == codes.size
    assert proof_title(whole) == f"{amounts['proved_stable']} of {tried} orbits are proved"
    texts = {text.get_text() for text in draw_proof_map(whole).axes[0].texts}
    assert any(text.startswith("proved, stable") for text in texts)
    caption = describe_proofs(whole)
    assert "it exists, is the only one of its law nearby" in caption
    assert "is not tried" in caption


def test_a_map_of_proofs_needs_proofs():
    text = MAP.replace("prove: true", "figure: {pictures: [proved]}")
    with pytest.raises(StudyError, match="must leave out proved unless the scene has prove: true"):
        study_of_text(text, "t")
    line = MAP.replace(", f: {start: 0.05, stop: 1.5, points: 16}", "").replace(
        "prove: true", "prove: true\n    figure: {pictures: [proved]}"
    )
    with pytest.raises(StudyError, match="must leave out proved unless two or more parameters"):
        study_of_text(line, "t")


def test_rows_are_proved_within_tolerances_as_each_is_alone():
    within = {"R1": 0.02, "delta": 0.004}
    rows = vp.sweep(EXCITER, {"nu": [0.8, 1.0, 1.1]}, outputs=["impacts", "stability"])
    proof = vp.prove(rows, within=within, parts=40)
    for n, nu in enumerate(rows.nu.values):
        alone = vp.prove(replace(EXCITER, nu=float(nu)), within=within, parts=40)
        assert int(proof.proved[n]) == int(alone.proved)
    assert proof.statement.endswith("proved within R1 +- 0.02 and delta +- 0.004.")
    wide = vp.prove(rows.isel(nu=[1]), within={"R1": 0.28})
    assert int(wide.proved[0]) == Proved.DISPROVED


UNITS = """
title: T
physical: {m: 0.35 kg, C: 6 N/mm, H: 9 N s/m, l: 4 mm, F: 24 N, omega: 21 Hz}
exciter: {R1: 0.7, R2: 0.7}
scenes:
  rows:
    kind: sweep
    over: {omega: {start: 20 Hz, stop: 22 Hz, points: 3}}
    prove: {within: {R1: 0.005, delta: 0.01 mm}}
  curve: {kind: branch, along: {omega: {from: 20.8 Hz, to: 21.2 Hz}}, prove: {within: {delta: 0.01 mm}}}
"""


def test_rows_and_points_of_a_study_with_units_are_proved_within_tolerances(tmp_path):
    study = study_in(tmp_path, UNITS)
    rows, curve = (solve_scene(study, name) for name in ("rows", "curve"))
    assert proof_answer(rows).lead == (
        "All 3 orbits are proved, of all exciters within R₁ ± 0.005 and δ ± 1 × 10⁻⁵ m."
    )
    n = curve.sizes["point"]
    assert (
        proof_answer(curve).lead
        == f"All {n} orbits are proved, of all exciters within δ ± 1 × 10⁻⁵ m."
    )
    assert curve.attrs["proof_within"] == "delta +- 1e-05"


@pytest.mark.parametrize(
    ("prove", "message"),
    [
        ("3", "prove: must be true, false, or a mapping with the key within, got 3"),
        ("{within: {R1: 0.5}}", r"prove\.within\.R1: must keep R1 a number from 0 to 1"),
        ("{within: {k1: 1}}", r"prove\.within\.k1: must be left out: support 1 is rigid"),
        ("{within: {m: 1}}", r"prove\.within\.m: is an unknown key"),
    ],
)
def test_tolerances_of_rows_that_are_not_possible_are_refused(prove, message):
    with pytest.raises(StudyError, match=message):
        study_of_text(MAP.replace("prove: true", f"prove: {prove}"), "t")
    assert (
        study_of_text(MAP.replace("prove: true", "prove: false"), "t").scene("rows").prove is None
    )
