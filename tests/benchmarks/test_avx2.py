"""Newmark in lanes with four floats per vector register: compiled for a processor with AVX2 only."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import pytest

FEATURES = dict(llvm.get_host_cpu_features())
WIDER = {name for name in FEATURES if "avx512" in name or name.startswith("avx10")}
TESTS = Path(__file__).parents[1]

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not FEATURES.get("avx2"), reason="no AVX2")]

MEASURE = """
import json
import numba
import numpy as np
from lane_rows import _drive, newmark_item
from newmark_lanes import SIZE, STRIDE, advance_block
from vibropipe.lab.bench import measure

item = newmark_item()
measure([item], 7)
compiled_for = [key[1] for key in _drive._cache._cache_file._load_index()]
alone = numba.jit(**advance_block.targetoptions)(advance_block.py_func)
alone(np.zeros(SIZE), np.zeros(2 * STRIDE), STRIDE)
(code,) = alone.inspect_asm().values()
(target,) = item.targets
print(json.dumps([item.ratios(target)[0], target.times, compiled_for, code]))
"""


@pytest.fixture(scope="module")
def without_avx512(tmp_path_factory):
    """Environment in which numba compiles for AVX2, into a cache of its own."""
    features = ["-" + name for name in WIDER] + [
        ("+" if is_present else "-") + name
        for name, is_present in FEATURES.items()
        if name not in WIDER
    ]
    return os.environ | {
        "PYTHONPATH": str(TESTS / "benchmarks"),
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": ",".join(sorted(features)),
        "VIBROPIPE_CACHE_DIR": str(tmp_path_factory.mktemp("avx2")),
    }


def run(environment: dict[str, str], *arguments: str) -> str:
    process = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


def test_the_ratio_of_lanes_meets_its_target(without_avx512):
    ratio, target, compiled_for, code = json.loads(run(without_avx512, "-c", MEASURE))
    # The timed kernel came from the cache and was compiled for one processor, without wide registers.
    ((_triple, processor, features),) = compiled_for
    assert (processor, features) == ("haswell", without_avx512["NUMBA_CPU_FEATURES"])
    assert "%ymm" in code
    assert "%zmm" not in code
    assert target == 3
    print(f"in lanes against the textbook loop: {ratio:.1f} times faster")
    assert ratio >= target


def test_lanes_are_the_scalar_path_to_the_last_bit(without_avx512):
    run(
        without_avx512,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        str(TESTS / "benchmarks" / "test_lanes.py"),
        "-m",
        "benchmark",
    )
