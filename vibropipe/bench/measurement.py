"""Measuring side by side: all contestants in turn in every round, so that a drift of the machine hits all alike."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vibropipe.lab.timing import Repeat, Timer, quartiles, time_in_rounds


class PreparedRun(NamedTuple):
    """A contestant that can be timed: `repeat` does its work so many times, `units` of it each; `error` is
    that against the twin, nan where none is asked."""

    repeat: Repeat
    units: float
    error: float = math.nan


@dataclass
class Candidate:
    """A method of an item. `build` makes it ready, or says in a text why it can not enter; `clock` tells seconds."""

    name: str
    build: Callable[[], PreparedRun | str]
    clock: Callable[[], float] = time.thread_time
    ready: PreparedRun | None = None
    why_not: str | None = None
    first_seconds: float = math.nan
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        """Error against the twin; nan where none is asked."""
        return math.nan if self.ready is None else self.ready.error

    def quartiles(self) -> list[float]:
        """Median and quartiles, in nanoseconds per unit; nan if it did not enter."""
        return quartiles(self.times)


class Target(NamedTuple):
    """How many times cheaper `ours` is to be than `peer`."""

    ours: str
    peer: str
    times: float


@dataclass
class Item:
    """What is measured: contestants doing the same work, per `unit`, and the ratios asked of them."""

    name: str
    what: str
    unit: str
    contestants: list[Candidate]
    targets: list[Target]

    def find(self, name: str) -> Candidate:
        """The contestant of that name."""
        return next(one for one in self.contestants if one.name == name)

    def ratios(self, target: Target) -> list[float]:
        """How many times cheaper: by medians, and the quartiles over rounds; nan without the peer."""
        ours, peer = self.find(target.ours), self.find(target.peer)
        _, low, high = quartiles([b / a for a, b in zip(ours.times, peer.times, strict=False)])
        return [peer.quartiles()[0] / ours.quartiles()[0], low, high]


def measure(items: Sequence[Item], rounds: int) -> None:
    """Take so many times of every contestant that enters; the first call of each, which compiles or loads what
    it needs, is timed apart."""
    timers = []
    for one in (one for item in items for one in item.contestants):
        begin = time.perf_counter()
        ready = one.build()
        if isinstance(ready, str):
            one.why_not = ready
            continue
        ready.repeat(1)
        one.ready, one.first_seconds = ready, time.perf_counter() - begin
        timers.append(Timer(ready.repeat, ready.units, one.clock, math.inf, is_warm=True))
        one.times = timers[-1].times
    time_in_rounds(timers, rounds)
