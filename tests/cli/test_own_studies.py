"""Studies in any folder: `new` writes a template, `run` makes the results."""

import re
import sys
from pathlib import Path

import pytest
import xarray as xr
from command_line import called, run
from sampling import sampled

from vibropipe import __version__
from vibropipe.jobs.run import read_run
from vibropipe.jobs.solving import identity
from vibropipe.store import save
from vibropipe.study import load_study
from vibropipe.study.schema import schema_text

STUDY = """\
title: Far away
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7}
scenes:
  forced: {kind: motion, tau_end: 5, samples_per_period: 16}
"""


def vibropipe(folder: Path, *arguments: str, code: int = 0) -> str:
    """Run the command line in a folder, check its exit code and return its output."""
    done = called(folder, *arguments, code=code)
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


@pytest.mark.slow
def test_results_of_a_study_elsewhere_are_made_in_the_current_folder(tmp_path):
    for name in ("studies", "here"):
        tmp_path.joinpath(name).mkdir()
    here = tmp_path / "here"
    file = tmp_path / "studies" / "far.yaml"
    file.write_text(STUDY)
    printed = vibropipe(here, "run", "../studies/far.yaml", "--cores", "2", "--results", "made")
    assert "far: made forced, figures, report (made/far/report.pdf)" in printed
    assert (here / "made/far/report.pdf").read_bytes().startswith(b"%PDF")
    assert [path.name for path in file.parent.iterdir()] == ["far.yaml"]

    # the same study by its absolute path
    printed = vibropipe(here, "run", str(file), "--cores", "2", "--results", "made")
    assert "Nothing to be done" in printed
    assert "far: up to date (made/far/report.pdf)" in printed
    file.write_text(STUDY.replace("tau_end: 5", "tau_end: 6"))
    printed = vibropipe(here, "run", str(file), "--dry-run", "--results", "made")
    assert set(re.findall(r"far: (.+)", printed)) >= {"solving forced", "typesetting the report"}


def test_a_mistake_is_reported_before_any_job(tmp_path):
    tmp_path.joinpath("far.yaml").write_text(STUDY.replace("tau_end", "tau_ende"))
    printed = vibropipe(tmp_path, "run", "far.yaml", code=2)
    assert printed == vibropipe(tmp_path, "plan", "far.yaml", code=2)
    assert [path.name for path in tmp_path.iterdir()] == ["far.yaml"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("a/mine.yaml", "b/mine.yaml"), "studies: must have each study once, got mine, mine"),
        (("mine.yaml", "--results", "re{s}ults"), "results: must be"),
        *sampled(
            [
                (("mine.yaml", "--results", "mine.yaml"), "results: must be a folder"),
                (("nowhere.yaml",), "nowhere.yaml: "),
            ]
        ),
    ],
)
def test_what_cannot_be_made_is_refused(tmp_path, arguments, message):
    tmp_path.joinpath("mine.yaml").write_text(STUDY)
    assert message in vibropipe(tmp_path, "run", *arguments, code=2)


@pytest.mark.parametrize("more", [(), ("--results", "/tmp/elsewhere")])
def test_a_folder_in_which_no_run_can_work_is_refused_with_one_line(
    tmp_path, more, monkeypatch, capsys
):
    file = tmp_path / "mine.yaml"
    file.write_text(STUDY)
    monkeypatch.chdir(tmp_path)

    def refuse(dir):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    assert run("run", "mine.yaml", *more) == 1
    printed = capsys.readouterr().err
    assert printed.startswith(f"vibropipe: {tmp_path}: cannot be written (Permission denied), but")
    assert printed.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["mine.yaml"]


def test_a_folder_in_place_of_a_study_is_refused_with_the_studies_in_it(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert run("run", ".") == 2
    told = capsys.readouterr().err
    assert "Invalid value for FILE: must be a YAML file, got the folder ." in told
    (tmp_path / "far.yaml").write_text(STUDY)
    assert run("run", ".") == 2
    told = " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert "got the folder . (there is far.yaml)" in told


def test_a_new_study_is_valid_and_never_overwrites(tmp_path):
    printed = vibropipe(tmp_path, "new", "mine")
    assert "vibropipe run mine.yaml" in printed
    study = load_study(tmp_path / "mine.yaml")
    assert set(study.scenes) == {"response", "detail"}
    assert tmp_path.joinpath("study.schema.json").read_text() == schema_text()
    assert (tmp_path / "mine.yaml").read_text().startswith("# yaml-language-server: $schema=study")
    assert "already" in vibropipe(tmp_path, "new", "mine", code=2)
    assert "'Mine'" in vibropipe(tmp_path, "new", "Mine", code=2)


def test_the_version_is_that_of_the_package(tmp_path):
    assert vibropipe(tmp_path, "--version") == f"vibropipe {__version__}\n"


def test_a_new_study_with_units_is_valid(tmp_path):
    vibropipe(tmp_path, "new", "--units", "robot")
    study = load_study(tmp_path / "robot.yaml")
    assert study.scenes["response"].mass_and_stiffness == (2.0, 8000.0)


def test_with_nothing_to_do_studies_are_still_named_and_so_is_what_they_no_longer_have(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "far.yaml"
    file.write_text(STUDY)
    study = read_run(None, {"studies": ["far.yaml"], "results": "made"}).studies["far"]
    monkeypatch.setattr("vibropipe.jobs.run.stale_files", lambda *_: iter(()))
    for name in ("forced", "old"):
        attrs = identity(study, study.scene("forced")) | {"title": f"far: {name}"}
        save(xr.Dataset(attrs=attrs), f"made/far/{name}.nc")
    monkeypatch.setattr("snakemake.cli.main", lambda: sys.exit(0))
    monkeypatch.setattr(sys, "argv", [])
    for more, lines in ((), 2), (("--dry-run",), 0):
        assert run("run", "far.yaml", "--results", "made", *more) == 0
        printed = capsys.readouterr().err.splitlines()
        assert (
            printed
            == [
                "far: up to date (made/far/report.pdf)",
                "  kept, though no longer in the study: results of old; delete them if not needed",
            ][:lines]
        )


def test_a_folder_of_results_has_any_letters_and_blanks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("far.yaml").write_text(STUDY)
    monkeypatch.setattr(sys, "argv", [])

    def main() -> None:
        settings = dict(each.split("=", 1) for each in sys.argv[sys.argv.index("--config") + 1 :])
        assert settings["results"] == '"für mich/Ω"'
        sys.exit(0)

    monkeypatch.setattr("snakemake.cli.main", main)
    run("run", "far.yaml", "--results", "für mich/Ω")
