"""The report shows the datasets, its PDF contains all of the report, and a title is never markup."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
import typst
from figures.sample_datasets import Scene, backbone, hard_cases, motion, steady, sweep

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.reporting import build_report, report_data
from vibropipe.report import template_folder, typeset
from vibropipe.report.data import paragraphs
from vibropipe.report.section import Section
from vibropipe.report.table import ZERO_WIDTH_SPACE, Table
from vibropipe.store import StoreError, write, write_sidecar
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

HOSTILE = (
    '#panic("no") $x$ *b* _i_ `c` @a <l> \\ // /* "q" #import "x": * https://a.b'
    ' = - + ~ {{}} [#read("/etc/passwd")]'
)
PROVENANCE = {
    "source": "vibropipe 0.1.0",
    "git_commit": "0123456789abcdef",
    "kernel_hash": "f4b9249e4ecc5c1e",
    "study_hash": "0636f6f3127e35600f6b",
    "fingerprint": "764a982da44fcee6fb30",
    "versions": '{"python": "3.11.7", "numpy": "2.4.6"}',
    "accuracy_asked": 1e-8,
    "accuracy_reached": "none",
}


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Return a study with its results on disk, figures drawn: (study, results, datasets)."""
    datasets = {
        "law": backbone(),
        "free": motion(f=0.0, h=0.0, R1=1.0, R2=1.0, v=-0.51, tau_end=10.0),
        "symmetric": steady(tau_end=13.0),
        "offset": steady(0.035, delta=0.01, tau_end=13.0),
        "very_unequal_scene": steady(-0.02, R1=0.6, R2=0.8, tau_end=13.0),
        "response": sweep(f=[0.1, 0.2, 0.5], all_regimes=True),
        "hard": hard_cases(),
    }
    datasets = {name: dataset.assign_attrs(PROVENANCE) for name, dataset in datasets.items()}
    kinds = {"law": "backbone", "response": "sweep", "hard": "hard_cases"}
    scenes = {name: Scene(kinds.get(name, "motion"), name, title="") for name in datasets}
    scenes["offset"].title = HOSTILE
    scenes["offset"].caption = f"Look at {HOSTILE}."
    study = SimpleNamespace(
        name="small",
        title=HOSTILE,
        description=f"First {HOSTILE}\n\nSecond one.",
        scenes=scenes,
        fingerprints={},
    )
    results = tmp_path_factory.mktemp("results")
    for name, dataset in datasets.items():
        write(dataset, results / "small" / f"{name}.nc")
    write_sidecar(results / "small" / "response.nc", seconds=1.25, threads=2)
    draw_study(study, results)
    return study, results, datasets


@pytest.fixture(scope="module")
def data(solved):
    study, _, datasets = solved
    return report_data(study, datasets, {"response": {"seconds": 1.25}})


@pytest.fixture(scope="module")
def typeset_text(solved, data):
    """Return what the typesetter made of the data: {kind of element: its fields as JSON text}."""
    study, results, _ = solved
    pictures = {name: results / "small" / "figures" / f"{name}.pdf" for name in study.scenes}
    with template_folder(data, pictures) as folder:
        compiler = typst.Compiler(folder / "template.typ", root=folder, ignore_system_fonts=True)
        return {
            kind: json.loads(compiler.query(kind))
            for kind in ("figure", "heading", "par", "image", "table", "math.equation")
        }


@pytest.fixture(scope="module")
def rows_on_pages(solved, data):
    """Return a function from sections to the rows of their table by page; row 0 is the caption."""
    study, results, _ = solved
    pictures = {name: results / "small" / "figures" / f"{name}.pdf" for name in study.scenes}
    bare = {"findings": [], "figures": data["figures"][:1], "main": data["figures"][0]["name"]}

    def rows(section) -> dict[int, list[int]]:
        with template_folder(data | bare | {"sections": [section.as_data()]}, pictures) as folder:
            compiler = typst.Compiler(
                folder / "template.typ", folder, ignore_system_fonts=True, sys_inputs={"marks": "1"}
            )
            marks = json.loads(compiler.query("<mark>", field="value"))
        pages: dict[int, list[int]] = {}
        for mark in marks:
            if mark["table"] == "Here it is.":
                pages.setdefault(mark["page"], []).append(mark["row"])
        return pages

    return rows


