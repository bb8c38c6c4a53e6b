"""Closed forms of orbits: each solution closes in many digits, from resonance to strong damping."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from strategies import log, signed
from textbook import Flight, Parameters, digits

from vibropipe.physics.closed_orbits import (
    FlightTerms,
    Response,
    first_impact_force,
    flight_multipliers,
    flight_terms,
    flip_condition,
    flip_velocity,
    fold_condition,
    fold_velocity,
    forcing_at_impact,
    impact_phase,
    impact_velocities,
    response,
)

DAMPINGS = st.one_of(st.sampled_from([0.0, 2.0, 2 + 1e-12, 2 - 1e-12]), log(-12, 2))
FREQUENCIES = st.one_of(
    st.sampled_from([1.0, 1 + 1e-9, 1 - 1e-12, 0.5, 2.0, 1 / 3]), log(-1.5, 1.5)
)

# few exciters of the whole space have the bifurcation
rare = settings(max_examples=50, suppress_health_check=[HealthCheck.filter_too_much])


@st.composite
def families(draw: Any) -> tuple[float, float, float, int, float]:
    """Return nu, h, R, n, b."""
    R = draw(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0, 1)))
    b = draw(st.one_of(st.sampled_from([0.0, 0.5]), signed(log(-2, 1))))
    return draw(FREQUENCIES), draw(DAMPINGS), R, draw(st.integers(1, 8)), b


def solved(nu: float, h: float, R: float, n: int) -> tuple[FlightTerms, Response]:
    terms = flight_terms(nu, h, n)
    return terms, response(nu, h, R, terms)


def end_of_flight(
    nu: float, f: float, h: float, R: float, n: int, b: float, turn: Any, v: Any
) -> Any:
    """Return (-1)^n (x, x') half n periods after the impact, in 40 digits or more."""
    c = digits(Parameters(nu=nu, f=f, h=h), 40)
    nu, f, h, R, b = (c.mpf(value) for value in (nu, f, h, R, b))
    tau, duration = 2 * c.pi * c.mpf(turn) / nu, n * c.pi / nu
    x, w = Flight(c, nu, f, h, (tau, b, -R * c.mpf(v)))(tau + duration)
    return (-1) ** n * x, (-1) ** n * w


@settings(max_examples=100)
@given(families(), signed(log(-2, 2)))
def test_every_solution_closes(family: Any, f: float) -> None:
    nu, h, R, n, b = family
    terms, r = solved(nu, h, R, n)
    for v in map(float, impact_velocities(f, b, r)):
        if not math.isfinite(v):
            continue
        turn = float(impact_phase(f, forcing_at_impact(b, v, r)))
        assert 0 <= turn < 1
        x, w = end_of_flight(nu, f, h, R, n, b, turn, v)
        # a rounding of phase or force moves the end by that share of the forced motion
        growth = min(float(terms.duration), 1 / h if h > 0 else math.inf)
        size = abs(b) + v + abs(f) * max(1.0, nu) * growth
        assert abs(float(x - b)) <= 1e-13 * size
        assert abs(float(w - v)) <= 1e-13 * size * max(1.0, nu)


@pytest.mark.parametrize(
    ("nu", "h", "R", "n", "b", "f"),
    [
        (1.6, 0.1, 0.7, 1, 0.5, 1.0),
        (2.3, 0.1, 0.8, 2, 0.0, -1.0),
        (1.05, 0.1, 0.8, 1, 0.5, 0.06),
        (3.7, 0.05, 0.9, 6, 0.1, 0.5),
        (0.7, 2.0, 0.5, 1, 0.5, 2.0),
        (1.2, 5.0, 0.3, 2, -0.2, 4.0),
    ],
)
def test_both_roots_to_many_digits(
    nu: float, h: float, R: float, n: int, b: float, f: float
) -> None:
    _terms, r = solved(nu, h, R, n)
    roots = [float(v) for v in impact_velocities(f, b, r) if v > 0]
    assert roots
    for v in roots:
        turn = float(impact_phase(f, forcing_at_impact(b, v, r)))

        def residual(u: Any, w: Any) -> Any:
            x, after = end_of_flight(nu, f, h, R, n, b, u, w)
            return x - b, after - w

        with mpmath.workdps(40):
            exact = mpmath.findroot(residual, (turn, v), tol=1e-60)
            assert abs(exact[0] - turn) < 2e-15
            assert abs(exact[1] - v) < 4e-15 * max(1.0, v)


def test_the_resonance_without_damping_has_the_limit() -> None:
    for n in range(1, 7):
        terms, r = solved(1.0, 0.0, 0.6, n)
        assert terms.determinant == 0
        v, _ = impact_velocities(-0.3, 0.5, r)
        assert v == pytest.approx(0.5 * n * math.pi * 0.3 / 1.6, rel=1e-15)
        near = impact_velocities(-0.3, 0.5, solved(1 + 1e-9, 1e-9, 0.6, n)[1])[0]
        assert near == pytest.approx(v, rel=1e-7)


@pytest.mark.parametrize(("nu", "n"), [(0.5, 2), (2.0, 4), (1 / 3, 1), (2 / 3, 4)])
def test_a_free_period_without_damping_leaves_no_orbit(nu: float, n: int) -> None:
    terms, r = solved(nu, 0.0, 0.6, n)
    if nu == 0.5 or nu == 2.0:
        assert terms.determinant == 0
    roots = impact_velocities(1.0, 0.5, r)
    assert all(not v > 1e-12 for v in roots)


@rare
@given(families())
def test_the_fold_is_where_the_roots_meet(family: Any) -> None:
    nu, h, R, n, b = family
    terms, r = solved(nu, h, R, n)
    b = -math.copysign(b, float(r.impulses.imag))  # else there is no fold
    v = float(fold_velocity(b, r))
    assume(math.isfinite(v) and 1e-6 < v < 1e6)
    f = float(abs(forcing_at_impact(b, v, r)))
    # beyond the first impact of the linear motion one root is left
    assume(f > 1e-6 and f * (1 + 1e-5) < abs(b * complex(r.stiffness)))
    # the derivative has the eigenvalue 1 there: both equations name one place
    scale = (
        1 + R * R * float(terms.decay) + abs(float(fold_condition(nu, b, R, math.inf, terms, r)))
    )
    assert abs(float(fold_condition(nu, b, R, v, terms, r))) <= 1e-9 * scale
    assert np.isnan(impact_velocities(f * (1 - 1e-9), b, r)).all()
    upper, lower = impact_velocities(f * (1 + 1e-6), b, r)
    assert lower < v < upper
    assert fold_condition(nu, b, R, lower, terms, r) < 0 < fold_condition(nu, b, R, upper, terms, r)


@rare
@given(families())
def test_the_flip_has_the_multiplier_minus_one(family: Any) -> None:
    nu, h, R, n, b = family
    terms, r = solved(nu, h, R, n)
    v = float(flip_velocity(nu, b, R, terms, r))
    assume(math.isfinite(v) and 1e-6 < v < 1e6)
    larger, smaller = flight_multipliers(nu, b, R, v, terms, r)
    nearest = min(abs(larger + 1), abs(smaller + 1))
    # two multipliers near -1 move by the root of a rounding
    assert nearest <= (1e-10 if abs(larger - smaller) > 1e-4 else 1e-6)
    step = 1e-4 * v
    below, above = (flip_condition(nu, b, R, v + s, terms, r) for s in (-step, step))
    assert below * above < 0
    assert fold_condition(nu, b, R, v, terms, r) >= 0


@settings(max_examples=100)
@given(families(), st.floats(0.01, 10))
def test_multipliers_have_the_product_and_the_conditions(family: Any, v: float) -> None:
    nu, h, R, n, b = family
    terms, r = solved(nu, h, R, n)
    assume(np.isfinite(r.impact))
    one, two = flight_multipliers(nu, b, R, v, terms, r)
    product = R * R * math.exp(-h * n * math.pi / nu)
    assert abs(one) >= abs(two) * (1 - 1e-12)
    assert one * two == pytest.approx(product, rel=1e-9, abs=1e-300)
    fold = (1 - one) * (1 - two)
    flip = (1 + one) * (1 + two)
    size = (1 + abs(one)) * (1 + abs(two))
    assert abs(fold - fold_condition(nu, b, R, v, terms, r)) <= 1e-12 * size
    assert abs(flip - flip_condition(nu, b, R, v, terms, r)) <= 1e-12 * size


@rare
@given(families())
def test_the_first_impact_is_a_root_of_zero_velocity(family: Any) -> None:
    nu, h, R, n, b = family
    _terms, r = solved(nu, h, R, n)
    f = float(first_impact_force(b, r))
    if b <= 0:
        assert math.isnan(f)
        return
    assume(f > 1e-9 and np.isfinite(r.impact))
    assert f == pytest.approx(b * abs(complex((1 - nu) * (1 + nu), h * nu)), rel=1e-14)
    # beyond it there is one root; short of it there are two or none
    assert np.isfinite(impact_velocities(f * (1 + 1e-9), b, r)).tolist() == [True, False]
    assert np.isfinite(impact_velocities(f * (1 - 1e-9), b, r)).tolist() in (
        [True] * 2,
        [False] * 2,
    )


def test_arrays_are_broadcast() -> None:
    nu, R = np.linspace(0.5, 3, 7), np.array([[0.5], [0.8]])
    terms = flight_terms(nu, 0.1, 1)
    r = response(nu, 0.1, R, terms)
    upper, _ = impact_velocities(1.0, 0.5, r)
    assert upper.shape == (2, 7)
    one = impact_velocities(1.0, 0.5, solved(float(nu[3]), 0.1, 0.8, 1)[1])[0]
    assert upper[1, 3] == pytest.approx(float(one), rel=1e-15)
