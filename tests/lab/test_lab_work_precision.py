"""Work-precision comparison: orders of convergence, reported failures, and reproducible results except times."""

import importlib.util
import math

import numpy as np
import pytest
from oracles import Oracle
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.lab import work_precision
from vibropipe.lab.motion_reference import MotionReference, pair_impacts
from vibropipe.lab.peers import solve_ivp
from vibropipe.lab.peers.packages import is_for_nivp
from vibropipe.lab.peers.solve_ivp import Recorder, scipy_peer
from vibropipe.lab.work_precision import build_method, solve_accuracy
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    MethodResult,
    effects_of_motion,
    exact,
    newmark,
    newmark_crude,
)
from vibropipe.march.grid import newmark_grid
from vibropipe.words.measurements import Outcome
from vibropipe.words.status import Status

SYMMETRIC = BenchmarkMotion(vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 6)
CHATTER = BenchmarkMotion(vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 2)


@pytest.fixture(scope="module")
def comparison():
    return solve_accuracy(
        {"symmetric": SYMMETRIC, "chatter": CHATTER},
        ("crude", "newmark", "exact", "DOP853"),
        steps=(64, 256, 1024, 4096),
        tolerances=(1e-5, 1e-9),
        accuracies=(1e-6, 1e-15),
        repeats=3,
    )


@pytest.mark.parametrize(("method", "low", "high"), [("newmark", 1.9, 2.1), ("crude", 0.7, 1.3)])
def test_newmark_converges_with_order_2_and_crude_with_order_1(comparison, method, low, high):
    one = comparison.sel({"motion": "symmetric", "method": method})
    steps, error = np.log(one.setting_value.values), np.log(one.error_impact_tau.values)
    assert low < -np.polyfit(steps, error, 1)[0] < high


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


def test_all_methods_run_the_same_periods_of_a_motion_that_strikes(comparison):
    assert comparison.periods_run.dims == ("motion",)
    assert comparison.periods_run.values.tolist() == [6, 2]
    assert comparison.impacts_per_period.values.tolist() == [2, 17.5]
    steps = comparison.work_steps.sel({"motion": "symmetric", "method": "DOP853"}).values
    assert steps[0] * 6 > 6  # counted over the whole motion


def test_what_is_asked_is_reached_or_refused(comparison):
    one = comparison.sel(motion="symmetric")
    assert one.accuracy.values.tolist() == [1e-6, 1e-15]
    assert (one.asked_error <= one.asked_estimate).all()
    assert one.asked_status.values.tolist() == [Status.OK, Status.INACCURATE]
    assert (one.asked_steps == 0).all()
    assert float(one.plain_time) > 0
    assert (one.asked_time > 0).all()


def test_a_step_costs_more_where_its_force_is_in_no_table(comparison):
    """The largest table of sines, of which a step of more per period has none."""
    assert comparison.attrs["tabulated_steps"] == 8192
    for steps, size in ((8192, 8192), (8193, 0)):
        p = SYMMETRIC.exciter.parameters()
        assert newmark_grid(effects_of_motion(SYMMETRIC), p, steps).table_1.size == size


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


def test_a_lag_is_an_error_of_time_and_no_missed_impact():
    """Impacts that come later and later, the last of them after the end: by a whole interval in the end."""
    reference = MotionReference(SYMMETRIC)
    result = changed_result()
    late = result.impact_tau * 1.1
    inside = late < SYMMETRIC.tau_end
    assert inside.sum() == inside.size - 1
    lagging = changed_result(
        impact_tau=late[inside],
        impact_support=result.impact_support[inside],
        impact_velocity=result.impact_velocity[inside],
    )
    outcome, errors = reference.errors(lagging)
    assert outcome == Outcome.OK
    assert errors[1] == pytest.approx(0.1 * result.impact_tau[-2] / SYMMETRIC.exciter.period)
    leading = changed_result(impact_tau=result.impact_tau * 0.95)
    assert reference.errors(leading)[0] == Outcome.OK


@pytest.mark.parametrize(
    ("other", "is_same"),
    [
        ([1.0, 2.0, 3.0, 4.0, 5.0], True),
        ([1.1, 2.2, 3.3, 4.4, 5.5], True),
        ([1.3, 2.6, 3.9, 5.2], True),  # the fifth comes at 6.5
        ([1.0, 3.0, 4.0, 5.0], False),
        ([1.0, 2.0, 3.0, 4.0], False),
        ([1.0, 2.0, 2.5, 3.0, 4.0, 5.0], False),
        ([0.9, 1.8, 2.7, 3.6, 4.5, 5.4], True),  # the sixth of the reference comes after the end
        ([], False),
    ],
)
def test_impacts_are_paired_in_order(other, is_same):
    taus = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    pairs = pair_impacts(taus, np.array(other), np.zeros(len(other), bool), 5.7)
    assert pairs.is_same == is_same


def test_a_chatter_that_comes_late_has_missed_nothing():
    """Intervals of a chatter shrink below the lag, and its slow impacts need no counterpart."""
    taus = np.cumsum(0.5 ** np.arange(8)) + np.array([0, 0, 0, 0, 9, 9, 9, 9])
    late = np.append(taus[:4] * 1.08, taus[4:] * 1.01)
    slow = np.insert(late, 4, late[3] + 0.01)
    is_slow = np.zeros(9, bool)
    is_slow[4] = True
    pairs = pair_impacts(taus, slow, is_slow, 20.0)
    assert pairs.is_same
    assert pairs.partner.tolist() == [0, 1, 2, 3, 5, 6, 7, 8]


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
        monkeypatch.setattr(solve_ivp, "MAX_WORK", max_work)
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


def test_a_missing_package_is_not_listed(monkeypatch):
    monkeypatch.setattr(work_precision, "is_installed", lambda method: method == "exact")
    short = {"one": SYMMETRIC._replace(periods=1)}
    ds = solve_accuracy(short, ("exact", "heyoka", "solve_nivp"), tolerances=(1e-6,), repeats=1)
    assert ds.method.values.tolist() == ["exact"]
    assert build_method("heyoka", 1e-6, SYMMETRIC) == Outcome.NOT_INSTALLED


def test_heyoka_agrees_with_the_reference_if_installed():
    candidate = build_method("heyoka", 1e-12, SYMMETRIC)
    if importlib.util.find_spec("heyoka") is None:
        assert candidate == Outcome.NOT_INSTALLED
        return
    outcome, errors = MotionReference(SYMMETRIC).errors(candidate.show())
    assert outcome == Outcome.OK
    assert max(errors) < 1e-9


@pytest.mark.skipif(
    importlib.util.find_spec("solve_nivp") is None, reason="solve_nivp is not installed"
)
def test_nonsmooth_time_stepping_finds_the_impacts_of_the_reference():
    short = SYMMETRIC._replace(periods=2)
    outcome, errors = MotionReference(short).errors(build_method("solve_nivp", 128, short).show())
    assert outcome == Outcome.OK
    assert max(errors) < 0.2


def test_nonsmooth_time_stepping_is_tried_on_rigid_supports_alone():
    soft = SYMMETRIC._replace(exciter=vp.Exciter(l=0.5, nu=1, f=-1, k1=100.0))
    assert not is_for_nivp(soft, 64)
    assert not is_for_nivp(SYMMETRIC, 10_000)
    assert is_for_nivp(SYMMETRIC, 64)
