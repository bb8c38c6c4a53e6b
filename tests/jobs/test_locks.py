"""Locks of snakemake: dropped where their run has ended here, told where it runs or ran elsewhere."""

import subprocess
import sys

import pytest

from vibropipe.jobs.locks import LOCKS, RunRecord, check_unlocked, drop_dead_locks
from vibropipe.scenes.costs import PlanError
from vibropipe.store.atomic import host_name

OTHER_RUN = """
import sys
from pathlib import Path
from vibropipe.jobs.locks import LOCKS, RunRecord
record = RunRecord()
record.write()
Path(LOCKS, sys.argv[1] + ".output.lock").write_text(f"results/{sys.argv[2]}/s.nc\\n")
if "named" in sys.argv:
    record.write()
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def other_run(tmp_path, monkeypatch):
    """Start a process that locks the results of a study."""
    monkeypatch.chdir(tmp_path)
    started = []

    def start(*arguments: str) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, "-c", OTHER_RUN, *arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        started.append(process)
        assert process.stdout.readline() == "ready\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.wait()


def locks() -> list[str]:
    return sorted(path.name for path in LOCKS.iterdir())


@pytest.mark.parametrize("named", [(), ("named",)])
def test_a_lock_counts_as_long_as_its_run(other_run, named):
    process = other_run("0", "mine", *named)
    drop_dead_locks()
    with pytest.raises(PlanError, match=rf"on results/mine/ \(process {process.pid}\): wait until"):
        check_unlocked("results", ["mine"])
    check_unlocked("results", ["yours"])
    process.kill()
    process.wait()
    drop_dead_locks()
    check_unlocked("results", ["mine"])
    assert locks() == []


def test_the_lock_of_a_killed_run_is_dropped_beside_one_that_runs(other_run):
    dead, alive = other_run("0", "mine", "named"), other_run("1", "yours", "named")
    dead.kill()
    dead.wait()
    drop_dead_locks()
    assert locks() == ["1.output.lock", f"{host_name()}.{alive.pid}.run"]


def test_locks_of_another_host_or_of_nobody_are_told_with_their_remedy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    LOCKS.mkdir(parents=True)
    (LOCKS / "0.output.lock").write_text("results/mine/s.nc\n")
    remedy = "delete .snakemake/locks and give the same command again"
    with pytest.raises(PlanError, match=rf"results/mine/: wait .* killed, {remedy}$"):
        check_unlocked("results", ["mine"])
    (LOCKS / "node-7.12.run").write_text("0.output.lock")
    drop_dead_locks()
    with pytest.raises(
        PlanError, match=rf"\(process 12 on node-7\): wait .* killed there, {remedy}$"
    ):
        check_unlocked("results", ["mine"])


def test_a_record_has_the_locks_of_no_other_run(other_run):
    other_run("0", "mine", "named")
    record = RunRecord()
    record.write()
    (LOCKS / "1.output.lock").write_text("results/yours/s.nc\n")
    record.write()
    assert record.path.read_text() == "1.output.lock"
