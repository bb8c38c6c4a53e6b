"""Results that do not match their study, and options that are no numbers: one message, and no file written."""

import shutil

import pytest
import xarray as xr
from command_line import run
from typer.testing import CliRunner

from vibropipe.cli.commands import app

STUDY = """\
title: A study of seconds
exciter: {l: 0.5, nu: 1, f: -1, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  forced: {kind: motion, tau_end: 7}
  response: {kind: sweep, over: {nu: [0.9, 1, 1.1, 1.2]}}
"""
OTHER = STUDY.replace("1.1", "1.15").replace("tau_end: 7", "tau_end: 8")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with two studies, the results of the first with figures, and shards of both."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "mine.yaml").write_text(STUDY)
    (folder / "other.yaml").write_text(OTHER)
    for scene in ("forced", "response"):
        output = folder / "results" / "mine" / f"{scene}.nc"
        assert run("solve", folder / "mine.yaml", "--scene", scene, "--output", output) == 0
    for name in ("mine", "other"):
        for shard in (1, 2):
            cut = ["--shard", f"{shard}/2", "--output", folder / "shards" / f"{name}_{shard}.nc"]
            assert run("solve", folder / f"{name}.yaml", "--scene", "response", *cut) == 0
    assert run("figure", folder / "mine.yaml", "--results", folder / "results") == 0
    return folder


@pytest.fixture
def place(made, tmp_path, monkeypatch):
    """A copy of this folder as working directory."""
    shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


def held(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_folder_of_results_may_be_the_current_one(place):
    shutil.move(place / "results" / "mine", place / "mine")
    shutil.rmtree(place / "mine" / "figures")
    made = run("report", "mine.yaml", "--results", ".", "--output", "mine/report.pdf")
    assert made == 0
    assert {path.name for path in place.glob("mine/**/*.pdf")} >= {"forced.pdf", "report.pdf"}


def refused(folder, capsys, words, *arguments):
    """Check that a command prints one message with these words and changes no file."""
    before = held(folder)
    capsys.readouterr()
    assert run(*arguments) == 2
    said = capsys.readouterr()
    assert not said.out
    assert said.err.startswith("vibropipe: ")
    assert said.err.count("\n") == 1
    for word in words:
        assert word in said.err
    assert held(folder) == before


BOTH = [["figure", "mine.yaml"], ["report", "mine.yaml", "-o", "report.pdf"]]


@pytest.mark.parametrize("verb", BOTH)
def test_a_dataset_that_is_missing(verb, place, capsys):
    (place / "results" / "mine" / "response.nc").unlink()
    words = ["results/mine: holds no dataset of response", "solve the study first"]
    refused(place, capsys, words, *verb)


@pytest.mark.parametrize("verb", BOTH)
def test_a_folder_without_results(verb, place, capsys):
    words = ["shards/mine: does not exist", "solve the study first"]
    refused(place, capsys, words, *verb, "--results", "shards")


@pytest.mark.parametrize("verb", BOTH)
def test_a_dataset_of_another_study(verb, place, capsys):
    (place / "mine.yaml").write_text(OTHER)
    words = ["results/mine/forced.nc: was made from another study", "recompute the scene"]
    refused(place, capsys, words, *verb)


@pytest.mark.parametrize("verb", BOTH)
def test_datasets_of_other_scenes(verb, place, capsys):
    results = place / "results" / "mine"
    (results / "forced.nc").rename(results / "kept.nc")
    (results / "response.nc").rename(results / "forced.nc")
    (results / "kept.nc").rename(results / "response.nc")
    refused(place, capsys, ["forced.nc: was made from another study"], *verb)


@pytest.mark.parametrize("verb", BOTH)
def test_a_shard_in_the_place_of_its_sweep(verb, place, capsys):
    shutil.copy(place / "shards" / "mine_1.nc", place / "results" / "mine" / "response.nc")
    refused(place, capsys, ["response.nc: is a shard of a sweep", "join"], *verb)


@pytest.mark.parametrize(
    "verb", [*BOTH, ["show", "results/mine"], ["show", "results/mine/response.nc"]]
)
def test_a_truncated_dataset(verb, place, capsys):
    path = place / "results" / "mine" / "response.nc"
    path.write_bytes(path.read_bytes()[:-500])
    refused(place, capsys, ["response.nc: is truncated", "delete it and rerun"], *verb)


@pytest.mark.parametrize("left", [0, 100, -20])
def test_a_damaged_figure_is_drawn_again_for_the_report(left, place, capsys):
    path = place / "results" / "mine" / "figures" / "forced.pdf"
    whole = path.read_bytes()
    path.write_bytes(whole[:left])
    assert run("report", "mine.yaml", "-o", "report.pdf") == 0
    assert capsys.readouterr().out == "report.pdf\n"
    assert path.read_bytes() == whole  # drawn again


@pytest.mark.parametrize("verb", ["show", "verify"])
@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("nowhere", ["nowhere"]),
        (
            "results/mine/figures",
            ["figures: holds no scene (no file *.nc)", "solve the study first"],
        ),
        ("results", ["results: holds no scene but the results of studies: name it: results/mine"]),
        ("mine.yaml", ["mine.yaml: is no dataset"]),
    ],
)
def test_no_dataset_to_show_or_verify(verb, target, words, place, capsys):
    refused(place, capsys, words, verb, target)


