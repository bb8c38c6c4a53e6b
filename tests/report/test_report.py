"""The report shows the datasets, its PDF contains all of the report, and a title is never markup."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from report_text import HOSTILE, plain

from vibropipe.jobs.reporting import build_report, report_data
from vibropipe.report import typeset
from vibropipe.report.data import is_physical, parameter_table
from vibropipe.report.table import ZERO_WIDTH_SPACE, Table
from vibropipe.store import StoreError, write
from vibropipe.words.wording import paragraphs


def test_two_runs_give_the_same_bytes(solved, tmp_path):
    study, results, _ = solved
    first = build_report(study, results, tmp_path / "a.pdf")
    second = build_report(study, results, tmp_path / "b.pdf")
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(b"%PDF-")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pdf", "b.pdf"]


def test_a_title_is_only_text(typeset_text, solved, data):
    study, results, _ = solved
    pictures = {name: results / "small" / "figures" / f"{name}.pdf" for name in study.scenes}
    # the PDF's own title stands in its metadata as XML
    assert b"#panic(&quot;no&quot;)" in typeset(data, pictures).replace(b'"', b"&quot;")
    texts = [plain(element) for element in typeset_text["par"]]
    assert any(text.endswith(f"First {HOSTILE}") for text in texts)
    captions = [plain(element["caption"]) for element in typeset_text["figure"]]
    assert any(HOSTILE in text and f"Look at {HOSTILE}." in text for text in captions)


def test_every_figure_is_there_with_its_caption(typeset_text, data):
    captions = " ".join(plain(element["caption"]) for element in typeset_text["figure"])
    for entry in data["figures"]:
        assert entry["caption"] in captions
    paths = {element["source"] for element in typeset_text["image"]}
    assert paths == {entry["path"] for entry in data["figures"]}
    assert all(element["alt"] for element in typeset_text["image"])


def test_equations_of_the_model_are_numbered_as_in_the_paper(typeset_text):
    numbered = [e for e in typeset_text["math.equation"] if e.get("block")]
    assert len(numbered) == 7


def test_further_effects_are_stated_only_where_a_scene_has_them(solved):
    study, _, datasets = solved
    assert report_data(study, datasets, {})["further"] == []
    name, data = next(iter(datasets.items()))
    changed = {**datasets, name: data.assign_coords(k1=100.0, friction=0.1)}
    assert report_data(study, changed, {})["further"] == ["soft", "friction"]


def test_eq_10_is_set_only_where_a_scene_shows_it(solved):
    study, _, datasets = solved
    without = {name: dataset for name, dataset in datasets.items() if name != "law"}
    assert report_data(study, datasets, {})["has_backbone"]
    assert not report_data(study, without, {})["has_backbone"]


def test_captions_of_the_author_stand_before_those_from_data(data):
    by_scene = {entry["name"]: entry for entry in data["figures"]}
    assert by_scene["offset"]["caption"] == f"Look at {HOSTILE}."
    assert by_scene["offset"]["title"] == HOSTILE
    assert "impacts on support" in by_scene["free"]["caption"]
    assert by_scene["offset"]["alt"] != by_scene["offset"]["caption"]


def test_parameters_of_each_scene(data):
    rows = {row[0].split(":")[0]: row for row in data["parameters"]["rows"]}
    assert data["parameters"]["head"] == ["scene", "nu", "f", "h", "l", "delta", "R1", "R2"]
    assert rows["offset"][1:] == ["1", "−1", "0.2", "0.5", "0.01", "0.7", "0.7"]
    assert rows["response"][1:3] == ["0.3 … 3 (121 values)", "0.1, 0.2, 0.5"]
    assert rows["law"][1:] == ["–"] * 7


def test_parameters_in_si_have_their_units(solved):
    _, _, datasets = solved
    assert not is_physical(datasets)
    dataset = datasets["response"].rename(nu="omega", f="F", h="H")
    dataset["omega"].attrs["units"], dataset["l"].attrs["units"] = "rad/s", "mm"
    assert is_physical({"response": dataset})
    table = parameter_table({"response": "sweep"}, {"response": dataset})
    assert table.head[:6] == ["scene", "omega (rad/s)", "f", "h", "l (mm)", "delta"]
    assert table.rows[0][1:4] == ["0.3 … 3 (121 values)", "0.1, 0.2, 0.5", "0.2"]


def test_beside_many_parameters_the_scenes_keep_a_column(solved):
    _, _, datasets = solved
    dataset = datasets["response"]
    assert parameter_table({"response": "sweep"}, {"response": dataset}).widths[0] == "1fr"
    soft = dataset.assign_coords(k1=200.0, k2=200.0, h1=3.0, h2=3.0)
    assert parameter_table({"response": "sweep"}, {"response": soft}).widths[0] == "2.2cm"


def test_accuracy_and_provenance(data):
    rows = {
        row[0].replace(ZERO_WIDTH_SPACE, ""): row[1:] for row in data["accuracy"]["table"]["rows"]
    }
    assert rows["offset"] == ["newmark", "1 × 10⁻⁸", "–", "0.001", "1 × 10⁻¹⁵", "–"]
    assert rows["response"][-1] == "1.2"
    assert (
        "differ from the exact motion of the same start by at most 0.001"
        in data["accuracy"]["text"]
    )
    provenance = dict(data["provenance"]["rows"])
    assert provenance["program"] == "vibropipe 0.1.0"
    assert provenance["kernels"] == "f4b9249e4ecc"
    assert provenance["versions"] == "python 3.11.7, numpy 2.4.6"


def test_datasets_of_different_origin_are_told_apart(solved):
    study, _, datasets = solved
    mixed = datasets | {"free": datasets["free"].assign_attrs(kernel_hash="another")}
    provenance = dict(report_data(study, mixed, {})["provenance"]["rows"])
    assert "another (free)" in provenance["kernels"]


def test_a_study_of_one_scene_without_steady_states(solved, tmp_path):
    study, results, datasets = solved
    alone = SimpleNamespace(
        name="small", title="One", description="", scenes={"free": study.scenes["free"]}
    )
    bare = {"free": datasets["free"].drop_attrs()}
    pictures = {"free": results / "small" / "figures" / "free.pdf"}
    assert typeset(report_data(alone, bare, {}), pictures).startswith(b"%PDF-")


def test_a_missing_figure_or_dataset_is_named(solved, tmp_path):
    study, _, datasets = solved
    write(datasets["free"], tmp_path / "small" / "free.nc")
    alone = SimpleNamespace(
        name="small",
        title="One",
        description="",
        scenes={"free": study.scenes["free"]},
        fingerprints={},
    )
    with pytest.raises(StoreError, match=r"free\.pdf.*draw the figures"):
        build_report(alone, tmp_path, tmp_path / "report.pdf")
    with pytest.raises(StoreError, match=r"no dataset of law, symmetric, offset"):
        build_report(study, tmp_path, tmp_path / "report.pdf")
    assert not (tmp_path / "report.pdf").exists()


def test_paragraphs_and_tables():
    assert paragraphs("one\ntwo\n\n \n\nthree") == ["one two", "three"]
    assert paragraphs("") == []
    with pytest.raises(ValueError, match="2 columns has a row of 1"):
        Table(["a", "b"], [["only"]]).as_data()


def test_data_is_json_without_loss(data):
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert not np.isnan([len(row) for row in data["accuracy"]["table"]["rows"]]).any()
