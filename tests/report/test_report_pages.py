"""The first page has question, main picture and findings; tables stay with their captions; failures are named."""

from __future__ import annotations

import json

import numpy as np
import pytest
import typst
from report_text import plain
from sampling import sampled

from vibropipe.jobs.reporting import report_data
from vibropipe.report import template_folder
from vibropipe.report.section import Section
from vibropipe.report.table import ZERO_WIDTH_SPACE, Table
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status


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
@pytest.mark.parametrize("n_rows", sampled([1, 7, 60], 7))
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
    assert (were_broken > 0) == (n_rows == 60), "only a tall table goes over pages"


def test_the_first_page_has_title_question_picture_and_findings(typeset_text, data):
    assert data["main"] == "response"
    assert data["asked"].startswith("Computed: one backbone scene over δ")
    assert "one sweep scene over ν = 0.3 … 3 (121 values) and f = 0.1, 0.2, 0.5" in data["asked"]
    titles = [plain(element["body"]) for element in typeset_text["heading"]]
    assert titles[:2] == ["Findings", "Results"]
    assert titles[-3:] == ["The model", "Scenes and parameters", "Accuracy and provenance"]
    assert typeset_text["figure"][0]["body"]["source"] == "figures/response.pdf"
    texts = " ".join(text for item in data["findings"] for text in item["texts"])
    assert "Orbits strike support 2 hardest, with 1.532 in the row" in texts
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
