"""Ctrl-C while kernels are compiled or loaded: it waits for the end of a function, and is not lost."""

from __future__ import annotations

import os
import signal
import threading

import pytest
from numba.core.dispatcher import Dispatcher

from vibropipe.compiler import jit
from vibropipe.compiler.cache import interrupted_between


def press() -> None:
    """Press Ctrl-C, and let Python handle it."""
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(1000):
        pass


def test_it_waits_for_the_end() -> None:
    reached = []

    def work() -> None:
        with interrupted_between():
            press()
            reached.append("end")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == ["end"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_it_stops_before_the_next_function_within() -> None:
    reached = []

    def work() -> None:
        with interrupted_between():
            press()
            reached.append("outer")
            with interrupted_between():
                reached.append("inner")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == ["outer"]


def test_a_handler_of_another_owner_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    before = signal.signal(signal.SIGINT, lambda *_: seen.append("own"))
    try:
        with interrupted_between():
            press()
            assert seen == ["own"]
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_thread_leaves_it_alone() -> None:
    found = []

    def work() -> None:
        with interrupted_between():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [signal.default_int_handler]


def test_a_function_that_is_compiled_or_loaded_raises_it_and_runs_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    @jit
    def double(x):  # type: ignore[no-untyped-def]
        return 2.0 * x

    compile_or_load = Dispatcher.compile

    def pressed(self: Dispatcher, signature: object) -> object:
        press()
        return compile_or_load(self, signature)

    monkeypatch.setattr(Dispatcher, "compile", pressed)
    with pytest.raises(KeyboardInterrupt):
        double(1.0)
    monkeypatch.undo()
    assert double(3.0) == 6.0
