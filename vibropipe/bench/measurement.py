"""Benchmark items: every candidate is timed in every round, so that drift of the machine affects all alike."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vibropipe.lab.timing import Repeat, Timer, quartiles, time_in_rounds


class PreparedRun(NamedTuple):
    """A candidate that is ready to be timed.

    `repeat` runs its work n times, each of `units` units; `error` is its deviation from the 40-digit reference,
    nan where none is measured.
    """

    repeat: Repeat
    units: float
    error: float = math.nan


@dataclass
class Candidate:
    """A method of an item.

    `build` prepares the run or returns the reason why the method cannot run; `clock` returns seconds; `times` are
    ns per unit, one for each round.
    """

    name: str
    build: Callable[[], PreparedRun | str]
    clock: Callable[[], float] = time.thread_time
    ready: PreparedRun | None = None
    why_not: str | None = None
    first_seconds: float = math.nan
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        """Error against the 40-digit reference; nan where none is measured."""
        return math.nan if self.ready is None else self.ready.error

    def quartiles(self) -> list[float]:
        """Return the median and the quartiles of the time per unit, in ns; nan if the method did not run."""
        return quartiles(self.times)


class Target(NamedTuple):
    """Smallest accepted ratio `times` of the time of `peer` to the time of `ours`."""

    ours: str
    peer: str
    times: float


@dataclass
class Item:
    """Candidates that do the same work, timed per `unit`, and the target ratios between them."""

    name: str
    what: str
    unit: str
    candidates: list[Candidate]
    targets: list[Target]

    def find(self, name: str) -> Candidate:
        """Return the candidate of this name."""
        return next(candidate for candidate in self.candidates if candidate.name == name)

    def ratios(self, target: Target) -> list[float]:
        """Return the ratio of the medians of a target, and the quartiles of the ratio over the rounds.

        All are nan if the reference was not measured.
        """
        ours, peer = self.find(target.ours), self.find(target.peer)
        _, low, high = quartiles([b / a for a, b in zip(ours.times, peer.times, strict=False)])
        return [peer.quartiles()[0] / ours.quartiles()[0], low, high]


def measure(items: Sequence[Item], rounds: int) -> None:
    """Time every candidate of the items that can run.

    Parameters
    ----------
    items : sequence of Item
        Receives the times (`Candidate.times`, ns per unit), or the reasons why a candidate cannot run.
    rounds : int
        Timings of each candidate. Its first call, which compiles and loads what it needs, is measured separately
        (`first_seconds`).
    """
    timers = []
    for candidate in (candidate for item in items for candidate in item.candidates):
        begin = time.perf_counter()
        ready = candidate.build()
        if isinstance(ready, str):
            candidate.why_not = ready
            continue
        ready.repeat(1)
        candidate.ready, candidate.first_seconds = ready, time.perf_counter() - begin
        timers.append(Timer(ready.repeat, ready.units, candidate.clock, math.inf, is_warm=True))
        candidate.times = timers[-1].times
    time_in_rounds(timers, rounds)
