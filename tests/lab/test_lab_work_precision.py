"""Work-precision comparison: orders of convergence, reported failures, and reproducible results except times."""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest
from oracles import Oracle
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.lab import work_precision
from vibropipe.lab.peers import recorder
from vibropipe.lab.peers.recorder import Recorder
from vibropipe.lab.peers.solve_ivp import scipy_peer
from vibropipe.lab.work_precision import MotionReference, build_method, solve_accuracy
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    MethodResult,
    exact,
    newmark,
    newmark_crude,
)
from vibropipe.scenes.accuracy.summary import orders
from vibropipe.words.vocabulary import Outcome

SYMMETRIC = BenchmarkMotion(vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 6)
CHATTER = BenchmarkMotion(vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 2)


@pytest.fixture(scope="module")
def comparison():
    return solve_accuracy(
        {"symmetric": SYMMETRIC, "chatter": CHATTER},
        ("crude", "newmark", "exact", "DOP853"),
        steps=(64, 256, 1024, 4096),
        tolerances=(1e-5, 1e-9),
        peer_periods=2,
        repeats=3,
    )


def test_newmark_converges_with_order_2_and_crude_with_order_1(comparison):
    order_of = orders(comparison).sel(motion="symmetric")
    assert 1.9 < float(order_of.sel({"method": "newmark"})) < 2.1
    assert 0.7 < float(order_of.sel({"method": "crude"})) < 1.3
    assert np.isnan(order_of.sel({"method": "exact"}))


def test_the_exact_method_is_at_rounding(comparison):
    one = comparison.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    assert float(one.error_end) < 1e-13
    assert float(one.error_impact_tau) < 1e-13
    assert float(one.error_harmonics) < 1e-13


@pytest.mark.benchmark
def test_the_exact_method_takes_less_time_than_newmark_at_1e_4(comparison):
    one = comparison.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    newmark = comparison.sel({"motion": "symmetric", "method": "newmark"})
    enough = newmark.error_end <= 1e-4
    assert float(newmark.time_per_period.where(enough).min()) > float(one.time_per_period)


def test_a_reference_package_is_accurate_without_chatter_and_does_not_end_with_it(comparison):
    peer = comparison.sel({"method": "DOP853"}).isel(setting=1)
    assert int(peer.sel(motion="symmetric").outcome) == Outcome.OK
    assert float(peer.sel(motion="symmetric").error_end) < 1e-7
    assert int(peer.sel(motion="chatter").outcome) == Outcome.DID_NOT_END
    assert np.isnan(peer.sel(motion="chatter").time_per_period)
    assert comparison.periods_run.sel({"method": "DOP853"}).values.tolist() == [2, 2]
    assert comparison.periods_run.sel({"method": "exact"}).values.tolist() == [6, 2]


def test_missing_settings_are_reported_as_not_tried(comparison):
    exact_only = comparison.sel({"method": "exact"}).outcome.values
    assert (exact_only[:, 1:] == Outcome.NOT_TRIED).all()
    assert (exact_only[:, 0] == Outcome.OK).all()


def test_quartiles_hold_the_median(comparison):
    timed = np.isfinite(comparison.time_per_period.values)
    low, high = comparison.time_per_period_low.values, comparison.time_per_period_high.values
    assert (low[timed] <= comparison.time_per_period.values[timed]).all()
    assert (comparison.time_per_period.values[timed] <= high[timed]).all()
    assert (low[timed] > 0).all()


def test_work_is_counted(comparison):
    steps = comparison.work_steps.sel({"motion": "symmetric", "method": "newmark"}).values
    np.testing.assert_array_equal(steps, [64, 256, 1024, 4096])
    one = comparison.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    assert 0 < float(one.work_evaluations) < float(one.work_steps)


def test_the_crude_kernel_follows_the_equations_of_the_method():
    """Constant average acceleration by its equations, with impacts at the end of the step."""
    motion, steps = SYMMETRIC._replace(periods=2), 40
    e, dt = motion.exciter, motion.exciter.period / steps
    x, v, impacts = 0.0, 0.0, []
    for n in range(2 * steps):
        force = e.f * math.sin((n + 1) * dt)
        a = e.f * math.sin(n * dt) - e.h * v - x
        ahead = force - e.h * (v + 0.5 * dt * a) - (x + dt * v + 0.25 * dt * dt * a)
        a1 = ahead / (1 + 0.5 * e.h * dt + 0.25 * dt * dt)
        x, v = x + dt * v + 0.25 * dt * dt * (a + a1), v + 0.5 * dt * (a + a1)
        for support, bound in ((1, e.upper), (2, e.lower)):
            side = 1 if support == 1 else -1
            if side * x >= side * bound:
                x = bound
                if side * v > 0:
                    impacts.append(((n + 1) * dt, support, v))
                    v = -0.7 * v
    result = newmark_crude(motion, steps).show()
    assert result.end == pytest.approx((x, v), abs=1e-12)
    assert result.impact_support.tolist() == [s for _, s, _ in impacts]
    np.testing.assert_allclose(result.impact_tau, [tau for tau, _, _ in impacts], rtol=1e-12)
    np.testing.assert_allclose(result.impact_velocity, [v for _, _, v in impacts], rtol=1e-10)


