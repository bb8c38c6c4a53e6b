"""What runs is what the cache holds, in the process that first asks for it as in those after it."""

import os
import signal
import subprocess
import sys

import pytest

from vibropipe.compiler import client

TOLD = """
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

def noted(dispatcher, signature):
    events.append("begin")
    done = compile_once(dispatcher, signature)
    events.append("end")
    return done

client._compile_once = noted
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
    done = subprocess.run(**command(script, cache, **more), capture_output=True, check=True)
    return done.stdout.split()


def test_what_is_not_cached_is_compiled_apart_and_loaded(tmp_path):
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]
    # What a kernel calls is kept as a piece, without machine code.
    kept = {path.name.split("-")[0]: path for path in tmp_path.rglob("*.nbc")}
    assert sorted(kept) == ["load.force_at", "load.sincos_turns"]
    is_piece = {name: client.PIECES in path.parts for name, path in kept.items()}
    assert is_piece == {"load.force_at": False, "load.sincos_turns": True}
    holds_code = {name: b"\x7fELF" in path.read_bytes() for name, path in kept.items()}
    assert holds_code == {"load.force_at": True, "load.sincos_turns": False}
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]


def test_processes_that_need_one_kernel_wait_for_the_first_of_them(tmp_path):
    begun = [
        subprocess.Popen(
            **command(TOLD + FIRST_CALL, tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        for _ in range(3)
    ]
    ended = [process.communicate() for process in begun]
    assert [out.split() for out, _ in ended] == [["1", "0"]] * 3
    assert "".join(err for _, err in ended) == "compiling physics.load.force_at\n"


def test_kernels_that_are_known_beforehand_are_compiled_at_once(tmp_path):
    assert run(SIDE_BY_SIDE, tmp_path) == ["begin", "begin", "end", "end", "2"]
    assert run(SIDE_BY_SIDE, tmp_path) == ["0"]


def test_a_copy_of_the_package_in_the_folder_one_is_in_is_not_compiled(tmp_path):
    (tmp_path / "vibropipe").mkdir()
    (tmp_path / "vibropipe" / "__init__.py").write_text("raise ImportError('another copy')\n")
    call = command(FIRST_CALL, tmp_path / "cache")
    call["args"].insert(1, "-P")
    done = subprocess.run(**call, cwd=tmp_path, capture_output=True, check=True)
    assert done.stdout.split() == ["1", "0"]
    assert done.stderr == ""


def test_without_a_cache_it_is_compiled_apart_too_and_goes_with_the_process(tmp_path):
    blocked, scratch = tmp_path / "file", tmp_path / "scratch"
    blocked.touch()
    scratch.mkdir()
    assert run(FIRST_CALL, blocked, TMPDIR=str(scratch)) == ["1", "0"]
    assert not list(scratch.iterdir())


def test_without_locks_and_forks_it_is_compiled_apart_too(tmp_path):
    """As on Windows; the compiler, a process of its own, is started without them as well."""
    taken_away = (
        "import os, sys\n"
        "sys.modules['fcntl'] = None\n"
        "for name in ('fork', 'killpg', 'forkpty'):\n"
        "    vars(os).pop(name, None)\n"
    )
    (tmp_path / "sitecustomize.py").write_text(taken_away)
    assert run(FIRST_CALL, tmp_path / "cache", PYTHONPATH=str(tmp_path)) == ["1", "0"]
    assert list(tmp_path.rglob("*.nbc"))


def test_where_numba_has_other_private_parts_a_process_compiles_for_itself(tmp_path):
    taken_away = "import numba.core.codegen\ndel numba.core.codegen.JITCodeLibrary\n"
    (tmp_path / "sitecustomize.py").write_text(taken_away)
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


@pytest.mark.slow
def test_the_first_process_computes_what_those_after_it_do(tmp_path):
    first, second = run(CHAOTIC, tmp_path), run(CHAOTIC, tmp_path)
    assert int(first[0]) >= 3
    assert first == second
