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
    predict,
    solve_factorised,
    verdict,
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


def test_the_tangent_points_along_the_plane() -> None:
    """On the unit circle from (1, 0) along its tangent: the plane across it is y = 0.3."""
    work, weights, u = new_work(2), np.array([1.0, 2.0]), np.empty(2)
    start, tangent = np.array([1.0, 0.0]), np.array([0.0, 0.5])
    target = predict(start, tangent, 0.6, weights, work.border, u)
    assert u == pytest.approx([1.0, 0.3])
    assert work.border @ u == pytest.approx(target)
    on_circle, new = np.array([math.sqrt(0.91), 0.3]), np.empty(2)
    work.matrix[:] = [2.0 * on_circle, work.border]
    factorise(work.matrix, work.pivots)
    fill_tangent(weights, work, new)
    assert new @ on_circle == pytest.approx(0.0, abs=1e-15)
    assert np.linalg.norm(new * weights) == pytest.approx(1.0)
    assert new[1] > 0.0


@pytest.mark.parametrize(
    ("change", "previous", "said"),
    [
        (1e-13, 1.0, DONE),
        (1e-3, 1e-1, GOES_ON),
        (9e-9, 1e-8, DONE),  # rounding: small, and decreases no more
        (1e-9, 1e-8, GOES_ON),
        (0.6, math.inf, FAILED),
        (math.nan, 1.0, FAILED),
    ],
)
def test_changes_say_whether_newtons_method_goes_on(change, previous, said) -> None:
    assert verdict(change, previous) == said
