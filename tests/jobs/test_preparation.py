"""Before a run: results are locked against other runs, and folders that cannot be written are reported."""

import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

from vibropipe.jobs.preparation import (
    check_working_folder,
    check_writable,
    clear_leftovers,
    lock_results,
)
from vibropipe.scenes.costs import PlanError
from vibropipe.store import NotWrittenError
from vibropipe.store.atomic import host_name

OTHER_RUN = """
import sys
from vibropipe.jobs.preparation import lock_results
lock_results("results", sys.argv[1:])
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def other_run(tmp_path, monkeypatch):
    """A process that makes the results of the study `mine`."""
    monkeypatch.chdir(tmp_path)
    process = subprocess.Popen(
        [sys.executable, "-c", OTHER_RUN, "mine"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline() == "ready\n"
    yield process
    process.kill()
    process.wait()


def test_results_are_locked_as_long_as_their_run_lasts(other_run):
    where = (
        rf"^results/mine: another run makes it \(process {other_run.pid} on {host_name()}\): wait"
    )
    with pytest.raises(PlanError, match=f"{where} until it has ended$"):
        lock_results("results", ["yours", "mine"])
    other_run.kill()
    other_run.wait()
    lock_results("results", ["mine"])


def test_a_run_that_ends_by_itself_leaves_no_lock(other_run):
    other_run.communicate("")
    assert other_run.returncode == 0
    assert not list(Path("results/mine").iterdir())


def test_a_lock_of_another_host_is_told_with_its_remedy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lock = Path("results/mine/.run")
    lock.parent.mkdir(parents=True)
    lock.write_text("node-7 12")
    with pytest.raises(PlanError) as refusal:
        lock_results("results", ["mine"])
    assert str(refusal.value) == (
        "results/mine: another run makes it (process 12 on node-7): wait until it has ended; if it was killed there,"
        " delete results/mine/.run and give the same command again"
    )


def test_a_folder_that_cannot_be_written_is_reported_and_another_one_created(tmp_path):
    check_writable(str(tmp_path / "new" / "results"))
    assert list(tmp_path.joinpath("new/results").iterdir()) == []
    tmp_path.joinpath("file").touch()
    with pytest.raises(
        NotWrittenError, match=r"file/results: cannot be written \(Not a directory\): change"
    ):
        check_writable(str(tmp_path / "file" / "results"))


@pytest.mark.parametrize("refused", [".", "logs"])
def test_a_working_folder_that_cannot_be_written_is_reported(tmp_path, refused, monkeypatch):
    folder = tmp_path
    monkeypatch.chdir(folder)
    folder.joinpath("logs").mkdir()
    check_working_folder()
    files = sorted(folder.rglob("*"))

    def temporary_file(dir):
        if dir == Path(refused):
            raise PermissionError(13, "Permission denied")
        return nullcontext()

    monkeypatch.setattr("tempfile.TemporaryFile", temporary_file)
    with pytest.raises(NotWrittenError) as refusal:
        check_working_folder()
    where = f"{folder / refused}: cannot be written (Permission denied), but"
    assert str(refusal.value).startswith(where)
    assert sorted(folder.rglob("*")) == files


def test_leftovers_of_other_cuts_are_removed_among_shards_alone(tmp_path):
    for folder in ("results/first", "results/first/shards/wide"):
        tmp_path.joinpath(folder).mkdir(parents=True)
        for name in ("0001", "0009"):
            tmp_path.joinpath(folder, f".{name}.nc.node-7.12.part").touch()
    clear_leftovers(
        str(tmp_path / folder / "0001.nc")
        for folder in ("results/first", "results/first/shards/wide")
    )
    left = [path.name for path in tmp_path.rglob("*.part")]
    assert left == [".0009.nc.node-7.12.part"]
    assert list(tmp_path.joinpath("results/first").glob(".*.part"))
