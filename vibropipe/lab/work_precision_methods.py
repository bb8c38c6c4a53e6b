"""Methods of the work-precision comparison that belong to this package, and the form of every method's result."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from vibropipe.lab.crude import crude_repeatedly
from vibropipe.lab.timing import Repeat, repeated
from vibropipe.march.grid import StepGrid, exact_grid, grid_time, newmark_grid
from vibropipe.march.log import EVALUATIONS, IMPACTS, POLYNOMIALS, STEPS, Log, Samples, new_log
from vibropipe.march.loop import march_repeatedly
from vibropipe.march.piece_log import piece_log_of
from vibropipe.march.piece_state import start_state
from vibropipe.physics.conservative import is_conservative
from vibropipe.physics.effects import (
    Effects,
    all_effects,
    grid_effects,
    kernel_effects,
    shared_effects,
)
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.equilibrium import about_equilibrium, from_equilibrium
from vibropipe.solve.motion.run import MARCH_LOG_CAPACITY, MotionRequest, run_motion
from vibropipe.words.measurements import Outcome
from vibropipe.words.status import Status

# Samples of the last forcing period, which give the harmonics of a result.
SAMPLES = 64
# Limit of contacts and releases of a motion: far above any that is compared.
MAX_CONTACTS = 2_000_000


class BenchmarkMotion(NamedTuple):
    """Motion over whole forcing periods from (x0, v0) at tau = 0."""

    exciter: Exciter
    x0: float
    v0: float
    periods: int

    @property
    def tau_end(self) -> float:
        """Time at the end of the motion."""
        return self.periods * self.exciter.period

    def about_equilibrium(self) -> BenchmarkMotion:
        """Return the same motion counted from the equilibrium, so that no method has to know of a constant load."""
        x0 = from_equilibrium(self.exciter, self.x0)
        return self._replace(exciter=about_equilibrium(self.exciter), x0=x0)

    def request(self, samples_per_period: int = 0) -> MotionRequest:
        """Return the request for this motion, with samples per forcing period."""
        return MotionRequest(
            0.0,
            self.tau_end,
            self.x0,
            self.v0,
            samples_per_period,
            MAX_CONTACTS,
            effects=effects_of_motion(self),
        )


class MethodResult(NamedTuple):
    """Result of a method on a motion.

    end : displacement and velocity; impact_* : in order of time; samples : (SAMPLES,) displacement at equal fractions
    of the last period; effort : steps, evaluations of a solution or of the equation, and iterations for impacts (nan
    where not counted).
    """

    outcome: Outcome
    end: tuple[float, float]
    impact_tau: np.ndarray
    impact_support: np.ndarray
    impact_velocity: np.ndarray
    samples: np.ndarray
    effort: tuple[float, float, float]


class Candidate(NamedTuple):
    """A method with its setting on one motion: `show` solves it once, `repeat(n_calls)` for timing."""

    show: Callable[[], MethodResult]
    repeat: Repeat


def failed(outcome: Outcome) -> MethodResult:
    """Return the empty result of a method that failed."""
    empty = np.empty(0)
    return MethodResult(outcome, (math.nan,) * 2, empty, empty, empty, empty, (math.nan,) * 3)


def effects_of_motion(motion: BenchmarkMotion) -> Effects:
    """Return all effects that the kernels of a motion have."""
    return all_effects(vars(motion.exciter), pieces=True, housing=True)


def exact(motion: BenchmarkMotion) -> Candidate:
    """Return the exact method; a conservative motion is evaluated in closed form."""
    p = motion.exciter.parameters()
    if is_conservative(p, motion.x0, motion.v0):
        solve = partial(run_motion, motion.exciter, motion.request())
        return Candidate(partial(solve_once, motion, None), repeated(solve))
    return marching_candidate(motion, exact_grid(grid_effects(effects_of_motion(motion)), p))


def newmark(motion: BenchmarkMotion, steps: int) -> Candidate:
    """Return Newmark's method with event location."""
    p = motion.exciter.parameters()
    return marching_candidate(
        motion, newmark_grid(grid_effects(effects_of_motion(motion)), p, steps)
    )


