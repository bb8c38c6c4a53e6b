"""Calls on several threads: in order, all made or dropped, an error told at once."""

import threading
import time

import pytest

from vibropipe.solve.threads import Threads


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
