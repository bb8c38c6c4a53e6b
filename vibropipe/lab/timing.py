"""Times of work on one core: rounds in which all take turns, so that a drift of the machine hits all alike."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np

# Seconds that timing one thing may take; a time shorter than this is taken of several runs in one go.
SECONDS = 0.25
MIN_SECONDS = 2e-3

Repeat = Callable[[int], object]


@dataclass
class Timer:
    """Times of one thing, a round at a time, in nanoseconds per unit.

    repeat: does it so many times in one go; units: how many (forcing periods, rows) there are in one run;
    `clock` tells seconds, of which no round begins once `budget` are spent; is_warm: whether it has been run
    already, so that its first time counts.
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
        """Take one more time, unless all that may be spent has been."""
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
        """Return median, lower and upper quartile of the times."""
        return quartiles(self.times)

    def over(self, other: Timer) -> list[float]:
        """Return these times as shares of another's, round by round."""
        return [a / b for a, b in zip(self.times, other.times, strict=False)]


def repeated(call: Callable[[], object]) -> Callable[[int], None]:
    """Return what makes a call so many times in a row."""

    def repeat(n_calls: int) -> None:
        for _ in range(n_calls):
            call()

    return repeat


def quartiles(values: Collection[float]) -> list[float]:
    """Return median, lower and upper quartile; nan where there are no values."""
    if not values:
        return [math.nan] * 3
    return [float(q) for q in np.percentile(list(values), [50, 25, 75])]


def time_in_rounds(
    timers: Collection[Timer], rounds: int, progress: Callable[[int, int], None] | None = None
) -> None:
    """So many rounds of all timers, after a run of each not warm yet that compiles and warms and is not counted.
    progress is told the times taken and all of them."""
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


def expected_timing(seconds: float, rounds: int) -> float:
    """Seconds that a timer will spend on something that takes so many, about."""
    # Runs in one go are doubled until they take long enough: half as long again, and as much before.
    each = max(seconds, 1.5 * MIN_SECONDS)
    return min(2 * MIN_SECONDS + rounds * each, SECONDS + each)
