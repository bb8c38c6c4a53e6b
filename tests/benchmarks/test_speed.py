"""The ratios that are asked, measured side by side: `pytest -m benchmark tests/benchmarks`."""

from __future__ import annotations

import math

import pytest

from vibropipe.bench.cases import items
from vibropipe.bench.measurement import measure

pytestmark = pytest.mark.benchmark
ROUNDS = 7


@pytest.fixture(scope="module")
def measured():
    found = items()
    measure(found, ROUNDS)
    return {item.name: item for item in found}


@pytest.mark.parametrize(
    ("item", "ours", "peer"),
    [
        ("one motion, exact", "exact", "heyoka, 1e-15"),
        ("one motion, exact", "exact", "DOP853, 1e-12"),
        ("newmark in lanes", "in lanes", "textbook loop"),
        ("sweep", "steady states", "heyoka, 1e-15"),
    ],
)
def test_as_many_times_cheaper_as_asked(measured, benchmark, item, ours, peer):
    found = measured[item]
    target = next(t for t in found.targets if (t.ours, t.peer) == (ours, peer))
    if found.find(peer).why_not is not None:
        pytest.skip(f"{peer}: {found.find(peer).why_not}")
    benchmark.pedantic(found.find(ours).ready.repeat, args=(1,), rounds=ROUNDS)
    ratio, low, high = found.ratios(target)
    benchmark.extra_info |= {"times cheaper": ratio, "quartiles": [low, high], "peer": peer}
    assert ratio >= target.times


def test_exact_errors_are_at_rounding(measured):
    error = measured["one motion, exact"].find("exact").error
    assert math.isfinite(error)
    assert error < 1e-13


def test_lanes_are_cheaper_than_the_scalar_path_too(measured, benchmark):
    found = measured["newmark in lanes"]
    benchmark.pedantic(found.find("one by one").ready.repeat, args=(1,), rounds=ROUNDS)
    assert found.find("one by one").quartiles()[0] > 2.5 * found.find("in lanes").quartiles()[0]
