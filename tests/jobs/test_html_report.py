"""Texts of `snakemake --report`: an opening page that says what each study is, a caption for each figure."""

from pathlib import Path

import pytest

from vibropipe.jobs.html_report import caption_files, captions, escaped, is_requested, write_opening
from vibropipe.jobs.run import read_run
from vibropipe.jobs.solving import solve_to_file

STUDY = """
title: An exciter & its *laws*
description: |
  What the offset {{ does }}.

  More of it.
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
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


def test_captions_are_text_whatever_marks_they_have_and_written_from_data(folder):
    run = read_run(None, {})
    # nothing is solved yet
    assert captions(run, "first") == {
        "one": r"Impacts \{\{ on \}\} \*both\*",
        "two": r"Two\_",
        "two-impacts": r"Two\_",
    }
    for name in ("one", "two"):
        solve_to_file(run.studies["first"], name, folder / f"results/first/{name}.nc", None, 1)
    found = captions(run, "first")
    assert found["one"] == r"Impacts \{\{ on \}\} \*both\*"
    assert "on support 1" in found["two"]
    assert found["two-impacts"].startswith("Velocity before each impact")
    files = caption_files(run)
    assert Path(files["first", "two"]).read_text() == found["two"] + "\n"


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
