"""Measured cost of effects: equal contacts by all kernels, alternating timers, consistent ratios."""

import math

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab import timing
from vibropipe.lab.effect_costs import TimingCase, measure_effects, stored_bytes, timed_work
from vibropipe.lab.timing import Timer, time_in_rounds
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.physics.effects import ALL_EFFECTS

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
    "plain": TimingCase(PLAIN, group="motions", title="the plain one"),
    "full": TimingCase(FULL, against="plain"),
    "free": TimingCase(FREE, against="plain"),
    "sampled": TimingCase(PLAIN, outputs=("impacts", "motion"), against="plain"),
    "general": TimingCase(PLAIN, kernel="all", against="plain"),
}
# each compiles the kernel of sweeps for its effects
ROWS = {
    "row": TimingCase(PLAIN, row=True, outputs=("harmonics",)),
    "quiet": TimingCase(QUIET, row=True, outputs=("harmonics",), against="row"),
}


def measure(cases):
    return measure_effects(cases, lambda motion, row, outputs: 8.0 + motion.periods, 9)


@pytest.fixture(scope="module")
def measured():
    return measure(MARCHED)


@pytest.fixture(scope="module")
def rows_too():
    return measure(MARCHED | ROWS)


def test_each_case_has_its_words_and_what_it_is_compared_with(measured):
    assert measured.compared_with.values.tolist() == ["plain"] * 5
    assert measured.label.values.tolist()[:3] == ["the plain one", "full", "free"]
    assert measured.group.values.tolist() == ["motions", "", "", "", ""]
    assert measured.kernel.values.tolist() == ["own"] * 4 + ["all"]
    assert measured.bytes_per_row.sel(motion="free") == 1008


def test_quartiles_hold_the_median_and_scatter_that_of_a_ratio_of_1(measured):
    for name in ("time_per_unit", "time_ratio"):
        assert (measured[f"{name}_low"] <= measured[name]).all()
        assert (measured[name] <= measured[f"{name}_high"]).all()
    plain = measured.sel(motion="plain")
    deviation = max(abs(float(plain[f"time_ratio{side}"]) - 1) for side in ("", "_low", "_high"))
    assert float(plain.time_scatter) == deviation
    assert np.unique(measured.time_scatter).size == 1


@pytest.mark.benchmark
def test_ratios_are_those_of_the_times(rows_too):
    for name, other in (("full", "plain"), ("sampled", "plain"), ("quiet", "row")):
        one, of = rows_too.sel(motion=name), rows_too.sel(motion=other)
        ratio = float(one.time_per_unit / of.time_per_unit)
        assert float(one.time_ratio) == pytest.approx(ratio, rel=0.3)


@pytest.mark.benchmark
def test_closed_forms_are_used_where_they_exist(rows_too):
    assert float(rows_too.time_ratio.sel(motion="free")) < 0.5
    assert float(rows_too.time_ratio.sel(motion="quiet")) < 0.5


def test_the_kernel_of_all_effects_marches_what_has_a_closed_form():
    free = TimingCase(FREE, kernel="all")
    assert timed_work(free).impacts == pytest.approx(timed_work(TimingCase(FREE)).impacts)
    assert timed_work(free).repeat.__self__.effects == free.all_effects


def test_effects_and_contacts_of_motions(measured):
    one = measured.sel(motion="full")
    assert one.rests_per_period > 0
    assert one.effects_present.item() == "damping, forcing, support_1, support_2, restitution, rest"
    assert measured.impacts_per_period.sel(motion="plain") == 2
    assert measured.outputs_asked.sel(motion="sampled").item() == "impacts, motion"


@pytest.mark.slow
def test_effects_and_outputs_of_rows(rows_too):
    assert rows_too.effects_present.sel(motion="quiet").item() == "damping, forcing"
    assert rows_too.impacts_per_period.sel(motion="quiet") == 0
    assert rows_too.unit.sel(motion="row").item() == "row"


@pytest.mark.slow
def test_a_row_counts_the_periods_of_its_transient():
    work = timed_work(TimingCase(PLAIN, row=True, outputs=("harmonics",)))
    steady = vp.steady_state(PLAIN.exciter)
    assert work.periods == int(steady.periods_to_settle)
    assert work.units == 1
    assert math.isclose(work.impacts, float(steady.impacts_per_orbit.sum()))


def test_bytes_are_measured_with_the_effects_of_the_motion_alone():
    exciter = vp.Exciter(l=0.5, nu=1, f=-1, h=0.2, R1=0.7, R2=0.6, delta=0.01, load=0.02)
    motion = BenchmarkMotion(exciter, 0.02, 0.0, 4)
    two = stored_bytes(motion, False, ("impacts",))
    assert two == pytest.approx(
        stored_bytes(motion._replace(periods=8), False, ("impacts",)), rel=0.5
    )
    assert stored_bytes(motion, True, ()) > 0
