"""Python blocks of the documents run as they stand and print what the documents show; YAML blocks are studies."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from documents import Block, Page, all_blocks

from vibropipe.jobs.drawing import draw_study
from vibropipe.jobs.reporting import build_report
from vibropipe.study import load_study

CONFIG = Path(__file__).parents[2] / "config"
PYTHON, STUDIES = all_blocks("python"), all_blocks("yaml")


def lines(text: str) -> list[str]:
    return [line.rstrip() for line in text.strip().splitlines()]


@pytest.mark.parametrize("block", PYTHON, ids=str)
def test_a_snippet_runs_and_prints_what_is_shown(
    block: Block, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    exec(compile(block.text, str(block), "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert printed.strip()
    assert "nan" not in printed
    if block.output is not None:
        assert lines(printed) == lines(block.output)


@pytest.mark.parametrize("block", STUDIES, ids=str)
def test_a_study_is_valid(block: Block, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(block.text, encoding="utf-8")
    for table in CONFIG.glob("*.csv"):  # the documents name those
        shutil.copy(table, tmp_path)
    assert load_study(path).scenes


def test_the_tutorial_ends_with_a_pdf(folder: Path) -> None:
    study, results = load_study(folder / "mine.yaml"), folder / "results"
    draw_study(study, results)
    build_report(study, results, results / "mine/report.pdf")
    shown = [name for name in Page("docs/tutorial.md").quoted if name.startswith("figures/")]
    assert shown
    for name in ("report.pdf", "detail.json", *shown):
        assert (results / "mine" / name).is_file(), name
