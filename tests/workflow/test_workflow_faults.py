"""Runs that are interrupted or killed: rerun, they give the undisturbed dataset and do nothing twice."""

import os
import random
import re
import shutil
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest
from sharded_study import SHARDS, STUDY, said_until

OFTEN = {"VIBROPIPE_SHARD_SECONDS": "0.01"}
TARGET = "results/tiny/response.nc"
MOMENTS = 20


@pytest.fixture(scope="module")
def undisturbed(fresh, tmp_path_factory):
    """A project with its sweep solved in shards, and the seconds that took."""
    project = fresh.copied(tmp_path_factory.mktemp("undisturbed") / "project")
    project.path("config/tiny.yaml").write_text(STUDY)
    project.snakemake(TARGET)  # its kernels are compiled, for all projects
    shutil.rmtree(project.path("results"))
    begin = time.perf_counter()
    said = project.snakemake("--notemp", TARGET, **OFTEN)
    assert len(jobs(said, "Finished")) == SHARDS + 1
    return project, time.perf_counter() - begin


@pytest.fixture
def unsolved(undisturbed, tmp_path):
    """A project with compiled kernels and nothing else done."""
    return undisturbed[0].copied(tmp_path / "project", ".snakemake", "tiny", "logs")


def jobs(said: str, which: str) -> set[str]:
    """Return the jobs that snakemake says it started or finished."""
    names = dict(re.findall(r"^Job (\d+): tiny: (.+)$", said, re.MULTILINE))
    if which == "Started":
        return set(names.values())
    done = re.findall(r"^Finished jobid: (\d+) ", said, re.MULTILINE)
    return {names[job] for job in done if job in names}


def processes_of(process: subprocess.Popen) -> list[int]:
    """Return the processes that a snakemake started, jobs before their shells; none of anybody else."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != process.pid:
            with suppress(ProcessLookupError):
                if os.getsid(int(entry.name)) == process.pid:
                    found.append(int(entry.name))
    return sorted(found, reverse=True)


def kill(process: subprocess.Popen, target: str, chosen: random.Random) -> None:
    """SIGKILL a job, snakemake, or both with everything they started."""
    own = processes_of(process)
    victims = {
        "job": [chosen.choice(own)] if own else [],
        "snakemake": [process.pid],
        "everything": [process.pid, *own],
    }[target]
    for victim in victims:
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)


def go_on(project) -> str:
    """Give the command again, and do what it asks for; return what the run says that did the work."""
    process = project.start("--notemp", TARGET, **OFTEN)
    said, _ = process.communicate()
    if process.returncode == 0:
        return said
    assert "--unlock" in said
    assert "Traceback" not in said
    project.snakemake("--unlock", **OFTEN)
    return project.snakemake("--notemp", TARGET, **OFTEN)


def wait_for_orphans(process: subprocess.Popen) -> None:
    deadline = time.monotonic() + 60
    while processes_of(process) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not processes_of(process)


def check_whole(project, undisturbed) -> None:
    """See that the dataset is the undisturbed one, bit for bit, and that nothing else was left."""
    assert project.path(TARGET).read_bytes() == undisturbed.path(TARGET).read_bytes()
    left = [path.name for path in project.path("results").rglob("*") if path.is_file()]
    assert not [name for name in left if name.endswith(".part")]
    shards = [name for name in left if re.fullmatch(r"\d{4}\.nc", name)]
    assert len(shards) == SHARDS


def disturbed(project, undisturbed, target: str, moment: float, seed: int) -> None:
    """Kill at a moment, give the command again, and compare."""
    process = project.start("--notemp", TARGET, **OFTEN)
    time.sleep(moment)
    kill(process, target, random.Random(seed))
    said, _ = process.communicate()
    again = go_on(project)
    assert not jobs(said, "Finished") & jobs(again, "Started")
    wait_for_orphans(process)
    check_whole(project, undisturbed)


def test_ctrl_c_is_one_line_and_130_and_the_same_command_goes_on(unsolved, undisturbed):
    process = unsolved.start("--notemp", TARGET, **OFTEN)
    said_until("solving response", process)
    os.killpg(process.pid, signal.SIGINT)
    last = process.stdout.read()
    assert process.wait() == 130
    assert [line for line in last.splitlines() if line and "solving response" not in line] == [
        "interrupted; completed files are kept; run the same command to resume"
    ]
    assert not list(unsolved.path("results").rglob(".*.part"))
    again = unsolved.snakemake("--notemp", TARGET, **OFTEN)
    assert "unlock" not in again
    check_whole(unsolved, undisturbed[0])


def test_results_that_cannot_be_written_stop_a_run_before_any_job(unsolved):
    shutil.rmtree(unsolved.path("results"))
    unsolved.path("results").write_text("a file where a folder should be")
    said = unsolved.snakemake(TARGET, code=2)
    assert "results: must be a folder, got the file results" in said
    assert "Traceback" not in said

    # no folder can be made there, whoever asks
    nowhere = "studies: [tiny]\nresults: /proc/results\n"
    unsolved.path("config/config.yaml").write_text(nowhere)
    said = unsolved.snakemake("/proc/results/tiny/response.nc", code=1)
    assert "/proc/results: cannot be written (No such file or directory): change" in said
    assert "Traceback" not in said
    assert not jobs(said, "Started")


def test_a_second_snakemake_is_refused_and_a_killed_one_can_be_gone_on_from(unsolved, undisturbed):
    process = unsolved.start("--notemp", TARGET, **OFTEN)
    said = said_until("Finished jobid", process)
    os.killpg(
        process.pid, signal.SIGSTOP
    )  # its shards are short: it would be done before the second is refused
    second = unsolved.snakemake("--notemp", TARGET, code=1, **OFTEN)
    assert "cannot be locked" in second
    assert "--unlock" in second
    assert "Traceback" not in second
    kill(process, "everything", random.Random(0))
    said += process.stdout.read()
    process.wait()
    # writers on another machine, of this cut and of another one: whether they still run cannot be asked
    for name in (".0002.nc.node-7.12.part", ".0009.nc.node-7.12.part"):
        unsolved.path("results/tiny/shards/response", name).write_bytes(b"half")
    again = go_on(unsolved)
    finished = jobs(said, "Finished")
    assert finished
    assert not finished & jobs(again, "Started")
    check_whole(unsolved, undisturbed[0])


@pytest.mark.slow
@pytest.mark.parametrize("target", ["job", "snakemake", "everything"])
@pytest.mark.parametrize("seed", range(MOMENTS))
def test_whatever_is_killed_at_whatever_moment_nothing_is_lost(target, seed, unsolved, undisturbed):
    whole, seconds = undisturbed
    moment = random.Random(f"{target} {seed}").uniform(0.3, seconds)
    disturbed(unsolved, whole, target, moment, seed)
