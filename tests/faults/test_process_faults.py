"""Few cores, no kernel cache: the same numbers."""

import os

import pytest

from vibropipe.store import load


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
