"""Known properties of hard cases, against long arithmetic and closed forms, and where common methods fail."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from oracles import Oracle
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.lab.hard_cases import failures
from vibropipe.lab.hard_cases.analytic import first_peak, flight_error, linear_end, response
from vibropipe.lab.hard_cases.contacts import FALL, PRESSED, chatter_series
from vibropipe.lab.hard_cases.failures import (
    COUNTS,
    DEPTHS,
    METHODS,
    RESTITUTIONS,
    grazing_velocity,
    relative_error,
    scipy_impacts,
)
from vibropipe.lab.hard_cases.labels import WINDOW, period_multiple_of
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.exciter import Exciter
from vibropipe.words.measurements import Outcome

# -- closed forms against arbitrary precision --------------------------------------------------


@pytest.mark.parametrize("h", [0.0, 1e-12, 0.2, 2.0, 50.0])
@pytest.mark.parametrize("nu", [0.7, 1.0, 1.0 + 1e-9])
def test_the_matrix_exponential_is_the_closed_form(nu: float, h: float) -> None:
    p = Parameters(nu=nu, f=0.8, h=h, l=1e9)
    c = digits(p, 110)
    zero = c.mpf(0)
    tau = c.mpf(2 * math.pi * 3 / nu)
    expected = Flight(c, c.mpf(nu), c.mpf(p.f), c.mpf(h), (zero, zero, zero))(tau)
    computed = linear_end(vp.Exciter(**p._asdict()), 3, None)
    size = max(abs(float(part)) for part in expected)
    np.testing.assert_allclose(
        computed, [float(part) for part in expected], rtol=0, atol=2e-14 * size
    )


def test_the_series_of_a_chatter_agrees_with_the_oracle() -> None:
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
    acceleration = -(dt / 2) / (1 + dt * dt / 4)
    assert first_peak(vp.Exciter(l=1.0), 3, v0=1.0)[1] == pytest.approx(
        -0.5 / acceleration, abs=1e-14
    )


def test_newmarks_steady_amplitude_agrees_with_powers_of_its_step() -> None:
    p = vp.Exciter(l=9.0, nu=1.3, f=0.7, h=0.4)
    x, _v = linear_end(p, 40, 12)
    assert x == pytest.approx(response(p, 12).imag, abs=1e-13)
    exact = mpmath.mpc(1 - mpmath.mpf(1.3) ** 2, mpmath.mpf(1.3) * mpmath.mpf(0.4))
    assert response(p, None) == pytest.approx(complex(0.7 / exact), abs=1e-15)


def test_a_flight_through_a_support_is_detected() -> None:
    p = vp.Exciter(l=0.5, R1=0.5, R2=0.5)
    ds = vp.simulate(p, tau_end=2.0, v0=1.0, samples_per_period=0)
    assert flight_error(p, ds, 2.0, 0.0, 1.0) < 1e-14
    without_impacts = ds.isel(impact=slice(0)).assign(
        displacement_end=math.sin(2.0), velocity_end=math.cos(2.0)
    )
    assert flight_error(p, without_impacts, 2.0, 0.0, 1.0) > 0.3


def test_an_impact_on_the_end_of_a_step_keeps_its_rebound() -> None:
    """nu = 2 and a support at the equilibrium: every impact falls on the end of a forcing period."""
    p = vp.Exciter(l=50.0, delta=50.0, nu=2.0, f=1.0)
    for v0 in (0.1, 0.2, 0.3, 1.0):
        ds = vp.simulate(p, tau_end=20.0, v0=v0, samples_per_period=0)
        expected = -(v0 + 4 / 3 * np.arange(1, 7))
        np.testing.assert_allclose(ds.impact_velocity.values, expected, rtol=1e-12)


# -- period multiples ---------------------------------------------------------------------------


def sections(section_of: Any) -> np.ndarray:
    """Sections (x, v) at the periods of a window from a complex number for each."""
    values = np.array([section_of(n) for n in range(WINDOW + 1)], complex)
    return np.column_stack([values.real, values.imag])


@pytest.mark.parametrize("m", [1, 2, 3, 8, 32])
def test_a_settled_motion_repeats_after_its_smallest_multiple(m: int) -> None:
    turn = np.exp(2j * math.pi / m)
    assert period_multiple_of(sections(lambda n: 2 + turn**n), 3.0) == m
    # still at a distance of 1e-8
    assert period_multiple_of(sections(lambda n: 2 + turn**n + 1e-8 * 0.99**n), 3.0) == m
    # on a spiral of about three periods per turn
    assert (
        period_multiple_of(sections(lambda n: 2 + turn**n + 1e-7 * (0.99 * np.exp(2.1j)) ** n), 3.0)
        == m
    )


def test_an_unsettled_motion_does_not_repeat() -> None:
    for rate in (0.9, 0.999, 0.999999):
        start = 1e-3 / rate**WINDOW
        assert period_multiple_of(sections(lambda n, r=rate, s=start: 1 + s * r**n), 1.0) == 0
    # a constant drift of 1e-8 per period
    assert period_multiple_of(sections(lambda n: 1 + 1e-8 * n), 1.0) == 0
    assert period_multiple_of(sections(lambda n: np.exp(1j * n)), 1.0) == 0
    assert period_multiple_of(sections(lambda n: np.exp(2j * math.pi / 33 * n)), 1.0) == 0


EPS = np.finfo(float).eps


def test_every_grazing_impact_is_found_as_well_as_its_start_is_known(monkeypatch):
    monkeypatch.setattr(failures, "DEPTHS", DEPTHS[::4])
    found = failures.grazing()
    # v = sqrt(v0^2 - 1/4): half an ulp of v0 moves it by this share
    allowed = 30 * EPS / (2 * DEPTHS[::4])
    for method in ("exact", "newmark", "DOP853_short"):
        assert (found[method].outcome == Outcome.OK).all()
        assert (found[method].error < allowed).all()
    # an integrator whose steps are longer than the contact steps over it
    assert found["DOP853"].outcome.tolist() == [Outcome.OK, *[Outcome.MISSED_IMPACT] * 5]
    assert found["crude"].error[0] > 1e-3
    assert found["crude"].outcome[-1] == Outcome.MISSED_IMPACT


def test_errors_are_relative_to_more_digits_than_a_double_has():
    with mpmath.workdps(40):
        truth = mpmath.sqrt(mpmath.mpf(0.5 + 1e-9) ** 2 - mpmath.mpf("0.25"))
        assert abs(mpmath.mpf(str(grazing_velocity(0.5 + 1e-9))) / truth - 1) < mpmath.mpf("1e-38")
    assert relative_error(
        float(truth) * (1 + 1e-10), grazing_velocity(0.5 + 1e-9)
    ) == pytest.approx(1e-10, rel=1e-4)
    assert math.isnan(relative_error(math.nan, grazing_velocity(0.6)))


def test_the_end_of_a_chatter_is_found_and_an_integrator_is_stuck_before_it(monkeypatch):
    monkeypatch.setattr(failures, "RESTITUTIONS", RESTITUTIONS[[0, 2, 5]])
    found = failures.chatter()
    assert (found["exact"].error < 1e-13).all()
    assert (found["newmark"].error < 1e-5).all()
    assert found["crude"].outcome.tolist() == [Outcome.OK, *[Outcome.DID_NOT_END] * 2]
    assert (found["DOP853"].outcome == Outcome.DID_NOT_END).all()
    assert ((found["DOP853"].error > 1e-3) & (found["DOP853"].error < 0.1)).all()


def test_the_energy_of_all_impacts_is_kept_but_by_the_crude_method(monkeypatch):
    monkeypatch.setattr(failures, "IMPACTS", 1000)
    monkeypatch.setattr(failures, "COUNTS", COUNTS[COUNTS <= 1000])
    monkeypatch.setattr(failures, "MAX_IMPACTS", 100)
    found = failures.energy()
    assert found["closed"].error.max() <= EPS
    assert found["exact"].error.max() < 1e-11
    assert found["newmark"].error.max() < 1e-11
    for method, least in (("DOP853", 1e-11), ("DOP853_loose", 1e-6), ("crude", 1e-4)):
        known = np.isfinite(found[method].error)
        assert found[method].error[known].max() > least
        assert (found[method].outcome[~known] == Outcome.DID_NOT_END).all()
        assert not known.all()


def test_errors_over_the_step_fall_with_the_order_of_each_method(monkeypatch):
    monkeypatch.setattr(failures, "STEPS_TRIED", np.array([64, 512, 4096]))
    monkeypatch.setattr(failures, "TOLERANCES", (1e-4, 1e-8))
    values = failures.step()
    count, error = (values[name] for name in ("step_count", "step_error"))
    newmark = METHODS.index("newmark")
    assert count[newmark].tolist() == [64, 512, 4096]
    order = np.log(error[newmark, 0] / error[newmark, 2]) / np.log(64)
    assert order == pytest.approx(2, abs=0.1)
    assert error[METHODS.index("exact"), 0] < 1e-14
    assert np.isnan(error[METHODS.index("closed")]).all()


def test_an_integrator_is_stopped_by_its_impacts_or_where_it_is_stuck():
    free = BenchmarkMotion(Exciter(l=0.5), 0.0, -0.51, 20)
    assert len(scipy_impacts(free, 1e-8, 5)) == 5
    pressed = Exciter(l=0.5, delta=-1.5, R1=0.5)
    impacts = scipy_impacts(BenchmarkMotion(pressed, -1.5, 0.0, 2), 1e-10, 1000)
    assert impacts[-1][0] - impacts[-2][0] <= math.ulp(impacts[-1][0])
