"""Interrupted and killed runs: a rerun gives the undisturbed dataset and repeats no finished job."""

import os
import random
import re
import shutil
import signal
import subprocess
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
from sharded_study import SHARDS, STUDY, read_until

OFTEN = {"VIBROPIPE_SHARD_SECONDS": "0.01"}
TARGET = "results/tiny/response.nc"
MOMENTS = 20


@pytest.fixture(scope="module")
def undisturbed(fresh, tmp_path_factory):
    """A project with its sweep solved in shards."""
    project = fresh.copied(tmp_path_factory.mktemp("undisturbed") / "project")
    project.path("config/tiny.yaml").write_text(STUDY)
    printed = project.snakemake("--notemp", TARGET, **OFTEN)
    assert len(jobs(printed, "Finished")) == SHARDS + 1
    return project


@pytest.fixture(scope="module")
def usual_seconds(undisturbed, tmp_path_factory):
    """Seconds of the same run with compiled kernels."""
    project = unsolved_copy(undisturbed, tmp_path_factory.mktemp("timed") / "project")
    begin = time.perf_counter()
    project.snakemake("--notemp", TARGET, **OFTEN)
    return time.perf_counter() - begin


def unsolved_copy(undisturbed, folder):
    """Return a copy of a project without results."""
    return undisturbed.copied(folder, ".snakemake", "tiny", "logs")


@pytest.fixture
def unsolved(undisturbed, tmp_path):
    """A project with compiled kernels and no results."""
    return unsolved_copy(undisturbed, tmp_path / "project")


def jobs(printed: str, which: str) -> set[str]:
    """Return the jobs that snakemake reports as started or finished."""
    names = dict(re.findall(r"^Job (\d+): tiny: (.+)$", printed, re.MULTILINE))
    if which == "Started":
        return set(names.values())
    done = re.findall(r"^Finished jobid: (\d+) ", printed, re.MULTILINE)
    return {names[job] for job in done if job in names}


def processes_of(process: subprocess.Popen) -> list[int]:
    """Return the processes in the session of a snakemake, jobs before their shells."""
    processes = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != process.pid:
            with suppress(ProcessLookupError):
                if os.getsid(int(entry.name)) == process.pid:
                    processes.append(int(entry.name))
    return sorted(processes, reverse=True)


def kill(process: subprocess.Popen, target: str, chosen: random.Random) -> None:
    """Send SIGKILL to a job, to snakemake, or to all processes of the run."""
    own = processes_of(process)
    victims = {
        "job": [chosen.choice(own)] if own else [],
        "snakemake": [process.pid],
        "everything": [process.pid, *own],
    }[target]
    for victim in victims:
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)


def wait_for_orphans(process: subprocess.Popen) -> None:
    """Wait for the processes of a killed run, which end by themselves."""
    deadline = time.monotonic() + 15
    while processes_of(process) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not processes_of(process)


def check_whole(project, undisturbed) -> None:
    """Check that the dataset equals the undisturbed one bit for bit, and that no leftovers exist."""
    assert project.path(TARGET).read_bytes() == undisturbed.path(TARGET).read_bytes()
    left = [path.name for path in project.path("results").rglob("*") if path.is_file()]
    assert not [name for name in left if name.endswith(".part")]
    shards = [name for name in left if re.fullmatch(r"\d{4}\.nc", name)]
    assert len(shards) == SHARDS


def disturbed(project, undisturbed, target: str, moment: float, seed: int) -> None:
    """Kill processes at some moment, repeat the command, and compare the results."""
    process = project.start("--notemp", TARGET, **OFTEN)
    time.sleep(moment)
    kill(process, target, random.Random(seed))
    printed, _ = process.communicate()
    resumed = project.snakemake("--notemp", TARGET, **OFTEN)
    assert not jobs(printed, "Finished") & jobs(resumed, "Started")
    wait_for_orphans(process)
    check_whole(project, undisturbed)


