"""Target ratios, measured in the same rounds: `pytest -m benchmark tests/benchmarks`."""

from __future__ import annotations

import math

import pytest

from vibropipe.bench.cases import items
from vibropipe.bench.measurement import measure

pytestmark = pytest.mark.benchmark
ROUNDS = 7


@pytest.fixture(scope="module")
def measured():
    all_items = items()
    measure(all_items, ROUNDS)
    return {item.name: item for item in all_items}


@pytest.mark.parametrize(
    ("item", "ours", "peer"),
    [
        ("one motion, exact", "exact", "heyoka, 1e-15"),
        ("one motion, exact", "exact", "DOP853, 1e-12"),
        ("newmark in lanes", "in lanes", "textbook loop"),
        ("sweep", "steady states", "heyoka, 1e-15"),
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
