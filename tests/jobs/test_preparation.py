"""Before and during a run: results are locked, folders must be writable, and Ctrl-C waits for snakemake."""

import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest

from vibropipe.jobs.preparation import (
    check_working_folder,
    check_writable,
    clear_leftovers,
    keep_earlier,
    lock_results,
)
from vibropipe.jobs.processes import STOPPED
from vibropipe.jobs.solving import solve_stale
from vibropipe.jobs.up_to_date import stale_files
from vibropipe.scenes.costs import PlanError
from vibropipe.store import NotWrittenError, read_sidecar
from vibropipe.store.atomic import host_name
from vibropipe.study import Study, load_study
from vibropipe.words.exit_codes import INTERRUPTED

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
    with pytest.raises(
        NotWrittenError, match=r"file/mine: cannot be written \(Not a directory\): change"
    ):
        check_writable(str(tmp_path), ["file/mine"])


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


SWEEP = "kind: sweep, outputs: [harmonics], over: {f: [0.2, 1], nu: [0.9, 1.1]}"
SWEEPS = f"{{title: t, exciter: {{l: 0.5, h: 0.2, R1: 0.7}}, scenes: {{a: {{{SWEEP}}}, b: {{{SWEEP}}}}}}}"


def test_datasets_of_sweeps_with_further_values_are_kept_until_they_are_made(tmp_path):
    file, folder = tmp_path / "t.yaml", tmp_path / "t"
    kept = folder / "shards/a/earlier.nc"

    def prepared(text: str) -> Study:
        """Prepare a run of the study, and return it."""
        file.write_text(text)
        study = load_study(file)
        keep_earlier(str(tmp_path), study, set(stale_files(study, str(tmp_path), {"a": 1, "b": 1})))
        return study

    solve_stale(prepared(SWEEPS), ["a", "b"], folder, None, 1)
    assert not kept.exists()
    study = prepared(SWEEPS.replace("f: [0.2, 1]", "f: [0.2, 0.6, 1]", 1))
    # a second name of the same bytes, for this scene alone
    assert kept.samefile(folder / "a.nc")
    assert [path.name for path in folder.glob("shards/*")] == ["a"]
    (folder / "a.nc").unlink()
    prepared(file.read_text())
    assert kept.is_file()
    solve_stale(study, ["a", "b"], folder, None, 1)
    assert read_sidecar(folder / "a.nc")["taken"] == 4
    assert not kept.parent.parent.exists()
    # an edit that is undone, a scene that is gone, and one whose rows would differ
    prepared(SWEEPS)
    assert kept.samefile(folder / "a.nc")
    prepared(file.read_text().replace("f: [0.2, 1]", "f: [0.2, 0.6, 1]", 1))
    assert not kept.exists()
    prepared(SWEEPS)
    prepared(SWEEPS.replace(f"a: {{{SWEEP}}}, ", ""))
    assert not kept.exists()
    prepared(SWEEPS.replace("R1: 0.7", "R1: 0.6"))
    assert not kept.exists()


def test_a_file_system_without_links_gets_a_copy(tmp_path, monkeypatch):
    def refused(*_):
        raise PermissionError

    monkeypatch.setattr("os.link", refused)
    file, folder = tmp_path / "t.yaml", tmp_path / "t"
    file.write_text(SWEEPS)
    solve_stale(load_study(file), ["a"], folder, None, 1)
    file.write_text(SWEEPS.replace("f: [0.2, 1]", "f: [0.2, 0.6, 1]", 1))
    keep_earlier(str(tmp_path), load_study(file), {str(folder / "a.nc")})
    assert (folder / "shards/a/earlier.nc").read_bytes() == (folder / "a.nc").read_bytes()


BEFORE = """
import asyncio, logging, os, signal, time
from vibropipe.jobs.processes import Interrupt

interrupt = Interrupt(logging.getLogger("snakemake"))
interrupt.reading = False
"""
IN_A_LOOP = """
async def wait():
    await asyncio.sleep(0.01)

async def prepare():
    async with asyncio.TaskGroup() as group:
        group.create_task(wait())
        os.kill(os.getpid(), signal.SIGINT)
    print("prepared")

with asyncio.Runner() as runner:
    runner.run(prepare())
    time.sleep(10)
"""
IN_A_HANDLER = """
class Handler(logging.Handler):
    def emit(self, record):
        os.kill(os.getpid(), signal.SIGINT)
        print("logged")

logger = logging.getLogger("other")
logger.addHandler(Handler())
logger.warning("")
time.sleep(10)
"""
IN_A_WRITE = """
import io, sys

class Raw(io.RawIOBase):
    def writable(self):
        return True

    def write(self, text):
        os.kill(os.getpid(), signal.SIGINT)
        return os.write(1, text)

sys.stderr = io.TextIOWrapper(io.BufferedWriter(Raw()), write_through=True)
logger = logging.getLogger("other")
logger.addHandler(logging.StreamHandler(sys.stderr))
logger.warning("logged")
sys.stderr.flush()
time.sleep(10)
"""


@pytest.mark.parametrize(
    ("busy", "done"), [(IN_A_LOOP, "prepared"), (IN_A_HANDLER, "logged"), (IN_A_WRITE, "logged")]
)
def test_a_run_ends_after_what_must_not_be_interrupted(busy, done):
    script = subprocess.run(
        [sys.executable, "-c", BEFORE + busy], capture_output=True, text=True, timeout=60
    )
    assert script.returncode == INTERRUPTED
    assert script.stdout.split() == [done]
    assert script.stderr.splitlines() == [STOPPED]
