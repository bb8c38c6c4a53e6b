"""The exact motion between impacts against closed forms, Newmark's step, and complex division."""

from __future__ import annotations

import cmath
import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from strategies import log

import vibropipe as vp
from vibropipe.compiler import jit
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.flow import (
    DEGREE,
    REACH,
    combine,
    displacement,
    exact_map,
    fastest_rate,
    fill_basis,
    free_flow,
    motion,
    new_basis,
    steps_for_exact,
    taylor,
    velocity,
)
from vibropipe.physics.load import Force, force_at
from vibropipe.physics.newmark import mean_acceleration, newmark_map, step
from vibropipe.physics.piece import flight_over, flown
from vibropipe.physics.quotient import divide

RATES = [
    (1.0, 0.0),
    (1.0, 0.2),
    (1.0 + 1e-9, 0.0),
    (0.3, 2.0),
    (2.2, 2.0 + 1e-12),
    (1.0, 5.0),
    (200.0, 0.2),
]


def basis_of(h, nu, dt):
    """Return the basis of a step."""
    basis = new_basis(None)
    fill_basis(basis, h, nu, dt, None)
    return basis


def exact_state(nu, h, y, w, load, s, c, t):
    """Return (y, y') at t of y'' = load + force - h y' - y, by the matrix exponential in 40 digits."""
    with mp.workdps(40):
        a = mp.matrix(
            [
                [0, 1, 0, 0, 0],
                [-1, -mp.mpf(h), 1, 1, 0],
                [0, 0, 0, 0, 0],
                [0, 0, 0, 0, nu],
                [0, 0, 0, -mp.mpf(nu), 0],
            ]
        )
        z = mp.expm(a * mp.mpf(t)) * mp.matrix([y, w, load, s, c])
        return float(z[0]), float(z[1])


@pytest.mark.parametrize(("nu", "h"), RATES)
def test_one_polynomial_covers_a_step_to_rounding(nu: float, h: float) -> None:
    dt = 2 * math.pi / nu / steps_for_exact(nu, h)
    c = np.empty(DEGREE + 1)
    taylor(c, 0.3, -0.7, Force(0.4, -0.9), 0.2, h, nu, dt)
    for theta in (0.0, 0.3, 1.0):
        y, w = exact_state(nu, h, 0.3, -0.7, 0.2, 0.4, -0.9, theta * dt)
        assert displacement(c, DEGREE, theta) == pytest.approx(y, abs=1e-15)
        assert velocity(c, DEGREE, theta, dt) == pytest.approx(w, abs=3e-15)
        assert motion(c, theta, dt) == pytest.approx((y, w), abs=3e-15)


@pytest.mark.parametrize(("nu", "h"), RATES)
def test_the_basis_adds_up_to_the_recurrence(nu: float, h: float) -> None:
    dt = REACH / fastest_rate(nu, h)
    one, other = np.empty(DEGREE + 1), np.empty(DEGREE + 1)
    taylor(one, 0.3, -0.7, Force(0.4, -0.9), 0.2, h, nu, dt)
    combine(ALL_EFFECTS, basis_of(h, nu, dt), other, 0.3, -0.7, 0.2, Force(0.4, -0.9))
    np.testing.assert_allclose(other, one, rtol=0, atol=2e-16)


@pytest.mark.parametrize(("nu", "h"), RATES)
def test_the_one_step_map_is_the_polynomial_at_its_end(nu: float, h: float) -> None:
    dt = REACH / fastest_rate(nu, h)
    (a11, a12, b1, a21, a22, b2), (p1, p2, q1, q2) = exact_map(basis_of(h, nu, dt), dt)
    y, w = exact_state(nu, h, 0.3, -0.7, 0.2, 0.4, -0.9, dt)
    assert a11 * 0.3 - a12 * 0.7 + b1 * 0.2 + p1 * 0.4 - p2 * 0.9 == pytest.approx(y, abs=1e-15)
    assert a21 * 0.3 - a22 * 0.7 + b2 * 0.2 + q1 * 0.4 - q2 * 0.9 == pytest.approx(w, abs=3e-15)
    assert a11 * a22 - a12 * a21 == pytest.approx(math.exp(-h * dt), rel=1e-14)


@given(h=st.floats(0, 50), t=st.floats(0, 30))
def test_the_free_flow_is_a_group_with_the_right_determinant(h: float, t: float) -> None:
    whole, half = (
        np.array(free_flow(h, t)).reshape(2, 2),
        np.array(free_flow(h, t / 2)).reshape(2, 2),
    )
    np.testing.assert_allclose(half @ half, whole, rtol=0, atol=1e-12)
    # Two halves: the determinant of the whole is lost in rounding where its terms are not small.
    assert np.linalg.det(half) == pytest.approx(math.exp(-h * t / 2), abs=1e-13)