def test_samples_of_all_methods_are_of_the_last_period():
    p = Parameters(nu=1, f=-1, h=0.2, l=0.5, R1=0.7, R2=0.7)
    oracle = Oracle(p, digits(p, 30)).run(SYMMETRIC.tau_end)
    times = (5 + np.arange(SAMPLES) / SAMPLES) * SYMMETRIC.exciter.period
    expected = [float(oracle.state(oracle.pieces[0][0] * 0 + t)[0]) for t in times]
    for candidate, tolerance in (
        (exact(SYMMETRIC), 1e-14),
        (newmark(SYMMETRIC, 4096), 1e-5),
        (newmark_crude(SYMMETRIC, 4096), 1e-2),
        (scipy_peer(SYMMETRIC, "DOP853", 1e-10), 1e-8),
    ):
        assert np.abs(candidate.show().samples - expected).max() < tolerance


def changed_result(**changes) -> MethodResult:
    result = exact(SYMMETRIC).show()
    return result._replace(**changes)


def test_a_missed_impact_is_detected():
    reference = MotionReference(SYMMETRIC)
    complete = changed_result()
    assert reference.errors(complete)[0] == Outcome.OK
    incomplete = changed_result(
        impact_tau=complete.impact_tau[1:],
        impact_support=complete.impact_support[1:],
        impact_velocity=complete.impact_velocity[1:],
    )
    assert reference.errors(incomplete)[0] == Outcome.MISSED_IMPACT


def test_errors_equal_imposed_deviations():
    reference = MotionReference(SYMMETRIC)
    result = changed_result()
    perturbed = changed_result(
        end=(result.end[0] + 1e-3 * reference.size, result.end[1]),
        impact_tau=result.impact_tau + 1e-4 * SYMMETRIC.exciter.period,
        impact_velocity=result.impact_velocity * (1 - 1e-5),
        samples=result.samples + 1e-6 * reference.size * np.cos(2 * np.pi * np.arange(64) / 64),
    )
    expected = [1e-3, 1e-4, 1e-5 * np.abs(result.impact_velocity).max() / reference.speed, 1e-6]
    assert reference.errors(perturbed)[1] == pytest.approx(expected, rel=1e-6)


def test_penetration_of_a_support_is_detected():
    run = Recorder(SYMMETRIC)
    inside, outside = np.zeros(SAMPLES), np.full(SAMPLES, 0.51)
    work = (1.0, 1.0, 1.0)
    assert run.result(inside, (0.0, 0.0), work).outcome == Outcome.OK
    assert run.result(outside, (0.0, 0.0), work).outcome == Outcome.FELL_THROUGH
    assert run.result(inside, (math.nan, 0.0), work).outcome == Outcome.DID_NOT_END


def test_a_run_that_does_not_end_is_stopped_by_its_work(monkeypatch):
    first = MotionReference(CHATTER).errors(build_method("DOP853", 1e-6, CHATTER).show())
    assert first[0] == Outcome.DID_NOT_END
    # a motion without impacts ends within a sufficient limit of work, and not within a smaller one
    easy = BenchmarkMotion(vp.Exciter(l=0.5, nu=1.0, f=0.01, h=0.2), 0.0, 0.0, 2)
    needed = build_method("RK45", 1e-6, easy).show().effort[1]
    for max_work, outcome in ((needed // 2 + 1, Outcome.OK), (needed // 2, Outcome.DID_NOT_END)):
        monkeypatch.setattr(recorder, "MAX_WORK", max_work)
        assert build_method("RK45", 1e-6, easy).show().outcome == outcome


def test_only_times_differ_from_run_to_run():
    arguments = ({"chatter": CHATTER}, ("crude", "newmark", "exact", "RK45", "heyoka"))
    one, two = (solve_accuracy(*arguments, (64,), (1e-5,), repeats=1) for _ in "12")
    names = [name for name in one.data_vars if not name.startswith("time_per_period")]
    assert len(names) == len(one.data_vars) - 3
    for name in names:
        np.testing.assert_array_equal(one[name].values, two[name].values, err_msg=str(name))


def test_crude_is_accurate_with_more_steps_than_a_table_holds():
    ends = [newmark_crude(SYMMETRIC, steps).show().end for steps in (8192, 10_000, 30_000)]
    expected = MotionReference(SYMMETRIC).end
    assert np.abs(np.array(ends) - expected).max() < 5e-3
    assert np.abs(np.array(ends[-1]) - expected).max() < 2e-3


def test_a_missing_package_is_reported_by_its_outcome(monkeypatch):
    monkeypatch.setattr(work_precision, "is_installed", lambda method: False)
    ds = solve_accuracy({"one": SYMMETRIC._replace(periods=1)}, ("heyoka",), tolerances=(1e-6,))
    assert ds.outcome.values.ravel().tolist() == [Outcome.NOT_INSTALLED]


def test_heyoka_agrees_with_the_reference_if_installed():
    candidate = build_method("heyoka", 1e-12, SYMMETRIC)
    if importlib.util.find_spec("heyoka") is None:
        assert candidate == Outcome.NOT_INSTALLED
        return
    outcome, errors = MotionReference(SYMMETRIC).errors(candidate.show())
    assert outcome == Outcome.OK
    assert max(errors) < 1e-9
