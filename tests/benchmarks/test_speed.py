"""Target ratios, measured in the same rounds: `pytest -m benchmark tests/benchmarks`."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from lane_rows import newmark_item

import vibropipe as vp
from vibropipe.lab.bench import measure
from vibropipe.lab.bench_items import items

pytestmark = pytest.mark.benchmark
ROUNDS = 7


@pytest.fixture(scope="module")
def measured():
    all_items = [*items(), newmark_item()]
    measure(all_items, ROUNDS)
    return {item.name: item for item in all_items}


@pytest.mark.parametrize(
    ("item", "ours", "peer"),
    [
        ("one motion, exact", "exact", "heyoka, 1e-15"),
        ("one motion, exact", "exact", "DOP853, 1e-12"),
        ("newmark in lanes", "in lanes", "textbook loop"),
        ("sweep", "steady states", "heyoka, 1e-15"),
        ("sweep", "steady states", "textbook loop"),
        ("branch", "branch", "followed sweep"),
    ],
)
def test_the_ratio_meets_its_target(measured, benchmark, item, ours, peer):
    measured_item = measured[item]
    target = next(t for t in measured_item.targets if (t.ours, t.peer) == (ours, peer))
    if measured_item.find(peer).why_not is not None:
        pytest.skip(f"{peer}: {measured_item.find(peer).why_not}")
    benchmark.pedantic(measured_item.find(ours).ready.repeat, args=(1,), rounds=ROUNDS)
    ratio, low, high = measured_item.ratios(target)
    benchmark.extra_info |= {"times faster": ratio, "quartiles": [low, high], "peer": peer}
    assert ratio >= target.times


def test_exact_errors_are_at_rounding(measured):
    error = measured["one motion, exact"].find("exact").error
    assert math.isfinite(error)
    assert error < 1e-13


def test_lanes_are_faster_than_the_scalar_kernel(measured, benchmark):
    item = measured["newmark in lanes"]
    benchmark.pedantic(item.find("one by one").ready.repeat, args=(1,), rounds=ROUNDS)
    assert item.find("one by one").quartiles()[0] > 2.5 * item.find("in lanes").quartiles()[0]


def test_a_million_starts_take_10_seconds_of_two_cores():
    """Measured by CPU time, since the threads share the starts evenly."""
    exciter = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
    vp.basins(exciter, [0.0], [0.0])  # loads the kernels
    begin = time.process_time()
    basins = vp.basins(exciter, np.linspace(-0.4, 0.6, 1000), np.linspace(-2, 2, 1000))
    assert time.process_time() - begin < 2 * 10
    assert (basins.attractor >= 0).all()
