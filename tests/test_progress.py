"""Words of progress: in a log, on a terminal, and what they cost."""

import io
import time

import pytest

from vibropipe import progress
from vibropipe.progress import shown, words
from vibropipe.scenes import in_passes


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
    ("given", "said"),
    [
        ((0, 10, 1.0), "0 of 10 rows, 0 rows/s"),
        ((12288, 100000, 5.0), "12,288 of 100,000 rows, 2,458 rows/s, 36 s left"),
        ((3, 10**6, 6.0), "3 of 1,000,000 rows, 0.5 rows/s, 555 h 33 min left"),
        ((500, 1000, 200.0), "500 of 1,000 rows, 2.5 rows/s, 3 min 20 s left"),
        ((1000, 1000, 0.5), "1,000 rows in 0.5 s, 2,000 rows/s"),
    ],
)
def test_words_tell_what_is_done_the_rate_and_the_time_left(given, said):
    assert words(*given, "rows") == said


def test_a_log_gets_few_plain_lines_and_a_last_one(clock):
    log = io.StringIO()
    with shown("response", stream=log) as told:
        for second in range(1, 3601):
            clock[0] = float(second)
            told(second, 3600)
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
    with shown("response", stream=terminal) as told:
        for done in (1000, 2000, 4000):
            clock[0] += 1.0
            told(done, 4000)
    said = terminal.getvalue()
    assert "1,000 of 4,000 rows, 1,000 rows/s, 3.0 s left" in said
    assert "4,000 rows in 3.0 s, 1,333 rows/s" in said
    assert "━" in said


def test_two_passes_over_the_rows_count_as_one():
    seen = []
    told = in_passes(lambda *counts: seen.append(counts), 10, 2)
    for done in (4, 10, 4, 10):
        told(done)
    assert seen == [(2, 10), (5, 10), (7, 10), (10, 10)]


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()])
def test_progress_costs_less_than_one_percent(stream, monkeypatch):
    """A word of progress every 10 ms, the quickest rows; in each half second one word is drawn."""
    monkeypatch.setenv("TERM", "xterm")
    begin, spent = time.perf_counter(), 0.0
    with shown("response", stream=stream) as told:
        told(1, 10**9)  # what is loaded once
        for done in range(2, 200):
            time.sleep(0.01)
            before = time.process_time()
            told(done, 10**9)
            spent += time.process_time() - before
    assert spent < 0.01 * (time.perf_counter() - begin)
