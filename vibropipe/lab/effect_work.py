"""Timed work of effects and outputs: a motion or a row, with its own kernel or with the kernel of all effects."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import NamedTuple

import numpy as np

from vibropipe.lab.timing import Repeat, repeated
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March, effects_of_motion
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.piece_log import piece_log_of
from vibropipe.physics.effects import Effects, all_effects, effects_of
from vibropipe.solve.motion.run import closed_form_solver, run_motion
from vibropipe.solve.rows.many import solve_piece
from vibropipe.solve.rows.row_results import (
    ORBIT_LOG_CAPACITY,
    new_impact_buffer,
    new_rows,
)
from vibropipe.solve.sweep.sweep import MAX_PERIODS
from vibropipe.solve.sweep.sweep_grid import ROWS_PER_CALL

# Harmonics of a row, and samples per forcing period of a motion, where a case includes them.
HARMONICS = 3
SAMPLES = 256


class TimingCase(NamedTuple):
    """What is timed: a motion over its periods or, with `row`, the steady state that it settles to.

    `outputs` of a motion: any of motion, impacts; of a row: any of a steady state's. `kernel`: "own", of the motion's
    effects, or "all", of all effects. `against` names the case whose time is the 1 of its ratio, "" for
    itself. `group`, `title`: words for readers.
    """

    motion: BenchmarkMotion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    kernel: str = "own"
    against: str = ""
    group: str = ""
    title: str = ""

    @property
    def effects(self) -> Effects:
        """Effects of the motion, derived as for a scene."""
        exciter, x0, v0, _periods = self.motion
        span = math.inf if self.row else self.motion.tau_end
        return effects_of(exciter.parameters()._asdict(), x0 - exciter.load, v0, span)

    @property
    def all_effects(self) -> Effects:
        """Effects of the all-effects kernel: those of eqs. (5), (6), and all of pieces where the motion has pieces."""
        return all_effects(self.motion.exciter.parameters()._asdict(), pieces=True)


class TimedWork(NamedTuple):
    """What a timer repeats.

    One call of `repeat` does `units` units (rows, or forcing periods of a motion) of `periods` forcing periods each;
    `impacts` and `rests` are mean numbers per forcing period.
    """

    repeat: Repeat
    units: int
    periods: int
    impacts: float
    rests: float


def row_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of a steady state as a sweep solves it: one row of as many periods as its transient takes."""
    motion = motion.about_equilibrium()
    row = np.tile(motion.exciter.parameters(), (ROWS_PER_CALL, 1))
    starts = np.tile((motion.x0, motion.v0), (ROWS_PER_CALL, 1))
    buffer = new_impact_buffer(ROWS_PER_CALL)
    out = new_rows(ROWS_PER_CALL, HARMONICS, case.outputs, buffer, effects)
    pieces = piece_log_of(effects, ORBIT_LOG_CAPACITY)
    limits = 1, MAX_PERIODS, MAX_PERIODS

    def solve(n_calls: int) -> None:
        for first in range(0, n_calls, ROWS_PER_CALL):
            piece = slice(min(n_calls - first, ROWS_PER_CALL))
            out.impacts[piece] = 0.0
            out.rests[piece] = 0.0
            solve_piece(effects, row[piece], starts[piece], *limits, out, *pieces)

    solve(1)
    periods, m = max(1, int(out.settled_after[0])), max(1, int(out.period_multiple[0]))
    impacts, rests = out.impacts[0].sum() / m, out.rests[0].sum() / m
    return TimedWork(solve, 1, periods, impacts, rests)


def samples_of(outputs: Collection[str]) -> int:
    """Return the samples per forcing period of a motion with some outputs."""
    return SAMPLES if "motion" in outputs else 0


def march_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of marching a motion over its periods, sampled if its outputs include the motion."""
    motion = motion.about_equilibrium()
    grid = exact_grid(effects_of_motion(motion), motion.exciter.parameters())
    march = March(motion, grid, effects, samples_of(case.outputs))
    march.repeat(1)
    impacts, rests = (float(march.log.counts[k]) / motion.periods for k in (IMPACTS, RESTS))
    return TimedWork(march.repeat, motion.periods, 1, impacts, rests)


def motion_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of a motion in closed form, or of marching it if there is none."""
    about = motion.about_equilibrium()
    exciter, request = about.exciter, about.request(samples_of(case.outputs))
    if not closed_form_solver(exciter, request):
        return march_work(case, motion, effects)
    solve = partial(run_motion, exciter, request)
    impact_tau = solve().contacts["impact_tau"]
    return TimedWork(repeated(solve), about.periods, 1, impact_tau.size / about.periods, 0.0)


def kernel_call(case: TimingCase) -> Callable[[], object]:
    """Return a call that compiles the kernel of a case with a minimum of work."""

    def call() -> None:
        timed_work(case).repeat(1)

    return call


def timed_work(case: TimingCase) -> TimedWork:
    """Return the work of a case by its kernel: in closed form where its own kernel has one; rows as a sweep does."""
    is_own = case.kernel == "own"
    effects = case.effects if is_own else case.all_effects
    if case.row:
        return row_work(case, case.motion, effects)
    return (motion_work if is_own else march_work)(case, case.motion, effects)
