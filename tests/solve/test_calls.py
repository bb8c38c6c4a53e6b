"""Calls: on several threads, in order, with progress, warnings where rows fail, and how each dataset was made."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.solve.sweep.blocks import solve_blocks
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.threads import Threads
from vibropipe.words.progress import WorkCount, part_of
from vibropipe.words.status import Status

EXCITER = vp.Exciter(l=0.5, h=0.2, nu=1.0, f=0.8, R1=0.7, R2=0.7)
EFFECTS = "damping, forcing, support_1, support_2, restitution, rest"
START = "x0 = 0, v0 = 0"
MADE = ("method", "effects", "start", "follow", "version", "steps_per_period")


def made(dataset: xr.Dataset) -> dict[str, object]:
    """Return the attributes that say how a dataset was made, without the version."""
    assert dataset.attrs["version"] == vp.__version__
    return {
        name: dataset.attrs[name] for name in MADE if name in dataset.attrs and name != "version"
    }


def test_datasets_from_python_say_how_they_were_made() -> None:
    exact = {"method": "exact", "effects": EFFECTS, "start": START}
    newmark = exact | {"method": "newmark", "steps_per_period": 40}
    assert made(vp.simulate(EXCITER, 3.0)) == exact
    assert made(vp.simulate(EXCITER, 3.0, method="newmark", steps_per_period=40)) == newmark
    assert made(vp.steady_state(EXCITER, x0=0.1)) == exact | {"start": "x0 = 0.1, v0 = 0"}
    over = {"nu": [1.0, 1.1]}
    assert made(vp.sweep(EXCITER, over)) == exact
    for way in ("up", "down", "both"):
        followed = vp.sweep(EXCITER, over, follow=("nu", way))
        assert made(followed) == exact | {"follow": f"nu {way}"}
    free = {"method": "exact", "effects": "support_1, support_2"}
    assert made(vp.backbone(0.1, 2.0)) == free | {"start": "free vibration"}
    start = "free vibration, tau = 0 at its end towards support 1"
    assert made(vp.amplitude_frequency(EXCITER, 2.0)) == free | {"start": start}


def test_an_accuracy_names_the_method_it_chose() -> None:
    # the march without steps is the cheapest, for a coarse accuracy too
    for accuracy in (1e-2, 1e-9):
        motion = vp.simulate(EXCITER, 3.0, accuracy=accuracy)
        assert motion.attrs["method"] == "exact"
        assert "steps_per_period" not in motion.attrs


STUDY = """\
title: t
exciter: {l: 0.5}
scenes:
  exact: {kind: motion, exciter: FORCED, tau_end: 3}
  newmark: {kind: motion, exciter: FORCED, tau_end: 3, solver: {method: newmark, steps_per_period: 40}}
  coarse: {kind: motion, exciter: FORCED, tau_end: 3, solver: {accuracy: 0.01}}
  sweep: {kind: sweep, exciter: SWEPT, over: {nu: [1, 1.1]}, follow: {along: nu, direction: down}}
  backbone: {kind: backbone, delta_over_l: [0.1], tau_bar: [2]}
  amplitude: {kind: backbone, amplitude: [2]}
