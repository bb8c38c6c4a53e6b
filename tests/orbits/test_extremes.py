"""Stationary points of a flight: against the closed form of a free motion and dense textbook samples."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from textbook import Flight

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.boundary.closed_flights import flight_extremes


def test_a_free_motion_turns_at_its_amplitude() -> None:
    p = Parameters(1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 1.0)
    least, most = flight_extremes(p, 0.0, 0.3, -0.4, 2)
    assert (least, most) == pytest.approx((-0.5, 0.5), rel=1e-14)
    # a quarter of the period downwards: it turns nowhere
    assert flight_extremes(p._replace(nu=2.0), 0.0, 0.5, -1e-9, 1) == (math.inf, -math.inf)


def test_with_damping_the_first_minimum_is_the_least() -> None:
    h, x = 0.2, 0.7
    omega = math.sqrt(1 - h * h / 4)
    least, most = flight_extremes(Parameters(0.1, 0.0, h, 0.5, 0.0, 1.0, 1.0), 0.25, x, 0.0, 2)
    assert least == pytest.approx(-x * math.exp(-0.5 * h * math.pi / omega), rel=1e-13)
    assert most == pytest.approx(x * math.exp(-h * math.pi / omega), rel=1e-13)


@given(
    nu=st.floats(0.2, 8),
    h=st.sampled_from([0.0, 0.1, 2.0, 7.0]),
    turn=st.floats(0, 0.999),
    x=st.floats(-1, 1),
    v=st.floats(-2, 2),
    n=st.integers(1, 5),
)
def test_they_are_those_of_dense_samples(
    nu: float, h: float, turn: float, x: float, v: float, n: int
) -> None:
    p = Parameters(nu, 1.0, h, 0.5, 0.0, 1.0, 1.0)
    start = 2 * math.pi * turn / nu
    flight = Flight(mpmath.fp, nu, 1.0, h, (start, x, v)) if nu != 1 or h > 0 else None
    if flight is None or abs(nu - 1) < 1e-6:
        return
    tau = start + np.linspace(0, n * math.pi / nu, 3001)
    xs = np.array([flight(t)[0] for t in tau])
    minima = xs[1:-1][(xs[1:-1] < xs[:-2]) & (xs[1:-1] < xs[2:])]
    maxima = xs[1:-1][(xs[1:-1] > xs[:-2]) & (xs[1:-1] > xs[2:])]
    least, most = flight_extremes(p, turn, x, v, n)
    # samples miss a stationary point between the first or last two of them, and one of a height below rounding
    if minima.size:
        assert least <= minima.min() + 1e-12
    if maxima.size:
        assert most >= maxima.max() - 1e-12
    bound = 1e-4 * max(1.0, abs(xs).max(), (n * math.pi / nu) ** 2)
    assert not math.isfinite(least) or least >= xs.min() - bound
    assert not math.isfinite(most) or most <= xs.max() + bound
