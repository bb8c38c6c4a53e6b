"""What `vibropipe bench` times: one motion, a sweep and a branch, their references, and the target ratios."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numba
import numpy as np

from vibropipe.lab.bench import Candidate, Item, PreparedRun, Target
from vibropipe.lab.motion_reference import MotionReference
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision import build_method
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
# Values of each parameter of the whole sweep; without `whole`, only every fourth of them is solved. The references
# march one transient, the textbook loop in so many steps per period.
SWEEP_POINTS, EVERY = 400, 4
PEER_PERIODS, PEER_MOTIONS, STEPS = 100, 100, 2000
# A branch that is stable from end to end: its range, its largest step, and the rows of the sweep beside it.
FOLLOWED = Exciter(h=0.1, nu=2.5, f=1.0, l=0.5, R1=0.8, R2=0.8)
BRANCH_ENDS, BRANCH_STEP, BRANCH_ROWS = (1.6, 3.0), 0.005, 1001


def items(*, whole: bool = False) -> list[Item]:
    """Return all items; `whole` solves the sweep at all of its points, not at every fourth value of each parameter."""
    return [motion_item(), sweep_item(whole=whole), branch_item()]


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


def sweep_item(*, whole: bool) -> Item:
    """Return the item of a sweep over nu and f on two threads; its references march one transient."""
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

    loop_run = partial(textbook_run, SWEPT, PEER_PERIODS)
    return Item(
        "sweep",
        f"steady states with three harmonics at {nu.size} x {f.size} of {SWEEP_POINTS} x {SWEEP_POINTS} points, "
        "nu from 0.3 to 3, f from 0.05 to 2, l = 0.5, h = 0.2, R = 0.7; wall time on two threads. "
        f"heyoka, and Newmark's method with {STEPS} steps per period and impacts at the end of a step: "
        f"{PEER_PERIODS} periods of one motion, nu = 1, f = 1",
        "point",
        [
            Candidate("steady states", sweep_run, time.perf_counter),
            Candidate("heyoka, 1e-15", heyoka_run, time.perf_counter),
            Candidate("textbook loop", loop_run, time.perf_counter),
        ],
        [
            Target("steady states", "heyoka, 1e-15", 60),
            Target("steady states", "textbook loop", 100),
        ],
    )


def textbook_run(exciter: Exciter, periods: int, unit: float = 1.0) -> PreparedRun:
    """Return the run of one motion by the textbook loop; `unit` is the number of units in it."""
    e = exciter
    march = partial(textbook, (e.nu, e.f, e.h, e.l, e.R1), STEPS, periods)
    return PreparedRun(repeated(march), unit)


def newmark_loop(p: tuple[float, ...], steps: int, periods: int) -> tuple[float, float, int]:
    """March from rest by Newmark's method with impacts applied at the end of the step.

    Constant average acceleration is written as one linear map of x, v and the mean force of a step.

    p : nu, f, h, l (supports at -l and l) and R of both supports
    steps, periods : steps per forcing period and number of forcing periods
    Returns x and v at the end, and the number of impacts.
    """
    nu, f, h, half_distance, R = p
    dt = 2.0 * math.pi / nu / steps
    divisor = 1.0 + 0.5 * h * dt + 0.25 * dt * dt
    a11, a12, b1 = (
        1.0 - 0.5 * dt * dt / divisor,
        dt - 0.5 * dt * dt * (h + 0.5 * dt) / divisor,
        0.5 * dt * dt / divisor,
    )
    a21, a22, b2 = -dt / divisor, 1.0 - dt * (h + 0.5 * dt) / divisor, dt / divisor
    x, v, n_impacts, force = 0.0, 0.0, 0, 0.0
    for n in range(1, periods * steps + 1):
        next_force = f * math.sin(nu * n * dt)
        mean = 0.5 * (force + next_force)
        x, v = a11 * x + a12 * v + b1 * mean, a21 * x + a22 * v + b2 * mean
        force = next_force
        if abs(x) >= half_distance and x * v > 0.0:
            x, v = math.copysign(half_distance, x), -R * v
            n_impacts += 1
    return x, v, n_impacts


textbook: Callable[..., tuple[float, float, int]] = numba.njit()(newmark_loop)


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
