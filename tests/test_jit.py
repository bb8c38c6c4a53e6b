"""What runs is what the cache holds, in the process that first asks for it as in those after it."""

import os
import signal
import subprocess
import sys

import pytest

from vibropipe import jit

FIRST_CALL = """
from vibropipe.physics.contact import force_at
from vibropipe.physics.exciter import Parameters
assert force_at(Parameters(1.0, 2.0, 0.0, 1.0, 0.0, 1.0, 1.0), 1.0, 0.25)[0] == 2.0
print(sum(force_at.stats.cache_hits.values()), sum(force_at.stats.cache_misses.values()))
"""
CHAOTIC = """
import hashlib
import numpy as np
import vibropipe as vp
rows = vp.sweep(
    vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7), {"f": [0.2], "nu": np.linspace(0.4, 1.4, 100)}
)
print((rows.regime == 5).sum().item(), hashlib.sha256(rows.displacement_strobe.values).hexdigest())
"""


def run(script, cache, **more):
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"VIBROPIPE_CACHE_DIR": str(cache)} | more,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_what_is_not_cached_is_compiled_apart_and_loaded(tmp_path):
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]
    # What a kernel calls is kept as a piece, without machine code.
    kept = {path.name.split("-")[0]: path for path in tmp_path.rglob("*.nbc")}
    assert sorted(kept) == ["contact.force_at", "forcing.sincos_turns"]
    is_piece = {name: jit.PIECES in path.parts for name, path in kept.items()}
    assert is_piece == {"contact.force_at": False, "forcing.sincos_turns": True}
    holds_code = {name: b"\x7fELF" in path.read_bytes() for name, path in kept.items()}
    assert holds_code == {"contact.force_at": True, "forcing.sincos_turns": False}
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]


def test_without_a_cache_it_is_compiled_apart_too_and_goes_with_the_process(tmp_path):
    blocked, scratch = tmp_path / "file", tmp_path / "scratch"
    blocked.touch()
    scratch.mkdir()
    assert run(FIRST_CALL, blocked, TMPDIR=str(scratch)) == ["1", "0"]
    assert not list(scratch.iterdir())


def test_a_compiler_that_has_ended_is_replaced():
    first = jit._compiler()
    assert jit._compiler() is first
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    assert jit._ask(first, b"task") == b""
    second = jit._compiler()
    assert second is not first
    second.kill()
    second.communicate()


@pytest.mark.slow
def test_the_first_process_computes_what_those_after_it_do(tmp_path):
    first, second = run(CHAOTIC, tmp_path), run(CHAOTIC, tmp_path)
    assert int(first[0]) >= 3
    assert first == second
