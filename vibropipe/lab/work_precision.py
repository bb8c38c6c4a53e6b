"""What accuracy costs: every method at every setting on every motion, its error and its time.

The judge is the 40-digit twin. Times are those a core works, compilation and tables of the grid left
out, all methods in turn in each round, so that a drift of the machine hits all alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab import peers
from vibropipe.lab import work_precision_methods as contestant
from vibropipe.lab.reference_solver import Truth, Twin, period_of
from vibropipe.lab.timing import Timer, take_turns
from vibropipe.lab.work_precision_methods import SAMPLES, Contestant, Motion, Shown
from vibropipe.solve.accuracy.motion_errors import partners
from vibropipe.words.vocabulary import PARAMETERS, Outcome, describe

if TYPE_CHECKING:
    import xarray as xr

OWN = ("crude", "newmark", "exact")
METHODS = (*OWN, *peers.SCIPY, "heyoka")
HARMONICS = 4
# Impacts slower than this share of the fastest belong to a chatter, in which methods need not agree.
SLOW = 0.05
# Own methods of more steps than this are left out.
MOST_STEPS = 20_000_000
ERRORS = ("error_end", "error_impact_tau", "error_impact_velocity", "error_harmonics")
WORK = ("work_steps", "work_evaluations", "work_iterations")
TIMES = ("time_per_period", "time_per_period_low", "time_per_period_high")


class Entry(NamedTuple):
    """One place of the table: a method at one of its settings."""

    method: int
    setting: int
    value: float


@dataclass
class Judge:
    """The truth of one motion, and the errors of others by it."""

    motion: Motion

    def __post_init__(self) -> None:
        period = period_of(self.motion.exciter.nu)
        times = [
            period * (self.motion.periods - 1) + period * k / SAMPLES for k in range(SAMPLES + 1)
        ]
        self.truth: Truth = Twin(self.motion.exciter).run(self.motion.x0, self.motion.v0, times)
        states = np.array(self.truth.states, dtype=float)
        self.samples, self.end = states[:-1, 0], states[-1]
        impacts = np.array(self.truth.impacts, dtype=float).reshape(-1, 4)
        self.speed = max(np.abs(states[:, 1]).max(), np.abs(impacts[:, 2]).max(initial=0.0))
        self.size = np.abs(states[:, 0]).max()
        self.tau, self.support, self.velocity = impacts[np.abs(impacts[:, 2]) > SLOW * self.speed][
            :, :3
        ].T

    def errors(self, shown: Shown) -> tuple[Outcome, list[float]]:
        """Errors (ERRORS) of a method, relative to the largest displacement and velocity of the last period
        and impacts, and to the forcing period; and its outcome, impacts missed among it."""
        if shown.outcome == Outcome.DID_NOT_END:
            return shown.outcome, [math.nan] * len(ERRORS)
        apart = np.abs(np.array(shown.end) - self.end) / (self.size, self.speed)
        waves = np.abs(np.fft.rfft(shown.samples - self.samples)[:HARMONICS]) * 2 / SAMPLES
        outcome, late, off = shown.outcome, math.nan, math.nan
        if self.tau.size:
            fast = np.abs(shown.impact_velocity) > 0.5 * SLOW * self.speed
            tau, support = shown.impact_tau[fast], shown.impact_support[fast]
            place = partners(self.tau, self.support, tau, support)
            if any((support == side).sum() < (self.support == side).sum() for side in (1, 2)):
                outcome = max(outcome, Outcome.MISSED_IMPACT)
            if (place >= 0).all():
                late = np.abs(tau[place] - self.tau).max() / self.motion.exciter.period
                off = np.abs(shown.impact_velocity[fast][place] - self.velocity).max() / self.speed
        return outcome, [float(apart.max()), late, off, float(waves.max() / self.size)]


def entries(
    methods: Sequence[str], steps: Sequence[int], tolerances: Sequence[float]
) -> list[Entry]:
    """All settings of all methods."""
    listed = []
    for m, method in enumerate(methods):
        values: Sequence[float] = tolerances
        if method in OWN:
            values = [math.nan] if method == "exact" else steps
        listed += [Entry(m, s, float(value)) for s, value in enumerate(values)]
    return listed


def enter(method: str, value: float, motion: Motion) -> Contestant | Outcome:
    """A method at a setting on a motion, or why it does not enter."""
    if method == "exact":
        return contestant.exact(motion)
    if method in OWN:
        if value * motion.periods > MOST_STEPS:
            return Outcome.NOT_TRIED
        build = contestant.newmark if method == "newmark" else contestant.newmark_crude
        return build(motion, int(value))
    if not peers.is_installed(method):
        return Outcome.NOT_INSTALLED
    if method == "heyoka":
        return peers.heyoka_peer(motion, value)
    return peers.scipy_peer(motion, method, value)


def race(motion: Motion, listed: Sequence[tuple[str, Entry]], repeats: int) -> dict[Entry, Any]:
    """Outcome, errors, work and times of each method on one motion."""
    judge, found, timers = Judge(motion), {}, {}
    for method, entry in listed:
        entered = enter(method, entry.value, motion)
        if isinstance(entered, Outcome):
            found[entry] = (entered, [math.nan] * len(ERRORS), [math.nan] * len(WORK))
            continue
        shown = entered.show()
        outcome, errors = judge.errors(shown)
        found[entry] = (outcome, errors, [count / motion.periods for count in shown.work])
        if outcome != Outcome.DID_NOT_END:
            # Peers show and repeat by the same code, a second of it where they are slow.
            timers[entry] = Timer(entered.repeat, motion.periods, is_warm=method not in OWN)
    take_turns(timers.values(), repeats)
    never = [math.nan] * len(TIMES)
    return {
        entry: (*result, timers[entry].quartiles() if entry in timers else never)
        for entry, result in found.items()
    }


def compile_methods(methods: Sequence[str], motion: Motion) -> None:
    """Have the kernels of our own methods compiled, by as many processes as this one may use threads."""
    short = motion._replace(periods=1)

    def show(method: str) -> None:
        entered = enter(method, 8.0, short)
        if not isinstance(entered, Outcome):
            entered.show()

    def repeat(method: str) -> None:
        entered = enter(method, 8.0, short)
        if not isinstance(entered, Outcome):
            entered.repeat(1)

    own = [method for method in methods if method in OWN]
    calls = [partial(call, method) for method in own for call in (show, repeat)]
    compile_side_by_side(calls, numba.get_num_threads())


def solve_accuracy(
    motions: Mapping[str, Motion],
    methods: Sequence[str] = METHODS,
    steps: Sequence[int] = (16, 64, 256, 1024, 4096, 16384),
    tolerances: Sequence[float] = (1e-4, 1e-7, 1e-10),
    peer_periods: int = 4,
    repeats: int = 7,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Error, time and work over (motion, method, setting).

    methods: any of METHODS; steps: steps per forcing period of crude and newmark; tolerances: of the peers,
    which run over `peer_periods` of a motion's periods at most; repeats: timings of each; progress: is told how many
    races (a motion by a method at a setting) are run, and of how many.
    Times differ from run to run; all else is the same with the same versions of the packages.
    """
    compile_methods(methods, next(iter(motions.values())))
    listed = entries(methods, steps, tolerances)
    shape = (len(motions), len(methods), max(entry.setting for entry in listed) + 1)
    columns = {name: np.full(shape, np.nan) for name in (*ERRORS, *WORK, *TIMES)}
    outcomes = np.full(shape, Outcome.NOT_TRIED, np.int8)
    values, periods = np.full(shape[1:], np.nan), np.zeros(shape[:2], np.int64)
    run = 0
    for entry in listed:
        values[entry.method, entry.setting] = entry.value
    for i, motion in enumerate(motions.values()):
        short = motion._replace(periods=min(motion.periods, peer_periods))
        for chosen, own in ((motion, True), (short, False)):
            part = [(methods[e.method], e) for e in listed if (methods[e.method] in OWN) == own]
            for entry, (outcome, errors, work, times) in race(chosen, part, repeats).items():
                place = (i, entry.method, entry.setting)
                outcomes[place], periods[place[:2]] = outcome, chosen.periods
                for name, value in zip(
                    (*ERRORS, *WORK, *TIMES), (*errors, *work, *times), strict=True
                ):
                    columns[name][place] = value
            run += len(part)
            if progress is not None:
                progress(run, len(motions) * len(listed))
    return labelled(motions, methods, columns, outcomes, values, periods)


