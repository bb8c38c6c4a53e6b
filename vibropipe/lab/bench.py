"""`vibropipe bench`: methods and other packages, all timed in the same rounds, so that drift affects all alike."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from vibropipe.lab.timing import Repeat, Timer, quartiles, time_in_rounds
from vibropipe.words.wording import aligned

UNITS = (("ms", 1e6), ("us", 1e3), ("ns", 1.0))


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

    items : receives the times (`Candidate.times`, ns per unit), or the reasons why a candidate cannot run
    rounds : timings of each candidate. Its first call, which compiles and loads what it needs, is measured separately
        (`first_seconds`)
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


def as_text(items: Sequence[Item]) -> str:
    """Return a table of times for each item, followed by its ratios and whether they meet their targets."""
    return "\n\n".join(item_text(item) for item in items)


def item_text(item: Item) -> str:
    """Return the table and the ratios of one item."""
    head = ("", f"time per {item.unit}", "quartiles", "error", "first call")
    lines = aligned([head, *(table_row(candidate) for candidate in item.candidates)])
    targets = [target_text(item, target) for target in item.targets]
    return "\n".join([f"{item.name}: {item.what}", *lines, *targets])


def table_row(candidate: Candidate) -> tuple[str, ...]:
    """Return the cells of one candidate."""
    if candidate.why_not is not None:
        return candidate.name, candidate.why_not, "", "", ""
    median, low, high = candidate.quartiles()
    error = "" if math.isnan(candidate.error) else f"{candidate.error:.0e}"
    spread = f"{time_text(low)} to {time_text(high)}"
    return candidate.name, time_text(median), spread, error, f"{candidate.first_seconds:.1f} s"


def target_text(item: Item, target: Target) -> str:
    """Return a ratio, its target and whether the target is met, as one sentence; a target below 1 is a limit."""
    ratios, times = item.ratios(target), target.times
    is_met = ratios[0] >= times
    word, of_times = ("faster", "target") if times >= 1.0 else ("slower", "limit")
    if times < 1.0:
        ratios, times = [1.0 / ratios[index] for index in (0, 2, 1)], 1.0 / times
    ratio, low, high = (f"{r:,.0f}" if r >= 100 else f"{r:.3g}" for r in ratios)
    head, end = f"{target.ours} against {target.peer}", f"{of_times} {times:,g}"
    if math.isnan(ratios[0]):
        return f"{head}: not measured, {end}"
    outcome = "met" if is_met else "not met"
    return f"{head}: {ratio} times {word} (quartiles {low} to {high}), {end}: {outcome}"


def time_text(nanoseconds: float) -> str:
    """Return a time in the largest unit in which it is at least 1."""
    unit, size = next((u for u in UNITS if nanoseconds >= 0.9995 * u[1]), UNITS[-1])
    return f"{nanoseconds / size:.3g} {unit}"


def as_json(items: Sequence[Item]) -> str:
    """Return all numbers as JSON, times in ns; null stands for a missing number."""
    measured = {"cores": os.cpu_count(), "items": [item_as_dict(item) for item in items]}
    return json.dumps(json.loads(json.dumps(measured), parse_constant=lambda _nan: None), indent=1)


def item_as_dict(item: Item) -> dict[str, Any]:
    """Return one item as a dict for JSON."""
    candidates = [
        {
            "name": candidate.name,
            "why_not": candidate.why_not,
            "nanoseconds": candidate.quartiles()[0],
            "quartiles": candidate.quartiles()[1:],
            "rounds": candidate.times,
            "error": candidate.error,
            "first_call_seconds": candidate.first_seconds,
        }
        for candidate in item.candidates
    ]
    targets = []
    for target in item.targets:
        ratio, *spread = item.ratios(target)
        reached = ratio >= target.times
        ratios = {"ratio": ratio, "ratio_quartiles": spread, "reached": reached}
        targets.append({**target._asdict(), **ratios})
    head = {"name": item.name, "what": item.what, "unit": item.unit}
    return {**head, "contestants": candidates, "targets": targets}