@pytest.mark.parametrize("is_landscape", [False, True])
@pytest.mark.parametrize("n_rows", [1, 4, 7, 60])
def test_no_table_parts_from_its_caption_or_leaves_a_single_row(
    rows_on_pages, n_rows, is_landscape
):
    table = Table(["a", "b"], [[f"row {n}", "b"] for n in range(n_rows)], "Here it is.")
    were_broken = 0
    for lines in range(20, 46, 3) if is_landscape else range(8, 30, 3):
        text = [f"Line {n}." for n in range(lines)]
        pages = rows_on_pages(Section("Section", text, [table], is_landscape=is_landscape))
        were_broken += len(pages) > 1
        assert sorted(row for rows in pages.values() for row in rows) == [*range(n_rows + 1)]
        first = min(pages)
        assert pages[first][:2] == [0, 1], f"the caption parts from its table after {lines} lines"
        for rows in pages.values():
            kept = [row for row in rows if row > 0]
            assert len(kept) >= min(3, n_rows), f"{len(kept)} of {n_rows} rows on a page"
    assert were_broken == 0 or n_rows > 5
    assert were_broken > 0 or n_rows < 60


def test_the_first_page_has_title_question_picture_and_findings(typeset_text, data):
    assert data["main"] == "response"
    assert data["asked"].startswith("Computed: one backbone scene over δ")
    assert "one sweep scene over ν = 0.3 … 3 (121 values) and f = 0.1, 0.2, 0.5" in data["asked"]
    titles = [plain(element["body"]) for element in typeset_text["heading"]]
    assert titles[:2] == ["Findings", "Results"]
    assert titles[-3:] == ["The model", "Scenes and parameters", "Accuracy and provenance"]
    assert typeset_text["figure"][0]["body"]["source"] == "figures/response.pdf"
    texts = " ".join(text for item in data["findings"] for text in item["texts"])
    assert "The largest impact velocity is 1.532, on support 2 at" in texts
    assert "The steady states of the motions are two-sided" in texts
    assert "of 10 checks are passed" in texts


def test_the_main_picture_is_shown_once_where_it_is_large_enough(solved, data):
    study, results, _ = solved
    pictures = {name: results / "small" / "figures" / f"{name}.pdf" for name in study.scenes}
    for findings, times in (([], 1), (data["findings"] * 3, 2)):
        with template_folder(data | {"findings": findings}, pictures) as folder:
            compiler = typst.Compiler(folder / "template.typ", folder, ignore_system_fonts=True)
            images = json.loads(compiler.query("image"))
        assert [image["source"] for image in images].count("figures/response.pdf") == times


def test_motions_and_rows_that_did_not_end_as_asked_are_named(solved, data):
    study, _, datasets = solved
    assert "Rows and motions to look at" not in [part["title"] for part in data["sections"]]
    regime = datasets["response"]["regime"]
    status = regime.copy(data=np.where(regime == Regime.UNRESOLVED, Status.MAX_IMPACTS, Status.OK))
    bad = datasets | {
        "free": datasets["free"].assign(status=np.int8(Status.LOG_FULL)),
        "response": datasets["response"].assign(status=status),
    }
    entries = report_data(study, bad, {})
    section = next(
        part for part in entries["sections"] if part["title"] == "Rows and motions to look at"
    )
    rows = {row[0]: row[1:] for row in section["tables"][0]["rows"]}
    number = int((status == Status.MAX_IMPACTS).sum())
    assert rows["free"] == [f"log_{ZERO_WIDTH_SPACE}full", "–", "–", Status.LOG_FULL.remedy]
    assert rows["response"][1] == f"{number} of 363"
    assert rows["response"][2] == "ν = 2.415 … 2.595, f = 0.1 … 0.5"
    texts = " ".join(text for item in entries["findings"] for text in item["texts"])
    assert "free (log_full) has a status other than ok" in texts
    assert f"{number} of 363 rows are unresolved: too many impacts" in texts


def plain(element) -> str:
    """Return all text inside a queried element, spaces run together."""
    if isinstance(element, dict):
        if element.get("func") == "space":
            return " "
        parts = [plain(value) for key, value in element.items() if key not in ("func", "alt")]
        return "".join(parts)
    if isinstance(element, list):
        return "".join(plain(item) for item in element)
    return element if isinstance(element, str) else ""


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
