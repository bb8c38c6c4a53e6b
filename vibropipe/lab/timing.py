"""CPU time of work on one core, in rounds that time every item so that drift affects all alike."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from vibropipe.words.progress import Progress

# Seconds after which no further round of a timer begins: a round of all timers stays short enough to repeat.
SECONDS = 0.25
# Shortest timed interval in seconds, far above the resolution of the clock; shorter calls are repeated to fill it.
MIN_SECONDS = 2e-3

Repeat = Callable[[int], object]


@dataclass
class Timer:
    """Times of one item in ns per unit, one for each round.

    repeat : called as `repeat(n_calls)`; units : units (forcing periods, rows) in one call; clock : returns seconds;
    budget : seconds after which no round begins; is_warm : whether it has run before, so that its first time counts.
    """

    repeat: Repeat
    units: float
    clock: Callable[[], float] = time.thread_time
    budget: float = SECONDS
    is_warm: bool = False
    times: list[float] = field(default_factory=list)
    n_calls: int = 1
    spent: float = 0.0

    def round(self) -> None:
        """Take one time, unless the budget is spent."""
        if self.spent > self.budget:
            return
        while True:
            begin = self.clock()
            self.repeat(self.n_calls)
            elapsed = self.clock() - begin
            self.spent += elapsed
            if elapsed >= MIN_SECONDS:
                break
            self.n_calls *= 2 if elapsed > MIN_SECONDS / 4 else 8
        self.times.append(elapsed / self.n_calls / self.units * 1e9)

    def quartiles(self) -> list[float]:
        """Return the median and the lower and upper quartile of the times."""
        return quartiles(self.times)

    def over(self, other: Timer) -> list[float]:
        """Return the ratios of these times to another timer's, round by round."""
        return [a / b for a, b in zip(self.times, other.times, strict=False)]


def repeated(call: Callable[[], object]) -> Callable[[int], None]:
    """Return a function that makes the call `n_calls` times."""

    def repeat(n_calls: int) -> None:
        for _ in range(n_calls):
            call()

    return repeat


def quartiles(values: Collection[float]) -> list[float]:
    """Return the median and the lower and upper quartile; nan if there are no values."""
    if not values:
        return [math.nan] * 3
    return [float(q) for q in np.percentile(list(values), [50, 25, 75])]


def compile_side_by_side(groups: Sequence[Sequence[Callable[[], object]]], processes: int) -> None:
    """Make the calls of each group in a forked process, some processes at a time, which leave what they compile.

    A process keeps what it has compiled: calls that share code belong into one group. Nothing is done where processes
    cannot be forked; an error is that of whoever makes the call again.
    """
    children: list[int] = []
    for calls in groups if hasattr(os, "fork") else ():
        if len(children) == processes:
            os.waitpid(children.pop(0), 0)
        child = os.fork()
        if child == 0:
            with suppress(BaseException):  # Ctrl-C ends this process here
                for call in calls:
                    with suppress(Exception):
                        call()
            os._exit(0)
        children.append(child)
    for child in children:
        os.waitpid(child, 0)


def time_in_rounds(
    timers: Collection[Timer], rounds: int, progress: Progress | None = None
) -> None:
    """Time all timers in every round.

    timers : a timer that is not warm runs once before, uncounted, to compile and load
    rounds : times taken of each
    progress : called as `progress(done, total)` with the number of times taken
    """
    for timer in timers:
        if not timer.is_warm:
            timer.repeat(1)
    done = 0
    for _ in range(rounds):
        for timer in timers:
            timer.round()
            done += 1
            if progress is not None:
                progress(done, rounds * len(timers))