def test_ctrl_c_is_one_line_and_130_and_the_same_command_goes_on(unsolved, undisturbed):
    process = unsolved.start("--notemp", TARGET, **OFTEN)
    read_until("solving response", process)
    os.killpg(process.pid, signal.SIGINT)
    late = threading.Timer(120, process.kill)
    late.start()
    last = process.stdout.read()
    late.cancel()
    assert process.wait() == 130
    # Another job may have started meanwhile: a line with its time, and one with what it solves.
    own = [
        each for each in last.splitlines() if each and not re.match(r"\[|.*solving response", each)
    ]
    assert own == ["interrupted; completed files are kept; run the same command to resume"]
    assert not list(unsolved.path("results").rglob(".*.part"))
    resumed = unsolved.snakemake("--notemp", TARGET, **OFTEN)
    assert "unlock" not in resumed
    check_whole(unsolved, undisturbed)


def test_results_that_cannot_be_written_stop_a_run_before_any_job(unsolved):
    shutil.rmtree(unsolved.path("results"))
    unsolved.path("results").write_text("a file where a folder should be")
    printed = unsolved.snakemake(TARGET, code=2)
    assert "results: must be a folder, got the file results" in printed
    assert "Traceback" not in printed

    # not even root can create a folder there
    nowhere = "studies: [tiny]\nresults: /proc/results\n"
    unsolved.path("config/config.yaml").write_text(nowhere)
    printed = unsolved.snakemake("/proc/results/tiny/response.nc", code=1)
    assert "/proc/results: cannot be written (No such file or directory): change" in printed
    assert "Traceback" not in printed
    assert not jobs(printed, "Started")


def test_a_damaged_dataset_is_named_last_and_a_truncated_one_stops_a_run_before_any_job(project):
    dataset, figure = (project.path("results/tiny", n) for n in ("free.nc", "figures/free.svg"))
    whole, again = dataset.read_bytes(), "delete it and rerun; only missing files are recomputed"
    dataset.write_bytes(whole[:-100])
    printed = project.snakemake(code=2)
    lost = "results/tiny/free.nc: is truncated or was changed since it was written"
    assert printed.splitlines()[-1] == f"vibropipe: {lost}: {again}"
    assert not jobs(printed, "Started")
    assert figure.is_file()

    middle = len(whole) // 2
    dataset.write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :])
    figure.unlink()
    printed = project.snakemake(code=1)
    lost = "results/tiny/free.nc: is damaged (its checksum does not match)"
    assert printed.splitlines()[-1] == f"vibropipe: {lost}: {again}"


@pytest.mark.slow
def test_a_second_snakemake_is_refused_and_a_killed_one_can_be_resumed(unsolved, undisturbed):
    process = unsolved.start("--notemp", TARGET, **OFTEN)
    printed = read_until("Finished jobid", process)
    # its shards are short: it would be done before the second run is refused
    os.killpg(process.pid, signal.SIGSTOP)
    second = unsolved.snakemake("--notemp", TARGET, code=2, **OFTEN)
    assert f"vibropipe: results/tiny: another run makes it (process {process.pid} on " in second
    assert "Traceback" not in second
    kill(process, "everything", random.Random(0))
    printed += process.stdout.read()
    process.wait()
    # leftovers of another machine, of this cut and of another one: whether their writers still run is unknown
    for name in (".0002.nc.node-7.12.part", ".0009.nc.node-7.12.part"):
        unsolved.path("results/tiny/shards/response", name).write_bytes(b"half")
    resumed = unsolved.snakemake("--notemp", TARGET, **OFTEN)
    finished = jobs(printed, "Finished")
    assert finished
    assert not finished & jobs(resumed, "Started")
    check_whole(unsolved, undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("target", ["job", "snakemake", "everything"])
@pytest.mark.parametrize("seed", range(MOMENTS))
def test_whatever_is_killed_at_whatever_moment_nothing_is_lost(
    target, seed, unsolved, undisturbed, usual_seconds
):
    moment = random.Random(f"{target} {seed}").uniform(0.3, usual_seconds)
    disturbed(unsolved, undisturbed, target, moment, seed)
