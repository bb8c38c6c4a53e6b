"""One call makes what an edit requires, and nothing else; what fails leaves the rest made."""

import os
import re
import shutil
import time
from pathlib import Path

import pytest
from command_line import called

from vibropipe.store.atomic import scenes_of

DRAWN = {"figures", "report"}
TYPESETTING = {"typesetting the report", "everything is made"}
SCENES = ("free", "forced", "response")
FREE = "free: {kind: motion, tau_end: 7"
SECOND = """\
title: Another study
exciter: {l: 0.5, nu: 1, f: -0.8, h: 0.2, R1: 0.6}
scenes:
  other: {kind: motion, tau_end: 5, samples_per_period: 16}
"""
THIRD = "  third: {kind: motion, tau_end: 6, samples_per_period: 16}\n"


def results(project) -> dict[str, set[Path]]:
    """Return the files of each dataset and report, and of all figures of a study."""
    files: dict[str, set[Path]] = {}
    for path in project.path("results").rglob("*"):
        study = path.relative_to(project.path("results")).parts[0]
        name = {".nc": path.stem, ".pdf": "report", ".svg": "figures"}.get(path.suffix)
        if name and (path.suffix != ".pdf" or path.name == "report.pdf"):
            files.setdefault(f"{study}/{name}", set()).add(path)
    return files


def made(project, *arguments: str) -> set[str]:
    """Run snakemake once and return what it made, by its summary and by the files; check that nothing is left to do."""
    held = project.path("held")
    held.mkdir()
    before = {}
    for number, path in enumerate(p for paths in results(project).values() for p in paths):
        os.link(path, held / str(number))  # its number is given to no other file
        before[path] = path.stat().st_ino
    printed = project.snakemake(*arguments)
    new = {
        name
        for name, paths in results(project).items()
        if any(path.stat().st_ino != before.get(path) for path in paths)
    }
    shutil.rmtree(held)
    reported = {
        f"{study}/{part}"
        for study, parts in re.findall(r"^(\w+): made ([^;(]*)", printed, re.MULTILINE)
        for part in parts.strip().split(", ")
    }
    assert reported == new
    for path in re.findall(r"\((\S+\.pdf)\)", printed):
        assert project.path(path).is_file()
    assert project.planned(*arguments) == set()
    return new


def redone(scene: str) -> set[str]:
    """Return the jobs of an edit of one scene."""
    return {f"solving {scene}", f"drawing {scene}", *TYPESETTING}


def test_a_second_study(project):
    project.path("config/second.yaml").write_text(SECOND)
    project.edit("config/config.yaml", "[tiny]", "[tiny, second]")
    assert made(project) == {"second/other", "second/figures", "second/report"}


@pytest.mark.slow
def test_a_study_that_is_on_no_list(project):
    project.path("config/second.yaml").write_text(SECOND)
    assert made(project, "results/second/other.nc") == {"second/other"}
    assert project.planned() == set()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "scene"),
    [
        ("  response:\n", f"{THIRD}  response:\n", "third"),
        # compiles a kernel of its own
        (f"{FREE}, exciter: {{f: 0}}", f"{FREE}, exciter: {{f: 0, h: 0}}", "free"),
    ],
    ids=["a scene", "an effect gone"],
)
def test_an_edit_of_a_scene(project, old, new, scene):
    project.edit("config/tiny.yaml", old, new)
    assert made(project) == {f"tiny/{part}" for part in (scene, *DRAWN)}


def test_edits_of_outputs_and_of_a_number_are_planned(project):
    project.edit("config/tiny.yaml", FREE, "free: {kind: motion, outputs: [impacts], tau_end: 7")
    project.edit("config/tiny.yaml", "tau_end: 20", "tau_end: 21")
    assert project.planned() == redone("free") | redone("forced")


def test_an_edit_of_words_solves_and_draws_nothing(project):
    project.edit("config/tiny.yaml", "A study of seconds", "A study")
    assert project.planned() == TYPESETTING
    project.edit("config/tiny.yaml", "title: A study", "title: A study of seconds")
    project.edit("config/tiny.yaml", "*both*", "both")
    assert made(project) == {"tiny/report"}


def test_files_that_were_deleted(project):
    project.path("results/tiny/report.pdf").unlink()
    assert project.planned() == TYPESETTING
    for name in ("figures/free.svg", "figures/forced.pdf", "response.nc"):
        project.path("results/tiny", name).unlink()
    assert project.planned() == {"drawing free", "drawing forced", *redone("response")}
    assert made(project) == {"tiny/response", "tiny/figures", "tiny/report"}


