"""Ctrl-C at any moment: one line, exit code 130, nothing left behind; in Python a normal exception."""

import random
import signal
import subprocess
import sys
import time

import pytest
from sharded_study import PROGRAM, read_until

import vibropipe as vp
from vibropipe.store import check_intact

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
