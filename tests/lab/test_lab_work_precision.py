"""The race of methods: orders by known laws, failures told as such, times apart from the rest."""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest
from oracles import Oracle
from textbook import Parameters, digits

import vibropipe as vp
from vibropipe.lab import peers
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

SYMMETRIC = BenchmarkMotion(vp.Exciter(l=0.5, f=-1, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 6)
CHATTER = BenchmarkMotion(vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 2)


@pytest.fixture(scope="module")
def race():
    return solve_accuracy(
        {"symmetric": SYMMETRIC, "chatter": CHATTER},
        ("crude", "newmark", "exact", "DOP853"),
        steps=(64, 256, 1024, 4096),
        tolerances=(1e-5, 1e-9),
        peer_periods=2,
        repeats=3,
    )


def test_newmark_is_of_second_order_and_the_crude_way_of_first(race):
    found = orders(race).sel(motion="symmetric")
    assert 1.9 < float(found.sel({"method": "newmark"})) < 2.1
    assert 0.7 < float(found.sel({"method": "crude"})) < 1.3
    assert np.isnan(found.sel({"method": "exact"}))


def test_the_exact_method_is_at_rounding(race):
    one = race.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    assert float(one.error_end) < 1e-13
    assert float(one.error_impact_tau) < 1e-13
    assert float(one.error_harmonics) < 1e-13


@pytest.mark.benchmark
def test_the_exact_method_takes_less_time_than_newmark_at_1e_4(race):
    one = race.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    newmark = race.sel({"motion": "symmetric", "method": "newmark"})
    enough = newmark.error_end <= 1e-4
    assert float(newmark.time_per_period.where(enough).min()) > float(one.time_per_period)


def test_a_peer_does_well_where_nothing_chatters_and_does_not_end_where_it_does(race):
    peer = race.sel({"method": "DOP853"}).isel(setting=1)
    assert int(peer.sel(motion="symmetric").outcome) == Outcome.OK
    assert float(peer.sel(motion="symmetric").error_end) < 1e-7
    assert int(peer.sel(motion="chatter").outcome) == Outcome.DID_NOT_END
    assert np.isnan(peer.sel(motion="chatter").time_per_period)
    assert race.periods_run.sel({"method": "DOP853"}).values.tolist() == [2, 2]
    assert race.periods_run.sel({"method": "exact"}).values.tolist() == [6, 2]


def test_places_without_a_setting_are_told(race):
    exact_only = race.sel({"method": "exact"}).outcome.values
    assert (exact_only[:, 1:] == Outcome.NOT_TRIED).all()
    assert (exact_only[:, 0] == Outcome.OK).all()


def test_quartiles_hold_the_median(race):
    timed = np.isfinite(race.time_per_period.values)
    low, high = race.time_per_period_low.values, race.time_per_period_high.values
    assert (low[timed] <= race.time_per_period.values[timed]).all()
    assert (race.time_per_period.values[timed] <= high[timed]).all()
    assert (low[timed] > 0).all()


def test_work_is_counted(race):
    steps = race.work_steps.sel({"motion": "symmetric", "method": "newmark"}).values
    np.testing.assert_array_equal(steps, [64, 256, 1024, 4096])
    one = race.sel({"motion": "symmetric", "method": "exact"}).isel(setting=0)
    assert 0 < float(one.work_evaluations) < float(one.work_steps)


def test_the_crude_kernel_is_the_crude_method_written_down_plainly():
    """Constant average acceleration by its own equations, and the support at the step's end."""
    motion, steps = SYMMETRIC._replace(periods=2), 40
    e, dt = motion.exciter, motion.exciter.period / steps
    x, v, struck = 0.0, 0.0, []
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
                    struck.append(((n + 1) * dt, support, v))
                    v = -0.7 * v
    shown = newmark_crude(motion, steps).show()
    assert shown.end == pytest.approx((x, v), abs=1e-12)
    assert shown.impact_support.tolist() == [s for _, s, _ in struck]
    np.testing.assert_allclose(shown.impact_tau, [tau for tau, _, _ in struck], rtol=1e-12)
    np.testing.assert_allclose(shown.impact_velocity, [v for _, _, v in struck], rtol=1e-10)


def test_samples_of_all_methods_are_of_the_last_period():
    p = Parameters(nu=1, f=-1, h=0.2, l=0.5, R1=0.7, R2=0.7)
    twin = Oracle(p, digits(p, 30)).run(SYMMETRIC.tau_end)
    times = (5 + np.arange(SAMPLES) / SAMPLES) * SYMMETRIC.exciter.period
    truth = [float(twin.state(twin.pieces[0][0] * 0 + t)[0]) for t in times]
    for contestant, allowed in (
        (exact(SYMMETRIC), 1e-14),
        (newmark(SYMMETRIC, 4096), 1e-5),
        (newmark_crude(SYMMETRIC, 4096), 1e-2),
        (peers.scipy_peer(SYMMETRIC, "DOP853", 1e-10), 1e-8),
    ):
        assert np.abs(contestant.show().samples - truth).max() < allowed


def shown(**changes) -> MethodResult:
    found = exact(SYMMETRIC).show()
    return found._replace(**changes)


def test_a_missed_impact_is_found_out():
    judge = MotionReference(SYMMETRIC)
    whole = shown()
    assert judge.errors(whole)[0] == Outcome.OK
    less = shown(
        impact_tau=whole.impact_tau[1:],
        impact_support=whole.impact_support[1:],
        impact_velocity=whole.impact_velocity[1:],
    )
    assert judge.errors(less)[0] == Outcome.MISSED_IMPACT


def test_errors_are_those_put_in():
    judge = MotionReference(SYMMETRIC)
    whole = shown()
    off = shown(
        end=(whole.end[0] + 1e-3 * judge.size, whole.end[1]),
        impact_tau=whole.impact_tau + 1e-4 * SYMMETRIC.exciter.period,
        impact_velocity=whole.impact_velocity * (1 - 1e-5),
        samples=whole.samples + 1e-6 * judge.size * np.cos(2 * np.pi * np.arange(64) / 64),
    )
    expected = [1e-3, 1e-4, 1e-5 * np.abs(whole.impact_velocity).max() / judge.speed, 1e-6]
    assert judge.errors(off)[1] == pytest.approx(expected, rel=1e-6)


def test_a_fall_through_a_support_is_found_out():
    recorder = peers.Recorder(SYMMETRIC)
    inside, outside = np.zeros(SAMPLES), np.full(SAMPLES, 0.51)
    work = (1.0, 1.0, 1.0)
    assert recorder.shown(inside, (0.0, 0.0), work).outcome == Outcome.OK
    assert recorder.shown(outside, (0.0, 0.0), work).outcome == Outcome.FELL_THROUGH
    assert recorder.shown(inside, (math.nan, 0.0), work).outcome == Outcome.DID_NOT_END


def test_a_peer_that_does_not_end_is_stopped_by_its_work_whatever_the_machine(monkeypatch):
    first = MotionReference(CHATTER).errors(build_method("DOP853", 1e-6, CHATTER).show())
    assert first[0] == Outcome.DID_NOT_END
    # a motion with no impact in it ends within a bound and not within one less than it needs
    easy = BenchmarkMotion(vp.Exciter(l=0.5, f=0.01, h=0.2), 0.0, 0.0, 2)
    needed = build_method("RK45", 1e-6, easy).show().effort[1]
    for most, outcome in ((needed // 2 + 1, Outcome.OK), (needed // 2, Outcome.DID_NOT_END)):
        monkeypatch.setattr(peers, "MAX_WORK", most)
        assert build_method("RK45", 1e-6, easy).show().outcome == outcome


def test_all_but_the_times_is_the_same_in_every_run():
    asked = ({"chatter": CHATTER}, ("crude", "newmark", "exact", "RK45", "heyoka"))
    one, two = (solve_accuracy(*asked, (64,), (1e-5,), repeats=1) for _ in "12")
    same = [name for name in one.data_vars if not name.startswith("time_per_period")]
    assert len(same) == len(one.data_vars) - 3
    for name in same:
        np.testing.assert_array_equal(one[name].values, two[name].values, err_msg=str(name))


def test_the_crude_way_is_right_where_steps_are_too_many_for_a_table():
    ends = [newmark_crude(SYMMETRIC, steps).show().end for steps in (8192, 10_000, 30_000)]
    truth = MotionReference(SYMMETRIC).end
    assert np.abs(np.array(ends) - truth).max() < 5e-3
    assert np.abs(np.array(ends[-1]) - truth).max() < 2e-3


def test_a_peer_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setattr(peers, "is_installed", lambda method: False)
    ds = solve_accuracy({"one": SYMMETRIC._replace(periods=1)}, ("heyoka",), tolerances=(1e-6,))
    assert ds.outcome.values.ravel().tolist() == [Outcome.NOT_INSTALLED]


def test_heyoka_meets_the_truth_where_it_is_installed():
    entered = build_method("heyoka", 1e-12, SYMMETRIC)
    if importlib.util.find_spec("heyoka") is None:
        assert entered == Outcome.NOT_INSTALLED
        return
    outcome, errors = MotionReference(SYMMETRIC).errors(entered.show())
    assert outcome == Outcome.OK
    assert max(errors) < 1e-9
