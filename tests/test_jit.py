"""What runs is what the cache holds, in the process that first asks for it as in those after it."""

import os
import subprocess
import sys

import pytest

FIRST_CALL = """
from vibropipe.physics.contact import reset
assert reset(0.5, 2.0) == 1.0
print(sum(reset.stats.cache_hits.values()), sum(reset.stats.cache_misses.values()))
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
    assert run(FIRST_CALL, tmp_path) == ["1", "0"]


def test_without_a_cache_it_is_compiled_apart_too_and_goes_with_the_process(tmp_path):
    blocked, scratch = tmp_path / "file", tmp_path / "scratch"
    blocked.touch()
    scratch.mkdir()
    assert run(FIRST_CALL, blocked, TMPDIR=str(scratch)) == ["1", "0"]
    assert not list(scratch.iterdir())


@pytest.mark.slow
def test_the_first_process_computes_what_those_after_it_do(tmp_path):
    first, second = run(CHAOTIC, tmp_path), run(CHAOTIC, tmp_path)
    assert int(first[0]) >= 3
    assert first == second