def labelled(
    motions: Any, methods: Any, columns: Any, outcomes: Any, values: Any, periods: Any
) -> xr.Dataset:
    """The table as a dataset, with the exciters as coordinates over `motion`."""
    import xarray as xr

    dims = ("motion", "method", "setting")
    variables: dict[str, Any] = {name: (dims, column) for name, column in columns.items()}
    variables |= {
        "outcome": (dims, outcomes),
        "setting_value": (dims[1:], values),
        "periods_run": (dims[:2], periods),
    }
    coords = {**motion_coordinates(motions), "method": ("method", list(methods))}
    comment = (
        "time_per_period* are of the run that took them; everything else is the same in every run "
        "with the same versions of the packages: what never ends is stopped by its work, not by time"
    )
    return describe(xr.Dataset(variables, coords, {"comment": comment}))


def motion_coordinates(motions: Mapping[str, Motion]) -> dict[str, Any]:
    """Names, exciters and starts of motions, over `motion`."""
    coords: dict[str, Any] = {
        name: ("motion", [getattr(m.exciter, name) for m in motions.values()])
        for name in PARAMETERS
    }
    return coords | {
        "displacement_start": ("motion", [m.x0 for m in motions.values()]),
        "velocity_start": ("motion", [m.v0 for m in motions.values()]),
        "motion": ("motion", list(motions)),
    }
