"""Progress in a log and on a terminal, and its cost."""

import io
import time

import pytest

from vibropipe.jobs import progress
from vibropipe.jobs.progress import progress_text, show_progress
from vibropipe.jobs.solving import solve_scene
from vibropipe.study import parse_study
from vibropipe.words.progress import WorkCount

SCENES = {
    "marched": {"kind": "motion", "tau_end": 5, "settle_periods": 4000},
    "newmark": {
        "kind": "motion",
        "tau_end": 3000,
        "settle_periods": 1000,
        "solver": {"method": "newmark", "steps_per_period": 20},
        "outputs": ["motion", "energy"],
        "samples_per_period": 1,
    },
    "cases": {"kind": "hard_cases", "cases": ["split", "damping"]},
    "race": {
        "kind": "accuracy",
        "motions": {"plain": {"periods": 1}, "soft": {"exciter": {"R1": 0.5}, "periods": 1}},
        "methods": ["newmark", "exact"],
        "steps_per_period": [16, 64],
        "repeats": 1,
    },
    "sweep": {"kind": "sweep", "over": {"nu": [0.9, 1.0, 1.1]}},
}
TOTALS = {"marched": 4000, "newmark": 3432, "cases": 2, "race": 6, "sweep": 3}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    exciter = {"l": 0.5, "nu": 1, "f": -1, "h": 0.2, "R1": 0.7, "R2": 0.7}
    file = tmp_path_factory.mktemp("study") / "t.yaml"
    file.write_text("a study")  # read for the provenance
    tree = {"title": "t", "exciter": exciter, "scenes": SCENES}
    return parse_study(tree, source=str(file))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    return now


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((0, 10, 1.0), "0 of 10 rows, 0 rows/s"),
        ((12288, 100000, 5.0), "12,288 of 100,000 rows, 2,458 rows/s, 36 s left"),
        ((3, 10**6, 6.0), "3 of 1,000,000 rows, 0.5 rows/s, 555 h 33 min left"),
        ((500, 1000, 200.0), "500 of 1,000 rows, 2.5 rows/s, 3 min 20 s left"),
        ((1000, 1000, 0.5), "1,000 rows in 0.5 s, 2,000 rows/s"),
    ],
)
def test_the_text_holds_points_rate_and_time_left(arguments, text):
    assert progress_text(*arguments, "rows") == text


def test_one_of_a_kind_is_singular():
    assert progress_text(1, 1, 0.1, "branches") == "1 branch in 0.1 s, 10 branches/s"
    assert progress_text(0, 1, 1.0, "curves") == "0 of 1 curve, 0 curves/s"
    assert progress_text(1, 0, 2.0, "steps") == "1 step, 0.5 steps/s"


def test_a_log_gets_few_plain_lines_and_a_last_one(clock):
    log = io.StringIO()
    with show_progress("response", stream=log) as on_progress:
        for second in range(1, 3601):
            clock[0] = float(second)
            on_progress(second, 3600)
    lines = log.getvalue().splitlines()
    assert lines[0] == "response: 5 of 3,600 rows, 1 rows/s, 59 min 55 s left"
    assert lines[1].startswith("response: 10 of 3,600")
    assert lines[-1] == "response: 3,600 rows in 1 h 00 min, 1 rows/s"
    # doubling up to five minutes, then one line in five minutes
    assert len(lines) == 18
    assert "\x1b" not in log.getvalue()


def test_a_terminal_gets_a_bar(clock, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal()
    with show_progress("response", stream=terminal) as on_progress:
        for done in (1000, 2000, 4000):
            clock[0] += 1.0
            on_progress(done, 4000)
    text = terminal.getvalue()
    assert "1,000 of 4,000 rows, 1,000 rows/s, 3.0 s left" in text
    assert "4,000 rows in 3.0 s, 1,333 rows/s" in text
    assert "━" in text


@pytest.mark.parametrize("name", SCENES)
def test_every_kind_of_scene_reports_its_progress(name, study):
    seen = []
    solve_scene(study, name, progress=lambda *counts: seen.append(counts))
    done = [count for count, _ in seen]
    assert done == sorted(done)
    (total,) = {total for _, total in seen}
    assert done[-1] == total
    # where a record begins at the end of a period it may be counted to either
    assert abs(total - TOTALS[name]) <= (name == "newmark")
    if name in ("marched", "cases", "race"):
        assert len(done) > 1


def test_work_of_unknown_length_shows_points_and_rate(clock, monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    for stream in (io.StringIO(), Terminal()):
        clock[0] = 0.0
        with show_progress("motion", "periods", stream) as on_progress:
            marched = WorkCount(0, on_progress)
            for _ in range(12):
                clock[0] += 1.0
                marched.add(1000)
        assert "10,000 periods, 1,000 periods/s" in stream.getvalue()
        assert "left" not in stream.getvalue()


@pytest.mark.benchmark
def test_reports_of_a_march_cost_less_than_one_percent(study):
    calls = []
    begin = time.process_time()
    solve_scene(study, "marched", progress=lambda *counts: calls.append(counts))
    worked = time.process_time() - begin
    with show_progress("marched", "periods", io.StringIO()) as on_progress:
        marched = WorkCount(10**9, on_progress)
        begin = time.process_time()
        for _ in range(10_000):
            marched.add(1)
        each = (time.process_time() - begin) / 10_000
    assert len(calls) * each < 0.01 * worked


@pytest.mark.benchmark
@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()])
def test_progress_costs_less_than_one_percent(stream, clock, monkeypatch):
    """One call every 10 ms, as by the fastest rows; the bar is drawn every half second."""
    monkeypatch.setenv("TERM", "xterm")
    with show_progress("response", stream=stream) as on_progress:
        clock[0] = 1e-3
        on_progress(1, 10**9)  # what is loaded once
        begin = time.process_time()
        for done in range(2, 1002):
            clock[0] += 0.01
            on_progress(done, 10**9)
        spent = time.process_time() - begin
    assert stream.getvalue()
    assert spent < 0.01 * 10
