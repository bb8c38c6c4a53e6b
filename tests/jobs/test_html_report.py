"""Texts of `snakemake --report`: an opening page that says what each study is, a caption for each figure."""

from __future__ import annotations

from pathlib import Path

import pytest

from vibropipe.jobs.html_report import escaped, is_requested, write_captions, write_opening
from vibropipe.jobs.run import read_run
from vibropipe.jobs.solving import solve_to_file

STUDY = """
title: An exciter & its *laws*
description: |
  What the offset {{ does }}.

  More of it.
exciter: {l: 0.5, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  one: {kind: motion, tau_end: 7, caption: 'Impacts {{ on }} *both*', samples_per_period: 16}
  two: {kind: motion, title: Two_, tau_end: 7, figure: {pictures: [panels, impacts]}, samples_per_period: 16}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "config.yaml").write_text("studies: [first]\n")
    (tmp_path / "config" / "first.yaml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_opening_page_says_what_each_study_is(folder):
    path = write_opening(read_run(None, {}))
    assert path == str(folder / ".snakemake/captions/opening.rst")
    lines = Path(path).read_text().splitlines()
    assert lines[:2] == ["Results of vibropipe", "=" * 20]
    assert lines[-2] == r"**An exciter \& its \*laws\***"
    assert lines[-1] == r"    What the offset \{\{ does \}\}\. 2 motion scenes, 3 figures."


def test_a_caption_is_text_whatever_marks_it_has(folder):
    paths = write_captions(read_run(None, {}), "first", from_data=False)
    assert paths["one"] == str(folder / ".snakemake/captions/first/one.rst")
    assert list(paths) == ["one", "two", "two-impacts"]
    assert Path(paths["one"]).read_text() == r"Impacts \{\{ on \}\} \*both\*" + "\n"
    assert Path(paths["two"]).read_text() == "Two\\_\n"


def test_captions_are_written_from_data_only_for_a_report(folder):
    run = read_run(None, {})
    # nothing is solved yet
    assert Path(write_captions(run, "first", from_data=True)["two"]).read_text() == "Two\\_\n"
    for name in ("one", "two"):
        solve_to_file(run.studies["first"], name, folder / f"results/first/{name}.nc", None, 1)
    paths = write_captions(run, "first", from_data=True)
    assert Path(paths["one"]).read_text() == r"Impacts \{\{ on \}\} \*both\*" + "\n"
    panels, impacts = (Path(paths[name]).read_text() for name in ("two", "two-impacts"))
    assert "on support 1" in panels
    assert impacts.startswith("Velocity before each impact")
    assert Path(write_captions(run, "first", from_data=False)["two"]).read_text() == "Two\\_\n"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["snakemake", "--report"], True),
        (["--report=a.html"], True),
        (["--report-stylesheet", "x"], False),
        (["results/first/report.pdf"], False),
    ],
)
def test_a_report_is_requested_by_its_option(arguments, expected):
    assert is_requested(arguments) == expected


def test_escaped_text_is_one_line():
    assert escaped("a\n b_.") == r"a b\_\."
