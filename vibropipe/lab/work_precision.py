"""What accuracy costs: every method at every setting on every motion, its error and its time.

The judge is the 40-digit twin. Times are those a core works, compilation and tables of the grid left
out, all methods in turn in each round, so that a drift of the machine hits all alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab import peers
from vibropipe.lab import work_precision_methods as contestant
from vibropipe.lab.reference_solver import ReferenceSolver, period_of
from vibropipe.lab.timing import Timer, time_in_rounds
from vibropipe.lab.work_precision_methods import SAMPLES, BenchmarkMotion, Candidate, MethodResult
from vibropipe.solve.accuracy.motion_errors import match_contacts
from vibropipe.words.measurements import COMPARED_METHODS, OWN_METHODS, Outcome
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

HARMONICS = 4
# Impacts slower than this share of the fastest belong to a chatter, in which methods need not agree.
SLOW = 0.05
# Own methods of more steps than this are left out.
MAX_STEPS = 20_000_000
ERRORS = ("error_end", "error_impact_tau", "error_impact_velocity", "error_harmonics")
WORK = ("work_steps", "work_evaluations", "work_iterations")
TIMES = ("time_per_period", "time_per_period_low", "time_per_period_high")


class Entry(NamedTuple):
    """One place of the table: a method at one of its settings."""

    method: str
    setting: int
    value: float


class MotionReference:
    """The truth of one motion, and the errors of others by it."""

    def __init__(self, motion: BenchmarkMotion) -> None:
        self.motion, period = motion, period_of(motion.exciter.nu)
        begin = period * (motion.periods - 1)
        times = [begin + period * k / SAMPLES for k in range(SAMPLES + 1)]
        truth = ReferenceSolver(motion.exciter).run(motion.x0, motion.v0, times)
        states = np.array(truth.states, dtype=float)
        self.samples, self.end = states[:-1, 0], states[-1]
        impacts = np.array(truth.impacts, dtype=float).reshape(-1, 4)[:, :3]
        self.speed = max(np.abs(states[:, 1]).max(), np.abs(impacts[:, 2]).max(initial=0.0))
        self.size = np.abs(states[:, 0]).max()
        fast = np.abs(impacts[:, 2]) > SLOW * self.speed
        self.tau, self.support, self.velocity = impacts[fast].T

    def errors(self, shown: MethodResult) -> tuple[Outcome, list[float]]:
        """Errors (ERRORS) of a method, relative to the largest displacement and velocity of the last period
        and impacts, and to the forcing period; and its outcome, impacts missed among it."""
        if shown.outcome == Outcome.DID_NOT_END:
            return shown.outcome, [math.nan] * len(ERRORS)
        end_error = np.abs(np.array(shown.end) - self.end) / (self.size, self.speed)
        waves = np.abs(np.fft.rfft(shown.samples - self.samples)[:HARMONICS]) * 2 / SAMPLES
        outcome, late, off = shown.outcome, math.nan, math.nan
        if self.tau.size:
            fast = np.abs(shown.impact_velocity) > 0.5 * SLOW * self.speed
            tau, support = shown.impact_tau[fast], shown.impact_support[fast]
            partner = match_contacts(self.tau, self.support, tau, support)
            if any((support == side).sum() < (self.support == side).sum() for side in (1, 2)):
                outcome = max(outcome, Outcome.MISSED_IMPACT)
            if (partner >= 0).all():
                late = np.abs(tau[partner] - self.tau).max() / self.motion.exciter.period
                off = (
                    np.abs(shown.impact_velocity[fast][partner] - self.velocity).max() / self.speed
                )
        return outcome, [float(end_error.max()), late, off, float(waves.max() / self.size)]


def entries(
    methods: Sequence[str], steps: Sequence[int], tolerances: Sequence[float]
) -> list[Entry]:
    """All settings of all methods."""
    settings = {"crude": steps, "newmark": steps, "exact": [math.nan]}
    return [
        Entry(method, place, float(value))
        for method in methods
        for place, value in enumerate(settings.get(method, tolerances))
    ]


def build_method(method: str, value: float, motion: BenchmarkMotion) -> Candidate | Outcome:
    """A method at a setting on a motion, or why it does not enter."""
    if method in OWN_METHODS and value * motion.periods > MAX_STEPS:
        return Outcome.NOT_TRIED
    if method not in OWN_METHODS and not peers.is_installed(method):
        return Outcome.NOT_INSTALLED
    return build(method, value, motion)


def build(method: str, value: float, motion: BenchmarkMotion) -> Candidate:
    """A method that is there, at a setting on a motion."""
    if method == "exact":
        return contestant.exact(motion)
    if method in OWN_METHODS:
        own = contestant.newmark if method == "newmark" else contestant.newmark_crude
        return own(motion, int(value))
    if method == "heyoka":
        return peers.heyoka_peer(motion, value)
    return peers.scipy_peer(motion, method, value)


def run_methods(
    motion: BenchmarkMotion, listed: Sequence[Entry], repeats: int
) -> dict[Entry, dict[str, float]]:
    """Outcome, errors, work and times of each method on one motion, by the names of the dataset."""
    judge, results, timers = MotionReference(motion), {}, {}
    for entry in listed:
        entered = build_method(entry.method, entry.value, motion)
        if isinstance(entered, Outcome):
            results[entry] = {"outcome": float(entered)}
            continue
        shown = entered.show()
        outcome, errors = judge.errors(shown)
        work = [count / motion.periods for count in shown.effort]
        names = ("outcome", *ERRORS, *WORK)
        results[entry] = dict(zip(names, (outcome, *errors, *work), strict=True))
        if outcome != Outcome.DID_NOT_END:
            # Peers show and repeat by the same code, a second of it where they are slow.
            is_warm = entry.method not in OWN_METHODS
            timers[entry] = Timer(entered.repeat, motion.periods, is_warm=is_warm)
    time_in_rounds(timers.values(), repeats)
    for entry, timer in timers.items():
        results[entry] |= zip(TIMES, timer.quartiles(), strict=True)
    return results


def compile_methods(methods: Sequence[str], motion: BenchmarkMotion) -> None:
    """Have the kernels of our own methods compiled, by as many processes as this one may use threads."""
    short = motion._replace(periods=1)

    def show(method: str) -> None:
        build(method, 8.0, short).show()

    def repeat(method: str) -> None:
        build(method, 8.0, short).repeat(1)

    own = [method for method in methods if method in OWN_METHODS]
    calls = [partial(call, method) for method in own for call in (show, repeat)]
    compile_side_by_side(calls, numba.get_num_threads())


def solve_accuracy(
    motions: Mapping[str, BenchmarkMotion],
    methods: Sequence[str] = COMPARED_METHODS,
    steps: Sequence[int] = (16, 64, 256, 1024, 4096, 16384),
    tolerances: Sequence[float] = (1e-4, 1e-7, 1e-10),
    peer_periods: int = 4,
    repeats: int = 7,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Measure error, time and work of methods over (motion, method, setting).

    Parameters
    ----------
    motions : mapping of str to BenchmarkMotion
        What is solved, by name.
    methods : sequence of str
        Any of METHODS, each once.
    steps : sequence of int
        Steps per forcing period of crude and newmark.
    tolerances : sequence of float
        Relative and absolute tolerances of the peers.
    peer_periods : int
        Forcing periods of a motion that peers run over at most.
    repeats : int
        Timings of each.
    progress : callable, optional
        Called as progress(done, total) with the number of runs, each a motion by a method at a setting.

    Returns
    -------
    xarray.Dataset
        Errors relative to the motion, work and times per forcing period (ns), `outcome`, `setting_value`,
        `periods_run`. Times differ from run to run; all else is the same with the same versions of the packages.
    """
    import xarray as xr

    compile_methods(methods, next(iter(motions.values())))
    listed = entries(methods, steps, tolerances)
    dims = ("motion", "method", "setting")
    shape = (len(motions), len(methods), max(entry.setting for entry in listed) + 1)
    columns = {name: np.full(shape, np.nan) for name in (*ERRORS, *WORK, *TIMES)}
    columns["outcome"] = np.full(shape, Outcome.NOT_TRIED, np.int8)
    values, periods = np.full(shape[1:], np.nan), np.zeros(shape[:2], np.int64)
    run = 0
    for i, motion in enumerate(motions.values()):
        short = motion._replace(periods=min(motion.periods, peer_periods))
        for chosen, own in ((motion, True), (short, False)):
            part = [entry for entry in listed if (entry.method in OWN_METHODS) == own]
            for entry, found in run_methods(chosen, part, repeats).items():
                index = (i, methods.index(entry.method), entry.setting)
                values[index[1:]], periods[index[:2]] = entry.value, chosen.periods
                for name, value in found.items():
                    columns[name][index] = value
            run += len(part)
            if progress is not None:
                progress(run, len(motions) * len(listed))
    variables: dict[str, Any] = {name: (dims, column) for name, column in columns.items()}
    variables |= {"setting_value": (dims[1:], values), "periods_run": (dims[:2], periods)}
    coords = {**motion_coordinates(motions), "method": ("method", list(methods))}
    comment = (
        "time_per_period* are of the run that took them; everything else is the same in every run "
        "with the same versions of the packages: what never ends is stopped by its work, not by time"
    )
    return describe(xr.Dataset(variables, coords, {"comment": comment}))


def motion_coordinates(motions: Mapping[str, BenchmarkMotion]) -> dict[str, Any]:
    """Names, exciters and starts of motions, over `motion`."""
    listed = motions.values()
    columns = {name: [getattr(m.exciter, name) for m in listed] for name in PARAMETERS} | {
        "displacement_start": [m.x0 for m in listed],
        "velocity_start": [m.v0 for m in listed],
        "motion": list(motions),
    }
    return {name: ("motion", values) for name, values in columns.items()}
