"""What is timed of effects and outputs: a motion or a row, by the kernel of its own effects and by that of all."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.lab.timing import Repeat, repeated
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS, Log, new_log
from vibropipe.orbits.outputs import RowResults
from vibropipe.orbits.row import march_row, row_parameters, sample_row
from vibropipe.physics.effects import ALL_EFFECTS, Effects, effects_of
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.rows import (
    ORBIT_LOG_CAPACITY,
    ORBIT_REST_CAPACITY,
    new_impact_buffer,
    new_rows,
    solve_piece,
)
from vibropipe.solve.run import closed_form_solver, run_motion
from vibropipe.solve.sweep import MAX_PERIODS
from vibropipe.solve.sweep_grid import ROWS_PER_CALL

HARMONICS = 3
SAMPLES = 256


class TimingCase(NamedTuple):
    """What is timed: a motion marched over its periods, or, with `row`, the steady state that settles from
    its start; outputs: of a motion any of motion, impacts, of a row any of harmonics, impacts, stability, energy.

    against: the trial whose time is the 1 of its target, "" for the kernel of all effects on the same motion;
    at_most: the target, nan for none.
    """

    motion: BenchmarkMotion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    against: str = ""
    at_most: float = math.nan

    @property
    def effects(self) -> Effects:
        """The effects that the motion calls for, as a scene of it would derive them."""
        exciter, x0, v0, _periods = self.motion
        span = math.inf if self.row else self.motion.tau_end
        return effects_of(exciter.parameters()._asdict(), x0, v0, span)


class TimedWork(NamedTuple):
    """What a timer repeats: so many units (rows, or forcing periods of a motion) of so many forcing periods
    each, with so many impacts and rests in a forcing period."""

    repeat: Repeat
    units: int
    periods: int
    impacts: float
    rests: float


@jit_allocating
def solve_row_repeatedly(
    e: Effects,
    row: np.ndarray,
    x: float,
    v: float,
    log: Log,
    c: np.ndarray,
    out: RowResults,
    n_calls: int,
) -> None:
    """Solve a row (1, 7) so many times, marched whatever it is."""
    p = row_parameters(row, 0)
    for _ in range(n_calls):
        out.impacts[0, :] = 0.0
        out.rests[0, :] = 0.0
        march_row(e, p, x, v, MAX_PERIODS, MAX_PERIODS, log, c, out, 0)


@jit_allocating
def sample_repeatedly(
    e: Effects,
    row: np.ndarray,
    x: float,
    v: float,
    periods: int,
    log: Log,
    c: np.ndarray,
    samples: np.ndarray,
    n_calls: int,
) -> None:
    """March the motion of a row (1, 7) so many times with samples, from tau = 0."""
    p = row_parameters(row, 0)
    for _ in range(n_calls):
        sample_row(e, p, x, v, periods, log, c, samples, 0)


def row_calls(
    trial: TimingCase, motion: BenchmarkMotion, effects: Effects
) -> tuple[Repeat, Repeat, RowResults]:
    """What solves the row of a motion so many times, marched whatever it is and as a sweep solves it, and where
    its results go."""
    row = np.tile(motion.exciter.parameters(), (ROWS_PER_CALL, 1))
    starts = np.tile((motion.x0, motion.v0), (ROWS_PER_CALL, 1))
    out = new_rows(ROWS_PER_CALL, HARMONICS, trial.outputs, new_impact_buffer(ROWS_PER_CALL))
    work = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY), np.empty(DEGREE + 1), out

    def solve(n_calls: int) -> None:
        for first in range(0, n_calls, ROWS_PER_CALL):
            part = slice(min(n_calls - first, ROWS_PER_CALL))
            out.impacts[part] = 0.0
            out.rests[part] = 0.0
            solve_piece(effects, row[part], starts[part], 1, MAX_PERIODS, MAX_PERIODS, out)

    return partial(solve_row_repeatedly, ALL_EFFECTS, row, motion.x0, motion.v0, *work), solve, out


def row_work(
    trial: TimingCase, motion: BenchmarkMotion, effects: Effects, closed: bool
) -> TimedWork:
    """The steady state of a motion: a row of as many periods as its march takes to settle, as a sweep solves it
    or marched whatever it is."""
    march, solve, out = row_calls(trial, motion, effects)
    march(1)
    periods, m = max(1, int(out.settled_after[0])), max(1, int(out.period_multiple[0]))
    impacts, rests = out.impacts[0].sum() / m, out.rests[0].sum() / m
    return TimedWork(solve if closed else march, 1, periods, impacts, rests)


def motion_work(
    trial: TimingCase, motion: BenchmarkMotion, effects: Effects, closed: bool
) -> TimedWork:
    """A motion over its periods, with samples where they are asked for."""
    (exciter, x0, v0, periods), sampled = motion, "motion" in trial.outputs
    task = motion.task(SAMPLES * sampled)
    if closed and closed_form_solver(exciter, task):
        solve = partial(run_motion, exciter, task)
        struck = solve().contacts["impact_tau"]
        return TimedWork(repeated(solve), periods, 1, struck.size / periods, 0.0)
    # Of the effects a grid knows the force alone: two kernels of it are enough.
    grid = exact_grid(ALL_EFFECTS._replace(forcing=effects.forcing), exciter.parameters())
    march = March(motion, grid, effects)
    march.repeat(1)
    impacts, rests = (float(march.log.counts[k]) / periods for k in (IMPACTS, RESTS))
    repeat: Repeat = march.repeat
    if sampled:
        row, samples = np.array([exciter.parameters()]), np.empty((1, 2, SAMPLES * periods))
        room = march.log, march.scratch, samples
        repeat = partial(sample_repeatedly, effects, row, x0, v0, periods, *room)
    return TimedWork(repeat, periods, 1, impacts, rests)


def kernel_calls(trial: TimingCase) -> list[Callable[[], object]]:
    """Calls of each kernel that a trial needs, with next to no work."""
    if trial.row:
        march, solve, _out = row_calls(trial, trial.motion, trial.effects)
        return [partial(march, 1), partial(solve, 1)]

    def call(effects: Effects, closed: bool) -> None:
        motion_work(trial, trial.motion, effects, closed).repeat(1)

    return [partial(call, trial.effects, True), partial(call, ALL_EFFECTS, False)]


def works_by_kernel(trial: TimingCase, full: BenchmarkMotion) -> dict[str, TimedWork]:
    """The work of a trial by the kernel of its motion's own effects (a closed form where there is one); on the same
    motion, by the kernel of all effects; the same by that kernel on the motion that has all effects."""
    build = row_work if trial.row else motion_work
    return {
        "own": build(trial, trial.motion, trial.effects, True),
        "all": build(trial, trial.motion, ALL_EFFECTS, False),
        "full": build(trial, full, ALL_EFFECTS, False),
    }
