"""Results that were copied, moved, renamed or lost their records: each call succeeds and makes what is stale."""

import os
import re
import shutil
from pathlib import Path

import pytest
from command_line import called
from sharded_study import parts_of

STUDY = """\
title: Measured
exciter: {l: 0.5, nu: 1, f: 1, h: 0.2, R1: 0.7, R2: 0.6}
scenes:
  fit: {kind: identify, measured: measured.csv, vary: {R1: [0.5, 0.9]}}
  free: {kind: motion, exciter: {f: 0}, start: {v0: 1}, tau_end: 5, samples_per_period: 16}
"""
TABLE = "nu,displacement_amplitude_1\n0.9,0.62\n1.0,0.6\n1.1,0.57\n"
FIT = {"fit", "figures", "report"}


def run(folder: Path, file: str, *arguments: str) -> set[str]:
    """Call `vibropipe run` and return what it made by its summary, which it prints once."""
    done = called(folder, "run", file, "--cores", "2", *arguments)
    name = Path(file).stem
    summary = re.search(rf"^{name}: (?:made ([^;(]*)|up to date \()", done.stderr, re.MULTILINE)
    jobs = {
        {"drawing": "figures", "typesetting": "report"}.get(part.split()[0], part.split()[1])
        for job in re.findall(rf"^Job \d+: {name}: (.*)$", done.stderr, re.MULTILINE)
        for part in parts_of(job)
    }
    parts = set((summary[1] or "").strip().split(", ")) - {""}
    assert parts == jobs
    return parts


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert text.count(old) == 1
    file.write_text(text.replace(old, new))


def title_of(report: Path) -> str:
    return re.search(rb"<dc:title>.*?<rdf:li[^>]*>(.*?)</rdf:li>", report.read_bytes(), re.S)[
        1
    ].decode()


def test_what_is_made_again_is_what_the_files_say_is_stale(tmp_path):
    here = tmp_path / "here"
    here.mkdir()
    (here / "mine.yaml").write_text(STUDY)
    (here / "measured.csv").write_text(TABLE)
    assert run(here, "mine.yaml") == {"fit", "free", "figures", "report"}

    # measured data, then a key
    edit(here / "measured.csv", "0.57", "0.58")
    assert run(here, "mine.yaml") == FIT
    edit(here / "mine.yaml", "f: 1,", "f: 0.99,")
    assert run(here, "mine.yaml") == FIT

    # without the records of snakemake; a title is in the report alone
    shutil.rmtree(here / ".snakemake")
    edit(here / "mine.yaml", "title: Measured", "title: Measured again")
    assert run(here, "mine.yaml") == {"report"}
    assert title_of(here / "results/mine/report.pdf") == "Measured again"
    shutil.rmtree(here / ".snakemake")
    assert run(here, "mine.yaml") == set()


@pytest.mark.slow
def test_results_may_be_copied_run_from_elsewhere_and_renamed(tmp_path):
    here, there, elsewhere = (tmp_path / name for name in ("here", "there", "elsewhere"))
    here.mkdir()
    elsewhere.mkdir()
    (here / "mine.yaml").write_text(STUDY)
    (here / "measured.csv").write_text(TABLE)
    assert run(here, "mine.yaml") == {"fit", "free", "figures", "report"}

    # copied, with other times
    shutil.copytree(here, there, ignore=shutil.ignore_patterns(".snakemake", "logs"))
    for age, path in enumerate(sorted(there.rglob("*"), reverse=True)):
        os.utime(path, (1.7e9 - age, 1.7e9 - age))
    assert run(there, "mine.yaml") == set()
    edit(there / "mine.yaml", "f: 1,", "f: 0.98,")
    assert run(there, "mine.yaml") == FIT

    # from another folder
    more = ("--results", str(there / "results"))
    assert run(elsewhere, "../there/mine.yaml", *more) == set()
    edit(there / "mine.yaml", "f: 0.98,", "f: 0.97,")
    assert run(elsewhere, "../there/mine.yaml", *more) == FIT
    assert run(there, "mine.yaml") == set()

    # datasets and report bear the name of the study
    (there / "mine.yaml").rename(there / "other.yaml")
    (there / "results/mine").rename(there / "results/other")
    assert run(there, "other.yaml") == {"fit", "free", "figures", "report"}


@pytest.mark.slow
def test_snakemake_needs_no_records_either(project):
    shutil.rmtree(project.path(".snakemake"))
    assert project.planned() == set()
    project.edit("config/tiny.yaml", "tau_end: 20", "tau_end: 21")
    project.snakemake()
    shutil.rmtree(project.path(".snakemake"))
    project.edit("config/tiny.yaml", "A study of seconds", "Another title")
    assert project.planned() == {"typesetting the report", "everything is made"}
