"""The time of a point of a branch over that of a row of a sweep that settles at once, in the same rounds."""

from __future__ import annotations

from statistics import median
from time import perf_counter

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.outputs import OF_STEADY_STATE

pytestmark = pytest.mark.benchmark
ROUNDS, LARGEST_RATIO = 7, 20


def test_a_point_of_a_branch_costs_at_most_20_rows_of_a_sweep() -> None:
    exciter = vp.Exciter(l=0.5, nu=2.5, f=1.0, h=0.1, R1=0.8, R2=0.8)
    nu = np.linspace(1.6, 3.0, 1001)

    def per_point() -> float:
        start = perf_counter()
        branch = vp.branch(exciter, "nu", (1.6, 3.0), max_step=0.005)
        return (perf_counter() - start) / branch.sizes["point"]

    def per_row() -> float:
        start = perf_counter()
        vp.sweep(exciter, {"nu": nu}, follow=("nu", "up"), harmonics=6, outputs=OF_STEADY_STATE)
        return (perf_counter() - start) / nu.size

    per_point(), per_row()
    assert median(per_point() / per_row() for _ in range(ROUNDS)) <= LARGEST_RATIO
