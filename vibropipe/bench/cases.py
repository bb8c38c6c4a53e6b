"""Benchmark items: what is timed, the reference of each, and the target ratios."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import llvmlite.binding as llvm
import numba
import numpy as np

from vibropipe.bench.measurement import Candidate, Item, PreparedRun, Target
from vibropipe.bench.textbook import textbook
from vibropipe.lab.motion_reference import MotionReference
from vibropipe.lab.simulate_rows import march_rows
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision import build, build_method
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.exciter import Exciter
from vibropipe.solve.branch.branch import branch
from vibropipe.solve.sweep.sweep import sweep
from vibropipe.words.measurements import Outcome
from vibropipe.words.outputs import OF_STEADY_STATE

FORCED = Exciter(h=0.1, nu=1.0, f=1.0, l=1.0, R1=0.8, R2=0.8)
SWEPT = Exciter(h=0.2, nu=1.0, f=1.0, l=0.5, R1=0.7, R2=0.7)
# Forcing periods that are timed; fewer for the slow reference, which takes milliseconds for each impact; and those
# over which the error against 40 digits is measured.
PERIODS, FEW_PERIODS, ERROR_PERIODS = 1000, 10, 10
STEPS, ROWS, ROW_PERIODS = 2000, 128, 50
# Values of each parameter of the whole sweep; without `whole`, only every fourth of them is solved.
SWEEP_POINTS, EVERY = 400, 4
PEER_PERIODS, PEER_MOTIONS = 100, 100
# A branch that is stable from end to end: its range, its largest step, and the rows of the sweep beside it.
FOLLOWED = Exciter(h=0.1, nu=2.5, f=1.0, l=0.5, R1=0.8, R2=0.8)
BRANCH_ENDS, BRANCH_STEP, BRANCH_ROWS = (1.6, 3.0), 0.005, 1001


def items(*, whole: bool = False) -> list[Item]:
    """Return all benchmark items.

    Parameters
    ----------
    whole : bool
        Solve the sweep at all of its points instead of every fourth value of each parameter.
    """
    return [motion_item(), newmark_item(), sweep_item(whole=whole), branch_item()]


def motion_item() -> Item:
    """Return the item of one long motion that strikes both supports and records its impacts."""
    reference = MotionReference(BenchmarkMotion(FORCED, 0.0, 0.0, ERROR_PERIODS))

    def candidate(name: str, method: str, tolerance: float, periods: int = PERIODS) -> Candidate:
        return Candidate(name, partial(prepare_method, method, tolerance, periods, reference))

    return Item(
        "one motion, exact",
        "h = 0.1, nu = 1, f = 1, l = 1, R = 0.8 from rest, impacts recorded; error against 40 digits",
        "impact",
        [
            candidate("exact", "exact", math.nan),
            candidate("heyoka, 1e-15", "heyoka", 1e-15),
            candidate("DOP853, 1e-12", "DOP853", 1e-12, FEW_PERIODS),
        ],
        [Target("exact", "heyoka, 1e-15", 20), Target("exact", "DOP853, 1e-12", 10_000)],
    )


def prepare_method(
    method: str, tolerance: float, periods: int, reference: MotionReference
) -> PreparedRun | str:
    """Return a method on the forced motion with its error over the first periods, or the reason why it cannot run."""
    short_run = build_method(method, tolerance, reference.motion)
    candidate = build_method(method, tolerance, BenchmarkMotion(FORCED, 0.0, 0.0, periods))
    if isinstance(short_run, Outcome) or isinstance(candidate, Outcome):
        return "not installed"
    outcome, errors = reference.errors(short_run.show())
    result = candidate.show()
    worst = max(outcome, result.outcome)
    if worst != Outcome.OK:
        return Outcome(worst).name.lower().replace("_", " ")
    return PreparedRun(candidate.repeat, result.impact_tau.size, max(errors))


def newmark_item() -> Item:
    """Return the item of Newmark's method on one thread: rows in lanes, row by row, and as a textbook loop."""
    return Item(
        "newmark in lanes",
        f"h, nu, f, l, R within 5 % of the above in {ROWS} rows, {STEPS} steps per period, two impacts in each",
        "step and row",
        [
            # kernels run on threads of numba, whose time must count
            Candidate("in lanes", lanes_run, time.process_time),
            Candidate("one by one", scalar_run),
            Candidate("textbook loop", textbook_run),
        ],
        [Target("in lanes", "textbook loop", 6 if has_avx512() else 3)],
    )


def has_avx512() -> bool:
    """Return whether a vector register of the target processor holds eight floats, not four or two."""
    features = numba.config.CPU_FEATURES  # type: ignore[attr-defined]
    if features is None:  # NUMBA_CPU_FEATURES is unset: the features of this processor apply
        features = llvm.get_host_cpu_features().flatten()
    return "+avx512f" in features.split(",")


