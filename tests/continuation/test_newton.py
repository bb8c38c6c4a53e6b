"""Linear systems and Newton steps of continuation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vibropipe.continuation.newton import (
    DONE,
    FAILED,
    GOES_ON,
    factorise,
    fill_tangent,
    new_work,
    newton_step,
    predict,
    solve_factorised,
)


def test_systems_are_solved_with_pivots() -> None:
    rng = np.random.default_rng(0)
    for size in (1, 2, 5, 20):
        a, b = rng.normal(size=(size, size)), rng.normal(size=size)
        a[0, 0] = 0.0 if size > 1 else 1.0
        factors, solution, pivots = a.copy(), b.copy(), np.zeros(size, np.int64)
        factorise(factors, pivots)
        solve_factorised(factors, pivots, solution)
        assert a @ solution == pytest.approx(b, abs=1e-10)


def test_a_zero_pivot_gives_the_null_vector() -> None:
    a, b, pivots = np.array([[1.0, 2.0], [2.0, 4.0]]), np.array([0.0, 1.0]), np.zeros(2, np.int64)
    factorise(a, pivots)
    solve_factorised(a, pivots, b)
    assert b / b[1] == pytest.approx([-2.0, 1.0])


def test_steps_end_on_the_plane_across_the_prediction() -> None:
    """On the unit circle from (1, 0) along its tangent: the plane across it is y = 0.3."""
    work, weights, u = new_work(2), np.array([1.0, 2.0]), np.empty(2)
    start, tangent = np.array([1.0, 0.0]), np.array([0.0, 0.5])
    target, said, steps = predict(start, tangent, 0.6, weights, work.border, u), GOES_ON, 0
    assert u == pytest.approx([1.0, 0.3])
    work.last[0] = math.inf
    while said == GOES_ON:
        work.rhs[0], work.matrix[0] = u @ u - 1.0, 2.0 * u
        said, steps = newton_step(u, target, weights, work), steps + 1
    assert said == DONE
    assert steps <= 5
    assert u == pytest.approx([math.sqrt(0.91), 0.3], abs=1e-15)
    new = np.empty(2)
    fill_tangent(weights, work, new)
    assert new @ u == pytest.approx(0.0, abs=1e-8)
    assert np.linalg.norm(new * weights) == pytest.approx(1.0)
    assert new[1] > 0.0


def test_a_step_that_leaves_the_curve_fails() -> None:
    work, u = new_work(1), np.array([3.0])
    work.border[:], work.last[0] = 1.0, math.inf
    assert newton_step(u, 0.0, np.ones(1), work) == FAILED
    assert u == [3.0]
