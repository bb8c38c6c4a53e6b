"""Work-precision comparison: error and run time of every method at every setting on every motion.

Errors are measured against the 40-digit reference. Times are CPU times of one core without compilation and tables of
the grid; all methods are timed in every round, so that drift of the machine affects all alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab import work_precision_methods as own_methods
from vibropipe.lab.peers.heyoka import heyoka_peer
from vibropipe.lab.peers.recorder import is_installed
from vibropipe.lab.peers.solve_ivp import scipy_peer
from vibropipe.lab.reference_pieces import PieceReferenceSolver
from vibropipe.lab.reference_solver import ReferenceSolver, period_of
from vibropipe.lab.timing import Timer, time_in_rounds
from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    Candidate,
    MethodResult,
    effects_of_motion,
)
from vibropipe.solve.accuracy.motion_errors import match_contacts
from vibropipe.words.measurements import COMPARED_METHODS, OWN_METHODS, Outcome
from vibropipe.words.parameters import FURTHER, PARAMETERS
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

HARMONICS = 4
# Impacts slower than this fraction of the largest velocity count as chatter, in which methods need not agree.
SLOW_IMPACT_RATIO = 0.05
# Steps of a motion above which a method of this package is not tried: at some ns per step, a run takes 0.1 s.
MAX_STEPS = 20_000_000
ERRORS = ("error_end", "error_impact_tau", "error_impact_velocity", "error_harmonics")
WORK = ("work_steps", "work_evaluations", "work_iterations")
TIMES = ("time_per_period", "time_per_period_low", "time_per_period_high")


class Entry(NamedTuple):
    """A method at one of its settings: index of the setting and its value (steps or tolerance)."""

    method: str
    setting: int
    value: float


class MotionReference:
    """The 40-digit reference of one motion, and the errors of results against it."""

    def __init__(self, motion: BenchmarkMotion) -> None:
        motion = motion.about_equilibrium()
        self.motion, period = motion, period_of(motion.exciter.nu)
        start = period * (motion.periods - 1)
        times = [start + period * k / SAMPLES for k in range(SAMPLES + 1)]
        states, impacts = reference_motion(motion, times)
        self.samples, self.end = states[:-1, 0], states[-1]
        self.speed = max(np.abs(states[:, 1]).max(), np.abs(impacts[:, 2]).max(initial=0.0))
        self.size = np.abs(states[:, 0]).max()
        is_fast = np.abs(impacts[:, 2]) > SLOW_IMPACT_RATIO * self.speed
        self.tau, self.support, self.velocity = impacts[is_fast].T

    def errors(self, result: MethodResult) -> tuple[Outcome, list[float]]:
        """Return the outcome and the errors of a result.

        Parameters
        ----------
        result : MethodResult
            Result of a method on the motion.

        Returns
        -------
        outcome : Outcome
            Outcome of the method; MISSED_IMPACT if it lacks an impact of the reference.
        errors : list of float
            ERRORS: of displacement and velocity, relative to their largest magnitudes in the last period and at
            impacts; of impact times, relative to the forcing period; of harmonics. nan where not comparable.
        """
        if result.outcome == Outcome.DID_NOT_END:
            return result.outcome, [math.nan] * len(ERRORS)
        end_error = np.abs(np.array(result.end) - self.end) / (self.size, self.speed)
        harmonics = np.abs(np.fft.rfft(result.samples - self.samples)[:HARMONICS]) * 2 / SAMPLES
        outcome, tau_error, speed_error = result.outcome, math.nan, math.nan
        if self.tau.size:
            is_fast = np.abs(result.impact_velocity) > 0.5 * SLOW_IMPACT_RATIO * self.speed
            tau, support = result.impact_tau[is_fast], result.impact_support[is_fast]
            partners = match_contacts(self.tau, self.support, tau, support)
            if any((support == number).sum() < (self.support == number).sum() for number in (1, 2)):
                outcome = max(outcome, Outcome.MISSED_IMPACT)
            if (partners >= 0).all():
                tau_error = np.abs(tau[partners] - self.tau).max() / self.motion.exciter.period
                speed_error = (
                    np.abs(result.impact_velocity[is_fast][partners] - self.velocity).max()
                    / self.speed
                )
        errors = end_error.max(), tau_error, speed_error, harmonics.max() / self.size
        return outcome, [float(error) for error in errors]


def reference_motion(
    motion: BenchmarkMotion, times: Sequence[Decimal]
) -> tuple[np.ndarray, np.ndarray]:
    """Return (x, x') at the times, and (tau, support, velocity) of impacts and beginnings of soft contacts."""
    if effects_of_motion(motion).has_pieces:
        pieces = PieceReferenceSolver(motion.exciter).run_pieces(motion.x0, motion.v0, times)
        states = pieces.states
        impacts = [
            (tau, support, velocity)
            for tau, kind, support, velocity in pieces.events
            if kind in ("in", "impact")
        ]
    else:
        exact_motion = ReferenceSolver(motion.exciter).run(motion.x0, motion.v0, times)
        states, impacts = exact_motion.states, [impact[:3] for impact in exact_motion.impacts]
    return np.array(states, dtype=float), np.array(impacts, dtype=float).reshape(-1, 3)


def entries(
    methods: Sequence[str], steps: Sequence[int], tolerances: Sequence[float]
) -> list[Entry]:
    """Return all settings of all methods."""
    settings = {"crude": steps, "newmark": steps, "exact": [math.nan]}
    return [
        Entry(method, setting, float(value))
        for method in methods
        for setting, value in enumerate(settings.get(method, tolerances))
    ]


def build_method(method: str, value: float, motion: BenchmarkMotion) -> Candidate | Outcome:
    """Return a method with its setting on a motion, or the outcome that states why it cannot run."""
    if method in OWN_METHODS and value * motion.periods > MAX_STEPS:
        return Outcome.NOT_TRIED
    if method not in OWN_METHODS and not is_installed(method):
        return Outcome.NOT_INSTALLED
    return build(method, value, motion)


def build(method: str, value: float, motion: BenchmarkMotion) -> Candidate:
    """Return an installed method with its setting on a motion, counted from its equilibrium."""
    motion = motion.about_equilibrium()
    if method == "exact":
        return own_methods.exact(motion)
    if method in OWN_METHODS:
        own_method = own_methods.newmark if method == "newmark" else own_methods.newmark_crude
        return own_method(motion, int(value))
    if method == "heyoka":
        return heyoka_peer(motion, value)
    return scipy_peer(motion, method, value)


def run_methods(
    motion: BenchmarkMotion, listed: Sequence[Entry], repeats: int
) -> dict[Entry, dict[str, float]]:
    """Run each method on one motion.

    Parameters
    ----------
    motion : BenchmarkMotion
        Motion to solve.
    listed : sequence of Entry
        Methods with their settings.
    repeats : int
        Timings of each.

    Returns
    -------
    dict
        Outcome, errors, work and times of each entry, by the names of the dataset.
    """
    reference, results, timers = MotionReference(motion), {}, {}
    for entry in listed:
        candidate = build_method(entry.method, entry.value, motion)
        if isinstance(candidate, Outcome):
            results[entry] = {"outcome": float(candidate)}
            continue
        result = candidate.show()
        outcome, errors = reference.errors(result)
        work = [count / motion.periods for count in result.effort]
        names = ("outcome", *ERRORS, *WORK)
        results[entry] = dict(zip(names, (outcome, *errors, *work), strict=True))
        if outcome != Outcome.DID_NOT_END:
            # Peers show and repeat by the same code, a second of it where they are slow.
            is_warm = entry.method not in OWN_METHODS
            timers[entry] = Timer(candidate.repeat, motion.periods, is_warm=is_warm)
    time_in_rounds(timers.values(), repeats)
    for entry, timer in timers.items():
        results[entry] |= zip(TIMES, timer.quartiles(), strict=True)
    return results


def compile_methods(methods: Sequence[str], motions: Iterable[BenchmarkMotion]) -> None:
    """Compile the kernels of this package's methods, in as many processes as there are threads."""
    short = [motion._replace(periods=1) for motion in motions]

    def show(method: str, motion: BenchmarkMotion) -> None:
        build(method, 8.0, motion).show()

    def repeat(method: str, motion: BenchmarkMotion) -> None:
        build(method, 8.0, motion).repeat(1)

    # The two calls of a method share most of their code, which side by side would be compiled twice.
    own = [method for method in methods if method in OWN_METHODS]
    calls = [
        partial(call, *arguments) for call in (show, repeat) for arguments in product(own, short)
    ]
    compile_side_by_side(calls, numba.get_num_threads())


def solve_accuracy(
    motions: Mapping[str, BenchmarkMotion],
    methods: Sequence[str] = COMPARED_METHODS,
    steps: Sequence[int] = (16, 64, 256, 1024, 4096, 16384),
    tolerances: Sequence[float] = (1e-4, 1e-7, 1e-10),
    peer_periods: int = 4,
    repeats: int = 7,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure error, run time and work of methods over (motion, method, setting).

    Parameters
    ----------
    motions : mapping of str to BenchmarkMotion
        Motions by name.
    methods : sequence of str
        Any of METHODS, each once.
    steps : sequence of int
        Steps per forcing period of crude and newmark.
    tolerances : sequence of float
        Relative and absolute tolerances of the reference packages.
    peer_periods : int
        Largest number of forcing periods of a motion that reference packages solve.
    repeats : int
        Timings of each.
    progress : callable, optional
        Called as `progress(done, total)` with the number of runs, each a motion by a method at a setting.

    Returns
    -------
    xarray.Dataset
        Errors relative to the motion, work and times per forcing period (ns), `outcome`, `setting_value`,
        `periods_run`. Only times differ from run to run with the same versions of the packages.
    """
    import xarray as xr

    compile_methods(methods, motions.values())
    listed = entries(methods, steps, tolerances)
    dims = ("motion", "method", "setting")
    shape = (len(motions), len(methods), max(entry.setting for entry in listed) + 1)
    columns = {name: np.full(shape, np.nan) for name in (*ERRORS, *WORK, *TIMES)}
    columns["outcome"] = np.full(shape, Outcome.NOT_TRIED, np.int8)
    values, periods = np.full(shape[1:], np.nan), np.zeros(shape[:2], np.int64)
    run = 0
    for i, motion in enumerate(motions.values()):
        short = motion._replace(periods=min(motion.periods, peer_periods))
        for solved, is_own in ((motion, True), (short, False)):
            tried = [entry for entry in listed if (entry.method in OWN_METHODS) == is_own]
            for entry, measured in run_methods(solved, tried, repeats).items():
                index = (i, methods.index(entry.method), entry.setting)
                values[index[1:]], periods[index[:2]] = entry.value, solved.periods
                for name, value in measured.items():
                    columns[name][index] = value
            run += len(tried)
            if progress is not None:
                progress(run, len(motions) * len(listed))
    variables: dict[str, Any] = {name: (dims, column) for name, column in columns.items()}
    variables |= {"setting_value": (dims[1:], values), "periods_run": (dims[:2], periods)}
    coords = {**motion_coordinates(motions), "method": ("method", list(methods))}
    comment = (
        "time_per_period* differ from run to run; all else is the same with the same versions of the "
        "packages, since methods that do not end are stopped by their work, not by time"
    )
    return describe(xr.Dataset(variables, coords, {"comment": comment}))


def motion_coordinates(motions: Mapping[str, BenchmarkMotion]) -> dict[str, Any]:
    """Return names, exciters and starts of motions as coordinates over `motion`."""
    all_motions = motions.values()
    columns = {
        name: values
        for name in PARAMETERS
        for values in [[getattr(motion.exciter, name) for motion in all_motions]]
        if name not in FURTHER or any(values)
    } | {
        "displacement_start": [motion.x0 for motion in all_motions],
        "velocity_start": [motion.v0 for motion in all_motions],
        "motion": list(motions),
    }
    return {name: ("motion", values) for name, values in columns.items()}
