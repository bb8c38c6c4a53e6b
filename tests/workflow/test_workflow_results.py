"""The results of the workflow, its messages before a run, and its messages in place of a run."""

import json
import re

import numpy as np
import pytest
import xarray as xr

from vibropipe.store import load
from vibropipe.study import StudyError, load_study


def test_all_results_are_there(finished):
    names = ["free", "forced", "response"]
    expected = {f"{name}.{suffix}" for name in names for suffix in ("nc", "json")}
    folder = finished.path("results/tiny")
    assert {path.name for path in folder.iterdir()} == {*expected, "figures", "report.pdf"}
    drawn = {path.name for path in (folder / "figures").iterdir()}
    assert drawn == {f"{name}.{suffix}" for name in names for suffix in ("svg", "pdf")}
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    assert json.loads((folder / "forced.json").read_text())["seconds"] > 0
    for name in names:
        assert finished.path(f"logs/tiny/{name}.log").is_file()


def test_a_dataset_is_made_by_its_name_with_the_other_small_scenes(fresh):
    scenes = {f"solving {name}" for name in ("free", "forced", "response")}
    assert fresh.planned("results/tiny/forced.nc") == scenes


def test_a_dry_run_prints_the_cost_of_each_study(fresh):
    printed = fresh.snakemake("--dry-run")
    assert re.search(r"^response +sweep +3 f x 4 nu +exact, nu down ", printed, re.MULTILINE)
    assert re.search(r"^3 scenes, 14 rows, estimated on this machine, ", printed, re.MULTILINE)


def test_shards_make_the_same_dataset(project):
    whole = load(project.path("results/tiny/response.nc"))
    often = {"VIBROPIPE_SHARD_SECONDS": "1e-6"}
    jobs = {f"solving response, shard {shard}/3" for shard in (1, 2, 3)}
    name = "results/tiny/response.nc"
    assert project.planned(name, **often) == set()  # another cut gives the same data
    project.path(name).unlink()
    assert project.planned(name, **often) == {*jobs, "joining the shards of response"}

    project.snakemake(name, **often)
    joined = load(project.path(name))
    xr.testing.assert_identical(whole, joined)
    for variable in whole.variables:
        assert np.asarray(whole[variable]).tobytes() == np.asarray(joined[variable]).tobytes()
    assert not list(project.path("results/tiny/shards").rglob("*.nc"))
    assert json.loads(project.path("results/tiny/response.json").read_text())["shards"] == 3


def test_the_html_report_shows_captions_without_a_network(project):
    project.snakemake("--report", "report.html")
    html = project.path("report.html").read_text()
    assert "Impacts {{ on }} *both* supports." in html
    # the page that it opens on says what the study is; a figure without a caption of its own has one from its data
    opening = re.search(r'workflow_desc = "(.*)";', html)[1]
    assert "A study of seconds" in opening
    assert "2 motion scenes and 1 sweep scene, 3 figures." in opening
    assert r'"caption": "<p>Steady states against \u03bd for f = 0.2, 0.6, 1;' in html
    for label in ("scene", "title", "picture"):
        assert f'"{label}": ' in html
    assert not re.search(r"<(script|link)[^>]+(src|href)=\"https?:", html)


def test_a_bad_study_stops_before_any_job(fresh, tmp_path):
    text = fresh.path("config/tiny.yaml").read_text()
    (tmp_path / "tiny.yaml").write_text(text.replace("tau_end: 20", "tau_ende: 20"))
    (tmp_path / "config.yaml").write_text("studies: [tiny]\n")
    printed = fresh.snakemake("--configfile", str(tmp_path / "config.yaml"), code=2)
    with pytest.raises(StudyError) as error:
        load_study(tmp_path / "tiny.yaml")
    assert printed.splitlines()[1:] == f"vibropipe: {error.value}".splitlines()
    assert not fresh.path("results").exists()


def test_a_missing_study_is_named_by_its_file(fresh):
    printed = fresh.snakemake("results/mine/report.pdf", code=2)
    assert "config/mine.yaml" in printed
    assert "Traceback" not in printed


def test_options_on_the_command_line_are_used_or_rejected(fresh):
    printed = fresh.snakemake("--dry-run", "--config", "results=elsewhere")
    assert "tiny: solving free, forced, response" in printed
    printed = fresh.snakemake("--dry-run", "--config", "result=elsewhere", code=2)
    assert "vibropipe: --config: must be studies or results, got result" in printed