@pytest.mark.parametrize("h", [0.0, 0.2, 1.999999, 2.0, 2.000001, 5.0, 1e4])
@pytest.mark.parametrize("t", [0.0, 1e-9, 0.3, 7.0])
def test_the_free_flow_against_forty_digits(h: float, t: float) -> None:
    for column, (y, w) in enumerate([(1.0, 0.0), (0.0, 1.0)]):
        flow = free_flow(h, t)[column], free_flow(h, t)[column + 2]
        assert flow == pytest.approx(exact_state(1.0, h, y, w, 0, 0, 0, t), abs=2e-15)


@given(
    y=st.floats(-2, 2), w=st.floats(-2, 2), start=st.floats(-2, 2), end=st.floats(-2, 2),
    h=st.floats(0, 9), dt=st.floats(1e-3, 3),
)  # fmt: skip
def test_newmark_is_constant_average_acceleration(
    y: float, w: float, start: float, end: float, h: float, dt: float
) -> None:
    """By definition: the mean of the accelerations at both ends, each from eq. (5) (beta 1/4, gamma 1/2)."""
    y1, w1 = step(y, w, start, end, h, dt)
    a0, a1 = start - h * w - y, end - h * w1 - y1
    assert w1 == pytest.approx(w + dt / 2 * (a0 + a1), abs=1e-12)
    assert y1 == pytest.approx(y + dt * w + dt * dt / 4 * (a0 + a1), abs=1e-12)
    a11, a12, b1, a21, a22, b2 = newmark_map(h, dt)
    mean = 0.5 * (start + end)
    assert a11 * y + a12 * w + b1 * mean == pytest.approx(y1, abs=1e-13)
    assert a21 * y + a22 * w + b2 * mean == pytest.approx(w1, abs=1e-13)
    assert mean_acceleration(y, w, mean, h, dt) == pytest.approx(0.5 * (a0 + a1), abs=1e-11)


def taylor_flight(p, start, end, x, v):
    """The same flight in short steps of the polynomial, which shares no formula with the closed form."""
    steps = max(1, int(np.ceil(2 * (end - start) * steps_for_exact(p.nu, p.h))))
    dt = (end - start) * 2 * np.pi / p.nu / steps
    c = np.empty(DEGREE + 1)
    for n in range(steps):
        turn = start + (end - start) * n / steps
        taylor(c, x, v, force_at(p, 1.0, turn), 0.0, p.h, p.nu, dt)
        x, v = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    return x, v


@given(
    nu=st.one_of(st.sampled_from([1.0, 1 + 1e-9, 1 - 1e-12]), log(-1, 1)),
    h=st.one_of(st.sampled_from([0.0, 1e-12, 2.0, 2 + 1e-12, 2 - 1e-9]), log(-6, 1.5)),
    start=st.floats(-2, 2),
    length=log(-3, 0.5),
)
@example(nu=1.0, h=0.0, start=0.3, length=5.0)
def test_flight_is_that_of_short_steps(nu: float, h: float, start: float, length: float) -> None:
    p = vp.Exciter(l=1.0, nu=nu, f=1.0, h=h).parameters()
    x, v = taylor_flight(p, start, start + length, 0.7, -0.4)
    flight = flight_over(1.0, p.h, 0.0, force_at(p, 1.0, start), p.nu, length)
    found = flown(flight, 0.7, -0.4)
    # The steps lose an ulp each, and the motion grows at resonance.
    assert found == pytest.approx((x, v), abs=2e-13 * (1 + length / nu))


TINY = 5e-324


@jit
def quotient(a: complex, b: complex) -> complex:
    return divide(a, b)


def test_quotients_equal_those_of_python() -> None:
    rng = np.random.default_rng(1)
    a, b = (
        (rng.normal(size=2000) + 1j * rng.normal(size=2000)) * 10.0 ** rng.integers(-140, 140, 2000)
        for _ in range(2)
    )
    for one, two in zip(a.tolist(), b.tolist(), strict=True):
        assert quotient(one, two) == pytest.approx(one / two, rel=4e-16)


@pytest.mark.parametrize("a", [0j, 1 + 2j, complex(math.inf, 0.0)])
@pytest.mark.parametrize("b", [0j, complex(-0.0, 0.0), complex(0.0, -0.0)])
def test_a_zero_divisor_gives_nan(a: complex, b: complex) -> None:
    assert cmath.isnan(quotient(a, b))


@pytest.mark.parametrize("b", [complex(TINY, 0.0), complex(0.0, -TINY), complex(math.nan, 1.0)])
def test_tiny_and_nan_divisors_do_not_raise(b: complex) -> None:
    assert not cmath.isfinite(quotient(1 + 1j, b))