"""


@pytest.mark.parametrize("name", ["exact", "newmark", "coarse", "sweep", "backbone", "amplitude"])
def test_a_study_says_the_same(name: str, tmp_path: Path) -> None:
    from vibropipe.jobs.solving import solve_to_file
    from vibropipe.study import load_study

    swept = "{f: 0.8, h: 0.2, R1: 0.7, R2: 0.7}"
    text = STUDY.replace("SWEPT", swept).replace("FORCED", "{nu: 1, " + swept[1:])
    (tmp_path / "t.yaml").write_text(text)
    solve_to_file(load_study(tmp_path / "t.yaml"), name, tmp_path / "s.nc", None, 1)
    over = {"nu": np.array([1, 1.1])}
    again = {
        "exact": lambda: vp.simulate(EXCITER, 3.0),
        "newmark": lambda: vp.simulate(EXCITER, 3.0, method="newmark", steps_per_period=40),
        "coarse": lambda: vp.simulate(EXCITER, 3.0, accuracy=0.01),
        "sweep": lambda: vp.sweep(EXCITER, over, follow=("nu", "down")),
        "backbone": lambda: vp.backbone(0.1, 2.0),
        "amplitude": lambda: vp.amplitude_frequency(EXCITER, 2.0),
    }
    stored, expected = made(vp.load(tmp_path / "s.nc")), made(again[name]())
    if "steps_per_period" in expected:
        # A study writes the method with its steps.
        expected["method"] = f"newmark, {expected['steps_per_period']} steps per forcing period"
    assert stored == expected


QUICK = vp.Exciter(l=0.5, nu=1.0, f=-1, h=0.2, R1=0.7, R2=0.7)
END = 2000.5 * QUICK.period
NEWMARK = {"method": "newmark", "steps_per_period": 20, "tau_end": END}


@pytest.mark.parametrize(
    ("call", "total"),
    [
        (lambda heard: vp.simulate(QUICK, tau_end=END, progress=heard), 2000),
        (lambda heard: vp.simulate(QUICK, tau_start=0.6, tau_end=END, progress=heard), 2000),
        (lambda heard: vp.simulate(QUICK, **NEWMARK, progress=heard), 2000),
        (lambda heard: vp.simulate(QUICK, **NEWMARK, energy=True, progress=heard), 4000),
        (lambda heard: vp.basins(QUICK, [0, 0.1], [0, 1, 2], starts=4, progress=heard), 6),
        (
            lambda heard: vp.basins(
                QUICK, [0, 0.1], [0], starts=4, over={"nu": [0.9, 1.0]}, progress=heard
            ),
            4,
        ),
        # 16 samples, and both ends of the axis of one parameter
        (lambda heard: vp.tolerance(QUICK, {"f": 0.01}, samples=16, progress=heard), 18),
        (
            lambda heard: list(
                solve_blocks(
                    grid_of(QUICK, {"nu": [0.9, 1.0, 1.1, 1.2]}), range(1, 4), 1, progress=heard
                )
            ),
            3,
        ),
    ],
)
def test_done_grows_to_the_total(call, total):
    counts = []
    call(lambda *each: counts.append(each))
    done = [each[0] for each in counts]
    assert done == sorted(done)
    assert {each[1] for each in counts} == {total}
    assert done[-1] == total


def test_the_total_of_a_motion_to_an_accuracy_is_unknown():
    counts = []
    progress = lambda *each: counts.append(each)  # noqa: E731
    vp.simulate(QUICK, tau_end=50 * QUICK.period, accuracy=1e-3, progress=progress)
    done = [each[0] for each in counts]
    assert done == sorted(done)
    assert done[-1] == 50  # marched once; another method would be marched beside it
    assert {each[1] for each in counts} == {0}


def test_a_part_reports_the_progress_of_all_work():
    counts = []
    part = part_of(lambda *each: counts.append(each), 3, 10)
    for done in (0, 4, 8):
        part(done, 8)
    assert counts == [(3, 10), (7, 10), (10, 10)]
    part = part_of(lambda *each: counts.append(each), 3, 0)
    part(4, 8)
    assert counts[-1] == (7, 0)
    assert part_of(None, 3, 10) is None


def test_a_count_ends_at_its_total():
    counts = []
    count = WorkCount(3, lambda *each: counts.append(each))
    for n in (1, 1, 5):
        count.add(n)
    assert counts == [(1, 3), (2, 3), (3, 3)]


@pytest.fixture
def threads():
    started = Threads(3)
    yield started
    started.stop()


def test_results_are_in_the_order_of_the_calls(threads):
    def late(n):
        time.sleep(0.02 * (n % 3))
        return n

    first = threads.submit([lambda n=n: late(n) for n in range(10)])
    second = threads.submit([lambda: "more"])
    assert second.take() == ["more"]
    assert first.take() == list(range(10))
    assert first.results == []


def test_calls_run_at_the_same_time(threads):
    together = threading.Barrier(3, timeout=20)
    assert sorted(threads.submit([together.wait] * 3).take()) == [0, 1, 2]


def test_waiting_ends_after_its_time_and_then_goes_on(threads):
    go_on = threading.Event()
    calls = threads.submit([lambda: go_on.wait(20)])
    assert not calls.wait(0.01)
    go_on.set()
    assert calls.wait(20)
    assert calls.wait(0.0)  # and again
    assert calls.take() == [True]


def test_an_error_is_raised_while_others_still_run(threads):
    go_on = threading.Event()
    calls = threads.submit([lambda: go_on.wait(20), lambda: 1 // 0])
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            calls.wait(20)
    go_on.set()


def test_stopping_drops_what_has_not_begun_and_waits_for_the_rest():
    threads, begun, made = Threads(2), threading.Barrier(3, timeout=20), []

    def call(n):
        if n < 2:
            begun.wait()
            time.sleep(0.1)
        made.append(n)

    calls = threads.submit([lambda n=n: call(n) for n in range(50)])
    begun.wait()
    threads.stop()
    assert sorted(made) == [0, 1]
    assert not calls.wait(0.0)


CHAOTIC = vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.1, R1=0.9, R2=0.9)
ORBIT = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)


def warned(call: Callable[[], xr.Dataset]) -> tuple[xr.Dataset, list[str]]:
    """Return a result and the texts of its warnings, which must name this file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        dataset = call()
    assert {warning.category for warning in caught} <= {vp.UnsolvedWarning}
    assert {warning.filename for warning in caught} <= {__file__}
    return dataset, [str(warning.message) for warning in caught]