def marching_candidate(motion: BenchmarkMotion, grid: StepGrid) -> Candidate:
    """Return the marching loop on a grid, whose tables are built before the clock starts."""
    return Candidate(partial(solve_once, motion, grid), March(motion, grid).repeat)


class March:
    """A march of a motion by a kernel of some effects, repeated in one call, with or without samples.

    `log` holds the contacts of the last march.
    """

    def __init__(
        self,
        motion: BenchmarkMotion,
        grid: StepGrid,
        effects: Effects | None = None,
        samples_per_period: int = 0,
    ) -> None:
        self.grid, self.scratch = grid, np.empty(3 if grid.exact is None else DEGREE + 1)
        self.effects = kernel_effects(effects or effects_of_motion(motion))
        self.parameters = motion.exciter.parameters()
        self.log = self.new_log(MARCH_LOG_CAPACITY)
        start = 0.0, motion.x0, motion.v0, 0.0
        problem = shared_effects(self.effects), self.parameters, grid
        self.start = start_state(self.log.pieces, *problem, *start)
        self.end = grid_time(float(motion.periods), grid.steps)
        self.samples = None
        if samples_per_period > 0:
            displacement, velocity = np.empty((2, samples_per_period * motion.periods))
            self.samples = Samples(displacement, velocity, 1, samples_per_period, 0, 0.0)

    def repeat(self, n_calls: int) -> None:
        """March `n_calls` times; the log grows until it has capacity for all contacts."""
        while True:
            self.log.counts[:] = 0
            _end, status = march_repeatedly(
                self.effects,
                self.parameters,
                self.grid,
                self.start,
                self.end,
                self.log,
                self.samples,
                self.scratch,
                MAX_CONTACTS,
                n_calls,
            )
            capacity = 4 * self.log.position.size
            if status != Status.LOG_FULL or capacity > 2 * MAX_CONTACTS:
                return
            self.log = self.new_log(capacity)

    def new_log(self, capacity: int) -> Log:
        """Return an empty log for so many contacts, and for their pieces."""
        pieces = piece_log_of(self.effects, 4 * capacity, self.scratch.size - 1)
        log: Log = new_log(capacity, capacity, *pieces)
        return log


def solve_once(motion: BenchmarkMotion, grid: StepGrid | None) -> MethodResult:
    """Return the result of one march, with samples of its last period."""
    run = run_motion(motion.exciter, motion.request(), grid)
    if run.status not in (Status.OK, Status.SHORT_FLIGHTS):
        return failed(Outcome.DID_NOT_END)
    sampled = run_motion(motion.exciter, motion.request(SAMPLES), grid)
    contacts, counts = run.contacts, run.counts
    return MethodResult(
        Outcome.OK,
        run.end,
        contacts["impact_tau"],
        contacts["impact_support"],
        contacts["impact_velocity"],
        sampled.displacement[-SAMPLES:],
        (float(counts[STEPS]), float(counts[POLYNOMIALS]), float(counts[EVALUATIONS])),
    )


def newmark_crude(motion: BenchmarkMotion, steps: int) -> Candidate:
    """Return Newmark's method with impacts applied at the end of the step."""
    p = motion.exciter.parameters()
    effects = effects_of_motion(motion)
    grid = newmark_grid(grid_effects(effects), p, steps)
    arguments = effects, p, grid, motion.periods, motion.x0, motion.v0
    capacity = MARCH_LOG_CAPACITY

    def show() -> MethodResult:
        nonlocal capacity
        samples = np.empty(SAMPLES)
        while True:
            log = new_log(capacity, 1)
            end = crude_repeatedly(*arguments, log, samples, 1)
            n = int(log.counts[IMPACTS])
            if n <= capacity:
                break
            capacity = n
        return MethodResult(
            Outcome.OK if all(map(math.isfinite, end)) else Outcome.DID_NOT_END,
            end,
            log.position[:n] * motion.exciter.period,
            log.support[:n],
            log.velocity[:n],
            samples,
            (float(log.counts[STEPS]), 0.0, 0.0),
        )

    def repeat(n_calls: int) -> None:
        crude_repeatedly(*arguments, new_log(capacity, 1), np.empty(0), n_calls)

    return Candidate(show, repeat)
