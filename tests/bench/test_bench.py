"""What `vibropipe bench` says: ratios by what was put in, peers that are missing, the textbook loop's motion."""

from __future__ import annotations

import json
import math

import pytest

import vibropipe as vp
from vibropipe import cli
from vibropipe.bench.cases import in_lanes, one_motion, rows_near, swept, textbook_run
from vibropipe.bench.formatting import as_json, as_text
from vibropipe.bench.measurement import Candidate, Item, PreparedRun, Target, measure
from vibropipe.bench.textbook import textbook
from vibropipe.lab import peers


class Work:
    """Work that takes so many seconds of a clock that only it turns."""

    now = 0.0

    def __init__(self, *seconds: float) -> None:
        self.seconds, self.calls = seconds, 0

    def __call__(self, often: int) -> None:
        Work.now += often * self.seconds[self.calls % len(self.seconds)]
        self.calls += 1

    def contestant(self, name: str, units: float = 1.0, error: float = math.nan) -> Candidate:
        return Candidate(name, lambda: PreparedRun(self, units, error), lambda: Work.now)


@pytest.fixture
def item():
    return Item(
        "work",
        "of a kind",
        "piece",
        [
            Work(0.01).contestant("ours", 10.0, 1e-15),
            Work(0.05).contestant("slow", 5.0),
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
    one = Item("work", "", "piece", [slow_at_first.contestant("ours")], [])
    measure([one], 2)
    assert max(one.find("ours").times) == pytest.approx(1e7)


def test_the_table_hides_nothing(item):
    measure([item], 3)
    said = as_text([item])
    assert "absent" in said
    assert "not installed" in said
    assert "1 ms to 1 ms" in said
    assert "1e-15" in said
    assert "ours against slow: 10 times cheaper (10 to 10), asked 10: reached" in said
    assert "asked 11: not reached" in said
    assert "ours against absent: not measured, asked 2" in said


def test_json_holds_every_round(item):
    measure([item], 3)
    told = json.loads(as_json([item]))["items"][0]
    assert len(told["contestants"][1]["rounds"]) == 3
    assert told["contestants"][2]["why_not"] == "not installed"
    assert told["contestants"][2]["nanoseconds"] is None
    assert [target["reached"] for target in told["targets"]] == [True, False, False]


def test_the_command_prints_the_table_or_json(item, monkeypatch, capsys):
    asked = []
    monkeypatch.setattr("vibropipe.bench.cases.items", lambda whole: asked.append(whole) or [item])
    for arguments in (["bench"], ["bench", "--whole", "--rounds", "2", "--json"]):
        with pytest.raises(SystemExit) as stopped:
            cli.main(arguments)
        assert not stopped.value.code
    said = capsys.readouterr().out
    table, told = said[: said.index("{")], json.loads(said[said.index("{") :])
    assert "ours against slow: 10 times cheaper (10 to 10), asked 10: reached" in table
    assert len(told["items"][0]["contestants"][0]["rounds"]) == 2
    assert asked == [False, True]


def test_a_peer_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setattr(peers, "is_installed", lambda package: False)
    for found in (one_motion(), swept(whole=False)):
        for target in found.targets:
            assert found.find(target.peer).build() == "not installed"


def test_the_textbook_loop_is_newmark_of_first_order_at_impacts():
    """Its end comes nearer to the exact motion's as the step shrinks."""
    e = vp.Exciter(l=1.0, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.8)
    exact = vp.simulate(e, 4 * e.period, samples_per_period=0)
    errors = []
    for steps in (1000, 16000):
        x, v, struck = textbook((e.nu, e.f, e.h, e.l, e.R1), steps, 4)
        assert struck == exact.sizes["impact"]
        errors.append(abs(x - float(exact.displacement_end)) + abs(v - float(exact.velocity_end)))
    assert errors[1] < errors[0] / 4
    assert errors[1] < 1e-3


def test_rows_of_the_lanes_strike_twice_a_period():
    listed = [vp.Exciter(**dict(zip(("nu", "f", "h", "l", "delta", "R1", "R2"), row, strict=True)))
              for row in rows_near()[:3].tolist()]  # fmt: skip
    for e in listed:
        found = vp.simulate(e, 20 * e.period, samples_per_period=0)
        assert found.sizes["impact"] == pytest.approx(40, abs=2)
    assert in_lanes().units == 128 * textbook_run().units
