"""Values added to a finished sweep: a run solves what is new, whole or in shards, and after an interruption too."""

import os
import signal
import time

import pytest
from sharded_study import STUDY, read_until

OFTEN = {"VIBROPIPE_SHARD_SECONDS": "0.01"}
TARGET = "results/tiny/response.nc"
TAKEN = "response: 600 of 1,180 rows taken from the earlier result"
FINER = "points: 59"


@pytest.fixture(scope="module")
def fresh_bytes(fresh, tmp_path_factory):
    """The dataset of the finer sweep, solved at once."""
    project = fresh.copied(tmp_path_factory.mktemp("at_once") / "project")
    project.path("config/tiny.yaml").write_text(STUDY.replace("points: 30", FINER))
    assert "taken" not in project.snakemake(TARGET)
    return project.path(TARGET).read_bytes()


@pytest.fixture(scope="module")
def coarse(fresh, tmp_path_factory):
    """A project with a sweep of 600 points."""
    project = fresh.copied(tmp_path_factory.mktemp("coarse") / "project")
    project.path("config/tiny.yaml").write_text(STUDY)
    project.snakemake(TARGET)
    return project


@pytest.fixture
def edited(coarse, tmp_path):
    """The same with points between those that are solved."""
    project = coarse.copied(tmp_path / "project")
    project.edit("config/tiny.yaml", "points: 30", FINER)
    return project


def files(project) -> list[str]:
    """Return the files and folders of the results of the study."""
    folder = project.path("results/tiny")
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


@pytest.mark.parametrize(
    "environment",
    [pytest.param({}, id="whole"), pytest.param(OFTEN, id="shards", marks=pytest.mark.slow)],
)
def test_new_points_are_solved_and_nothing_is_left(edited, fresh_bytes, environment):
    assert f"\n  {TAKEN}\n" in edited.snakemake(TARGET, **environment)
    assert edited.path(TARGET).read_bytes() == fresh_bytes
    assert files(edited) == ["response.json", "response.nc"]
    assert edited.planned(TARGET, **environment) == set()
    # without results nothing is taken
    edited.path(TARGET).unlink()
    assert "taken" not in edited.snakemake(TARGET, **environment)
    assert edited.path(TARGET).read_bytes() == fresh_bytes


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["solving response", "Finished jobid"])
def test_a_run_that_is_killed_goes_on_with_the_earlier_rows(edited, fresh_bytes, moment):
    process = edited.start(TARGET, **OFTEN)
    read_until(moment, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    time.sleep(2)  # in which its jobs end by themselves
    assert edited.path("results/tiny/shards/response/earlier.nc").is_file()
    printed = edited.snakemake(TARGET, **OFTEN)
    assert "rows taken from the earlier result" in printed
    assert edited.path(TARGET).read_bytes() == fresh_bytes
    assert files(edited) == ["response.json", "response.nc"]


def test_a_damaged_dataset_is_told_and_solved_as_a_whole(edited, fresh_bytes):
    whole = edited.path(TARGET).read_bytes()
    middle = len(whole) // 2
    edited.path(TARGET).write_bytes(
        whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    )
    printed = edited.snakemake(TARGET)
    told = "results/tiny/shards/response/earlier.nc: is damaged (its checksum does not match)"
    assert f"  response: no row taken from the earlier result: {told}\n" in printed
    assert edited.path(TARGET).read_bytes() == fresh_bytes
