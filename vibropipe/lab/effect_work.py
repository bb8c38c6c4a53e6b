"""Timed work of effects and outputs: a motion or a row, with its own kernel and with the kernel of all effects."""

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
from vibropipe.physics.effects import ALL_EFFECTS, Effects, all_effects, effects_of
from vibropipe.solve.row_results import (
    ORBIT_LOG_CAPACITY,
    new_impact_buffer,
    new_rows,
)
from vibropipe.solve.rows import solve_piece
from vibropipe.solve.run import closed_form_solver, run_motion
from vibropipe.solve.sweep import MAX_PERIODS
from vibropipe.solve.sweep_grid import ROWS_PER_CALL

# Harmonics of a row, and samples per forcing period of a motion, where a case includes them.
HARMONICS = 3
SAMPLES = 256


class TimingCase(NamedTuple):
    """What is timed: a motion over its periods or, with `row`, the steady state that it settles to.

    `outputs` of a motion: any of motion, impacts; of a row: any of harmonics, impacts, stability, energy. `against`
    names the case whose time is the reference of the target ratio, "" for the all-effects kernel on the same motion.
    `at_most` is the target, nan for none.
    """

    motion: BenchmarkMotion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    against: str = ""
    at_most: float = math.nan

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


Work = Callable[[TimingCase, BenchmarkMotion, Effects], TimedWork]


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


def kernel_calls(case: TimingCase) -> list[Callable[[], object]]:
    """Return calls that compile each kernel of a case with a minimum of work."""

    def call(work: Work, effects: Effects) -> None:
        work(case, case.motion, effects).repeat(1)

    own, reference = works_of(case)
    return [partial(call, own, case.effects), partial(call, reference, case.all_effects)]


def works_by_kernel(case: TimingCase, full: BenchmarkMotion) -> dict[str, TimedWork]:
    """Return the work of a case for each kernel.

    "own": the kernel of its effects, or a closed form where there is one; "all": the all-effects kernel on the same
    motion, marched; "full": as "all", on the motion that contains all effects. Rows are solved as a sweep does.
    """
    own, reference = works_of(case)
    return {
        "own": own(case, case.motion, case.effects),
        "all": reference(case, case.motion, case.all_effects),
        "full": reference(case, full, ALL_EFFECTS),
    }


def works_of(case: TimingCase) -> tuple[Work, Work]:
    """Return the function of the work with a case's own kernel, and that with the kernel of all effects."""
    return (row_work, row_work) if case.row else (motion_work, march_work)
