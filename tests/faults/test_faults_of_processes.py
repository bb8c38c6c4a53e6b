"""Few cores, no kernel cache, Ctrl-C in Python: the same numbers, or an end without harm."""

import os
import subprocess
import sys

import pytest

from vibropipe.store import read

INTERRUPTED_SWEEP = """\
import os, signal, threading, time
import numpy as np
import vibropipe as vp

exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
few = {"f": [0.5, 1.0], "nu": [0.8, 1.0]}
before = vp.sweep(exciter, few)
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
begin = time.perf_counter()
try:
    vp.sweep(exciter, {"f": np.linspace(0.1, 3, 2000), "nu": np.linspace(0.3, 3, 1000)})
except KeyboardInterrupt:
    print(f"{time.perf_counter() - begin:.1f}")
assert vp.sweep(exciter, few).identical(before)
print("as before")
"""


def one_core() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no choice of cores here")
def test_one_core_and_one_thread_give_the_same_values_to_the_last_bit(work, tmp_path):
    output = tmp_path / "response.nc"
    alone = os.environ | {"NUMBA_NUM_THREADS": "1"}
    done = work.solve_apart(output, "--threads", 2, env=alone, preexec_fn=one_core)
    assert done.returncode == 0, done.stderr
    one, other = read(output), read(work.whole)
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


def test_ctrl_c_in_python_ends_a_sweep_and_the_next_one_is_right():
    command = [sys.executable, "-c", INTERRUPTED_SWEEP]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    seconds, then = done.stdout.splitlines()
    assert float(seconds) < 30
    assert then == "as before"
