"""`vibropipe bench`: ratios of known times, missing reference packages, and the motion of the textbook loop."""

import json
import math

import pytest
from command_line import run

import vibropipe as vp
from vibropipe.lab import work_precision
from vibropipe.lab.bench import Candidate, Item, PreparedRun, Target, as_json, as_text, measure
from vibropipe.lab.bench_items import motion_item, sweep_item, textbook


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
