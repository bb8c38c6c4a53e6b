"""The results of the workflow and its messages, for small studies and for a million points."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from vibropipe.store import load
from vibropipe.study import StudyError, load_study
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status


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


# One of its rows once ended its shard, its job and the study.
STUDY = """\
title: A million points
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  regimes:
    kind: sweep
    over:
      nu: {start: 0.3, stop: 3, points: 1000}
      f: {start: 0.05, stop: 2, points: 1000}
"""


@pytest.mark.slow
def test_a_million_points_from_yaml_to_pdf(fresh: Any, tmp_path: Path) -> None:
    project = fresh.copied(tmp_path / "project")
    project.path("config/config.yaml").write_text("studies: [million]\n")
    project.path("config/million.yaml").write_text(STUDY)
    project.snakemake()
    folder = project.path("results/million")
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    assert (folder / "figures" / "regimes.pdf").read_bytes().startswith(b"%PDF")
    with netCDF4.Dataset(folder / "regimes.nc") as file:
        regime, status, m = (
            np.asarray(file[name][...]) for name in ("regime", "status", "period_multiple")
        )
    assert regime.shape == (1000, 1000)
    orbit = regime <= Regime.WITH_REST
    np.testing.assert_array_equal(orbit, m > 0)
    np.testing.assert_array_equal(orbit, status == Status.OK)
    assert orbit.mean() > 0.85
    # motions that still grow after 1,000 periods
    unresolved = int((regime == Regime.UNRESOLVED).sum())
    assert unresolved < 100
    assert json.loads((folder / "regimes.json").read_text())["unresolved"] == unresolved
