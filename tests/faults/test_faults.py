"""Damaged files, full disks, Ctrl-C at any moment, few cores: the message, what is left, the result of a rerun."""

import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

import pytest
from sharded_study import PROGRAM, read_until

import vibropipe as vp
from vibropipe.store import check_intact, load

MOMENTS = 40
INTERRUPTED_IMPORT = """\
import os, signal, sys

class Interrupted:
    def find_spec(self, name, path, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupted())
from vibropipe.cli import main
main()
"""
INTERRUPTED_SWEEP = """\
import os, random, signal, threading, time
import numpy as np
import vibropipe as vp

exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
few = {"f": [0.5, 1.0], "nu": [0.8, 1.0]}
before = vp.sweep(exciter, few)
many = {"f": np.linspace(0.1, 3, 2000), "nu": np.linspace(0.3, 3, 1000)}
longest, moments = 0.0, random.Random(1)
for _ in range(8):
    begin = time.perf_counter()
    try:
        interrupt = os.getpid(), signal.SIGINT
        threading.Timer(moments.uniform(0, 0.4), os.kill, interrupt).start()
        vp.sweep(exciter, many)
    except KeyboardInterrupt:
        longest = max(longest, time.perf_counter() - begin)
print(longest)
assert vp.sweep(exciter, few).identical(before)
print("as before")
"""


def check_end(process: subprocess.Popen) -> None:
    """Check that a program ends as specified after Ctrl-C; lines of progress are ignored."""
    printed = process.communicate(timeout=60)[1]
    assert process.returncode == 130, printed
    lines = [line for line in printed.splitlines() if not line.startswith("response")]
    assert lines == ["vibropipe: interrupted; completed files are kept, no partial file is left"]


@pytest.mark.parametrize("name", ["typer", "pydantic", "numba"])
def test_ctrl_c_while_libraries_are_loaded(name, work, tmp_path):
    code = INTERRUPTED_IMPORT.format(name=name)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    command = [
        sys.executable,
        "-c",
        code,
        *work.solve_arguments(tmp_path / "1.nc", "--shard", "1/3"),
    ]
    with subprocess.Popen(command, **pipes) as process:
        check_end(process)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(MOMENTS))
def test_ctrl_c_at_any_moment(seed, work, tmp_path):
    """From the first line of the program to the end of a job, about two seconds."""
    code = "print('begun', flush=True)\n" + PROGRAM[-1]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    output = tmp_path / "response.nc"
    with subprocess.Popen([*PROGRAM[:-1], code, *work.solve_arguments(output)], **pipes) as process:
        read_until("begun", process)
        # before this line the interpreter loads the package
        time.sleep(0.05 + random.Random(seed).uniform(0, 2))
        process.send_signal(signal.SIGINT)
        if output.exists():  # only the end of the interpreter was left
            assert "Traceback" not in process.communicate(timeout=60)[1]
            check_intact(output)
        else:
            check_end(process)
    assert {path.name for path in tmp_path.iterdir()} <= {"response.nc", "response.json"}


def test_ctrl_c_in_python_ends_a_sweep_at_any_moment_and_the_next_one_is_right():
    vp.sweep(vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7), {"nu": [0.8]})  # compiles, maybe for long
    command = [sys.executable, "-c", INTERRUPTED_SWEEP]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    seconds, then = done.stdout.splitlines()
    assert float(seconds) < 30
    assert then == "as before"


def truncated(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    damaged = bytearray(content)
    damaged[len(content) // 3] ^= 0x10
    return bytes(damaged)


def empty(_: bytes) -> bytes:
    return b""


@pytest.mark.parametrize("damage", [truncated, flipped, empty])
def test_a_damaged_shard_is_never_joined_and_solved_again_alone(damage, work, said, tmp_path):
    shard, output = work.shards[1], tmp_path / "joined.nc"
    whole = shard.read_bytes()
    try:
        shard.write_bytes(damage(whole))
        assert work.join(output) == 2
        told = said()
        assert str(shard) in told
        assert "delete it and rerun; only missing files are recomputed" in told
        assert not list(tmp_path.iterdir())
        shard.unlink()
        assert work.solve_shard(2) == 0
        assert shard.read_bytes() == whole
    finally:
        shard.write_bytes(whole)
    assert work.join(output) == 0
    assert output.read_bytes() == work.whole.read_bytes()


def test_on_a_full_disk_nothing_is_left_and_with_room_the_same_is_made(work, said, disk):
    place = disk("size=48k")
    (place / "other.bin").write_bytes(bytes(40_000))
    for verb in (work.join, work.solve):
        assert verb(place / "response.nc") == 1
        told = said()
        assert "response.nc: was not written: the disk is full" in told
        assert "Free disk space and rerun the command; completed files are kept" in told
        assert [path.name for path in place.iterdir()] == ["other.bin"]
    disk("size=4m")
    assert work.join(place / "response.nc") == 0
    assert (place / "response.nc").read_bytes() == work.whole.read_bytes()


def test_in_a_read_only_folder_nothing_is_touched(work, said, disk):
    place = disk("size=4m")
    shutil.copy(work.shards[0], place / "response.nc")
    before = (place / "response.nc").read_bytes()
    disk("ro")
    for verb, output in ((work.join, "response.nc"), (work.solve, "new/response.nc")):
        assert verb(place / output) == 1
        told = said()
        assert "response.nc: was not written: " in told
        assert "does not allow it (Read-only file system). Change its permissions" in told
    assert [path.name for path in place.iterdir()] == ["response.nc"]
    assert (place / "response.nc").read_bytes() == before


def test_a_write_cut_off_by_a_limit_leaves_nothing(work, tmp_path):
    def limited() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    done = work.solve_apart(tmp_path / "response.nc", preexec_fn=limited)
    assert done.returncode == 1
    assert "response.nc: was not written" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def one_core() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no choice of cores here")
def test_one_core_and_one_thread_give_the_same_values_to_the_last_bit(work, tmp_path):
    output = tmp_path / "response.nc"
    alone = os.environ | {"NUMBA_NUM_THREADS": "1"}
    done = work.solve_apart(output, "--threads", 2, env=alone, preexec_fn=one_core)
    assert done.returncode == 0, done.stderr
    one, other = load(output), load(work.whole)
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes()


@pytest.mark.slow
def test_without_a_kernel_cache_all_is_compiled_and_the_same(work, tmp_path):
    nowhere = os.environ | {"VIBROPIPE_CACHE_DIR": "/dev/null/cache"}
    output = tmp_path / "1.nc"
    done = work.solve_apart(output, "--shard", "1/3", env=nowhere)
    assert done.returncode == 0, done.stderr
    assert "the kernel cache /dev/null/cache" in done.stderr
    assert "Set VIBROPIPE_CACHE_DIR to a folder that can be written" in done.stderr
    assert output.read_bytes() == work.shards[0].read_bytes()
