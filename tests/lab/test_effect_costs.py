"""Measured times: cost of effects by all kernels, and `vibropipe bench` beside other packages."""

import json
import math

import numpy as np
import pytest
from command_line import run

import vibropipe as vp
from vibropipe.lab import timing, work_precision
from vibropipe.lab.bench import Candidate, Item, PreparedRun, Target, as_json, as_text, measure
from vibropipe.lab.bench_items import motion_item, sweep_item, textbook
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


def measured_costs(cases):
    return measure_effects(cases, lambda motion, row, outputs: 8.0 + motion.periods, 9)


@pytest.fixture(scope="module")
def measured():
    return measured_costs(MARCHED)


@pytest.fixture(scope="module")
def rows_too():
    return measured_costs(MARCHED | ROWS)


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


class Work:
    """Work that takes the given seconds of a clock of its own, call by call."""

    now = 0.0

    def __init__(self, *seconds: float) -> None:
        self.seconds, self.calls = seconds, 0

    def __call__(self, n_calls: int) -> None:
        Work.now += n_calls * self.seconds[self.calls % len(self.seconds)]
        self.calls += 1

    def candidate(self, name: str, units: float = 1.0, error: float = math.nan) -> Candidate:
        return Candidate(name, lambda: PreparedRun(self, units, error), lambda: Work.now)


@pytest.fixture
def item():
    return Item(
        "work",
        "of a kind",
        "piece",
        [
            Work(0.01).candidate("ours", 10.0, 1e-15),
            Work(0.05).candidate("slow", 5.0),
            Candidate("absent", lambda: "not installed"),
        ],
        [Target("ours", "slow", 10), Target("ours", "slow", 11), Target("ours", "absent", 2)],
    )


def test_times_are_per_unit_and_ratios_of_medians(item):
    measure([item], 3)
    assert item.find("ours").quartiles() == pytest.approx((1e6, 1e6, 1e6))
    assert item.find("slow").quartiles() == pytest.approx((1e7, 1e7, 1e7))
    assert item.ratios(item.targets[0]) == pytest.approx((10, 10, 10))
    assert len(item.find("slow").times) == 3


def test_the_first_call_is_not_among_the_times():
    slow_at_first = Work(9.0, 0.01, 0.01)
    one = Item("work", "", "piece", [slow_at_first.candidate("ours")], [])
    measure([one], 2)
    assert max(one.find("ours").times) == pytest.approx(1e7)


def test_the_table_shows_all_candidates_and_targets(item):
    measure([item], 3)
    text = as_text([item])
    assert "absent" in text
    assert "not installed" in text
    assert "1 ms to 1 ms" in text
    assert "1e-15" in text
    assert "ours against slow: 10 times faster (quartiles 10 to 10), target 10: met" in text
    assert "target 11: not met" in text
    assert "ours against absent: not measured, target 2" in text


def test_a_target_below_one_is_a_limit(item):
    item.targets = [Target("slow", "ours", 1 / 20), Target("slow", "ours", 1 / 5)]
    measure([item], 3)
    text = as_text([item])
    assert "slow against ours: 10 times slower (quartiles 10 to 10), limit 20: met" in text
    assert "limit 5: not met" in text


def test_json_contains_every_round(item):
    measure([item], 3)
    result = json.loads(as_json([item]))["items"][0]
    assert len(result["contestants"][1]["rounds"]) == 3
    assert result["contestants"][2]["why_not"] == "not installed"
    assert result["contestants"][2]["nanoseconds"] is None
    assert [target["reached"] for target in result["targets"]] == [True, False, False]


def test_the_command_prints_the_table_or_json(item, monkeypatch, capsys):
    whole_options = []
    monkeypatch.setattr(
        "vibropipe.lab.bench_items.items", lambda whole: whole_options.append(whole) or [item]
    )
    for arguments in (["bench"], ["bench", "--whole", "--rounds", "2", "--json"]):
        assert run(*arguments) == 0
    output = capsys.readouterr().out
    table, result = output[: output.index("{")], json.loads(output[output.index("{") :])
    assert "ours against slow: 10 times faster (quartiles 10 to 10), target 10: met" in table
    assert len(result["items"][0]["contestants"][0]["rounds"]) == 2
    assert whole_options == [False, True]


def test_a_missing_package_is_reported(monkeypatch):
    monkeypatch.setattr(work_precision, "is_installed", lambda package: False)
    for item in (motion_item(), sweep_item(whole=False)):
        for peer in {target.peer for target in item.targets} - {"textbook loop"}:
            assert item.find(peer).build() == "not installed"


def test_the_textbook_loop_is_newmark_of_first_order_at_impacts():
    """Its end converges to that of the exact motion as the step shrinks."""
    e = vp.Exciter(l=1.0, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.8)
    exact = vp.simulate(e, 4 * e.period, samples_per_period=0)
    errors = []
    for steps in (1000, 16000):
        x, v, n_impacts = textbook((e.nu, e.f, e.h, e.l, e.R1), steps, 4)
        assert n_impacts == exact.sizes["impact"]
        errors.append(abs(x - float(exact.displacement_end)) + abs(v - float(exact.velocity_end)))
    assert errors[1] < errors[0] / 4
    assert errors[1] < 1e-3