def test_nobody_is_told_to_delete_a_file_that_is_no_dataset(place, capsys):
    for verb in (
        ["show", "mine.yaml"],
        ["join", "mine.yaml", "mine.yaml", "--scene", "response", "-o", "j.nc"],
    ):
        assert run(*verb) == 2
        assert "delete" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("shards", "words"),
    [
        (["mine_1.nc"], ["rows 2 to 3 of 4 are not in the only shard"]),
        (["mine_1.nc", "absent.nc"], ["shards/absent.nc: cannot be read"]),
        (
            ["mine_1.nc", "other_2.nc"],
            ["other_2.nc: nu of row 2 differs from the study (must be 1.1, got 1.15)"],
        ),
        (
            ["other_1.nc", "other_2.nc"],
            ["other_2.nc: nu of row 2 differs from the study (must be 1.1, got 1.15)"],
        ),
        (["mine_1.nc", "../results/mine/response.nc"], ["response.nc: is no shard"]),
        (["../results/mine/forced.nc"], ["forced.nc: is no shard"]),
        (["mine_1.nc", "cut.nc"], ["cut.nc: is truncated"]),
        (["mine_1.nc", "../mine.yaml"], ["mine.yaml: is no dataset (not a netCDF4 file)"]),
        (["../shards"], ["shards: must be a file, got a folder"]),
    ],
)
def test_shards_that_do_not_join(shards, words, place, capsys):
    folder = place / "shards"
    (folder / "cut.nc").write_bytes((folder / "mine_2.nc").read_bytes()[:-100])
    paths = [f"shards/{name}" for name in shards]
    verb = ["join", "mine.yaml", *paths, "--scene", "response", "-o", "joined.nc"]
    refused(place, capsys, words, *verb)


def test_shards_of_the_study_join(place):
    paths = ["shards/mine_2.nc", "shards/mine_1.nc"]
    assert run("join", "mine.yaml", *paths, "--scene", "response", "-o", "joined.nc") == 0
    whole = place / "results" / "mine" / "response.nc"
    with xr.open_dataset("joined.nc") as joined, xr.open_dataset(whole) as solved:
        xr.testing.assert_identical(joined, solved)


def test_a_title_is_no_other_study(place):
    (place / "mine.yaml").write_text(STUDY.replace("A study of seconds", "Renamed"))
    assert run("report", "mine.yaml", "-o", "report.pdf") == 0


@pytest.mark.parametrize(
    ("option", "text", "hint"),
    [
        ("--l", "0,5", "write 0.5, with a point"),
        ("--l", "8mm", "numbers of this command have no unit"),
        ("--x0", "8 mm", "no unit belongs here: quantities with units go with `physical`"),
        ("--accuracy", "x", "numbers of this command have no unit"),
    ],
)
def test_an_option_that_is_no_number_is_told_with_its_value_and_a_hint(option, text, hint):
    done = CliRunner().invoke(app, ["simulate", "--l", "1", option, text], terminal_width=200)
    assert done.exit_code == 2
    told = " ".join(done.output.replace("│", " ").split())
    assert f"Invalid value for '{option}': must be a number, got '{text}' ({hint})" in told
