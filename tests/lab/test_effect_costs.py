"""Measured cost of effects: equal contacts by all kernels, alternating timers, consistent ratios."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab import timing
from vibropipe.lab.effect_costs import KERNELS, measure_effects
from vibropipe.lab.effect_work import TimingCase, works_by_kernel
from vibropipe.lab.timing import Timer, expected_timing, time_in_rounds
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.words.measurements import Passed

FULL = BenchmarkMotion(vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 4)
PLAIN = BenchmarkMotion(vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7), 0.0, 0.0, 20)
UNFORCED = BenchmarkMotion(vp.Exciter(l=0.5, h=0.005, R1=0.99, R2=0.99), 0.0, 2.0, 20)
FREE = BenchmarkMotion(vp.Exciter(l=0.5), 0.0, -0.51, 1000)
QUIET = BenchmarkMotion(vp.Exciter(l=0.5, nu=1.0, f=0.04, h=0.2), 0.0, 0.0, 20)


class Clock:
    """A clock that advances only with the calls of its timers."""

    def __init__(self):
        self.now, self.done = 0.0, []

    def timer(self, name, seconds, units):
        def repeat(n_calls):
            self.done.append(name)
            self.now += n_calls * seconds

        return Timer(repeat, units, lambda: self.now)


def test_times_are_per_unit_and_timers_alternate():
    clock = Clock()
    quick, slow = clock.timer("quick", 1e-6, 4), clock.timer("slow", 0.05, 1)
    progress = []
    time_in_rounds([quick, slow], 3, lambda *counts: progress.append(counts))
    assert progress == [(done, 6) for done in range(1, 7)]
    assert quick.times == pytest.approx([250.0] * 3)
    assert slow.times == pytest.approx([5e7] * 3)
    assert quick.n_calls * 1e-6 >= timing.MIN_SECONDS
    rounds = [name for i, name in enumerate(clock.done) if i == 0 or clock.done[i - 1] != name]
    assert rounds == ["quick", "slow"] * 4  # the first run of each warms up


def test_a_timer_stops_when_its_budget_is_spent():
    timer = Clock().timer("long", 0.1, 1)
    time_in_rounds([timer], 50)
    assert timer.spent == pytest.approx(0.3)
    assert expected_timing(0.1, 50) == pytest.approx(0.35)
    assert expected_timing(1e-6, 10) == pytest.approx(2 * 2e-3 + 10 * 3e-3)


@pytest.mark.parametrize("motion", [FULL, PLAIN, UNFORCED], ids=["full", "plain", "unforced"])
def test_every_kernel_marches_the_same_contacts(motion):
    marches = []
    for effects in (ALL_EFFECTS, TimingCase(motion).effects):
        march = March(motion, exact_grid(effects, motion.exciter.parameters()), effects)
        march.repeat(3)
        marches.append(march.log)
    simulated = vp.simulate(
        motion.exciter, motion.tau_end, motion.x0, motion.v0, samples_per_period=0
    )
    for log in marches:
        n = int(log.counts[IMPACTS])
        struck = log.support[:n] > 0
        tau = log.position[:n][struck] * motion.exciter.period
        np.testing.assert_allclose(tau, simulated.impact_tau.values, rtol=1e-11)
        assert int(log.counts[RESTS]) == np.isfinite(simulated.rest_end.values).sum()


MARCHED = {
    "full": TimingCase(FULL),
    "plain": TimingCase(PLAIN, at_most=1e6),
    "free": TimingCase(FREE, at_most=1e-6),
    "sampled": TimingCase(PLAIN, outputs=("impacts", "motion")),
    "alone": TimingCase(PLAIN, against="sampled", at_most=0.9),
}
# each compiles the kernel of sweeps for its effects
ROWS = {
    "row": TimingCase(PLAIN, row=True, outputs=("harmonics",)),
    "quiet": TimingCase(QUIET, row=True, outputs=("harmonics",), against="row"),
}


def measure(cases):
    return measure_effects(cases, FULL, lambda motion, row, outputs: 8.0 + motion.periods, 9)


@pytest.fixture(scope="module")
def measured():
    return measure(MARCHED)


@pytest.fixture(scope="module")
def rows_too():
    return measure(MARCHED | ROWS)


def test_ratios_of_the_own_kernel_to_itself_are_1(measured):
    own = measured.sel(kernel="own")
    np.testing.assert_array_equal(own.time_ratio, 1)
    np.testing.assert_array_equal(own.bytes_ratio, 1)
    assert measured.kernel.values.tolist() == list(KERNELS)
    for name in ("kernel_time", "time_ratio"):
        assert (measured[f"{name}_low"] <= measured[name]).all()
        assert (measured[name] <= measured[f"{name}_high"]).all()


@pytest.mark.benchmark
def test_ratios_are_those_of_the_times(rows_too):
    motions = ["full", "plain", "free", "sampled", "row"]  # equally long by every kernel
    ratio = rows_too.kernel_time.sel(kernel="own") / rows_too.kernel_time.sel(kernel="all")
    measured_ratio = rows_too.time_ratio.sel(kernel="all").sel(motion=motions)
    np.testing.assert_allclose(measured_ratio, ratio.sel(motion=motions), rtol=0.5)


def test_ratios_are_those_of_the_bytes(measured):
    bytes_ratio = measured.bytes_ratio.sel(motion="free", kernel="full")
    assert float(bytes_ratio) == pytest.approx(1008 / 12)


@pytest.mark.benchmark
def test_closed_forms_are_used_where_they_exist(rows_too):
    assert float(rows_too.time_ratio.sel(motion="free", kernel="all")) < 0.5
    # A row is in closed form by every kernel; the one of all effects is marched.
    assert 0.5 < float(rows_too.time_ratio.sel(motion="quiet", kernel="all")) < 2
    assert float(rows_too.time_ratio.sel(motion="quiet", kernel="full")) < 0.5
    assert 0.5 < float(rows_too.time_ratio.sel(motion="plain", kernel="all")) < 2


def test_targets_follow_from_the_ratios(measured):
    met = dict(zip(measured.motion.values, measured.target_met.values.tolist(), strict=True))
    assert (met["plain"], met["free"]) == (Passed.PASSED, Passed.NOT_PASSED)
    assert met["full"] == Passed.NOT_ASKED
    alone = measured.sel(motion="alone")
    assert (float(alone.target_ratio) <= 0.9) == bool(alone.target_met == Passed.PASSED)
    assert alone.target_against.item() == "sampled"
    assert np.isnan(measured.target.sel(motion="full"))


def test_effects_and_contacts_of_motions(measured):
    one = measured.sel(motion="full", kernel="own")
    assert one.rests_per_period > 0
    assert one.effects_present.item() == "damping, forcing, support_1, support_2, restitution, rest"
    np.testing.assert_array_equal(measured.sel(motion="plain").impacts_per_period[:2], 2)


@pytest.mark.slow
def test_effects_and_outputs_of_rows(rows_too):
    assert rows_too.effects_present.sel(motion="quiet").item() == "damping, forcing"
    assert (rows_too.impacts_per_period.sel(motion="quiet", kernel=["own", "all"]) == 0).all()
    assert rows_too.outputs_asked.sel(motion="row").item() == "steady state, harmonics"


@pytest.mark.slow
def test_a_row_counts_the_periods_of_its_transient():
    works = works_by_kernel(TimingCase(PLAIN, row=True, outputs=("harmonics",)), FULL)
    steady = vp.steady_state(PLAIN.exciter)
    assert works["own"].periods == int(steady.periods_to_settle)
    assert works["own"].units == 1
    assert math.isclose(works["own"].impacts, float(steady.impacts_per_orbit.sum()))