def test_another_folder_of_results(project):
    shutil.copytree(project.path("results"), project.path("kept"))
    with project.path("config/config.yaml").open("a") as file:
        file.write("results: elsewhere\n")
    assert project.planned() == set.union(*map(redone, SCENES))
    project.edit("config/config.yaml", "elsewhere", "results")
    assert project.planned() == set()


@pytest.mark.slow
def test_a_study_that_was_removed_is_left_as_it_is(project):
    project.path("config/second.yaml").write_text(SECOND)
    project.edit("config/config.yaml", "[tiny]", "[second]")
    files = [path for paths in results(project).values() for path in paths]
    before = [path.stat().st_mtime_ns for path in files]
    printed = project.snakemake()
    assert [path.stat().st_mtime_ns for path in files] == before
    assert "tiny" not in printed.split("Select jobs")[-1]


def test_a_run_that_makes_less_than_it_should_says_so_and_fails(project):
    """As when results are put back while it runs."""
    project.edit("config/tiny.yaml", "tau_end: 20", "tau_end: 21")
    rules = "workflow/rules/solve.smk"
    project.edit(
        rules, '"vibropipe solve {params.file:q}', "\"bash -c 'vibropipe solve {params.file}"
    )
    project.edit(rules, '{log} 2>&1"', "{log} 2>&1; cp old/* results/tiny'\"")
    project.path("old").mkdir()
    for name in ("forced.nc", "forced.json"):
        shutil.copy2(project.path("results/tiny", name), project.path("old", name))
    printed = project.snakemake("results/tiny/forced.nc", code=1)
    assert "some requested files are missing" in printed
    assert "tiny: not made: forced (" in printed
    assert "results/tiny/forced.nc" in printed
    assert "Traceback" not in printed


DRAWING = {"drawing free", "drawing forced", "drawing response", *TYPESETTING}
SOLVING = {"solving free", "solving forced", "solving response"}


def test_a_shared_number_recomputes_the_scenes_that_use_it(project):
    project.edit("config/tiny.yaml", "f: -1,", "f: -0.9,")
    assert project.planned() == {"solving forced", "drawing forced", *TYPESETTING}


def test_edited_kernels_recompute_all(project):
    project.own_package()
    with project.path("vibropipe/march/loop.py").open("a") as source:
        source.write("# an edit\n")
    assert project.planned() == {*SOLVING, *DRAWING}


def test_touched_files_comments_and_spelling_recompute_nothing(project):
    project.own_package()
    project.edit("config/tiny.yaml", "tau_end: 20", "tau_end: 2.0e1  # as long as it was")
    later = time.time() + 60
    for path in project.folder.rglob("*"):
        if path.is_file() and ".snakemake" not in path.parts:
            os.utime(path, (later, later))
    assert project.planned() == set()


def test_edited_figures_recompute_no_data(project):
    project.own_package()
    with project.path("vibropipe/figures/style.py").open("a") as source:
        source.write("# an edit\n")
    assert project.planned() == DRAWING


STUDY = """\
title: Chaos beside order
exciter: {l: 0.5, nu: 1, f: 2, h: 0.05, R1: 0.8, R2: 0.8, delta: 0.1}
scenes:
  good: {kind: motion, tau_end: 7, samples_per_period: 16}
  bad: {kind: branch, along: {nu: {from: 0.633, to: 0.64}}}
"""
REASON = (
    "scenes.bad.exciter: must lead from (x0, v0) to an orbit that repeats with the force, got a motion with the regime"
    " aperiodic: begin at another value (along.nu.from) or from another start"
)


def run(folder: Path, code: int) -> str:
    return called(folder, "run", "mine.yaml", "--cores", "2", code=code).stderr


@pytest.mark.slow
def test_a_branch_that_cannot_start_fails_alone(tmp_path):
    (tmp_path / "mine.yaml").write_text(STUDY)
    report = tmp_path / "results/mine/report.pdf"
    for _ in range(2):  # it is tried again by each call
        report.unlink(missing_ok=True)
        printed = run(tmp_path, 1)
        assert "mine: results/mine/report.pdf, without bad" in printed
        assert printed.splitlines()[-1] == f"vibropipe: {REASON}"
        assert report.is_file()
    assert not (tmp_path / "results/mine/bad.nc").exists()
    # once the scene is gone, so is the line on it
    before = report.read_bytes()
    (tmp_path / "mine.yaml").write_text(STUDY[: STUDY.index("  bad:")])
    assert "mine: made report; up to date: good, figures (" in run(tmp_path, 0)
    assert report.read_bytes() != before
    assert scenes_of(report) == ["good"]
