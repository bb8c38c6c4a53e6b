"""Calls on several threads that Ctrl-C can end at any moment, the rows that each solves, and the end of orphans."""

from __future__ import annotations

import os
import threading
import time
from _thread import start_new_thread
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from itertools import count
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar, cast

T = TypeVar("T")
# Seconds between two looks at the parent, and the exit code of a process without it.
LOOK_EVERY, ORPHANED = 1.0, 1
# Seconds after which a wait begins anew: without an end it cannot be interrupted on every system.
INTERRUPTIBLE = 1.0
# Rows per call of the kernel. Small enough for progress reports and Ctrl-C, large enough to hide the call overhead;
# pieces shrink towards the end, to a TAIL_FRACTION-th of the remaining rows, so that threads finish together.
ROWS_PER_CALL, MIN_ROWS_PER_CALL, TAIL_FRACTION = 256, 64, 4


class Calls(Generic[T]):
    """Some number of calls that were handed over together."""

    def __init__(self, number: int) -> None:
        self.results: list[T | None] = [None] * number
        self.error: BaseException | None = None
        self.is_over = False
        self._finished, self._woken = count(1), SimpleQueue[bool]()

    def finish(self, n: int, call: Callable[[], T]) -> None:
        """Make call n, on a thread. The last one, or one that fails, wakes up who waits."""
        try:
            self.results[n] = call()
        except BaseException as error:  # raised where the results are taken
            self.error = error
            self._woken.put(True)
        if next(self._finished) == len(self.results):
            self._woken.put(True)

    def wait(self, seconds: float) -> bool:
        """Wait for all calls, at most for some time; return whether they are finished, raise what one has raised."""
        with suppress(Empty):
            self.is_over = self.is_over or self._woken.get(timeout=seconds)
        if self.error is not None:
            raise self.error
        return self.is_over

    def take(self) -> list[T]:
        """Wait for all calls, and return their results in order, once: they are not kept."""
        while not self.wait(INTERRUPTIBLE):
            pass
        results, self.results = self.results, []
        return cast(list[T], results)


class Threads:
    """Some number of threads that take calls in order.

    An interrupt within a lock, an event or a pool of the standard library, which are written in Python, may leave it
    locked, so that threads and program wait for each other without end. The queues used here cannot be left half done.
    """

    def __init__(self, number: int) -> None:
        self._number, self._is_stopped = number, False
        self._tasks, self._ended = SimpleQueue[Any](), SimpleQueue[None]()
        for _ in range(number):
            start_new_thread(self._work, ())

    def submit(self, calls: Sequence[Callable[[], T]]) -> Calls[T]:
        """Hand over calls, at least one, to be made after those before."""
        handed: Calls[T] = Calls(len(calls))
        for n, call in enumerate(calls):
            self._tasks.put(partial(handed.finish, n, call))
        return handed

    def stop(self) -> None:
        """Drop the calls that have not begun, and wait for those that have."""
        self._is_stopped = True
        for _ in range(self._number):
            self._tasks.put(None)
        for _ in range(self._number):
            self._ended.get()

    def _work(self) -> None:
        while (task := self._tasks.get()) is not None:
            if not self._is_stopped:
                task()
            del task  # and its results, which may be large
        self._ended.put(None)


def row_blocks(
    rows: int, chain_length: int = 1, block_rows: int | None = None
) -> list[list[list[int]]]:
    """Cut rows into blocks, and blocks into pieces that are solved in parallel.

    Returns, for each block, for each of its pieces, the ends of the consecutive calls that solve it. A piece consists
    of whole chains solved in one call, or of the parts of one longer chain. The cuts do not depend on the number of
    threads.

    rows, chain_length : number of rows, in whole chains, and rows per chain
    block_rows : least number of rows per block (default: all)
    """
    blocks: list[list[list[int]]] = []
    first = begin = 0
    while first < rows:
        max_rows = min(ROWS_PER_CALL, max(MIN_ROWS_PER_CALL, (rows - first) // TAIL_FRACTION))
        stop = min(rows, first + max(1, max_rows // chain_length) * chain_length)
        if not blocks or first - begin >= (rows if block_rows is None else block_rows):
            blocks.append([])
            begin = first
        blocks[-1].append([*range(first, stop, ROWS_PER_CALL), stop])
        first = stop
    return blocks


def watch_parent() -> None:
    """End this process soon after the one that started it."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_EVERY)
        # at once, even within a kernel; files appear only when whole
        os._exit(ORPHANED)

    threading.Thread(target=watch, daemon=True).start()
