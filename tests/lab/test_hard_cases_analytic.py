"""What the cases of the study of hard cases are judged by, against arbitrary precision and closed forms."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from oracles import Oracle
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.lab.hard_cases.analytic import first_peak, flight_error, linear, transfer
from vibropipe.lab.hard_cases.chatter import FALL, PRESSED, chatter_series
from vibropipe.lab.hard_cases.long_march import WINDOW, multiple_of

# -- what is known, against arbitrary precision ------------------------------------------------


@pytest.mark.parametrize("h", [0.0, 1e-12, 0.2, 2.0, 50.0])
@pytest.mark.parametrize("nu", [0.7, 1.0, 1.0 + 1e-9])
def test_the_matrix_exponential_is_the_closed_form(nu: float, h: float) -> None:
    p = Parameters(nu=nu, f=0.8, h=h, l=1e9)
    c = digits(p, 110)
    zero = c.mpf(0)
    at = c.mpf(2 * math.pi * 3 / nu)
    known = Flight(c, c.mpf(nu), c.mpf(p.f), c.mpf(h), (zero, zero, zero))(at)
    got = linear(vp.Exciter(**p._asdict()), 3, None)
    size = max(abs(float(part)) for part in known)
    np.testing.assert_allclose(got, [float(part) for part in known], rtol=0, atol=2e-14 * size)


def test_the_series_of_a_chatter_is_the_twins() -> None:
    p = Parameters(**PRESSED, R1=0.8)
    impacts = Oracle(p, digits(p)).run(9.0, FALL, 0.0).impacts
    assert len(impacts) > 8
    for n, impact in enumerate(impacts[:9]):
        tau, speed = chatter_series(0.8, n)
        assert tau == pytest.approx(float(impact.tau), rel=1e-14)
        assert speed == pytest.approx(abs(float(impact.after)), rel=1e-14)


def test_a_peak_is_where_the_velocity_turns() -> None:
    tau, height = first_peak(vp.Exciter(l=1.0), None, v0=1.3)
    assert tau == pytest.approx(math.pi / 2, abs=1e-14)
    assert height == pytest.approx(1.3, abs=1e-14)
    # one step of constant average acceleration: a = -(dt v/2)/(1 + dt^2/4), x = v^2/(-2a)
    dt = 2 * math.pi / 3
    pull = -(dt / 2) / (1 + dt * dt / 4)
    assert first_peak(vp.Exciter(l=1.0), 3, v0=1.0)[1] == pytest.approx(-0.5 / pull, abs=1e-14)


def test_newmarks_own_steady_motion_answers_the_force_as_its_powers_do() -> None:
    p = vp.Exciter(l=9.0, nu=1.3, f=0.7, h=0.4)
    x, _v = linear(p, 40, 12)
    assert x == pytest.approx(transfer(p, 12).imag, abs=1e-13)
    exact = mpmath.mpc(1 - mpmath.mpf(1.3) ** 2, mpmath.mpf(1.3) * mpmath.mpf(0.4))
    assert transfer(p, None) == pytest.approx(complex(0.7 / exact), abs=1e-15)


def test_a_flight_through_a_support_is_seen() -> None:
    p = vp.Exciter(l=0.5, R1=0.5, R2=0.5)
    ds = vp.simulate(p, tau_end=2.0, v0=1.0, samples_per_period=0)
    assert flight_error(p, ds, 2.0, 0.0, 1.0) < 1e-14
    unseen = ds.isel(impact=slice(0)).assign(
        displacement_end=math.sin(2.0), velocity_end=math.cos(2.0)
    )
    assert flight_error(p, unseen, 2.0, 0.0, 1.0) > 0.3


def test_an_impact_on_the_end_of_a_step_keeps_its_rebound() -> None:
    """nu = 2 and a support at the equilibrium: every impact falls on the end of a forcing period."""
    p = vp.Exciter(l=50.0, delta=50.0, nu=2.0, f=1.0)
    for v0 in (0.1, 0.2, 0.3, 1.0):
        ds = vp.simulate(p, tau_end=20.0, v0=v0, samples_per_period=0)
        known = -(v0 + 4 / 3 * np.arange(1, 7))
        np.testing.assert_allclose(ds.impact_velocity.values, known, rtol=1e-12)


# -- what repeats -------------------------------------------------------------------------------


def sections(of: Any) -> np.ndarray:
    """Sections (x, v) at the periods of a window from a complex number for each."""
    at = np.array([of(n) for n in range(WINDOW + 1)], complex)
    return np.column_stack([at.real, at.imag])


@pytest.mark.parametrize("m", [1, 2, 3, 8, 32])
def test_what_has_arrived_repeats_after_its_least_multiple(m: int) -> None:
    turn = np.exp(2j * math.pi / m)
    assert multiple_of(sections(lambda n: 2 + turn**n), 3.0) == m
    # still on its way, by 1e-8 in all
    assert multiple_of(sections(lambda n: 2 + turn**n + 1e-8 * 0.99**n), 3.0) == m
    # in a spiral of three periods a turn, nearly
    assert (
        multiple_of(sections(lambda n: 2 + turn**n + 1e-7 * (0.99 * np.exp(2.1j)) ** n), 3.0) == m
    )


def test_what_has_far_to_go_does_not_repeat() -> None:
    for rate in (0.9, 0.999, 0.999999):
        start = 1e-3 / rate**WINDOW
        assert multiple_of(sections(lambda n, r=rate, s=start: 1 + s * r**n), 1.0) == 0
    # a change of 1e-8 a period, for ever
    assert multiple_of(sections(lambda n: 1 + 1e-8 * n), 1.0) == 0
    assert multiple_of(sections(lambda n: np.exp(1j * n)), 1.0) == 0
    assert multiple_of(sections(lambda n: np.exp(2j * math.pi / 33 * n)), 1.0) == 0