def test_what_ends_as_requested_is_silent() -> None:
    over = {"nu": [0.9, 1.0]}
    assert warned(lambda: vp.simulate(ORBIT, 9.0))[1] == []
    assert warned(lambda: vp.simulate(ORBIT, 9.0, accuracy=1e-6))[1] == []
    assert warned(lambda: vp.steady_state(ORBIT))[1] == []
    assert warned(lambda: vp.sweep(ORBIT, over))[1] == []


@pytest.mark.parametrize(
    ("call", "status"),
    [
        (lambda: vp.simulate(ORBIT, 90.0, max_impacts=3), Status.MAX_IMPACTS),
        (lambda: vp.simulate(CHAOTIC, 900.0, accuracy=1e-12), Status.INACCURATE),
        (lambda: vp.steady_state(CHAOTIC), Status.MAX_PERIODS),
    ],
)
def test_a_motion_warns_with_its_remedy(call: Callable[[], xr.Dataset], status: Status) -> None:
    dataset, texts = warned(call)
    assert int(dataset.status) == status
    assert texts == [f"status {status.name.lower()}. {status.remedy}"]


@pytest.mark.parametrize(
    "effects",
    [
        None,
        # compiles a kernel of its own
        pytest.param(
            ["damping", "forcing", "support_1", "restitution", "rest"], marks=pytest.mark.slow
        ),
    ],
)
def test_a_sweep_warns_once_for_each_status_with_its_rows(effects: list[str] | None) -> None:
    over = {"nu": np.linspace(0.5, 0.8, 4), "f": [0.01, 1.0]}
    dataset, texts = warned(lambda: vp.sweep(CHAOTIC, over, effects=effects))
    expected = [
        f"{count} of 8 rows: status {Status(code).name.lower()}. {Status(code).remedy}"
        for code, count in zip(*np.unique(dataset.status, return_counts=True), strict=True)
        if code != Status.OK
    ]
    assert expected
    assert texts == expected
    assert Status.OK in dataset.status.values
