"""What is measured, against whom, and the ratios that are asked."""

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
from vibropipe.lab.simulate_rows import march_rows
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision import MotionReference, build, build_method
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.exciter import Exciter
from vibropipe.solve.sweep import sweep
from vibropipe.words.measurements import Outcome

FORCED = Exciter(h=0.1, nu=1.0, f=1.0, l=1.0, R1=0.8, R2=0.8)
SWEPT = Exciter(h=0.2, nu=1.0, f=1.0, l=0.5, R1=0.7, R2=0.7)
# Forcing periods of a motion, and of the slow peer, which takes milliseconds an impact; those that the 40-digit
# twin judges.
PERIODS, FEW_PERIODS, JUDGED_PERIODS = 1000, 10, 10
STEPS, ROWS, ROW_PERIODS = 2000, 128, 50
# Values of either parameter of the whole sweep; every so manieth is solved if not the whole is asked.
SWEEP_POINTS, EVERY = 400, 4
PEER_PERIODS, PEER_MOTIONS = 100, 100


def items(*, whole: bool = False) -> list[Item]:
    """Everything that `vibropipe bench` measures; whole: the sweep over all its points."""
    return [one_motion(), newmark(), swept(whole=whole)]


def one_motion() -> Item:
    """A long motion that strikes both supports, its impacts recorded."""
    judge = MotionReference(BenchmarkMotion(FORCED, 0.0, 0.0, JUDGED_PERIODS))

    def entry(name: str, method: str, tolerance: float, periods: int = PERIODS) -> Candidate:
        return Candidate(name, partial(ready, method, tolerance, periods, judge))

    return Item(
        "one motion, exact",
        "h = 0.1, nu = 1, f = 1, l = 1, R = 0.8 from rest, impacts recorded; error against 40 digits",
        "impact",
        [
            entry("exact", "exact", math.nan),
            entry("heyoka, 1e-15", "heyoka", 1e-15),
            entry("DOP853, 1e-12", "DOP853", 1e-12, FEW_PERIODS),
        ],
        [Target("exact", "heyoka, 1e-15", 20), Target("exact", "DOP853, 1e-12", 10_000)],
    )


def ready(method: str, tolerance: float, periods: int, judge: MotionReference) -> PreparedRun | str:
    """A method on the forced motion, with its error over the first periods; or why it does not enter."""
    judged = build_method(method, tolerance, judge.motion)
    entered = build_method(method, tolerance, BenchmarkMotion(FORCED, 0.0, 0.0, periods))
    if isinstance(judged, Outcome) or isinstance(entered, Outcome):
        return "not installed"
    outcome, errors = judge.errors(judged.show())
    shown = entered.show()
    worst = max(outcome, shown.outcome)
    if worst != Outcome.OK:
        return Outcome(worst).name.lower().replace("_", " ")
    return PreparedRun(entered.repeat, shown.impact_tau.size, max(errors))


def newmark() -> Item:
    """Newmark's method on many rows: in lanes, one by one, and as a textbook has it, on one thread."""
    return Item(
        "newmark in lanes",
        f"h, nu, f, l, R within 5 % of the above in {ROWS} rows, {STEPS} steps per period, two impacts in each",
        "step and row",
        [
            # the threads of numba work elsewhere: their time counts
            Candidate("in lanes", in_lanes, time.process_time),
            Candidate("one by one", scalar_run),
            Candidate("textbook loop", textbook_run),
        ],
        [Target("in lanes", "textbook loop", 6 if has_avx512() else 3)],
    )


def has_avx512() -> bool:
    """Whether eight numbers fit a vector register of the processor that is compiled for, and not four or two."""
    features = numba.config.CPU_FEATURES  # type: ignore[attr-defined]
    if features is None:  # not told by NUMBA_CPU_FEATURES: those of this one
        features = llvm.get_host_cpu_features().flatten()
    return "+avx512f" in features.split(",")


def rows_near() -> np.ndarray:
    """Parameters (ROWS, 7) of exciters near the forced one, supports in the middle."""
    near = 1.0 + np.random.default_rng(0).uniform(-0.05, 0.05, (ROWS, 7))
    return near * np.array(FORCED.parameters())


def in_lanes() -> PreparedRun:
    """All rows in lanes, impacts recorded, on one thread."""
    parameters, starts = rows_near(), np.zeros((ROWS, 2))
    turns = np.full(ROWS, float(ROW_PERIODS))
    march = partial(march_rows, parameters, starts, turns, STEPS, 10**6)
    return PreparedRun(threads(1)(repeated(march)), ROWS * ROW_PERIODS * STEPS)


def scalar_run() -> PreparedRun:
    """One row by the scalar path that gives the same motion."""
    entered = build("newmark", STEPS, BenchmarkMotion(FORCED, 0.0, 0.0, ROW_PERIODS))
    entered.show()
    return PreparedRun(entered.repeat, ROW_PERIODS * STEPS)


def textbook_run() -> PreparedRun:
    """One row by the textbook loop."""
    p = FORCED.parameters()
    march = partial(textbook, (p.nu, p.f, p.h, p.l, p.R1), STEPS, ROW_PERIODS)
    return PreparedRun(repeated(march), ROW_PERIODS * STEPS)


def swept(*, whole: bool) -> Item:
    """Steady states over nu and f, on two threads, against a peer that waits for one of them to settle."""
    every = 1 if whole else EVERY
    nu = np.linspace(0.3, 3.0, SWEEP_POINTS)[every // 2 :: every]
    f = np.linspace(0.05, 2.0, SWEEP_POINTS)[every // 2 :: every]

    def steady() -> PreparedRun:
        over = {"nu": nu, "f": f}
        solve = partial(sweep, SWEPT, over, harmonics=3, outputs=("harmonics",))
        return PreparedRun(threads(2)(repeated(solve)), nu.size * f.size)

    def heyoka_run() -> PreparedRun | str:
        entered = build_method("heyoka", 1e-15, BenchmarkMotion(SWEPT, 0.0, 0.0, PEER_PERIODS))
        if isinstance(entered, Outcome):
            return "not installed"
        return PreparedRun(lambda n_calls: entered.repeat(n_calls * PEER_MOTIONS), PEER_MOTIONS)

    return Item(
        "sweep",
        f"steady states with three harmonics at {nu.size} x {f.size} of {SWEEP_POINTS} x {SWEEP_POINTS} points, "
        "nu from 0.3 to 3, f from 0.05 to 2, l = 0.5, h = 0.2, R = 0.7; wall time on two threads. "
        f"heyoka: {PEER_PERIODS} periods of one motion, nu = 1, f = 1",
        "point",
        [
            Candidate("steady states", steady, time.perf_counter),
            Candidate("heyoka, 1e-15", heyoka_run, time.perf_counter),
        ],
        [Target("steady states", "heyoka, 1e-15", 40)],
    )


@contextmanager
def threads(count: int) -> Iterator[None]:
    """So many threads for the kernels, as far as there are, and then as many as before."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(count, int(numba.config.NUMBA_NUM_THREADS)))  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.set_num_threads(before)