def random_parameters() -> np.ndarray:
    """Return the parameters of exciters, in rows, within 5 % of the forced one, equilibrium in the middle."""
    rows = np.tile(FORCED.parameters(), (ROWS, 1))
    rows[:, :7] *= 1.0 + np.random.default_rng(0).uniform(-0.05, 0.05, (ROWS, 7))
    return rows


def lanes_run() -> PreparedRun:
    """Return the run of all rows in lanes on one thread, impacts recorded."""
    parameters, starts = random_parameters(), np.zeros((ROWS, 2))
    turns = np.full(ROWS, float(ROW_PERIODS))
    march = partial(march_rows, parameters, starts, turns, STEPS, 10**6)
    return PreparedRun(limit_threads(1)(repeated(march)), ROWS * ROW_PERIODS * STEPS)


def scalar_run() -> PreparedRun:
    """Return the run of one row by the scalar kernel, which computes the same motion."""
    candidate = build("newmark", STEPS, BenchmarkMotion(FORCED, 0.0, 0.0, ROW_PERIODS))
    candidate.show()
    return PreparedRun(candidate.repeat, ROW_PERIODS * STEPS)


def textbook_run() -> PreparedRun:
    """Return the run of one row by the textbook loop."""
    p = FORCED.parameters()
    march = partial(textbook, (p.nu, p.f, p.h, p.l, p.R1), STEPS, ROW_PERIODS)
    return PreparedRun(repeated(march), ROW_PERIODS * STEPS)


def sweep_item(*, whole: bool) -> Item:
    """Return the item of a sweep over nu and f on two threads; its reference marches one transient."""
    every = 1 if whole else EVERY
    nu = np.linspace(0.3, 3.0, SWEEP_POINTS)[every // 2 :: every]
    f = np.linspace(0.05, 2.0, SWEEP_POINTS)[every // 2 :: every]

    def sweep_run() -> PreparedRun:
        over = {"nu": nu, "f": f}
        solve = partial(sweep, SWEPT, over, harmonics=3, outputs=("harmonics",))
        return PreparedRun(limit_threads(2)(repeated(solve)), nu.size * f.size)

    def heyoka_run() -> PreparedRun | str:
        candidate = build_method("heyoka", 1e-15, BenchmarkMotion(SWEPT, 0.0, 0.0, PEER_PERIODS))
        if isinstance(candidate, Outcome):
            return "not installed"
        return PreparedRun(lambda n_calls: candidate.repeat(n_calls * PEER_MOTIONS), PEER_MOTIONS)

    return Item(
        "sweep",
        f"steady states with three harmonics at {nu.size} x {f.size} of {SWEEP_POINTS} x {SWEEP_POINTS} points, "
        "nu from 0.3 to 3, f from 0.05 to 2, l = 0.5, h = 0.2, R = 0.7; wall time on two threads. "
        f"heyoka: {PEER_PERIODS} periods of one motion, nu = 1, f = 1",
        "point",
        [
            Candidate("steady states", sweep_run, time.perf_counter),
            Candidate("heyoka, 1e-15", heyoka_run, time.perf_counter),
        ],
        [Target("steady states", "heyoka, 1e-15", 60)],
    )


def branch_item() -> Item:
    """Return the item of a branch; its reference is a sweep whose rows settle at once, on one thread."""
    nu = np.linspace(*BRANCH_ENDS, BRANCH_ROWS)

    def branch_run() -> PreparedRun:
        follow = partial(branch, FOLLOWED, "nu", BRANCH_ENDS, max_step=BRANCH_STEP)
        return PreparedRun(limit_threads(1)(repeated(follow)), follow().sizes["point"])

    def sweep_run() -> PreparedRun:
        solve = partial(
            sweep, FOLLOWED, {"nu": nu}, follow=("nu", "up"), harmonics=6, outputs=OF_STEADY_STATE
        )
        return PreparedRun(limit_threads(1)(repeated(solve)), nu.size)

    low, high = BRANCH_ENDS
    return Item(
        "branch",
        f"the symmetric orbit along nu from {low:g} to {high:g}, h = 0.1, f = 1, l = 0.5, R = 0.8, "
        "with six harmonics and impacts; a point of the branch against a row of a sweep that follows it",
        "point",
        [
            Candidate("branch", branch_run, time.perf_counter),
            Candidate("followed sweep", sweep_run, time.perf_counter),
        ],
        [Target("branch", "followed sweep", 1 / 20)],
    )


@contextmanager
def limit_threads(count: int) -> Iterator[None]:
    """Use at most `count` threads in kernels, and restore the previous number afterwards."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(count, int(numba.config.NUMBA_NUM_THREADS)))  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.set_num_threads(before)
