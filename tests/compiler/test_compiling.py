"""Every process runs the kernels that the cache holds, also the process that first needs them."""

import os
import pickle
import signal
import subprocess
import sys

import numba
import pytest

from vibropipe.compiler import client

PRINTS_NAMES = """
import sys
from vibropipe.compiler import client
client.on_compiling.append(lambda name: print("compiling", name, file=sys.stderr))
"""
FIRST_CALL = """
from vibropipe.physics.load import force_at
from vibropipe.physics.exciter import Parameters
assert force_at(Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0), 1.0, 0.25)[0] == 2.0
print(sum(force_at.stats.cache_hits.values()), sum(force_at.stats.cache_misses.values()))
"""
SIDE_BY_SIDE = """
from vibropipe.compiler import client
from vibropipe.physics.load import force_at
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import free_flow
events, compile_once = [], client._compile_once

def recorded(dispatcher, signature):
    events.append("begin")
    completed = compile_once(dispatcher, signature)
    events.append("end")
    return completed

client._compile_once = recorded
p = Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0)
client.compile_side_by_side([lambda: force_at(p, 1.0, 0.25), lambda: free_flow(0.2, 1.0)], 2)
print(*events, len(client._idle))
"""
CHAOTIC = """
import hashlib
import numpy as np
import vibropipe as vp
from vibropipe.words.regimes import Regime
rows = vp.sweep(
    vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7), {"f": [0.2], "nu": np.linspace(0.4, 1.4, 100)}
)
print((rows.regime == Regime.APERIODIC).sum().item(), hashlib.sha256(rows.displacement_strobe.values).hexdigest())
"""


def command(script, cache, **more):
    environment = os.environ | {"VIBROPIPE_CACHE_DIR": str(cache)} | more
    return {"args": [sys.executable, "-c", script], "env": environment, "text": True}


def run(script, cache, **more):
    completed = subprocess.run(**command(script, cache, **more), capture_output=True, check=True)
    return completed.stdout.split()


def test_a_missing_kernel_is_compiled_in_another_process_and_loaded(tmp_path):
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]
    # Functions that a kernel calls are cached as pieces, without machine code.
    files = {path.name.split("-")[0]: path for path in tmp_path.rglob("*.nbc")}
    pieces = {name for name, path in files.items() if client.PIECES in path.parts}
    assert pieces == {"load.force_of_angle", "turns.sincos_turns"}
    holds_code = {name for name, path in files.items() if b"\x7fELF" in path.read_bytes()}
    assert holds_code == {"load.force_at"} == set(files) - pieces
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]


def test_processes_that_need_one_kernel_compile_it_once(tmp_path):
    processes = [
        subprocess.Popen(
            **command(PRINTS_NAMES + FIRST_CALL, tmp_path),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for _ in range(3)
    ]
    outputs = [process.communicate() for process in processes]
    assert [out.split() for out, _ in outputs] == [["1", "0"]] * 3
    assert "".join(err for _, err in outputs) == "compiling physics.load.force_at\n"


def test_known_kernels_are_compiled_side_by_side(tmp_path):
    assert run(SIDE_BY_SIDE, tmp_path) == ["begin", "begin", "end", "end", "2"]
    assert run(SIDE_BY_SIDE, tmp_path) == ["0"]


def test_a_copy_of_the_package_in_the_working_directory_is_ignored(tmp_path):
    (tmp_path / "vibropipe").mkdir()
    (tmp_path / "vibropipe" / "__init__.py").write_text("raise ImportError('another copy')\n")
    call = command(FIRST_CALL, tmp_path / "cache")
    call["args"].insert(1, "-P")
    completed = subprocess.run(**call, cwd=tmp_path, capture_output=True, check=True)
    assert completed.stdout.split() == ["1", "0"]
    assert completed.stderr == ""


def test_without_a_writable_cache_kernels_are_temporary(tmp_path):
    blocked, scratch = tmp_path / "file", tmp_path / "scratch"
    blocked.touch()
    scratch.mkdir()
    assert run(FIRST_CALL, blocked, TMPDIR=str(scratch)) == ["1", "0"]
    assert not list(scratch.iterdir())


def test_without_locks_and_forks_another_process_compiles(tmp_path):
    """As on Windows; the compiling process is started without them as well."""
    removal = (
        "import os, sys\n"
        "sys.modules['fcntl'] = None\n"
        "for name in ('fork', 'killpg', 'forkpty'):\n"
        "    vars(os).pop(name, None)\n"
    )
    (tmp_path / "sitecustomize.py").write_text(removal)
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["1", "0"]
    assert list(tmp_path.rglob("*.nbc"))


def test_without_private_parts_of_numba_a_process_compiles_for_itself(tmp_path):
    removal = "import numba.core.codegen\ndel numba.core.codegen.JITCodeLibrary\n"
    (tmp_path / "sitecustomize.py").write_text(removal)
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["0", "1"]


def test_a_compiler_that_has_ended_is_replaced():
    first = client._compiler()
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    client._idle.append((os.getpid(), first))
    second = client._compiler()
    assert second is not first
    second.kill()
    second.communicate()


def test_a_compiler_finishes_its_task_in_silence_if_its_client_is_killed(tmp_path):
    task = pickle.dumps(("vibropipe.physics.turns", "sincos_turns", (numba.float64,)))
    served = command(client.COMMAND, tmp_path, **{client.COMPILER: client.SERVES})
    served |= {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(**{**served, "text": False}) as compiler:
        compiler.stdout.close()
        compiler.stdin.write(task)
        compiler.stdin.close()
        assert compiler.stderr.read() == b""
    assert compiler.returncode == 0
    assert any(b"\x7fELF" in path.read_bytes() for path in tmp_path.rglob("*.nbc"))


@pytest.mark.slow
def test_the_first_process_computes_the_same_bits_as_later_ones(tmp_path):
    first, second = run(CHAOTIC, tmp_path), run(CHAOTIC, tmp_path)
    assert int(first[0]) >= 3
    assert first == second
