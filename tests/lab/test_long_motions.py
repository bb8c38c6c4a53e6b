"""Motions of a million events, and limits of the work of a motion."""

import math
import time
from typing import Any

import numpy as np
import pytest
from comparisons import energy, methods, reference, rests_of
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.words.status import Status

TURN = 2 * math.pi


# -- long motions ------------------------------------------------------------------------------


def test_a_million_ideal_impacts_keep_their_energy() -> None:
    e = vp.Exciter(l=0.5)
    flight = 2 * math.asin(0.5 / 10)  # between the supports on the circle of radius 10
    ds = vp.simulate(e, tau_end=1.0001e6 * flight, v0=10.0, samples_per_period=0)
    assert ds.impact_tau.size >= 1_000_000
    end = energy(float(ds.displacement_end), float(ds.velocity_end))
    assert abs(end / 50 - 1) < 1e-10
    after = energy(0.5, ds.impact_velocity_after.values)
    assert np.abs(after / 50 - 1).max() < 1e-10


@pytest.mark.parametrize("steps", [8, 64, 500])
@pytest.mark.parametrize("speed", [0.6, 2.0])
def test_newmark_neither_loses_nor_gains_energy(steps: int, speed: float) -> None:
    """The method conserves x^2 + v^2; 20,000 ideal impacts add only rounding errors."""
    e = vp.Exciter(l=0.5)
    tau_end = 20_100 * 2 * math.asin(0.5 / speed)
    ds = vp.simulate(
        e, tau_end=tau_end, v0=speed, samples_per_period=0, method="newmark", steps_per_period=steps
    )
    error = energy(0.5, ds.impact_velocity.values) / (speed**2 / 2) - 1
    assert error.size >= 19_000
    roundings = np.finfo(float).eps * (tau_end / TURN * steps + 20 * error.size)
    assert np.abs(error).max() <= roundings


def test_phase_after_a_million_periods() -> None:
    """The settled motion of figure 9 strikes at the phases of the reference orbit to the end."""
    entry = reference("steady")["fig9"]
    e = vp.Exciter(**{key: float(entry[key]) for key in Parameters._fields})
    n = 1_000_000
    ds = vp.simulate(e, tau_end=n * TURN, samples_per_period=0)
    last = ds.impact_tau.values[-2:] / TURN - (n - 1)
    expected = [float(impact["phase"]) for impact in entry["impacts"]]
    np.testing.assert_allclose(last, expected, rtol=0, atol=1e-9)
    assert ds.impact_tau.size == pytest.approx(2 * n, abs=4)


@pytest.mark.parametrize("nu", [1.0, 0.7, math.sqrt(3)])
def test_force_after_a_million_periods(nu: float) -> None:
    """Without impacts the closed form holds at any time."""
    p = Parameters(nu=nu, f=0.3, h=0.3, l=2.0)
    tau = 1e6 * TURN / nu
    ds = vp.simulate(vp.Exciter(**p._asdict()), tau_end=tau, samples_per_period=0)
    c = digits(p)
    zero = c.mpf(0)
    flight = Flight(c, c.mpf(p.nu), c.mpf(p.f), c.mpf(p.h), (zero, zero, zero))
    x, v = flight(c.mpf(tau))
    # tau itself is only known to 1e-9 here, and nu * tau to one ulp of it
    assert float(ds.displacement_end) == pytest.approx(float(x), abs=1e-9)
    assert float(ds.velocity_end) == pytest.approx(float(v), abs=1e-9)


def test_release_through_heavy_damping() -> None:
    """h = 1e4: after a rest the mass creeps off along the closed form."""
    p = Parameters(nu=1.0, f=2e4, h=1e4, l=2.0, R1=0.4, R2=0.4)
    ds = vp.simulate(vp.Exciter(**p._asdict()), tau_end=5.0, samples_per_period=0)
    c = digits(p)
    release = c.pi - c.asin(c.mpf(2) / 20000)
    assert rests_of(ds)[0][1] == pytest.approx(float(release), abs=1e-12)
    start = (release, c.mpf(2), c.mpf(0))
    x, v = Flight(c, c.mpf(1), c.mpf(p.f), c.mpf(p.h), start)(c.mpf(5))
    assert float(ds.displacement_end) == pytest.approx(float(x), abs=1e-11)
    assert float(ds.velocity_end) == pytest.approx(float(v), abs=1e-11)


# -- limits of work ----------------------------------------------------------------------------


@methods
@pytest.mark.parametrize("R", [0.5, 0.9, 0.99])
def test_a_chatter_ends_in_bounded_work(R: float, method: dict[str, Any]) -> None:
    """A complete chatter takes at most the impacts until the speed is 1e-9 of the first."""
    e = vp.Exciter(l=0.5, delta=-1.5, h=0.1, R1=R, R2=R)
    ds = vp.simulate(e, tau_end=200.0, x0=-1.5, **method)
    assert len(rests_of(ds)) == 1
    assert rests_of(ds)[0][1] == math.inf
    assert ds.impact_tau.size <= 20 + math.log(1e-9) / math.log(R)


def test_the_bound_on_impacts_counts_grazes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The motion grazes a support in each half turn, and the log holds at most three grazings."""
    monkeypatch.setattr("vibropipe.solve.motion.run.MARCH_LOG_CAPACITY", 4)
    for most, status in ((10, Status.MAX_IMPACTS), (1000, Status.OK)):
        e = vp.Exciter(l=0.5, nu=1.0, f=1e-300)
        ds = vp.simulate(e, 200.0, 0.5, samples_per_period=0, max_impacts=most)
        assert int(ds.status) == status
    assert ds.grazing_tau.size == 63


@methods
def test_an_ideal_support_that_the_damped_mass_is_pushed_into(method: dict[str, Any]) -> None:
    """R = 1, h > 0: the hops shrink without end; the run ends with a valid state or a status."""
    e = vp.Exciter(l=0.5, delta=-1.5, h=50.0)
    ds = vp.simulate(e, tau_end=60.0, x0=-1.2, samples_per_period=0, **method)
    if math.isnan(float(ds.displacement_end)):
        assert int(ds.status) != Status.OK
        return
    # newmark overdamps or underdamps hops shorter than its step: its error is of its own order
    x_tolerance, v_tolerance = (
        ((TURN / method["steps_per_period"]) ** 2, 0.1) if method else (1e-9, 1e-6)
    )
    assert -1.5 - 1e-12 <= float(ds.displacement_end) <= -1.0
    assert float(ds.displacement_end) == pytest.approx(-1.0, abs=x_tolerance)
    assert float(ds.velocity_end) == pytest.approx(0.0, abs=v_tolerance)


@pytest.mark.benchmark
@methods
def test_a_march_at_an_ideal_support_ends_in_bounded_time(method: dict[str, Any]) -> None:
    started = time.process_time()
    vp.simulate(
        vp.Exciter(l=0.5, delta=-1.5, h=50.0), 60.0, x0=-1.2, samples_per_period=0, **method
    )
    assert time.process_time() - started < 60
